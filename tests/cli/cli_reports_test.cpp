// compare, inspect, list, render and help: texts, JSON and exit codes.
#include "tests/cli/program.h"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

namespace sfumato::cli_tests {

using CliCompare = ProgramTest;
using CliInspect = ProgramTest;
using CliList = ProgramTest;
using CliRender = ProgramTest;

namespace {

nlohmann::json parse(const std::string& text) {
    auto json = nlohmann::json::parse(text, nullptr, false);
    EXPECT_FALSE(json.is_discarded()) << text;
    return json;
}

} // namespace

TEST_F(CliCompare, exit_codes) {
    write_frames(1, 2);
    EXPECT_EQ(run({"compare", "shot.0001.exr", "shot.0002.exr"}).code, 0) << "no threshold, no difference";
    EXPECT_EQ(run({"compare", "shot.0001.exr", "shot.0001.exr", "--psnr-min", "100", "--rmse-max", "0", "--ssim-min",
                   "1", "--error-max", "0"})
                  .code,
              0);
    const ProgramResult differs = run({"compare", "shot.0001.exr", "shot.0002.exr", "--psnr-min", "50"});
    EXPECT_EQ(differs.code, 1);
    EXPECT_NE(differs.out.find("is below 50"), std::string::npos) << differs.out;
    EXPECT_EQ(differs.error, "");
    EXPECT_EQ(run({"compare", "shot.0001.exr", "shot.0002.exr", "--rmse-max", "0.001", "-q"}).out, "");
    EXPECT_EQ(run({"compare", "shot.0001.exr", "shot.0002.exr", "--ssim-min", "0.99"}).code, 1);
    expect_error({"compare", "shot.0001.exr", "shot.0002.exr", "--mask", "moving"}, 2, {"--sharp"});
    expect_error({"compare", "shot.0001.exr", "none.exr"}, 3, {"none.exr"});
    FrameOptions small;
    small.width = 50;
    ASSERT_TRUE(media::write_exr(path("small.exr"), make_frame(1, small)));
    expect_error({"compare", "shot.0001.exr", "small.exr"}, 3, {"96x64", "50x64"});
}

TEST_F(CliCompare, regions_difference_and_json) {
    write_frames(1, 3);
    const ProgramResult result = run(
        {"compare", "shot.0003.exr", "shot.0002.exr", "--sharp", "shot.0001.exr", "--json", "--diff", "new/diff.png"});
    ASSERT_EQ(result.code, 0) << result.error;
    const auto json = parse(result.out);
    const auto& regions = json["regions"];
    EXPECT_EQ(regions["moving"]["pixels"].get<int>() + regions["still"]["pixels"].get<int>(), 96 * 64);
    EXPECT_LT(regions["moving"]["psnr"].get<double>(), regions["still"]["psnr"].get<double>());
    EXPECT_TRUE(exists("new/diff.png"));
    // Thresholds judge the region that is asked for.
    const std::string threshold = std::to_string(regions["all"]["psnr"].get<double>());
    for (const auto& [mask, code] : {std::pair("moving", 1), std::pair("still", 0)})
        EXPECT_EQ(run({"compare", "shot.0003.exr", "shot.0002.exr", "--sharp", "shot.0001.exr", "--mask", mask,
                       "--psnr-min", threshold})
                      .code,
                  code)
            << mask;
}

TEST_F(CliCompare, one_channel) {
    write_frames(1, 2);
    const ProgramResult result =
        run({"compare", "shot.0001.exr", "shot.0002.exr", "--channel", "Depth.Z", "--error-max", "4.9"});
    EXPECT_EQ(result.code, 1);
    EXPECT_NE(result.out.find("largest error 5 is above 4.9"), std::string::npos) << result.out;
    expect_error({"compare", "shot.0001.exr", "shot.0002.exr", "--channel", "View.Depth.X"}, 2, {"'View.Depth.Z'?"});
}

TEST_F(CliCompare, not_a_number_is_a_difference) {
    media::ExrImage image = make_frame(1);
    ASSERT_TRUE(media::write_exr(path("a.exr"), image));
    image.parts[0].channels[2].values[5] = std::numeric_limits<float>::quiet_NaN();
    ASSERT_TRUE(media::write_exr(path("b.exr"), image));
    EXPECT_EQ(run({"compare", "b.exr", "a.exr", "--psnr-min", "10"}).code, 1);
    EXPECT_NE(run({"compare", "b.exr", "a.exr"}).out.find("1 NaN or infinite"), std::string::npos);
}

TEST_F(CliInspect, tells_what_it_found) {
    FrameOptions large;
    large.width = 240;
    large.height = 160;
    large.background = 0.3f;
    large.camera = true;
    write_frames(1, 3, large);
    const ProgramResult result = run({"inspect", "shot.0002.exr"});
    ASSERT_EQ(result.code, 0) << result.error;
    for (const char* part : {"240x160", "colour: View.Combined (RGBA)", "depth: View.Depth (Z)",
                             "motion: View.Vector (XYZW)", "convention blender (by name)", "warp check: confirmed",
                             "camera: from worldToCamera", "artist (string) = somebody", "0 NaN, 0 infinite"})
        EXPECT_NE(result.out.find(part), std::string::npos) << "no '" << part << "' in:\n" << result.out;
    const ProgramResult wrong = run({"inspect", "shot.0002.exr", "--motion-convention", "blender,flip-x"});
    EXPECT_NE(wrong.out.find("blender,flip-x is wrong; better: --motion-convention blender\n"), std::string::npos)
        << wrong.out;
    const auto json = parse(run({"inspect", "shot.####.exr", "--json"}).out);
    ASSERT_EQ(json.size(), 3u);
    EXPECT_EQ(json[1]["motion"]["warp_check"]["verdict"], "confirmed");
    EXPECT_EQ(json[1]["motion"]["convention"], "blender");
    EXPECT_EQ(json[1]["values"].size(), 9u);
}

TEST_F(CliInspect, counts_what_is_not_finite) {
    media::ExrImage image = make_frame(1);
    for (media::ExrChannel& channel : image.parts[0].channels)
        if (channel.name == "View.Depth.Z") {
            channel.values[3] = std::numeric_limits<float>::quiet_NaN();
            channel.values[4] = std::numeric_limits<float>::infinity();
            channel.values[5] = std::numeric_limits<float>::infinity();
        }
    ASSERT_TRUE(media::write_exr(path("shot.exr"), image));
    const ProgramResult result = run({"inspect", "shot.exr"});
    EXPECT_NE(result.out.find("1 NaN, 2 infinite"), std::string::npos) << result.out;
    EXPECT_NE(result.out.find("warp check: none"), std::string::npos) << result.out;
}

TEST_F(CliInspect, goes_on_after_a_broken_file) {
    write_frames(1, 1);
    write("broken.exr", "no");
    const ProgramResult result = run({"inspect", "broken.exr", "shot.0001.exr"});
    EXPECT_EQ(result.code, 3);
    EXPECT_EQ(result.error_lines(), 1u);
    EXPECT_NE(result.out.find("View.Combined"), std::string::npos);
}

TEST_F(CliList, everything_in_both_forms) {
    for (const char* what : {"effects", "presets", "parameters", "devices", "scenes"}) {
        const ProgramResult text = run({"list", what});
        EXPECT_EQ(text.code, 0) << what << text.error;
        EXPECT_GT(text.out.size(), 20u) << what;
        EXPECT_GT(parse(run({"list", what, "--json"}).out).size(), 0u) << what;
    }
    const auto parameters = parse(run({"list", "parameters", "motion-blur", "--json"}).out);
    bool found = false;
    for (const auto& row : parameters)
        found = found || (row["name"] == "shutter" && row["default"] == "0.5" && row["maximum"].get<double>() >= 1.0);
    EXPECT_TRUE(found);
    expect_error({"list", "presets", "motion-blurr"}, 2, {"did you mean 'motion-blur'?"});
}

TEST_F(CliList, markdown_tables) {
    const ProgramResult result = run({"list", "parameters", "motion-blur", "--markdown"});
    ASSERT_EQ(result.code, 0) << result.error;
    const auto parameters = parse(run({"list", "parameters", "motion-blur", "--json"}).out);
    const auto presets = parse(run({"list", "presets", "motion-blur", "--json"}).out);
    for (const auto* list : {&parameters, &presets})
        for (const auto& row : *list) {
            EXPECT_NE(result.out.find("\n| `" + row["name"].get<std::string>() + "` | "), std::string::npos) << row;
            EXPECT_NE(result.out.find(" | " + row["doc"].get<std::string>() + " |"), std::string::npos) << row;
        }
    for (const char* part :
         {"| `shutter` | `0.5` | 0 to 4 | of a frame | ", "| `none`, `checkerboard`, ", " `taps=8` "})
        EXPECT_NE(result.out.find(part), std::string::npos) << "no '" << part << "' in:\n" << result.out;
    // Every row of a table has as many cells as its head.
    size_t columns = 0;
    std::istringstream lines(result.out);
    for (std::string line; std::getline(lines, line);) {
        const auto bars = static_cast<size_t>(std::count(line.begin(), line.end(), '|'));
        EXPECT_TRUE(columns == 0 || bars == 0 || bars == columns) << line;
        columns = bars;
    }
    EXPECT_EQ(run({"list", "parameters", "--markdown"}).code, 0);
    expect_error({"list", "scenes", "--markdown"}, 2, {"--markdown", "'scenes'"});
    expect_error({"list", "parameters", "--markdown", "--json"}, 2, {"exclude"});
    expect_error({"list", "parameters", "motion-blurr", "--markdown"}, 2, {"did you mean 'motion-blur'?"});
}

TEST_F(CliList, help_and_version) {
    EXPECT_EQ(run({"--version"}).out.substr(0, 8), "sfumato ");
    for (const char* command : {"apply", "render", "compare", "inspect", "list"}) {
        EXPECT_NE(run({"--help"}).out.find(command), std::string::npos);
        const ProgramResult help = run({command, "--help"});
        EXPECT_EQ(help.code, 0);
        EXPECT_NE(help.out.find("--json"), std::string::npos) << help.out;
    }
}

TEST_F(CliRender, what_it_writes_is_what_apply_reads) {
    ASSERT_EQ(
        run({"render", "two-trains", "-o", "t.####.exr", "--frames", "11-13", "--size", "320x180", "--samples", "1"})
            .code,
        0);
    const auto json = parse(run({"inspect", "t.0012.exr", "--json"}).out);
    EXPECT_EQ(json[0]["motion"]["convention"], "sfumato");
    EXPECT_EQ(json[0]["motion"]["warp_check"]["verdict"], "confirmed");
    EXPECT_EQ(json[0]["depth"]["convention"], "planar");
    EXPECT_TRUE(json[0]["camera"].is_object());
    // The camera of the header is the scene's: with effects while rendering or afterwards, the picture is the same.
    ASSERT_EQ(run({"render", "two-trains", "-o", "direct.exr", "--frames", "12", "--size", "320x180", "--samples", "1",
                   "--effects", "motion-blur"})
                  .code,
              0);
    ASSERT_EQ(run({"apply", "motion-blur", "t.0012.exr", "-o", "applied.exr"}).code, 0);
    const ProgramResult same = run({"compare", "applied.exr", "direct.exr", "--psnr-min", "55"});
    EXPECT_EQ(same.code, 0) << same.out;
}

TEST_F(CliRender, true_occlusion) {
    const auto mean_visibility = [&](const std::vector<std::string>& more) {
        std::vector<std::string> arguments = {"render",       "crevices", "-o",      "o.exr",
                                              "--size",       "80x45",    "--truth", "ambient-occlusion",
                                              "--truth-rays", "16"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        EXPECT_EQ(run(arguments).code, 0);
        const auto image = media::read_exr(path("o.exr"));
        double sum = 0.0;
        for (const char* name : {"AO", "bent_normal.X", "bent_normal.Z", "R", "Z", "N.X"})
            EXPECT_TRUE(image && image->parts[0].find_channel(name)) << name;
        for (const float value : image->parts[0].find_channel("AO")->values)
            sum += static_cast<double>(value) / (80 * 45);
        return sum;
    };
    const double hard = mean_visibility({}), soft = mean_visibility({"--truth-falloff", "contact"});
    const double narrow = mean_visibility({"--truth-radius", "0.3"});
    EXPECT_GT(hard, 0.4);
    EXPECT_LT(hard, soft - 0.05);
    EXPECT_LT(hard, narrow - 0.05);
    EXPECT_LT(narrow, 0.98);
    ASSERT_EQ(run({"render", "crevices", "-o", "o.png", "--size", "64x36", "--truth", "ambient-occlusion"}).code, 0);
    expect_error({"render", "crevices", "-o", "x.png", "--truth", "8,ambient-occlusion"}, 2, {"one picture"});
    expect_error({"render", "crevices", "-o", "x.exr", "--truth", "shadows"}, 2, {"'shadows'", "ambient-occlusion"});
    expect_error({"render", "crevices", "-o", "x.exr", "--truth-falloff", "cubic"}, 2, {"cubic", "quadratic"});
}

TEST_F(CliRender, truth_passes_and_errors) {
    ASSERT_EQ(run({"render", "fairground", "-o", "f.exr", "--size", "160x90", "--samples", "1", "--truth", "16",
                   "--passes", "--effects", "motion-blur", "--set", "motion-blur.taps=9"})
                  .code,
              0);
    auto image = media::read_exr(path("f.exr"));
    ASSERT_TRUE(image);
    for (const char* name :
         {"R", "Z", "N.X", "sfumato_velocity.X", "sfumato_velocity.W", "truth.R", "sharp.G", "ambient.B", "shadow"})
        EXPECT_NE(image->parts[0].find_channel(name), nullptr) << name;
    ASSERT_EQ(run({"render", "still", "-o", "s.png", "--size", "64x36"}).code, 0);
    ASSERT_EQ(run({"render", "still", "-o", "t.png", "--size", "64x36", "--truth", "4"}).code, 0);
    EXPECT_EQ(run({"compare", "s.png", "t.png", "--psnr-min", "60"}).code, 0) << "nothing moves";
    expect_error({"render", "still", "-o", "x.exr", "--truth", "0"}, 2,
                 {"--truth 0", "sub-frames", "ambient-occlusion"});
    expect_error({"render", "fairgroundd", "-o", "x.exr"}, 2, {"did you mean 'fairground'?"});
    expect_error({"render", "still", "-o", "x.exr", "--size", "12"}, 2, {"--size 12", "WIDTHxHEIGHT"});
    expect_error({"render", "still", "-o", "x.exr", "--frames", "1-2"}, 2, {"one file"});
    expect_error({"render", "still", "-o", "x.exr", "--preset", "high"}, 2, {"--effects"});
    expect_error({"render", "still", "-o", "s.png", "--no-clobber"}, 3, {"s.png", "exists already"});
}

} // namespace sfumato::cli_tests
