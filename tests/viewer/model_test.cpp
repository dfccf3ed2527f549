// The viewer's state by itself: time, camera, effects, pictures and the command line that says all of it.
#include "apps/cli/viewpoint.h"
#include "apps/viewer/model.h"
#include "apps/viewer/statistics.h"
#include "apps/viewer/truth.h"
#include "scene/vec3.h"

#include <cmath>
#include <filesystem>
#include <gtest/gtest.h>
#include <set>
#include <sstream>
#include <unistd.h>

namespace sfumato::viewer {
namespace {

// Knows its facts and draws nothing.
class StillScene final : public scene::SceneSource {
  public:
    StillScene() {
        info_.name = "still";
        info_.frames = 6;
        info_.key_frame = 3;
        info_.frames_per_second = 10.0;
        info_.effects = {"ambient-occlusion"};
    }
    const scene::SceneInfo& info() const override { return info_; }
    scene::Bounds bounds() const override { return {{0, 1, 0}, 2.0}; }
    const scene::Lens& lens() const override { return lens_; }
    scene::Vec3 to_sun() const override { return {0, 1, 0}; }
    scene::View view(double frame) const override { return {{frame, 1, 8}, {0, 0, -2}, {0, 1, 0}, 35.0}; }
    void set_camera(scene::CameraPath) override {}
    Result<void> record(VkCommandBuffer, double, const scene::RenderOptions&, const scene::SceneImages&,
                        uint64_t) override {
        return {};
    }
    std::vector<PassTime> times() override { return {}; }

  private:
    scene::SceneInfo info_;
    scene::Lens lens_;
};

Model make_model(const std::string& effects = "", const std::string& preset = "",
                 std::vector<std::string> settings = {}) {
    auto model = Model::create({effects, preset, std::move(settings), ""});
    EXPECT_TRUE(model) << (model ? "" : model.error().message);
    model->set_scene("still", StillScene());
    return *model;
}

EffectSlot& slot(Model& model, const std::string& name) {
    for (EffectSlot& one : model.effects())
        if (name == one.link.effect->name)
            return one;
    throw std::runtime_error("no effect " + name);
}

double value(const EffectSlot& slot, const char* parameter) {
    return slot.link.effect->parameters->find(parameter)->get(slot.link.parameters.data());
}

std::vector<std::string> ids(const Model& model) {
    std::vector<std::string> result;
    for (const PictureChoice& choice : model.pictures())
        result.push_back(choice.id);
    return result;
}

bool has(const std::vector<std::string>& list, const std::string& name) {
    return std::find(list.begin(), list.end(), name) != list.end();
}

// The words of a command line as a shell splits them; nothing here needs quotes.
std::vector<std::string> words(const std::string& text) {
    std::istringstream stream(text);
    std::vector<std::string> result;
    for (std::string word; stream >> word;)
        result.push_back(word);
    return result;
}

TEST(ViewerModel, starts_with_every_effect_and_those_of_the_scene_on) {
    const Model plain = make_model();
    EXPECT_EQ(plain.effects().size(), effects().size());
    for (const EffectSlot& one : plain.effects())
        EXPECT_EQ(one.enabled, std::string(one.link.effect->name) == "ambient-occlusion");
    Model named = make_model("motion-blur", "high", {"taps=7"});
    EXPECT_STREQ(named.effects().front().link.effect->name, "motion-blur");
    EXPECT_TRUE(slot(named, "motion-blur").enabled);
    EXPECT_FALSE(slot(named, "ambient-occlusion").enabled);
    EXPECT_EQ(value(slot(named, "motion-blur"), "taps"), 7.0);
    EXPECT_FALSE(Model::create({"motion-blurr", "", {}, ""}));
    EXPECT_FALSE(Model::create({"", "high", {}, ""}));
}

TEST(ViewerModel, time_moves_one_frame_when_one_is_due) {
    Model model = make_model();
    EXPECT_EQ(model.frame(), 3);
    EXPECT_TRUE(model.take_cut());
    EXPECT_FALSE(model.advance(10.0)); // paused
    model.play(true);
    EXPECT_FALSE(model.advance(0.06));
    EXPECT_TRUE(model.advance(0.06)); // 0.12 s at 10 frames a second
    EXPECT_EQ(model.frame(), 4);
    EXPECT_TRUE(model.advance(5.0)); // however slow the machine: the next frame, no other
    EXPECT_EQ(model.frame(), 5);
    EXPECT_FALSE(model.take_cut());
    EXPECT_TRUE(model.advance(0.1));
    EXPECT_TRUE(model.advance(0.1)); // round to the first
    EXPECT_EQ(model.frame(), 1);
    EXPECT_TRUE(model.take_cut());
}

TEST(ViewerModel, step_goes_round_and_scrub_stays_inside) {
    Model model = make_model();
    model.play(true);
    model.step(4);
    EXPECT_FALSE(model.playing());
    EXPECT_EQ(model.frame(), 1);
    model.step(-1);
    EXPECT_EQ(model.frame(), 6);
    EXPECT_TRUE(model.take_cut());
    model.scrub(99);
    EXPECT_EQ(model.frame(), 6);
    EXPECT_FALSE(model.take_cut() && model.frame() != 6);
    model.scrub(-5);
    EXPECT_EQ(model.frame(), 1);
    EXPECT_TRUE(model.take_cut());
}

TEST(ViewerModel, values_are_clamped_and_rounded_and_reset_to_the_preset) {
    Model model = make_model("motion-blur");
    EffectSlot& blur = slot(model, "motion-blur");
    const ParameterTable& table = *blur.link.effect->parameters;
    for (const ParameterInfo& info : table.parameters) {
        model.set_value(blur, info, info.maximum * 2.0 + 1.0);
        EXPECT_EQ(info.get(blur.link.parameters.data()), static_cast<float>(info.maximum)) << info.name;
        model.set_value(blur, info, info.minimum - 1.0);
        EXPECT_EQ(info.get(blur.link.parameters.data()), static_cast<float>(info.minimum)) << info.name;
        model.set_value(blur, info, std::nan(""));
        EXPECT_TRUE(validate_parameters(table, blur.link.parameters.data())) << info.name;
        model.reset_value(blur, info);
        EXPECT_FALSE(model.is_changed(blur, info)) << info.name;
    }
    const ParameterInfo& taps = *table.find("taps");
    model.set_value(blur, taps, 11.6);
    EXPECT_EQ(value(blur, "taps"), 12.0);
    ASSERT_TRUE(model.choose_preset(blur, "low"));
    const double low = value(blur, "taps");
    model.set_value(blur, taps, low + 1.0);
    EXPECT_TRUE(model.is_changed(blur, taps));
    model.reset_value(blur, taps);
    EXPECT_EQ(value(blur, "taps"), low);
    EXPECT_FALSE(model.choose_preset(blur, "lowest"));
    EXPECT_EQ(blur.link.preset, "low");
}

TEST(ViewerModel, a_preset_leaves_the_view_of_the_inside_alone) {
    Model model = make_model("motion-blur");
    EffectSlot& blur = slot(model, "motion-blur");
    model.set_value(blur, *blur.link.effect->parameters->find("debug_view"), 2.0);
    ASSERT_TRUE(model.choose_preset(blur, "high"));
    EXPECT_EQ(value(blur, "debug_view"), 2.0);
}

// The chain that render makes of the same options is the viewer's, and what is chosen by hand stays.
TEST(ViewerModel, a_model_chooses_what_render_chooses) {
    const cli::SceneFit fit{0.25};
    const auto adapted = [&](const cli::ChainOptions& options) {
        auto model = Model::create(options);
        EXPECT_TRUE(model) << (model ? "" : model.error().message);
        model->adapt(options, fit);
        auto chain = cli::make_chain(options);
        EXPECT_TRUE(chain);
        cli::adapt_chain(*chain, options, fit);
        EXPECT_EQ(cli::parameters_text(model->effects().front().link), cli::parameters_text(chain->front()));
        return *model;
    };
    Model model = adapted({"ambient-occlusion", "", {}, ""});
    EffectSlot& occlusion = slot(model, "ambient-occlusion");
    const ParameterInfo& radius = *occlusion.link.effect->parameters->find("radius");
    EXPECT_FLOAT_EQ(static_cast<float>(value(occlusion, "radius")), 0.125f);
    EXPECT_EQ(value(occlusion, "application"), 1.0) << "of the ambient light alone";
    EXPECT_FALSE(model.is_changed(occlusion, radius));
    model.set_value(occlusion, radius, 1.5); // the table's default is a choice as well
    EXPECT_TRUE(model.is_changed(occlusion, radius));
    EXPECT_TRUE(has(words(model.command_line({64, 36}, "out.png")), "ambient-occlusion.radius=1.5"));
    model.reset_value(occlusion, radius);
    EXPECT_FLOAT_EQ(static_cast<float>(value(occlusion, "radius")), 0.125f);
    ASSERT_TRUE(model.choose_preset(occlusion, "high"));
    EXPECT_FLOAT_EQ(static_cast<float>(value(occlusion, "radius")), 0.125f);
    // Named on the command line: kept, until a preset takes its place.
    Model by_hand = adapted({"ambient-occlusion", "", {"radius=1.5"}, ""});
    EXPECT_EQ(value(slot(by_hand, "ambient-occlusion"), "radius"), 1.5);
    ASSERT_TRUE(by_hand.choose_preset(slot(by_hand, "ambient-occlusion"), "high"));
    EXPECT_FLOAT_EQ(static_cast<float>(value(slot(by_hand, "ambient-occlusion"), "radius")), 0.125f);
    // Effects that are off are ready as well; a built-in scene leaves lengths alone.
    Model other = adapted({"motion-blur", "", {}, ""});
    EXPECT_FLOAT_EQ(static_cast<float>(value(slot(other, "ambient-occlusion"), "radius")), 0.125f);
    Model builtin = make_model("ambient-occlusion");
    builtin.adapt({}, {});
    EXPECT_EQ(value(slot(builtin, "ambient-occlusion"), "radius"), 1.5);
    EXPECT_EQ(value(slot(builtin, "ambient-occlusion"), "application"), 1.0);
    // A file is whole.
    const auto path = std::filesystem::temp_directory_path() / ("sfumato-adapt-" + std::to_string(getpid()) + ".toml");
    ASSERT_TRUE(make_model("ambient-occlusion").save(path));
    Model loaded = adapted({"ambient-occlusion", "", {}, path.string()});
    EXPECT_EQ(value(slot(loaded, "ambient-occlusion"), "radius"), 1.5);
    std::filesystem::remove(path);
}

TEST(ViewerModel, effects_change_places) {
    Model model = make_model("motion-blur,ambient-occlusion");
    model.move_effect(1, -1);
    EXPECT_STREQ(model.effects()[0].link.effect->name, "ambient-occlusion");
    EXPECT_STREQ(model.request({64, 36}).chain.front().effect->name, "ambient-occlusion");
    model.move_effect(0, -3); // as far as it goes
    model.move_effect(7, 1);
    EXPECT_STREQ(model.effects()[0].link.effect->name, "ambient-occlusion");
    model.move_effect(0, 100);
    EXPECT_STREQ(model.effects().back().link.effect->name, "ambient-occlusion");
}

TEST(ViewerModel, requests_differ_where_pictures_do) {
    Model model = make_model("motion-blur");
    const auto key = [&] { return model.request({64, 36}).key(); };
    std::set<std::string> keys = {key()};
    const auto differs = [&] { return keys.insert(key()).second; };
    model.exposure = 2.0; // only shown differently
    model.divider = 0.2;
    EXPECT_FALSE(differs());
    model.step(1);
    EXPECT_TRUE(differs());
    model.set_value(slot(model, "motion-blur"), *slot(model, "motion-blur").link.effect->parameters->find("taps"), 33);
    EXPECT_TRUE(differs());
    model.samples = 3;
    EXPECT_TRUE(differs());
    model.move_camera({}).orbit(10, 0);
    EXPECT_TRUE(differs());
    model.right = "shadow";
    EXPECT_TRUE(differs());
    slot(model, "motion-blur").enabled = false;
    EXPECT_TRUE(differs());
    EXPECT_NE(model.request({65, 36}).key(), key());
}

TEST(ViewerModel, pictures_are_those_of_the_scene_and_of_the_effects_that_are_on) {
    Model model = make_model("ambient-occlusion");
    EXPECT_TRUE(has(ids(model), "ambient-occlusion.visibility"));
    EXPECT_FALSE(has(ids(model), "motion-blur.output"));
    EXPECT_TRUE(has(ids(model), "velocity"));
    EXPECT_FALSE(has(ids(model), "truth"));
    EXPECT_FALSE(has(ids(model), "frozen"));
    model.truth.kind = TruthKind::occlusion;
    EXPECT_TRUE(has(ids(model), "difference"));
    EXPECT_EQ(model.compared_picture(), "ambient-occlusion.visibility");
    model.right = "ambient-occlusion.bent_normal";
    EXPECT_EQ(model.picture(model.right).kind, PictureKind::normal);
    const auto outputs = model.request({64, 36}).chain.front().outputs;
    EXPECT_TRUE(has(outputs, "output") && has(outputs, "visibility") && has(outputs, "bent_normal"));
    slot(model, "ambient-occlusion").enabled = false;
    EXPECT_EQ(model.picture(model.right).id, "result"); // what is shown is gone
    EXPECT_EQ(model.truth_effect(), nullptr);
}

TEST(ViewerModel, an_effect_that_leaves_the_picture_alone_makes_its_plane) {
    Model model = make_model("ambient-occlusion", "", {"application=none"});
    EXPECT_EQ(model.request({64, 36}).chain.front().outputs, std::vector<std::string>{"visibility"});
}

TEST(ViewerModel, history_takes_preroll) {
    Model model = make_model("ambient-occlusion");
    EXPECT_EQ(model.request({64, 36}).preroll, 0);
    EffectSlot& occlusion = slot(model, "ambient-occlusion");
    model.set_value(occlusion, *occlusion.link.effect->parameters->find("temporal"), 1.0);
    EXPECT_EQ(model.request({64, 36}).preroll, 8);
}

TEST(ViewerModel, parameters_go_to_a_file_and_come_back) {
    const auto path = std::filesystem::temp_directory_path() / ("sfumato-viewer-" + std::to_string(getpid()) + ".toml");
    Model model = make_model("motion-blur", "", {"taps=31"});
    ASSERT_TRUE(model.save(path));
    Model other = make_model("ambient-occlusion");
    ASSERT_TRUE(other.load(path));
    EXPECT_EQ(value(slot(other, "motion-blur"), "taps"), 31.0);
    EXPECT_TRUE(slot(other, "ambient-occlusion").enabled);
    std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2 + 1);
    ASSERT_FALSE(make_model().load(path.string() + ".none"));
    std::filesystem::remove(path);
}

std::string after(const std::vector<std::string>& list, const std::string& name) {
    const auto found = std::find(list.begin(), list.end(), name);
    return found == list.end() || found + 1 == list.end() ? "" : *(found + 1);
}

TEST(ViewerCommand, says_what_differs_from_the_preset_and_no_more) {
    Model model = make_model("ambient-occlusion,motion-blur", "motion-blur=low", {"motion-blur.shutter=0.25"});
    model.step(-1);
    const auto command = words(model.command_line({320, 180}, "out.png"));
    EXPECT_EQ(command[0], "sfumato");
    EXPECT_EQ(command[1], "render");
    EXPECT_EQ(command[2], "still");
    EXPECT_EQ(after(command, "--frames"), "2");
    EXPECT_EQ(after(command, "--size"), "320x180");
    EXPECT_EQ(after(command, "--effects"), "ambient-occlusion,motion-blur");
    EXPECT_EQ(after(command, "--preset"), "motion-blur=low");
    EXPECT_TRUE(has(command, "motion-blur.shutter=0.25"));
    // What render would choose by itself is told as well.
    EXPECT_TRUE(has(command, "ambient-occlusion.application=everything"));
    EXPECT_EQ(std::count(command.begin(), command.end(), "--set"), 4); // and both radii
    EXPECT_EQ(after(command, "--outputs"), "colour");
    EXPECT_EQ(after(command, "--viewpoint"), "");
    EXPECT_EQ(command.back(), "out.png");
    // The same chain comes out of what the command says.
    std::vector<std::string> settings;
    for (size_t i = 0; i + 1 < command.size(); ++i)
        if (command[i] == "--set")
            settings.push_back(command[i + 1]);
    const auto chain = cli::make_chain({after(command, "--effects"), after(command, "--preset"), settings, ""});
    ASSERT_TRUE(chain);
    for (size_t i = 0; i < chain->size(); ++i)
        EXPECT_EQ(cli::parameters_text((*chain)[i]), cli::parameters_text(model.effects()[i].link));
}

TEST(ViewerCommand, follows_the_picture_on_the_right) {
    Model model = make_model("ambient-occlusion");
    const auto command = [&](const std::string& right) {
        model.right = right;
        return words(model.command_line({64, 36}, "out.png"));
    };
    EXPECT_EQ(after(command("before"), "--effects"), "");
    EXPECT_EQ(after(command("ambient-occlusion.visibility"), "--outputs"), "visibility");
    EXPECT_TRUE(has(command("velocity"), "--passes"));
    EXPECT_EQ(command("velocity").back(), "out.exr");
    model.truth.kind = TruthKind::occlusion;
    EXPECT_EQ(after(command("truth"), "--truth"), "ambient-occlusion");
}

TEST(ViewerCommand, a_moved_camera_is_the_one_that_is_rendered) {
    Model model = make_model();
    EXPECT_FALSE(model.viewpoint());
    model.move_camera({{1.23456789, 2, 7}, {0.1, -0.2, -1}, {0, 1, 0}, 33.0}).orbit(17.77, -4.4);
    ASSERT_TRUE(model.viewpoint());
    const auto text = after(words(model.command_line({64, 36}, "out.png")), "--viewpoint");
    const auto view = cli::parse_viewpoint(text, 40.0);
    ASSERT_TRUE(view) << text;
    EXPECT_TRUE(same_view(*view, *model.viewpoint()));
    EXPECT_NEAR(view->eye.x, model.camera().view().eye.x, 1e-5);
    model.set_camera_mode(CameraMode::scene, {});
    EXPECT_FALSE(model.viewpoint());
}

TEST(ViewerCommand, viewpoints_that_are_none) {
    for (const char* text : {"", "1,2,3", "1,2,3,4,5,6,7,8", "a,b,c,d,e,f", "0,0,0,0,0,0", "0,0,0,0,5,0",
                             "1,2,3,4,5,6,0", "1,2,3,4,5,6x", "1,2,3,4,5,", "nan,0,0,1,1,1", "1e300,0,0,1,1,1"})
        EXPECT_FALSE(cli::parse_viewpoint(text, 40.0)) << text;
    const auto view = cli::parse_viewpoint("1,2,3,1,2,0", 41.0);
    ASSERT_TRUE(view);
    EXPECT_EQ(view->forward.z, -3.0);
    EXPECT_EQ(view->view_angle, 41.0);
}

TEST(ViewerCamera, orbit_keeps_the_pivot_and_fly_moves_it) {
    using namespace scene;
    const View start = {{0, 1, 6}, {0, 0, -1}, {0, 1, 0}, 40.0};
    const Bounds bounds = {{0, 1, 0}, 2.0};
    CameraRig rig(start, bounds);
    EXPECT_DOUBLE_EQ(rig.distance(), 6.0);
    const auto pivot = [&] { return rig.view().eye + rig.view().forward * rig.distance(); };
    rig.orbit(90, 0);
    EXPECT_NEAR(rig.view().eye.x, -6.0, 1e-9); // dragged to the right: what is seen turns to the right
    rig.orbit(13, -500);
    EXPECT_NEAR(pivot().y, 1.0, 1e-9);
    EXPECT_LT(std::abs(rig.view().forward.y), 1.0); // never straight down
    rig.approach(0.5);
    EXPECT_NEAR(rig.distance(), 3.0, 1e-9);
    EXPECT_NEAR(pivot().x, 0.0, 1e-9);
    const Vec3 before = rig.view().eye;
    rig.fly(0, 0, 2.0);
    const Vec3 way = rig.view().eye - before;
    EXPECT_NEAR(std::sqrt(dot(way, way)), 2.0, 1e-9);
    EXPECT_NEAR(dot(way, rig.view().forward), 2.0, 1e-9);
    for (int i = 0; i < 500; ++i)
        rig.approach(0.5);
    EXPECT_GT(rig.distance(), 0.0);
}

TEST(ViewerCamera, what_is_dragged_follows_the_mouse) {
    using namespace scene;
    CameraRig rig({{0, 0, 5}, {0, 0, -1}, {0, 1, 0}, 40.0}, {{0, 0, 0}, 1.0});
    // The pivot's place on screen after a pan by a tenth of the height to the right and two down.
    rig.pan(0.1, 0.2);
    const Camera camera = camera_of(rig.view(), Lens{}, {100, 100});
    const auto& m = camera.world_to_view;
    const double x = static_cast<double>(m[12]), y = static_cast<double>(m[13]), z = static_cast<double>(-m[14]);
    EXPECT_NEAR(x / z * static_cast<double>(camera.projection[0]) / 2.0, 0.1, 1e-5);
    EXPECT_NEAR(y / z * static_cast<double>(camera.projection[5]) / 2.0, 0.2, 1e-5);
}

TEST(ViewerCamera, the_path_of_a_moved_camera_passes_both_views) {
    const scene::View a = {{0, 1, 5}, {0, 0, -1}, {0, 1, 0}, 40.0}, b = {{1, 1, 5}, {-0.1, 0, -1}, {0, 1, 0}, 40.0};
    const auto path = moving_camera(a, b, 7);
    EXPECT_TRUE(same_view(path(6), a));
    EXPECT_TRUE(same_view(path(7), b));
    EXPECT_NEAR(path(6.5).eye.x, 0.5, 1e-12);
    EXPECT_NEAR(path(8).eye.x, 2.0, 1e-12);
    const auto still = moving_camera(b, b, 7);
    for (const double time : {6.0, 6.3, 7.0, 8.0})
        EXPECT_TRUE(same_view(still(time), b)) << time;
}

TEST(ViewerTruth, slices_are_the_shutter_in_parts) {
    scene::Shutter shutter;
    shutter.open = 0.8;
    shutter.position = scene::ShutterPosition::end;
    shutter.sub_frames = 32;
    const auto slices = shutter_slices(5, shutter, 8);
    std::set<double> starts;
    double together = 0.0;
    int share = 0;
    for (const TruthSlice& slice : slices) {
        starts.insert(slice.frame);
        EXPECT_EQ(slice.options.shutter.position, scene::ShutterPosition::start);
        together += slice.options.shutter.open;
        share += slice.share;
    }
    EXPECT_EQ(starts.size(), 8u);
    EXPECT_NEAR(*starts.begin(), 4.2, 1e-12);
    EXPECT_NEAR(*starts.rbegin(), 4.9, 1e-12);
    EXPECT_NEAR(together, 0.8, 1e-12);
    EXPECT_EQ(share, 32);
    // The second is far from the first: early means see most of the shutter.
    EXPECT_NEAR(slices[1].frame - slices[0].frame, 0.4, 1e-12);
    std::set<uint32_t> seeds;
    for (const TruthSlice& slice : ray_slices(5, {}, 16))
        seeds.insert(slice.options.occlusion.seed);
    EXPECT_EQ(seeds.size(), 16u);
}

TEST(ViewerTimes, median_least_and_most) {
    TimeSeries series;
    EXPECT_EQ(series.median(), 0.0);
    for (const double value : {5.0, 1.0, 3.0})
        series.add(value);
    EXPECT_EQ(series.median(), 3.0);
    series.add(100.0);
    EXPECT_EQ(series.median(), 4.0);
    EXPECT_EQ(series.minimum(), 1.0);
    EXPECT_EQ(series.maximum(), 100.0);
    for (size_t i = 0; i < TimeSeries::most; ++i)
        series.add(2.0);
    EXPECT_EQ(series.values().size(), TimeSeries::most);
    EXPECT_EQ(series.maximum(), 2.0);
}

TEST(ViewerTimes, passes_that_are_gone_are_forgotten) {
    PassTimes times;
    times.add({{"scene", "a", 1.0}, {"blur", "b", 2.0}, {"blur", "b", 3.0}});
    times.add({{"scene", "a", 3.0}, {"blur", "b", 5.0}, {"blur", "c", 1.0}});
    ASSERT_EQ(times.rows().size(), 3u);
    EXPECT_EQ(times.rows()[1].series.values(), (std::vector<float>{5.0f, 5.0f})); // both runs of b together
    EXPECT_EQ(times.totals()[1].second.values(), (std::vector<float>{5.0f, 6.0f}));
    times.add({{"scene", "a", 1.0}});
    EXPECT_EQ(times.rows().size(), 1u);
    EXPECT_EQ(times.rows()[0].series.values().size(), 3u);
}

} // namespace
} // namespace sfumato::viewer
