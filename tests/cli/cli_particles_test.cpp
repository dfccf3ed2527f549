// Particles on scenes and files.
#include "media/exr_file.h"
#include "tests/cli/program.h"

#include <cmath>

namespace sfumato::cli_tests {

using CliParticles = ProgramTest;

namespace {

media::ExrImage load(const std::filesystem::path& path) {
    auto image = media::read_exr(path);
    EXPECT_TRUE(image) << (image ? "" : image.error().message);
    return image ? std::move(*image) : media::ExrImage{};
}

const std::string few = "particles.count=3000", large = "particles.radius_start=0.5"; // which shows what is on a disc

double difference(const media::ExrImage& a, const media::ExrImage& b) {
    const auto *x = a.parts[0].find_channel("G"), *y = b.parts[0].find_channel("G");
    EXPECT_TRUE(x && y && x->values.size() == y->values.size());
    double sum = 0.0;
    for (size_t i = 0; x && y && i < x->values.size(); ++i)
        sum += std::abs(double{x->values[i]} - double{y->values[i]});
    return sum / static_cast<double>(x->values.size());
}

} // namespace

TEST_F(CliParticles, smoke_rises_among_columns) {
    const std::vector<std::string> render = {"render", "smoke-columns", "--size", "96x54", "-q"};
    const auto with = [&](std::vector<std::string> more) {
        std::vector<std::string> all = render;
        all.insert(all.end(), more.begin(), more.end());
        return run(all);
    };
    ASSERT_EQ(with({"-o", "plain.exr"}).code, 0);
    const ProgramResult smoke = with({"-o", "smoke.exr", "--particles", "smoke", "--set", few});
    ASSERT_EQ(smoke.code, 0) << smoke.error;
    EXPECT_GT(difference(load(path("plain.exr")), load(path("smoke.exr"))), 0.001);
    // The smoke is there in the first frame, and the same each time.
    ASSERT_EQ(with({"-o", "again.exr", "--particles", "smoke", "--set", few}).code, 0);
    EXPECT_EQ(difference(load(path("smoke.exr")), load(path("again.exr"))), 0.0);
    // Before the other effects, each with its own preset.
    const ProgramResult chain = with({"-o", "chain.exr", "--particles", "explosion", "--effects", "motion-blur",
                                      "--preset", "low", "--set", few, "--set", "particles.burst=2000"});
    ASSERT_EQ(chain.code, 0) << chain.error;
    const ProgramResult wrong = with({"-o", "x.exr", "--particles", "smok"});
    EXPECT_EQ(wrong.code, 2);
    EXPECT_NE(wrong.error.find("did you mean 'smoke'"), std::string::npos) << wrong.error;
}

// A texture comes from a file for scenes, from a layer of the frames for frames.
TEST_F(CliParticles, profiles_of_noise_and_of_a_file) {
    const auto render = [&](const std::string& output, std::vector<std::string> more) {
        std::vector<std::string> all = {"render", "smoke-columns", "--size", "96x54", "-q",  "--particles",
                                        "smoke",  "--set",         few,      "--set", large, "-o"};
        all.push_back(output);
        all.insert(all.end(), more.begin(), more.end());
        return run(all);
    };
    media::ExrImage texture;
    texture.parts.emplace_back();
    texture.parts[0].data_window = texture.parts[0].display_window = {0, 0, 15, 7};
    std::vector<float> values(128, 0.0f);
    values[36] = values[37] = values[60] = 1.0f;
    texture.parts[0].set_channel("Y", values);
    ASSERT_TRUE(media::write_exr(path("grey.exr"), texture));
    texture.parts[0].set_channel("profile", std::vector<float>(128, 1.0f));
    ASSERT_TRUE(media::write_exr(path("named.exr"), texture));
    const std::vector<std::string> wanted = {"--set", "particles.profile=texture", "--particle-texture"};
    const auto with = [&](const std::string& file) {
        std::vector<std::string> all = wanted;
        all.push_back(file);
        return all;
    };
    ASSERT_EQ(render("sphere.exr", {}).code, 0);
    ASSERT_EQ(render("noise.exr", {"--set", "particles.profile=noise"}).code, 0);
    ASSERT_EQ(render("texture.exr", with("grey.exr")).code, 0);
    ASSERT_EQ(render("layer.exr", with("named.exr")).code, 0);
    EXPECT_GT(difference(load(path("sphere.exr")), load(path("noise.exr"))), 1e-5);
    EXPECT_GT(difference(load(path("sphere.exr")), load(path("texture.exr"))), 1e-4);
    EXPECT_GT(difference(load(path("texture.exr")), load(path("layer.exr"))), 1e-4);

    const ProgramResult without = render("x.exr", {"--set", "particles.profile=texture"});
    EXPECT_EQ(without.code, 2);
    EXPECT_EQ(without.error, "sfumato: particles.profile=texture needs --particle-texture FILE\n");
    const ProgramResult unused = render("x.exr", {"--particle-texture", "grey.exr"});
    EXPECT_EQ(unused.code, 2);
    EXPECT_NE(unused.error.find("--set particles.profile=texture"), std::string::npos) << unused.error;
    EXPECT_EQ(render("x.exr", with("nowhere.exr")).code, 3);

    const ProgramResult frames = run(
        {"apply", "particles", "sphere.exr", "-o", "x.exr", "-q", "--set", few, "--set", "particles.profile=texture"});
    EXPECT_EQ(frames.code, 3);
    EXPECT_NE(frames.error.find("particles needs 'profile'"), std::string::npos) << frames.error;
}

TEST_F(CliParticles, particles_come_into_rendered_frames) {
    ASSERT_EQ(run({"render", "smoke-columns", "-o", "shot.exr", "--size", "96x54", "-q"}).code, 0);
    const ProgramResult done = run({"apply", "particles", "shot.exr", "-o", "smoke.exr", "--set", few});
    ASSERT_EQ(done.code, 0) << done.error;
    EXPECT_GT(difference(load(path("shot.exr")), load(path("smoke.exr"))), 0.001);
    media::ExrImage with_profile = load(path("shot.exr"));
    with_profile.parts[0].set_channel("profile", std::vector<float>(96 * 54, 1.0f));
    ASSERT_TRUE(media::write_exr(path("textured.exr"), with_profile));
    const auto with = [&](const std::string& profile) {
        return run({"apply", "particles", "textured.exr", "-o", profile + ".exr", "-q", "--set", few, "--set", large,
                    "--set", "particles.profile=" + profile});
    };
    ASSERT_EQ(with("sphere").code, 0);
    const ProgramResult textured = with("texture");
    ASSERT_EQ(textured.code, 0) << textured.error;
    EXPECT_GT(difference(load(path("sphere.exr")), load(path("texture.exr"))), 1e-4);
}

namespace {

std::string after(const std::string& text, const std::string& start) {
    const size_t place = text.find(start);
    if (place == std::string::npos)
        return "";
    const size_t begin = place + start.size();
    return text.substr(begin, text.find_first_of(" ;\n", begin) - begin);
}

} // namespace

// Large particles touch every tile. The warning is one line for all frames, and what it advises is enough.
TEST_F(CliParticles, too_little_room_is_told_once_with_the_remedy) {
    std::vector<std::string> arguments = {"render", "smoke-columns", "-o",    "s.####.exr",  "--frames",
                                          "23-24",  "--size",        "64x36", "--particles", "smoke"};
    for (const char* setting :
         {"count=600", "radius_start=1", "radius_end=1", "extinction=0.05", "layers=4", "shadow_resolution=64"})
        arguments.insert(arguments.end(), {"--set", std::string("particles.") + setting});
    const auto with = [&](const std::vector<std::string>& more) {
        std::vector<std::string> all = arguments;
        for (const std::string& setting : more)
            all.insert(all.end(), {"--set", "particles." + setting});
        return run(all);
    };
    const ProgramResult narrow = with({"pairs_per_particle=1"});
    ASSERT_EQ(narrow.code, 0) << narrow.error;
    EXPECT_EQ(narrow.error_lines(), 1u) << narrow.error;
    EXPECT_TRUE(narrow.error.starts_with("sfumato: warning: frames 23-24: particles: ")) << narrow.error;
    // A pair for each of 600 particles, and 16 for each of 4×3 tiles.
    EXPECT_EQ(after(narrow.error, "room for "), "792,") << narrow.error;
    const std::string enough = after(narrow.error, "--set particles.");
    EXPECT_TRUE(enough.starts_with("pairs_per_particle=")) << narrow.error;
    const ProgramResult wide = with({enough});
    ASSERT_EQ(wide.code, 0) << wide.error;
    EXPECT_EQ(wide.error, "");
    // One less than that is not enough.
    const int number = std::stoi(after(narrow.error, "pairs_per_particle="));
    EXPECT_EQ(with({"pairs_per_particle=" + std::to_string(number - 1)}).error_lines(), 1u);
}

TEST_F(CliParticles, depths_that_were_cut_are_told_with_the_remedy) {
    ASSERT_EQ(run({"render", "smoke-columns", "-o", "shot.exr", "--size", "96x54", "-q"}).code, 0);
    const auto with = [&](const std::string& setting) {
        return run({"apply", "particles", "shot.exr", "-o", "smoke.exr", "--set", few, "--set",
                    "particles.dilution=0.5", "--set", "particles." + setting});
    };
    const ProgramResult deep = with("extinction=500");
    ASSERT_EQ(deep.code, 0) << deep.error;
    EXPECT_NE(deep.error.find("sfumato: warning: shot.exr: particles: optical depths"), std::string::npos)
        << deep.error;
    const std::string remedy = after(deep.error, "--set particles.");
    EXPECT_TRUE(remedy.starts_with("extinction=")) << deep.error;
    const ProgramResult thin = with(remedy);
    ASSERT_EQ(thin.code, 0) << thin.error;
    EXPECT_EQ(thin.error.find("optical depths"), std::string::npos) << thin.error;
}

} // namespace sfumato::cli_tests
