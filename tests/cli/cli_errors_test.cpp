// What goes wrong: one line that says what, where and what would be right; the exit code; nothing left behind.
#include "tests/cli/program.h"

namespace sfumato::cli_tests {

using CliUsage = ProgramTest;
using CliInput = ProgramTest;
using CliDevice = ProgramTest;

TEST_F(CliUsage, commands_and_options) {
    expect_error({}, 2, {"no command"});
    expect_error({"aply"}, 2, {"unknown command 'aply'", "did you mean 'apply'?"});
    expect_error({"view"}, 2, {"view", "SCENE"});
    expect_error({"--versoin"}, 2, {"unknown option '--versoin'", "did you mean '--version'?"});
    expect_error({"apply"}, 2, {"apply", "EFFECTS"});
    expect_error({"apply", "motion-blur", "a.exr"}, 2, {"--output"});
    expect_error({"apply", "motion-blur", "a.exr", "-o", "b.exr", "--presett", "high"}, 2,
                 {"no option '--presett'", "did you mean '--preset'?"});
    expect_error({"apply", "motion-blur", "a.exr", "-o", "b.exr", "--preroll", "-3"}, 2, {"--preroll"});
    expect_error({"compare", "a.exr", "b.exr", "--psnr-min", "high"}, 2, {"--psnr-min"});
    expect_error({"list", "presetz"}, 2, {"did you mean 'presets'?"});
}

TEST_F(CliUsage, names) {
    write_frames(1, 1);
    const auto apply = [&](const std::string& effect, std::vector<std::string> more, std::vector<std::string> parts) {
        std::vector<std::string> arguments = {"apply", effect, "shot.0001.exr", "-o", "out.exr"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        expect_error(arguments, 2, parts);
    };
    apply("motion-blurr", {}, {"no effect is called 'motion-blurr'", "did you mean 'motion-blur'?"});
    apply("motion-blur,motion-blur", {}, {"named twice"});
    apply("motion-blur", {"--preset", "hihg"}, {"no preset 'hihg'", "did you mean 'high'?"});
    apply("motion-blur", {"--preset", "motion-blurr=high"}, {"did you mean 'motion-blur'?"});
    apply("motion-blur", {"--set", "motion-blur.tapz=3"}, {"no parameter 'tapz'", "did you mean 'taps'?"});
    apply("motion-blur", {"--set", "motion-blur.taps=100000"}, {"taps", "'100000'", "from 1 to"});
    apply("motion-blur", {"--set", "motion-blur.taps=2.5"}, {"taps", "whole number"});
    apply("motion-blur", {"--set", "motion-blur.weighting=tlak"}, {"weighting", "one of talk"});
    apply("motion-blur", {"--set", "motion-blur.shutter=nan"}, {"shutter"});
    apply("motion-blur", {"--set", "taps"}, {"effect.parameter=value"});
    apply("motion-blur", {"--layer", "Viwe"}, {"no layer 'Viwe'", "did you mean 'View'?"});
    apply("motion-blur", {"--motion-convention", "blendr"}, {"'blendr' is unknown", "did you mean 'blender'?"});
    apply("motion-blur", {"--depth-convention", "planr"}, {"did you mean 'planar'?"});
    EXPECT_EQ(files(), std::vector<std::string>{"shot.0001.exr"});
}

TEST_F(CliUsage, patterns_and_frames) {
    write_frames(1, 3);
    const auto apply = [&](std::vector<std::string> arguments, int code, std::vector<std::string> parts) {
        arguments.insert(arguments.begin(), {"apply", "motion-blur"});
        expect_error(arguments, code, parts);
    };
    apply({"shot.####.exr", "-o", "out.exr"}, 2, {"3 frames go in", "'out.exr' is one file", "####"});
    apply({"shot.0001.exr", "shot.0002.exr", "-o", "out.exr"}, 2, {"2 frames go in", "'out.exr' is one file"});
    apply({"shot.0001.exr", "-o", "out.tif"}, 2, {"'.tif'", ".exr and .png"});
    apply({"shot.0001.exr", "-o", "shot.0001.exr"}, 2, {"the output is the input"});
    apply({"shot.0001.exr", "-o", "out.exr", "--frames", "1-3"}, 2, {"is one file"});
    apply({"shot.####.exr", "-o", "out.####.exr", "--frames", "1-x"}, 2, {"'1-x' is not a frame or range"});
    apply({"shot.####.exr", "-o", "out.####.exr", "--frames", "1-6"}, 3, {"3 of 6 frames missing: 4-6"});
    apply({"none.####.exr", "-o", "out.####.exr"}, 3, {"none.####.exr", "no file matches"});
    apply({"none.exr", "-o", "out.exr"}, 3, {"none.exr", "no such file"});
}

TEST_F(CliInput, no_clobber) {
    write_frames(1, 1);
    write("out.0001.exr", "precious");
    expect_error({"apply", "motion-blur", "shot.####.exr", "-o", "out.####.exr", "--no-clobber"}, 3,
                 {"out.0001.exr", "exists already"});
    EXPECT_EQ(read("out.0001.exr"), "precious");
}

TEST_F(CliInput, broken_files) {
    write_frames(1, 1);
    const std::string whole = read("shot.0001.exr");
    write("cut.exr", whole.substr(0, whole.size() / 2));
    expect_error({"apply", "motion-blur", "cut.exr", "-o", "out.exr"}, 3, {"cut.exr"});
    expect_error({"inspect", "cut.exr"}, 3, {"cut.exr"});
    write("text.exr", "this is no picture");
    expect_error({"apply", "motion-blur", "text.exr", "-o", "out.exr"}, 3, {"text.exr"});
    write("empty.exr", "");
    expect_error({"compare", "empty.exr", "shot.0001.exr"}, 3, {"empty.exr"});
    // Width and height of 65536 and more in a file of a few kilobytes.
    std::string huge = whole;
    const size_t window = huge.find(std::string("dataWindow\0box2i\0", 17)) + 17 + 4;
    ASSERT_LT(window + 16, huge.size());
    for (const size_t high_byte : {window + 10, window + 14})
        huge[high_byte] = 1;
    write("huge.exr", huge);
    expect_error({"apply", "motion-blur", "huge.exr", "-o", "out.exr"}, 3, {"huge.exr"});
    EXPECT_FALSE(exists("out.exr"));
}

TEST_F(CliInput, missing_channels) {
    FrameOptions no_motion;
    no_motion.motion = false;
    write_frames(1, 1, no_motion);
    expect_error({"apply", "motion-blur", "shot.0001.exr", "-o", "out.exr"}, 3,
                 {"shot.0001.exr", "needs motion channels", "--camera", "View.Depth"});
    // Two channels that could mean anything.
    FrameOptions nameless;
    nameless.motion_layer = "motion";
    nameless.two_channels = true;
    write_frames(1, 1, nameless);
    expect_error({"apply", "motion-blur", "shot.0001.exr", "-o", "out.exr"}, 2,
                 {"nothing tells what the motion channels motion (XY) mean", "--motion-convention"});
    EXPECT_EQ(run({"apply", "motion-blur", "shot.0001.exr", "-o", "out.exr", "--motion-convention", "pixels"}).code, 0);
}

TEST_F(CliInput, unwritable_output) {
    write_frames(1, 1);
    write("file", "in the way");
    expect_error({"apply", "motion-blur", "shot.0001.exr", "-o", "file/out.exr"}, 3, {"file/out.exr"});
    std::filesystem::create_directory(path("folder.exr"));
    expect_error({"apply", "motion-blur", "shot.0001.exr", "-o", "folder.exr", "-q"}, 3, {"folder.exr"});
    EXPECT_EQ(files(), (std::vector<std::string>{"file", "shot.0001.exr"}));
}

TEST_F(CliInput, cameras) {
    write_frames(1, 1);
    expect_error({"apply", "motion-blur", "shot.0001.exr", "-o", "out.exr", "--camera", "none.toml"}, 3, {"none.toml"});
    write("camera.toml", "width = 96\nheight = 64\nvertical_fov_degrees = 40\nnear = 0.1\nfarr = 3\n");
    expect_error({"apply", "motion-blur", "shot.0001.exr", "-o", "out.exr", "--camera", "camera.toml"}, 3,
                 {"camera.toml", "farr"});
    write("camera.toml", "width = 96\nheight = 64\nvertical_fov_degrees = 40\n[[frame]]\nnumber = 7\n"
                         "world_to_camera = [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]\n");
    expect_error({"apply", "motion-blur", "shot.0001.exr", "-o", "out.exr", "--camera", "camera.toml"}, 3,
                 {"no camera for frame 1", "it has 7 to 7"});
}

TEST_F(CliDevice, none) {
    write_frames(1, 1);
    const std::vector<std::string> nothing = {"VK_DRIVER_FILES=/dev/null", "VK_ICD_FILENAMES=/dev/null"};
    expect_error({"apply", "motion-blur", "shot.0001.exr", "-o", "out.exr"}, 4, {"no Vulkan device"}, nothing);
    expect_error({"render", "still", "-o", "out.exr"}, 4, {"no Vulkan device"}, nothing);
    expect_error({"list", "devices"}, 4, {"no Vulkan device"}, nothing);
    expect_error({"apply", "motion-blur", "shot.0001.exr", "-o", "out.exr", "--device", "abacus"}, 4, {"\"abacus\""});
    // What needs no device works without one.
    EXPECT_EQ(run({"inspect", "shot.0001.exr"}, nothing).code, 0);
    EXPECT_EQ(run({"list", "effects"}, nothing).code, 0);
    EXPECT_EQ(run({"apply", "motion-blur", "shot.0001.exr", "-o", "out.exr", "-n"}, nothing).code, 0);
    EXPECT_EQ(files(), std::vector<std::string>{"shot.0001.exr"});
}

} // namespace sfumato::cli_tests
