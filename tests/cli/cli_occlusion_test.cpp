// Ambient occlusion on files and scenes: what is found out, what is written, what is refused.
#include "media/camera_file.h"
#include "tests/cli/program.h"
#include "tests/unit/media_test_support.h"

#include <array>
#include <nlohmann/json.hpp>

namespace sfumato::cli_tests {

using CliOcclusion = ProgramTest;

namespace {

media::ExrImage load(const std::filesystem::path& path) {
    auto image = media::read_exr(path);
    EXPECT_TRUE(image) << (image ? "" : image.error().message);
    return image ? std::move(*image) : media::ExrImage{};
}

double mean_of(const std::vector<float>& values) {
    double sum = 0.0;
    for (const float value : values)
        sum += double{value};
    return sum / static_cast<double>(std::max<size_t>(1, values.size()));
}

// The normals of a rendered scene in world space, as another renderer might write them.
void turn_to_world(media::ExrImage& image, bool is_unsigned = false, double sign = 1.0) {
    media::ExrPart& part = image.parts[0];
    const auto camera = media::camera_from_attributes(part, "test");
    ASSERT_TRUE(camera && *camera);
    const Matrix4& m = (*camera)->world_to_view;
    std::array<std::vector<float>, 3> turned;
    const char* names[] = {"N.X", "N.Y", "N.Z"};
    const size_t count = part.find_channel("N.X")->values.size();
    for (size_t i = 0; i < count; ++i) {
        std::array<double, 3> v{};
        for (size_t c = 0; c < 3; ++c)
            v[c] = double{part.find_channel(names[c])->values[i]};
        const bool is_sky = v[0] == 0.0 && v[1] == 0.0 && v[2] == 0.0;
        for (size_t c = 0; c < 3; ++c) { // the transpose turns back
            const double value = sign * (m[c * 4] * v[0] + m[c * 4 + 1] * v[1] + m[c * 4 + 2] * v[2]);
            turned[c].push_back(static_cast<float>(is_unsigned && !is_sky ? 0.5 * value + 0.5 : value));
        }
    }
    for (size_t c = 0; c < 3; ++c)
        part.set_channel(names[c], turned[c], media::PixelType::half);
    std::erase_if(part.attributes, [](const auto& attribute) { return attribute.name == "sfumato/normals"; });
}

} // namespace

TEST_F(CliOcclusion, adds_visibility_and_leaves_the_picture) {
    ASSERT_EQ(run({"render", "contact", "-o", "shot.exr", "--size", "96x54", "-q"}).code, 0);
    const ProgramResult result = run({"apply", "ambient-occlusion", "shot.exr", "-o", "ao.exr", "--preset", "low"});
    ASSERT_EQ(result.code, 0) << result.error;
    EXPECT_EQ(result.error, "");
    const media::ExrImage before = load(path("shot.exr")), after = load(path("ao.exr"));
    for (const media::ExrChannel& channel : before.parts[0].channels)
        EXPECT_EQ(after.parts[0].find_channel(channel.name)->values, channel.values) << channel.name;
    const media::ExrChannel* visibility = after.parts[0].find_channel("AO");
    ASSERT_NE(visibility, nullptr);
    EXPECT_GT(mean_of(visibility->values), 0.5);
    EXPECT_LT(mean_of(visibility->values), 0.99);
    EXPECT_EQ(after.parts[0].channels.size(), before.parts[0].channels.size() + 1);
    const ProgramResult again = run({"apply", "ambient-occlusion", "ao.exr", "-o", "again.exr", "--preset", "low"});
    EXPECT_EQ(again.code, 0);
    EXPECT_NE(again.error.find("channel AO is replaced"), std::string::npos) << again.error;
}

TEST_F(CliOcclusion, finds_out_the_space_of_normals) {
    ASSERT_EQ(run({"render", "contact", "-o", "view.exr", "--size", "160x90", "-q"}).code, 0);
    ASSERT_EQ(run({"apply", "ambient-occlusion", "view.exr", "-o", "a.exr", "--preset", "low"}).code, 0);
    struct Case {
        bool is_unsigned;
        double sign;
        const char* space;
    };
    for (const Case& one :
         {Case{false, 1.0, "world"}, Case{true, 1.0, "world,unsigned"}, Case{false, -1.0, "world,flipped"}}) {
        media::ExrImage image = load(path("view.exr"));
        turn_to_world(image, one.is_unsigned, one.sign);
        ASSERT_TRUE(media::write_exr(path("world.exr"), image));
        const ProgramResult result =
            run({"apply", "ambient-occlusion", "world.exr", "-o", "b.exr", "--preset", "low", "--json"});
        ASSERT_EQ(result.code, 0) << result.error;
        const auto json = nlohmann::json::parse(result.out, nullptr, false);
        ASSERT_FALSE(json.is_discarded()) << result.out;
        EXPECT_EQ(json["normal_convention"], one.space);
        EXPECT_EQ(result.error.find("read as such") != std::string::npos, std::string(one.space) != "world");
        const ProgramResult same = run({"compare", "b.exr", "a.exr", "--channel", "AO", "--rmse-max", "0.005"});
        EXPECT_EQ(same.code, 0) << one.space << ": " << same.out;
    }
    const ProgramResult inspected = run({"inspect", "world.exr"});
    EXPECT_NE(inspected.out.find("space world,flipped (by values)"), std::string::npos) << inspected.out;
    EXPECT_NE(inspected.out.find("against normals from depth"), std::string::npos) << inspected.out;
}

TEST_F(CliOcclusion, warns_of_a_wrong_space_and_refuses_unknown_words) {
    ASSERT_EQ(run({"render", "contact", "-o", "shot.exr", "--size", "160x90", "-q"}).code, 0);
    const ProgramResult wrong =
        run({"apply", "ambient-occlusion", "shot.exr", "-o", "ao.exr", "--normal-space", "world"});
    EXPECT_EQ(wrong.code, 0);
    EXPECT_NE(wrong.error.find("normal space world looks wrong"), std::string::npos) << wrong.error;
    EXPECT_NE(wrong.error.find("--normal-space view"), std::string::npos) << wrong.error;
    // The parameter says the same as the option.
    const ProgramResult set =
        run({"apply", "ambient-occlusion", "shot.exr", "-o", "ao.exr", "--set", "normal_space=world"});
    EXPECT_NE(set.error.find("normal space world looks wrong"), std::string::npos) << set.error;
    EXPECT_EQ(run({"apply", "ambient-occlusion", "shot.exr", "-o", "ao.exr", "--normal-space", "view"}).error, "");
    expect_error({"apply", "ambient-occlusion", "shot.exr", "-o", "x.exr", "--normal-space", "wolrd"}, 2, {"wolrd"});
    expect_error({"apply", "ambient-occlusion", "shot.exr", "-o", "x.exr", "--outputs", "visibilty"}, 2,
                 {"did you mean 'visibility'?"});
    expect_error({"apply", "ambient-occlusion", "shot.exr", "-o", "x.png", "--outputs", "bent_normal"}, 2, {".exr"});
    EXPECT_FALSE(exists("x.exr") || exists("x.png"));
}

TEST_F(CliOcclusion, says_what_is_missing) {
    write_frames(1, 1);
    expect_error({"apply", "ambient-occlusion", "shot.0001.exr", "-o", "x.exr"}, 3, {"shot.0001.exr", "--camera"});
    FrameOptions flat;
    flat.depth = false;
    flat.camera = true;
    write_frames(1, 1, flat);
    expect_error({"apply", "ambient-occlusion", "shot.0001.exr", "-o", "x.exr"}, 3, {"needs 'depth'"});
    ASSERT_EQ(run({"render", "contact", "-o", "shot.exr", "--size", "96x54", "-q"}).code, 0);
    expect_error({"apply", "ambient-occlusion", "shot.exr", "-o", "x.exr", "--outputs", "soft_shadow"}, 3,
                 {"needs 'shadow'"});
    expect_error({"apply", "ambient-occlusion", "shot.exr", "-o", "x.exr", "--set", "application=ambient"}, 3,
                 {"needs 'ambient'"});
    EXPECT_FALSE(exists("x.exr"));
}

TEST_F(CliOcclusion, writes_what_is_asked_for) {
    ASSERT_EQ(run({"render", "contact", "-o", "shot.exr", "--size", "96x54", "--passes", "-q"}).code, 0);
    ASSERT_EQ(run({"apply", "ambient-occlusion", "shot.exr", "-o", "ao.exr", "--preset", "low", "--outputs",
                   "bent_normal,soft_shadow,colour", "--set", "application=ambient"})
                  .code,
              0);
    const media::ExrImage before = load(path("shot.exr")), after = load(path("ao.exr"));
    const media::ExrPart& part = after.parts[0];
    EXPECT_EQ(part.find_channel("AO"), nullptr);
    for (const char* name : {"bent_normal.X", "bent_normal.Y", "bent_normal.Z", "soft_shadow"})
        EXPECT_NE(part.find_channel(name), nullptr) << name;
    EXPECT_LT(mean_of(part.find_channel("G")->values), mean_of(before.parts[0].find_channel("G")->values));
    // A PNG shows the visibility where the picture is left alone.
    ASSERT_EQ(run({"apply", "ambient-occlusion", "shot.exr", "-o", "ao.png", "--preset", "low"}).code, 0);
    ASSERT_EQ(run({"apply", "ambient-occlusion", "shot.exr", "-o", "low.exr", "--preset", "low"}).code, 0);
    const ProgramResult grey = run({"render", "contact", "-o", "same.png", "--size", "96x54", "--effects",
                                    "ambient-occlusion", "--preset", "low"});
    ASSERT_EQ(grey.code, 0) << grey.error;
    const ProgramResult compared = run({"compare", "ao.png", "same.png", "--psnr-min", "35"});
    EXPECT_EQ(compared.code, 0) << compared.out;
}

TEST_F(CliOcclusion, goes_before_motion_blur) {
    ASSERT_EQ(run({"render", "fairground", "-o", "shot.exr", "--size", "96x54", "-q"}).code, 0);
    ASSERT_EQ(run({"apply", "motion-blur", "shot.exr", "-o", "blur.exr", "--preset", "low"}).code, 0);
    const ProgramResult both =
        run({"apply", "ambient-occlusion,motion-blur", "shot.exr", "-o", "both.exr", "--preset", "low"});
    ASSERT_EQ(both.code, 0) << both.error;
    const media::ExrImage blur = load(path("blur.exr")), image = load(path("both.exr"));
    EXPECT_NE(image.parts[0].find_channel("AO"), nullptr);
    EXPECT_LT(mean_of(image.parts[0].find_channel("R")->values), mean_of(blur.parts[0].find_channel("R")->values));
}

TEST_F(CliOcclusion, history_and_truth_of_scenes) {
    ASSERT_EQ(run({"render", "contact", "-o", "all.####.exr", "--frames", "8-12", "--size", "96x54", "--effects",
                   "ambient-occlusion", "--preset", "soma", "-q"})
                  .code,
              0);
    ASSERT_EQ(run({"render", "contact", "-o", "one.exr", "--size", "96x54", "--effects", "ambient-occlusion",
                   "--preset", "soma", "--preroll", "4", "--truth", "ambient-occlusion", "--truth-rays", "16", "-q"})
                  .code,
              0);
    const ProgramResult same = run({"compare", "one.exr", "all.0012.exr", "--channel", "AO", "--error-max", "0"});
    EXPECT_EQ(same.code, 0) << same.out;
    const ProgramResult truth =
        run({"compare", "one.exr", "one.exr", "--channel", "AO", "--reference-channel", "truth.AO"});
    EXPECT_EQ(truth.code, 0) << truth.error;
    EXPECT_EQ(truth.out.find("RMSE 0.000000"), std::string::npos) << truth.out;
    // Frames from files keep their history as well.
    ASSERT_EQ(run({"render", "contact", "-o", "shot.####.exr", "--frames", "8-12", "--size", "96x54", "-q"}).code, 0);
    ASSERT_EQ(
        run({"apply", "ambient-occlusion", "shot.0012.exr", "-o", "file.exr", "--preset", "soma", "--preroll", "4"})
            .code,
        0);
    const ProgramResult close = run({"compare", "file.exr", "one.exr", "--channel", "AO", "--rmse-max", "0.01"});
    EXPECT_EQ(close.code, 0) << close.out;
}

TEST_F(CliOcclusion, frames_from_blender) {
    SKIP_WITHOUT_KINETIC();
    const std::filesystem::path folder = media::test::kinetic_folder();
    const std::string camera = (folder / "camera.toml").string();
    const ProgramResult result =
        run({"apply", "ambient-occlusion", (folder / "kinetic.0006.exr").string(), "--camera", camera, "--set",
             "ambient-occlusion.radius=1.5", "-o", "out/ao.exr", "--preset", "high"});
    ASSERT_EQ(result.code, 0) << result.error;
    EXPECT_EQ(result.error, "");
    const ProgramResult compared = run(
        {"compare", "out/ao.exr", (folder / "kinetic-ao.0006.exr").string(), "--channel", "AO", "--rmse-max", "0.06"});
    EXPECT_EQ(compared.code, 0) << compared.out;
}

} // namespace sfumato::cli_tests
