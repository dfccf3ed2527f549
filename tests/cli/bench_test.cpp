// The measuring program as its users see it: exit codes, messages, tables, JSON and figures that can be repeated.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

namespace {

using nlohmann::json;

struct Finished {
    int exit_code = -1;
    std::string out, error;
};

std::string text_of(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

// A folder of its own for every test.
class Bench : public testing::Test {
  protected:
    void SetUp() override {
        std::string pattern = (std::filesystem::temp_directory_path() / "sfumato-bench-XXXXXX").string();
        ASSERT_NE(mkdtemp(pattern.data()), nullptr);
        folder_ = pattern;
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    std::string path(const std::string& name) const { return (folder_ / name).string(); }

    Finished run(const std::string& arguments, const std::string& environment = "") const {
        const std::string command = environment + " '" SFUMATO_BENCH_PATH "' " + arguments + " >'" + path("out") +
                                    "' 2>'" + path("error") + "'";
        const int status = std::system(command.c_str());
        return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, text_of(path("out")), text_of(path("error"))};
    }

    void expect_failure(const std::string& arguments, int exit_code, const std::string& message,
                        const std::string& environment = "") const {
        const Finished finished = run(arguments, environment);
        EXPECT_EQ(finished.exit_code, exit_code) << arguments;
        EXPECT_NE(finished.error.find(message), std::string::npos) << arguments << ": " << finished.error;
        EXPECT_EQ(std::count(finished.error.begin(), finished.error.end(), '\n'), 1) << finished.error;
    }

    // A frame of 32×16 pixels with a square that moves 8 pixels a frame, and a rough truth.
    void write_raw(const std::string& name, const std::string& header_end = "\n") const {
        std::ofstream file(path(name), std::ios::binary);
        file << "SFRAW1\n"
             << "colour 32 16 3 float32 little-endian\n"
             << "depth 32 16 1 float32 little-endian\n"
             << "velocity 32 16 2 float32 little-endian\n"
             << "truth 32 16 3 float32 little-endian\n"
             << header_end;
        const auto inside = [](int x, int y) { return x >= 12 && x < 20 && y >= 4 && y < 12; };
        const auto put = [&](auto value) {
            for (int y = 0; y < 16; ++y)
                for (int x = 0; x < 32; ++x)
                    for (const float v : value(x, y))
                        file.write(reinterpret_cast<const char*>(&v), sizeof v);
        };
        put([&](int x, int y) { return std::vector<float>(3, inside(x, y) ? 0.8f : 0.1f); });
        put([&](int x, int y) { return std::vector<float>(1, inside(x, y) ? 2.0f : 10.0f); });
        put([&](int x, int y) { return std::vector<float>{inside(x, y) ? 8.0f : 0.0f, 0.0f}; });
        put([&](int x, int y) {
            float sum = 0.0f;
            for (int shift = -2; shift <= 2; ++shift)
                sum += inside(x + shift, y) ? 0.8f : 0.1f;
            return std::vector<float>(3, sum / 5.0f);
        });
    }

    std::filesystem::path folder_;
};

constexpr const char* small_quality =
    "quality --effect motion-blur --scene two-trains --size 48x27 --subframes 4 --preset low,high ";

TEST_F(Bench, SaysWhatIsWrongInOneLine) {
    expect_failure("", 2, "subcommand");
    expect_failure("tims", 2, "did you mean 'times'?");
    expect_failure("times --preset hihg", 2, "did you mean 'high'?");
    expect_failure("times --effect motion-blurr", 2, "did you mean 'motion-blur'?");
    expect_failure("times --set motion-blur.tapps=3", 2, "did you mean 'taps'?");
    expect_failure("times --set motion-blur.taps=3000", 2, "3000");
    expect_failure("quality --scene two-train", 2, "did you mean 'two-trains'?");
    expect_failure("quality --size 12", 2, "WIDTHxHEIGHT");
    expect_failure("tune", 2, "--budget");
    expect_failure("tune --budget 3parsec", 2, "0.2ms");
    expect_failure("times --input-raw " + path("missing.raw"), 3, "missing.raw");
    expect_failure("times --device 'no such device'", 4, "no such device");
    expect_failure("times", 4, "Vulkan", "VK_DRIVER_FILES=/nonexistent VK_ICD_FILENAMES=/nonexistent");
}

TEST_F(Bench, TellsHelpAndWhatThereIs) {
    EXPECT_EQ(run("--help").exit_code, 0);
    EXPECT_EQ(run("times --help").exit_code, 0);
    const Finished list = run("list --json -");
    ASSERT_EQ(list.exit_code, 0) << list.error;
    const json parsed = json::parse(list.out);
    EXPECT_GE(parsed["effects"].size(), 1u);
    EXPECT_GE(parsed["scenes"].size(), 5u);
    EXPECT_EQ(parsed["scenes"][0]["effects"][0], "motion-blur");
    // Without a driver it still tells what it knows itself.
    EXPECT_EQ(run("list", "VK_DRIVER_FILES=/nonexistent VK_ICD_FILENAMES=/nonexistent").exit_code, 0);
}

TEST_F(Bench, TimesEveryPresetAndPass) {
    const Finished finished =
        run("times --effect motion-blur --scene still --size 64x36,40x24 --frames 3 --warm-up 0 --batch 8 "
            "--preset low,high --validation --json " +
            path("times.json"));
    ASSERT_EQ(finished.exit_code, 0) << finished.error;
    EXPECT_NE(finished.out.find("median ms"), std::string::npos);
    const json parsed = json::parse(text_of(path("times.json")));
    EXPECT_FALSE(parsed["device"]["name"].get<std::string>().empty());
    EXPECT_GT(parsed["machine"]["compute_copy_bytes_per_second"].get<double>(), 0.0);
    ASSERT_EQ(parsed["rows"].size(), 4u);
    for (const json& row : parsed["rows"]) {
        EXPECT_GT(row["time"]["median_ms"].get<double>(), 0.0);
        EXPECT_GE(row["time"]["samples"].get<int>(), 3);
        EXPECT_GT(row["moved_bytes"].get<double>(), 0.0);
        EXPECT_GT(row["transient_bytes"].get<double>(), 0.0);
        EXPECT_FALSE(row["passes"].empty());
    }
}

TEST_F(Bench, TimesAndChecksSorting) {
    expect_failure("sort --bits 33", 2, "33");
    expect_failure("sort --count 0", 2, "0");
    const Finished finished =
        run("sort --count 1,5000 --bits 16,24 --frames 2 --warm-up 0 --validation --json " + path("sort.json"));
    ASSERT_EQ(finished.exit_code, 0) << finished.error;
    EXPECT_NE(finished.out.find("checked"), std::string::npos);
    const json parsed = json::parse(text_of(path("sort.json")));
    ASSERT_EQ(parsed["rows"].size(), 16u); // two counts, two paths; two sorts, sums and compaction
    for (const json& row : parsed["rows"]) {
        EXPECT_TRUE(row["checked"].get<bool>());
        EXPECT_GT(row["moved_bytes"].get<double>(), 0.0);
        const auto bits = row["bits"].get<size_t>();
        EXPECT_EQ(row["passes"].size(), bits > 0 ? 3 * bits / 8 : 2);
    }
}

TEST_F(Bench, ScoresBetweenDoingNothingAndTheCeiling) {
    const Finished finished =
        run(std::string(small_quality) + "--pictures " + path("pictures") + " --json " + path("quality.json"));
    ASSERT_EQ(finished.exit_code, 0) << finished.error;
    const json rows = json::parse(text_of(path("quality.json")))["rows"];
    ASSERT_EQ(rows.size(), 4u);
    EXPECT_EQ(rows.front()["preset"], "do nothing");
    EXPECT_EQ(rows.back()["preset"], "ceiling");
    for (size_t i = 1; i < rows.size(); ++i) {
        EXPECT_GT(rows[i]["psnr_moving"].get<double>(), rows[0]["psnr_moving"].get<double>());
        EXPECT_EQ(rows[i]["non_finite_pixels"], 0);
    }
    EXPECT_EQ(text_of(path("pictures") + "/motion-blur.two-trains.high.png").substr(1, 3), "PNG");
}

TEST_F(Bench, QualityRepeatsToTheLastBit) {
    const Finished first = run(std::string(small_quality) + "--json -");
    const Finished second = run(std::string(small_quality) + "--json -");
    ASSERT_EQ(first.exit_code, 0) << first.error;
    EXPECT_EQ(first.out, second.out);
}

TEST_F(Bench, ReadsFramesFromFiles) {
    write_raw("square.raw");
    const Finished quality = run(
        "quality --scene none --preset high --set motion-blur.radius=0.25 --json - --input-raw " + path("square.raw"));
    ASSERT_EQ(quality.exit_code, 0) << quality.error;
    const json rows = json::parse(quality.out)["rows"];
    ASSERT_EQ(rows.size(), 2u); // no ceiling: the truth cannot be computed again
    EXPECT_EQ(rows[0]["scene"], "square");
    EXPECT_EQ(rows[0]["width"], 32);
    EXPECT_GT(rows[1]["psnr_moving"].get<double>(), rows[0]["psnr_moving"].get<double>() + 3.0);
    const Finished times = run("times --scene none --preset low --size 100x50 --frames 2 --warm-up 0 --json - "
                               "--input-raw " +
                               path("square.raw"));
    ASSERT_EQ(times.exit_code, 0) << times.error;
    EXPECT_EQ(json::parse(times.out)["rows"][0]["width"], 100);
}

TEST_F(Bench, ScoresOcclusionByRootMeanSquareError) {
    const std::string common = "quality --effect ambient-occlusion --scene contact --size 96x54 --rays 64 --preset ";
    const Finished finished = run(common + "high,hbao-crease,soma --preroll 3 --json -");
    ASSERT_EQ(finished.exit_code, 0) << finished.error;
    const json rows = json::parse(finished.out)["rows"];
    ASSERT_EQ(rows.size(), 7u); // do nothing, two presets and the ceiling; the same with the crease's radius
    EXPECT_EQ(rows[1]["preset"], "high");
    EXPECT_LT(rows[1]["rmse"].get<double>(), rows[0]["rmse"].get<double>());
    EXPECT_LT(rows[3]["rmse"].get<double>(), rows[1]["rmse"].get<double>());
    EXPECT_GT(rows[0]["bias_occluded"].get<double>(), 0.0);
    EXPECT_EQ(rows[5]["truth"], "radius 0.3");
    // Another falloff of the truth is another truth.
    const Finished own = run(common + "hbao --truth-falloff own --json -");
    ASSERT_EQ(own.exit_code, 0) << own.error;
    EXPECT_EQ(json::parse(own.out)["rows"][0]["truth"], "quadratic");
    expect_failure(common + "high --truth-falloff square", 2, "hard, linear, quadratic");
    expect_failure(common + "high --with colors", 2, "colors");
}

TEST_F(Bench, FilesTellTheirCameraAndRadius) {
    const auto write = [&](const std::string& name, bool camera, float radius) {
        std::ofstream file(path(name), std::ios::binary);
        file << "SFRAW1\ncolour 8 4 3 float32 little-endian\ndepth 8 4 1 float32 little-endian\n"
             << "true_visibility 8 4 1 float32 little-endian\ntruth_radius 1 1 1 float32 little-endian\n";
        if (camera)
            file << "world_to_view 4 4 1 float32 little-endian\nprojection 4 4 1 float32 little-endian\n";
        file << "\n";
        const auto put = [&](float v) { file.write(reinterpret_cast<const char*>(&v), sizeof v); };
        for (int i = 0; i < 96; ++i)
            put(0.5f);
        for (int i = 0; i < 32; ++i)
            put(4.0f);
        for (int i = 0; i < 32; ++i)
            put(1.0f);
        put(radius);
        if (!camera)
            return;
        for (int i = 0; i < 16; ++i)
            put(i % 5 == 0 ? 1.0f : 0.0f);
        for (const float v :
             {1.0f, 0.0f, 0.0f, 0.0f, 0.0f, -2.0f, 0.0f, 0.0f, 0.0f, 0.0f, -1.0f, -0.1f, 0.0f, 0.0f, -1.0f, 0.0f})
            put(v);
    };
    const std::string common = "quality --effect ambient-occlusion --scene none --no-ssim --preset low,hbao-crease "
                               "--json - --input-raw ";
    write("wall.raw", true, 1.5f);
    const Finished wall = run(common + path("wall.raw"));
    ASSERT_EQ(wall.exit_code, 0) << wall.error;
    const json rows = json::parse(wall.out)["rows"];
    ASSERT_EQ(rows.size(), 2u); // the crease wants another radius than the file's truth has
    EXPECT_LT(rows[1]["rmse"].get<double>(), 0.01);
    write("blind.raw", false, 1.5f);
    expect_failure(common + path("blind.raw"), 3, "camera");
    write("wide.raw", true, 7.0f);
    expect_failure(common + path("wide.raw"), 3, "radius of 7");
}

TEST_F(Bench, RefusesBrokenFiles) {
    write_raw("good.raw");
    const std::string whole = text_of(path("good.raw"));
    const auto refuse = [&](const std::string& content, const std::string& message) {
        std::ofstream(path("bad.raw"), std::ios::binary) << content;
        expect_failure("quality --effect motion-blur --scene none --input-raw " + path("bad.raw"), 3, message);
    };
    refuse("", "SFRAW1");
    refuse("SFRAW1\n", "empty line");
    refuse(whole.substr(0, whole.size() - 4), "announces");
    refuse(whole + "more", "announces");
    refuse("SFRAW1\ncolour 99999 16 3 float32 little-endian\n\n", "99999");
    refuse("SFRAW1\ncolour 0 16 3 float32 little-endian\n\n", "0");
    refuse("SFRAW1\ncolour -1 16 3 float32 little-endian\n\n", "-1");
    refuse("SFRAW1\ncolour wide 16 3 float32 little-endian\n\n", "header line");
    refuse("SFRAW1\ncolour 1 1 3 float16 little-endian\n\n", "float32");
    refuse("SFRAW1\ndepth 1 1 1 float32 little-endian\n\n" + std::string(4, '\0'), "colour");
    refuse("SFRAW1\ncolour 1 1 1 float32 little-endian\n\n" + std::string(4, '\0'), "channels");
    refuse("SFRAW1\ncolour 1 1 3 float32 little-endian\n\n" + std::string(12, '\0'), "truth");
}

TEST_F(Bench, DrawsTheFrontier) {
    const Finished finished =
        run("frontier --effect motion-blur --scene two-trains --size 48x27 --quality-size 48x27 --subframes 4 "
            "--frames 2 --warm-up 0 --preset low --vary taps=2,8 --json -");
    ASSERT_EQ(finished.exit_code, 0) << finished.error;
    const json points = json::parse(finished.out)["points"];
    ASSERT_EQ(points.size(), 3u);
    EXPECT_EQ(points[0]["preset"], "do nothing");
    EXPECT_EQ(points[0]["on_frontier"], true);
}

TEST_F(Bench, TunesWithinABudget) {
    const std::string common = "--effect motion-blur --scene two-trains,fairground --size 32x18 --quality-size 32x18 "
                               "--subframes 4 --frames 1 --warm-up 0 --evaluations 9 --seed 7 --json - ";
    const Finished roomy = run("tune --budget 10000ms --only taps,soft_extent " + common);
    ASSERT_EQ(roomy.exit_code, 0) << roomy.error;
    const json found = json::parse(roomy.out);
    EXPECT_TRUE(found["within_budget"].get<bool>());
    EXPECT_EQ(found["training"], "two-trains");
    EXPECT_EQ(found["report"], "fairground");
    EXPECT_EQ(found["rows"].front()["setting"], "do nothing");
    EXPECT_EQ(found["rows"].back()["setting"], "found");
    for (const json& set : found["sets"]) {
        const auto text = set.get<std::string>();
        EXPECT_TRUE(text.starts_with("motion-blur.taps=") || text.starts_with("motion-blur.soft_extent=")) << text;
    }
    // A budget that any setting keeps makes the search independent of the clock.
    const Finished again = run("tune --budget 10000ms --only taps,soft_extent " + common);
    EXPECT_EQ(found["sets"], json::parse(again.out)["sets"]);
    const Finished tight = run("tune --budget 0.001us --only taps " + common);
    ASSERT_EQ(tight.exit_code, 0) << tight.error;
    EXPECT_FALSE(json::parse(tight.out)["within_budget"].get<bool>());
}

TEST_F(Bench, ParticlesLeavePictures) {
    const Finished finished =
        run("particles --part quality --count 50 --size 16x9 --pictures '" + path("pictures") + "'");
    ASSERT_EQ(finished.exit_code, 0) << finished.error;
    for (const char* name : {"modes", "slices", "flip"}) {
        const std::string picture = text_of(path("pictures/particles-" + std::string(name) + ".png"));
        EXPECT_EQ(picture.substr(0, 4), "\x89PNG") << name;
        EXPECT_GT(picture.size(), 400000u) << name;
    }
    { std::ofstream(path("file")); } // no folder can be made where a file is
    expect_failure("particles --part quality --pictures '" + path("file") + "'", 3, path("file"));
    expect_failure("particles --part times --pictures '" + path("pictures") + "'", 2, "--pictures");
    expect_failure("particles --part quality --profile noise", 2, "--profile");
}

} // namespace
