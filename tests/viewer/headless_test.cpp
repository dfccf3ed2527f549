// The viewer without a window: its picture is the one that sfumato render makes, and what is wrong is said in one line.
#include "tests/cli/program.h"
#include "tests/viewer/display.h"

namespace sfumato::viewer_tests {
namespace {

using cli_tests::ProgramResult;

class ViewerHeadless : public cli_tests::ProgramTest {
  protected:
    // The picture of a viewer without a window, under validation.
    Pixels view(std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), "view");
        arguments.insert(arguments.end(), {"--headless", "--validate", "-o", "view.png"});
        const ProgramResult result = run(arguments);
        EXPECT_EQ(result.code, 0) << result.error;
        return read_png(path("view.png"));
    }

    Pixels render(std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), "render");
        arguments.insert(arguments.end(), {"-o", "render.png"});
        const ProgramResult result = run(arguments);
        EXPECT_EQ(result.code, 0) << result.error;
        return read_png(path("render.png"));
    }
};

constexpr int width = 160, height = 90;
const std::string size = "160x90";

void expect_same(const Pixels& a, const Pixels& b, int tolerance) {
    ASSERT_EQ(a.width, b.width);
    ASSERT_EQ(a.height, b.height);
    EXPECT_LE(compare(a, b, 0, 0, a.width, a.height).largest, tolerance);
}

TEST_F(ViewerHeadless, is_the_picture_of_render) {
    const std::vector<std::string> common = {"fairground",
                                             "--effects",
                                             "ambient-occlusion,motion-blur",
                                             "--set",
                                             "motion-blur.shutter=0.8",
                                             "--set",
                                             "ambient-occlusion.application=everything"};
    auto viewed = common, rendered = common;
    viewed.insert(viewed.end(), {"--size", size, "--frame", "5"});
    rendered.insert(rendered.end(), {"--size", size, "--frames", "5", "--outputs", "colour"});
    const Pixels picture = view(viewed);
    expect_same(picture, render(rendered), 1);
    // Which is not the picture before the effects.
    viewed.insert(viewed.end(), {"--right", "before"});
    EXPECT_GT(compare(picture, view(viewed), 0, 0, width, height).mean, 1.0);
}

TEST_F(ViewerHeadless, history_begins_where_render_begins_it) {
    const std::vector<std::string> common = {"contact", "--effects", "ambient-occlusion", "--preset", "soma",
                                             "--size",  size,        "--preroll",         "3"};
    auto viewed = common, rendered = common;
    viewed.insert(viewed.end(), {"--right", "ambient-occlusion.visibility"});
    rendered.insert(rendered.end(), {"--outputs", "visibility"});
    expect_same(view(viewed), render(rendered), 1);
}

// A wall of two metres on the ground: occlusion reaches as far as render has it, not 1.5 metres.
TEST_F(ViewerHeadless, a_model_looks_as_render_has_it) {
    write("wall.gltf", R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "scene": 0, "nodes": [{"mesh": 0}],
"materials": [{"doubleSided": true}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
"accessors": [
  {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-1, 0, 0], "max": [1, 2, 0]},
  {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}],
"bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
"buffers": [{"byteLength": 60, "uri": "data:application/octet-stream;base64,)"
                       R"(AACAvwAAAAAAAAAAAACAPwAAAAAAAAAAAACAPwAAAEAAAAAAAACAvwAAAEAAAAAAAAABAAIAAAACAAMA"}]})");
    const std::vector<std::string> common = {"wall.gltf", "--effects", "ambient-occlusion", "--size", size};
    const auto with = [&](std::vector<std::string> more) {
        more.insert(more.begin(), common.begin(), common.end());
        return more;
    };
    expect_same(view(with({})), render(with({"--outputs", "colour"})), 1);
    const Pixels picture = view(with({"--right", "ambient-occlusion.visibility"}));
    expect_same(picture, render(with({"--outputs", "visibility"})), 1);
    const Pixels far = view(with({"--right", "ambient-occlusion.visibility", "--set", "ambient-occlusion.radius=1.5"}));
    EXPECT_GT(compare(picture, far, 0, 0, width, height).largest, 8);
}

TEST_F(ViewerHeadless, viewpoint_and_other_pictures) {
    const std::string place = "3,2,5,0,1,0,50";
    const Pixels moved = view({"still", "--effects", "motion-blur", "--size", size, "--viewpoint", place});
    expect_same(moved, render({"still", "--size", size, "--viewpoint", place}), 1);
    const Pixels normals = view({"still", "--size", size, "--right", "normal"});
    const Pixels depth = view({"still", "--size", size, "--right", "depth"});
    EXPECT_GT(compare(normals, depth, 0, 0, width, height).mean, 10.0);
    // Grey is what has one channel.
    for (const auto& pixel : depth.values)
        ASSERT_TRUE(pixel[0] == pixel[1] && pixel[1] == pixel[2]);
}

TEST_F(ViewerHeadless, the_divider_parts_two_pictures) {
    const std::vector<std::string> common = {"fairground", "--effects", "motion-blur", "--size", size};
    auto with = [&](std::vector<std::string> more) {
        more.insert(more.begin(), common.begin(), common.end());
        return view(more);
    };
    const Pixels both = with({"--split", "0.25", "--left", "velocity"});
    const Pixels left = with({"--right", "velocity"}), right = with({});
    EXPECT_EQ(compare(both, left, 0, 0, width / 4 - 2, height).largest, 0);
    EXPECT_EQ(compare(both, right, width / 4 + 2, 0, width * 3 / 4 - 2, height).largest, 0);
    EXPECT_GT(compare(left, right, 0, 0, width / 4, height).mean, 5.0);
}

TEST_F(ViewerHeadless, playing_moves_on_frame_by_frame) {
    const Pixels played =
        view({"fairground", "--effects", "motion-blur", "--size", size, "--frame", "3", "--play", "--frames", "4"});
    expect_same(played, render({"fairground", "--effects", "motion-blur", "--size", size, "--frames", "6"}), 1);
}

TEST_F(ViewerHeadless, truth_is_gathered_turn_by_turn) {
    const std::vector<std::string> common = {"two-trains", "--effects", "motion-blur", "--size", "96x54"};
    const auto with = [&](std::vector<std::string> more) {
        more.insert(more.begin(), common.begin(), common.end());
        return more;
    };
    const auto truth = with({"--truth", "motion-blur", "--right", "truth", "--frames"});
    const auto turns = [&](const char* count) {
        auto arguments = truth;
        arguments.emplace_back(count);
        return arguments;
    };
    // 64 sub-frames in slices of 4.
    const Pixels whole = view(turns("16"));
    expect_same(whole, render({"two-trains", "--size", "96x54", "--truth", "64"}), 1);
    EXPECT_GT(compare(whole, view(turns("2")), 0, 0, 96, 54).largest, 8);
    // The distance that the viewer tells is that of sfumato compare, but for the rounding of the files.
    auto arguments = turns("16");
    arguments.insert(arguments.begin(), "view");
    arguments.insert(arguments.end(), {"--headless", "-o", "view.png"});
    const std::string said = run(arguments).out;
    ASSERT_NE(said.find("RMSE "), std::string::npos) << said;
    EXPECT_NE(said.find("64 of 64"), std::string::npos) << said;
    render(common);
    ASSERT_EQ(run({"render", "two-trains", "--size", "96x54", "--truth", "64", "-o", "truth.png"}).code, 0);
    const std::string compared = run({"compare", "render.png", "truth.png"}).out;
    ASSERT_NE(compared.find("RMSE "), std::string::npos) << compared;
    const auto rmse = [](const std::string& text) { return std::stod(text.substr(text.find("RMSE ") + 5)); };
    EXPECT_NEAR(rmse(said), rmse(compared), 5e-4);
    EXPECT_GT(rmse(said), 5e-3);
}

TEST_F(ViewerHeadless, what_the_picture_lacks_is_told) {
    const auto said = [&](const std::string& room) {
        return run({"view", "smoke-columns", "--effects", "particles", "--size", "96x54", "--headless", "-o",
                    "view.png", "--set", "particles.count=3000", "--set", "particles.radius_end=1", "--set",
                    "particles.pairs_per_particle=" + room})
            .out;
    };
    const std::string narrow = said("1");
    EXPECT_NE(narrow.find("room for 3384"), std::string::npos) << narrow;
    EXPECT_EQ(said("64").find("room for"), std::string::npos);
}

TEST_F(ViewerHeadless, panels_lie_beside_the_picture) {
    const Pixels panels = view({"still", "--effects", "motion-blur", "--size", "800x400", "--scale", "0.25", "--ui"});
    EXPECT_EQ(panels.width, 800);
    EXPECT_EQ(panels.height, 400);
    // Text and widgets: bright pixels on the dark panel.
    int bright = 0;
    for (int y = 0; y < 400; ++y)
        for (int x = 420; x < 800; ++x)
            bright += panels.at(x, y)[1] > 200 ? 1 : 0;
    EXPECT_GT(bright, 300);
}

TEST_F(ViewerHeadless, errors_are_one_line) {
    const std::vector<std::string> headless = {"--headless", "-o", "out.png"};
    const auto fails = [&](std::vector<std::string> arguments, int code, const std::vector<std::string>& parts,
                           const std::vector<std::string>& environment = {}) {
        arguments.insert(arguments.begin(), "view");
        arguments.insert(arguments.end(), headless.begin(), headless.end());
        expect_error(arguments, code, parts, environment);
    };
    fails({"fairgruond"}, 2, {"no scene is called 'fairgruond'", "did you mean 'fairground'?"});
    fails({"still", "--effects", "motion-blurr"}, 2, {"did you mean 'motion-blur'?"});
    fails({"still", "--set", "taps=3"}, 2, {"--effects"});
    fails({"still", "--frame", "99"}, 2, {"--frame 99", "1 to 24"});
    fails({"still", "--right", "velocty"}, 2, {"--right velocty", "did you mean 'velocity'?"});
    fails({"still", "--truth", "ambient-occlusion", "--effects", "motion-blur"}, 2, {"--truth ambient-occlusion"});
    fails({"still", "--viewpoint", "1,2,3"}, 2, {"--viewpoint 1,2,3"});
    fails({"still", "--size", "0x9"}, 2, {"--size 0x9"});
    fails({"still", "--config", "none.toml"}, 3, {"none.toml"});
    fails({"still"}, 4, {"no Vulkan device"}, {"VK_DRIVER_FILES=/dev/null", "VK_ICD_FILENAMES=/dev/null"});
    expect_error({"view", "still", "--headless"}, 2, {"-o picture.png"});
    expect_error({"view", "still", "-o", "out.exr"}, 2, {".png"});
    expect_error({"view", "still"}, 4, {"no display", "--headless -o picture.png"},
                 {"DISPLAY=", "WAYLAND_DISPLAY=", "XDG_SESSION_TYPE="});
    EXPECT_TRUE(files().empty());
}

} // namespace
} // namespace sfumato::viewer_tests
