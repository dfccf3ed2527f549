// Configuration files: what wins, what is written, what is refused.
#include "tests/cli/program.h"

namespace sfumato::cli_tests {

class CliConfig : public ProgramTest {
  protected:
    // The parameters of a dry run with these options.
    std::string parameters(const std::vector<std::string>& options) const {
        std::vector<std::string> arguments = {"apply", "motion-blur", "shot.0001.exr", "-o", "out.exr", "-n"};
        arguments.insert(arguments.end(), options.begin(), options.end());
        const ProgramResult result = run(arguments);
        EXPECT_EQ(result.code, 0) << result.error;
        const size_t begin = result.out.find("motion-blur: ");
        return begin == std::string::npos ? "" : result.out.substr(begin, result.out.find('\n', begin) - begin);
    }
};

TEST_F(CliConfig, precedence) {
    write_frames(1, 1);
    write("f.toml", "[motion-blur]\nradius = 0.03\npreset = \"low\"\ntaps = 20\n");
    EXPECT_NE(parameters({"--config", "f.toml"}).find(" taps=20 "), std::string::npos);
    EXPECT_NE(parameters({"--config", "f.toml"}).find(" radius=0.03 "), std::string::npos);
    const std::string preset = parameters({"--config", "f.toml", "--preset", "high"});
    EXPECT_EQ(preset, parameters({"--preset", "high"}));
    EXPECT_NE(parameters({"--config", "f.toml", "--set", "motion-blur.taps=9"}).find(" taps=9 "), std::string::npos);
    EXPECT_NE(parameters({"--preset", "high", "--set", "taps=9"}).find(" taps=9 "), std::string::npos);
}

TEST_F(CliConfig, round_trip) {
    write_frames(1, 1);
    const std::vector<std::string> options = {"--preset", "dx11",
                                              "--set",    "motion-blur.shutter=0.37",
                                              "--set",    "motion-blur.shutter_position=end",
                                              "--set",    "motion-blur.hdr_weighting=on"};
    std::vector<std::string> arguments = {"apply",   "motion-blur",   "shot.0001.exr", "-o",
                                          "out.exr", "--save-config", "a.toml"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    ASSERT_EQ(run(arguments).code, 0);
    EXPECT_EQ(parameters({"--config", "a.toml"}), parameters(options));
    ASSERT_EQ(
        run({"apply", "motion-blur", "shot.0001.exr", "-o", "out.exr", "--config", "a.toml", "--save-config", "b.toml"})
            .code,
        0);
    // Only the note of the preset is lost.
    std::string a = read("a.toml");
    const size_t note = a.find("# began as preset dx11\n");
    ASSERT_NE(note, std::string::npos);
    EXPECT_EQ(a.erase(note, 23), read("b.toml"));
}

TEST_F(CliConfig, errors) {
    write_frames(1, 1);
    const auto expect = [&](const std::string& text, const std::vector<std::string>& parts) {
        write("f.toml", text);
        expect_error({"apply", "motion-blur", "shot.0001.exr", "-o", "out.exr", "--config", "f.toml"}, 3, parts);
    };
    expect("[motion-blur]\n\ntapz = 3\n", {"f.toml:3:", "'tapz'", "did you mean 'taps'?"});
    expect("[motion-blr]\ntaps = 3\n", {"f.toml:1:", "did you mean 'motion-blur'?"});
    expect("[motion-blur]\ntaps = 1000000\n", {"f.toml:2:", "'1000000'"});
    expect("[motion-blur]\ntaps = [1]\n", {"f.toml:2:", "one value"});
    expect("[motion-blur]\npreset = \"hihg\"\n", {"f.toml:2:", "did you mean 'high'?"});
    expect("motion-blur = 3\n", {"f.toml:1:", "must be a table"});
    expect("[motion-blur\n", {"f.toml:1:"});
    expect_error({"apply", "motion-blur", "shot.0001.exr", "-o", "out.exr", "--config", "none.toml"}, 3, {"none.toml"});
}

} // namespace sfumato::cli_tests
