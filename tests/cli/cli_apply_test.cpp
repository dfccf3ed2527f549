// sfumato apply on small sequences: files, order, what is kept, what is skipped.
#include "tests/cli/program.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace sfumato::cli_tests {

using CliApply = ProgramTest;

namespace {

media::ExrImage load(const std::filesystem::path& path) {
    auto image = media::read_exr(path);
    EXPECT_TRUE(image) << (image ? "" : image.error().message);
    return image ? std::move(*image) : media::ExrImage{};
}

} // namespace

TEST_F(CliApply, blurs_a_sequence_and_keeps_the_rest) {
    write_frames(1, 4);
    const ProgramResult result =
        run({"apply", "motion-blur", "shot.####.exr", "-o", "made/here/blur.%04d.exr", "--preset", "high"});
    ASSERT_EQ(result.code, 0) << result.error;
    EXPECT_EQ(result.error, "");
    EXPECT_NE(result.out.find("shot.0001.exr -> made/here/blur.0001.exr\nshot.0002.exr"), std::string::npos)
        << result.out;
    const media::ExrImage before = load(path("shot.0002.exr")), after = load(path("made/here/blur.0002.exr"));
    ASSERT_EQ(after.parts.size(), 1u);
    const media::ExrPart &in = before.parts[0], &out = after.parts[0];
    ASSERT_EQ(in.channels.size(), out.channels.size());
    for (const media::ExrChannel& channel : in.channels) {
        const media::ExrChannel* other = out.find_channel(channel.name);
        ASSERT_NE(other, nullptr) << channel.name;
        const bool is_colour = channel.name.starts_with("View.Combined.");
        EXPECT_EQ(other->type, is_colour ? media::PixelType::half : channel.type) << channel.name;
        EXPECT_TRUE(is_colour || other->values == channel.values) << channel.name;
    }
    // The square's edge smears; far from it nothing changes but the rounding to half.
    const auto& sharp = in.find_channel("View.Combined.R")->values;
    const auto& blurred = out.find_channel("View.Combined.R")->values;
    double changed = 0.0, still = 0.0;
    for (size_t i = 0; i < sharp.size(); ++i)
        (i % 96 > 70 ? still : changed) =
            std::max(i % 96 > 70 ? still : changed, std::abs(double{sharp[i]} - blurred[i]));
    EXPECT_GT(changed, 0.1);
    EXPECT_LT(still, 0.001);
    EXPECT_EQ(out.string_attribute("artist"), "somebody");
    EXPECT_EQ(out.string_attribute("sfumato/command"),
              "sfumato apply motion-blur shot.####.exr -o made/here/blur.%04d.exr --preset high");
    EXPECT_NE(out.string_attribute("sfumato/motion-blur").value_or("").find("shutter=0.5"), std::string::npos);
}

TEST_F(CliApply, same_bytes_every_time) {
    write_frames(1, 6);
    std::vector<std::string> first;
    for (int turn = 0; turn < 3; ++turn) {
        // Another number of frames must not change a frame either.
        std::vector<std::string> arguments = {"apply", "motion-blur", "shot.####.exr", "-o", "out.####.exr", "-q"};
        const ProgramResult result = run(arguments);
        ASSERT_EQ(result.code, 0) << result.error;
        EXPECT_EQ(result.out + result.error, "");
        std::vector<std::string> bytes;
        for (int frame = 1; frame <= 6; ++frame)
            bytes.push_back(read("out.000" + std::to_string(frame) + ".exr"));
        if (turn == 0)
            first = bytes;
        EXPECT_EQ(bytes, first) << "turn " << turn;
    }
    const media::ExrImage all = load(path("out.0004.exr"));
    ASSERT_EQ(run({"apply", "motion-blur", "shot.0004.exr", "-o", "one.exr"}).code, 0);
    const media::ExrImage one = load(path("one.exr"));
    EXPECT_EQ(all.parts[0].find_channel("View.Combined.R")->values,
              one.parts[0].find_channel("View.Combined.R")->values);
}

TEST_F(CliApply, frame_ranges_and_shell_expansion) {
    write_frames(1, 5);
    ASSERT_EQ(run({"apply", "motion-blur", "shot.####.exr", "-o", "a.####.exr", "--frames", "1-5x2"}).code, 0);
    ASSERT_EQ(
        run({"apply", "motion-blur", "shot.0002.exr", "shot.0004.exr", "-o", "b.####.exr", "--preroll", "2"}).code, 0);
    for (const char* name : {"a.0001.exr", "a.0003.exr", "a.0005.exr", "b.0002.exr", "b.0004.exr"})
        EXPECT_TRUE(exists(name)) << name;
    EXPECT_EQ(files().size(), 10u);
}

TEST_F(CliApply, float_and_png) {
    write_frames(1, 1);
    ASSERT_EQ(run({"apply", "motion-blur", "shot.0001.exr", "-o", "out.exr", "--float"}).code, 0);
    EXPECT_EQ(load(path("out.exr")).parts[0].find_channel("View.Combined.R")->type, media::PixelType::float32);
    ASSERT_EQ(run({"apply", "motion-blur", "shot.0001.exr", "-o", "out.png"}).code, 0);
    EXPECT_EQ(read("out.png").substr(1, 3), "PNG");
    const ProgramResult same = run({"compare", "out.png", "out.exr", "--psnr-min", "50"});
    EXPECT_EQ(same.code, 0) << same.out;
}

TEST_F(CliApply, skips_bad_frames) {
    write_frames(1, 5);
    const std::string whole = read("shot.0003.exr");
    write("shot.0003.exr", whole.substr(0, whole.size() - 100));
    const ProgramResult stopped = run({"apply", "motion-blur", "shot.####.exr", "-o", "a.####.exr"});
    EXPECT_EQ(stopped.code, 3);
    EXPECT_EQ(stopped.error_lines(), 1u) << stopped.error;
    EXPECT_NE(stopped.error.find("shot.0003.exr"), std::string::npos) << stopped.error;
    // Everything before the bad frame is there, whole; nothing after it.
    EXPECT_TRUE(exists("a.0001.exr") && exists("a.0002.exr"));
    EXPECT_FALSE(exists("a.0003.exr") || exists("a.0004.exr"));
    const ProgramResult skipped =
        run({"apply", "motion-blur", "shot.####.exr", "-o", "b.####.exr", "--frames", "1-6", "--skip-bad-frames"});
    EXPECT_EQ(skipped.code, 3);
    EXPECT_NE(skipped.error.find("skipped: shot.0003.exr"), std::string::npos) << skipped.error;
    EXPECT_NE(skipped.error.find("skipped: shot.0006.exr"), std::string::npos) << skipped.error;
    EXPECT_NE(skipped.error.find("sfumato: 2 of 6 frames were skipped, 4 written"), std::string::npos) << skipped.error;
    EXPECT_TRUE(exists("b.0002.exr") && exists("b.0004.exr") && exists("b.0005.exr"));
    for (const std::string& name : files())
        EXPECT_EQ(name.find(".tmp"), std::string::npos) << name;
}

TEST_F(CliApply, writing_fails_in_the_middle) {
    write_frames(1, 6);
    std::filesystem::create_directory(path("out.0003.exr"));
    expect_error({"apply", "motion-blur", "shot.####.exr", "-o", "out.####.exr"}, 3, {"out.0003.exr"});
    EXPECT_TRUE(exists("out.0001.exr") && exists("out.0002.exr"));
    EXPECT_FALSE(exists("out.0004.exr"));
    for (const std::string& name : files())
        EXPECT_EQ(name.find(".tmp"), std::string::npos) << name;
}

TEST_F(CliApply, depth_is_optional_and_cameras_stand_in_for_vectors) {
    FrameOptions flat;
    flat.depth = false;
    write_frames(1, 1, flat);
    const ProgramResult result = run({"apply", "motion-blur", "shot.0001.exr", "-o", "out.exr"});
    EXPECT_EQ(result.code, 0);
    EXPECT_NE(result.error.find("warning: shot.0001.exr: no depth channel"), std::string::npos) << result.error;
    FrameOptions camera;
    camera.motion = false;
    camera.camera = true;
    write_frames(1, 3, camera);
    const ProgramResult verbose = run({"apply", "motion-blur", "shot.0002.exr", "-o", "moved.exr", "-v"});
    ASSERT_EQ(verbose.code, 0) << verbose.error;
    EXPECT_NE(verbose.error.find("camera, previous camera, next camera"), std::string::npos) << verbose.error;
    const ProgramResult compared = run({"compare", "moved.exr", "shot.0002.exr", "--psnr-min", "40"});
    EXPECT_EQ(compared.code, 1) << "the camera's motion must blur: " << compared.out;
}

TEST_F(CliApply, warns_of_a_wrong_convention) {
    FrameOptions large;
    large.width = 240;
    large.height = 160;
    large.background = 0.3f;
    write_frames(1, 3, large);
    const ProgramResult right = run({"apply", "motion-blur", "shot.0002.exr", "-o", "out.exr", "-v"});
    EXPECT_EQ(right.code, 0);
    EXPECT_NE(right.error.find("warp check: confirmed"), std::string::npos) << right.error;
    const ProgramResult wrong =
        run({"apply", "motion-blur", "shot.0002.exr", "-o", "out.exr", "--motion-convention", "blender,flip-x"});
    EXPECT_EQ(wrong.code, 0);
    EXPECT_NE(wrong.error.find("looks wrong"), std::string::npos) << wrong.error;
    EXPECT_NE(wrong.error.find("--motion-convention blender "), std::string::npos) << wrong.error;
}

TEST_F(CliApply, dry_run_and_json) {
    write_frames(1, 2);
    const ProgramResult dry = run({"apply", "motion-blur", "shot.####.exr", "-o", "out.####.exr", "-n"});
    EXPECT_EQ(dry.code, 0);
    EXPECT_NE(dry.out.find("would make shot.0002.exr -> out.0002.exr"), std::string::npos) << dry.out;
    EXPECT_EQ(files().size(), 2u);
    const ProgramResult made = run({"apply", "motion-blur", "shot.####.exr", "-o", "out.####.exr", "--json"});
    EXPECT_EQ(made.code, 0);
    const auto json = nlohmann::json::parse(made.out, nullptr, false);
    ASSERT_FALSE(json.is_discarded()) << made.out;
    EXPECT_EQ(json["written"], 2);
    EXPECT_EQ(json["motion_convention"], "blender");
    EXPECT_EQ(json["outputs"][1], "out.0002.exr");
}

TEST_F(CliApply, windows_stay) {
    media::ExrImage image = make_frame(1);
    image.parts[0].data_window = {-5, 7, 90, 70};
    image.parts[0].display_window = {0, 0, 79, 79};
    image.parts[0].pixel_aspect = 2.0f;
    ASSERT_TRUE(media::write_exr(path("shot.exr"), image));
    ASSERT_EQ(run({"apply", "motion-blur", "shot.exr", "-o", "out.exr"}).code, 0);
    const media::ExrImage out = load(path("out.exr"));
    EXPECT_EQ(out.parts[0].data_window, image.parts[0].data_window);
    EXPECT_EQ(out.parts[0].display_window, image.parts[0].display_window);
    EXPECT_EQ(out.parts[0].pixel_aspect, 2.0f);
}

TEST_F(CliApply, roles_by_name) {
    media::ExrImage image = make_frame(1);
    image.parts[0].set_channel("View.exclusion_mask.R", std::vector<float>(96 * 64, 1.0f));
    ASSERT_TRUE(media::write_exr(path("shot.exr"), image));
    ASSERT_EQ(run({"apply", "motion-blur", "shot.exr", "-o", "out.exr", "--float"}).code, 0);
    EXPECT_EQ(run({"compare", "out.exr", "shot.exr", "--error-max", "0"}).code, 0) << "all is excluded from the blur";
}

TEST_F(CliApply, several_parts) {
    const media::ExrImage whole = make_frame(1);
    ASSERT_TRUE(media::write_exr(path("whole.exr"), whole));
    // Colour in one part; depth and motion in another, whose window misses the still columns at the right.
    media::ExrImage image;
    image.parts.resize(2);
    for (media::ExrPart& part : image.parts)
        part.display_window = whole.parts[0].display_window;
    media::ExrPart &beauty = image.parts[0], &data = image.parts[1];
    beauty.name = "beauty";
    beauty.data_window = whole.parts[0].data_window;
    data.name = "data";
    data.data_window = {0, 0, 79, 63};
    for (const media::ExrChannel& channel : whole.parts[0].channels) {
        const std::string name = channel.name.substr(5);
        if (name.starts_with("Combined")) {
            beauty.set_channel(name.substr(9), channel.values, channel.type);
            continue;
        }
        std::vector<float> cut;
        for (size_t i = 0; i < channel.values.size(); ++i)
            if (i % 96 < 80)
                cut.push_back(channel.values[i]);
        data.set_channel(name, cut, channel.type);
    }
    ASSERT_TRUE(media::write_exr(path("parts.exr"), image));
    ASSERT_EQ(run({"apply", "motion-blur", "whole.exr", "-o", "a.exr"}).code, 0);
    const ProgramResult result = run({"apply", "motion-blur", "parts.exr", "-o", "b.exr"});
    ASSERT_EQ(result.code, 0) << result.error;
    const media::ExrImage out = load(path("b.exr"));
    ASSERT_EQ(out.parts.size(), 2u);
    EXPECT_EQ(out.parts[1].data_window, data.data_window);
    const ProgramResult compared = run({"compare", "b.exr", "a.exr", "--error-max", "0"});
    EXPECT_EQ(compared.code, 0) << compared.out;
}

TEST_F(CliApply, negative_frames_and_options_anywhere) {
    for (const int number : {-2, -1, 0}) {
        char name[32];
        std::snprintf(name, sizeof name, "shot.%04d.exr", number);
        ASSERT_TRUE(media::write_exr(path(name), make_frame(number)));
    }
    const ProgramResult result = run({"apply", "--set", "motion-blur.taps=9", "motion-blur", "-q", "shot.%04d.exr",
                                      "--frames=-2--1", "-o", "out.%04d.exr"});
    ASSERT_EQ(result.code, 0) << result.error;
    EXPECT_TRUE(exists("out.-002.exr") && exists("out.-001.exr"));
    EXPECT_FALSE(exists("out.0000.exr"));
}

} // namespace sfumato::cli_tests
