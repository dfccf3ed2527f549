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

const std::string few = "particles.count=3000";

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

TEST_F(CliParticles, particles_come_into_rendered_frames) {
    ASSERT_EQ(run({"render", "smoke-columns", "-o", "shot.exr", "--size", "96x54", "-q"}).code, 0);
    const ProgramResult done = run({"apply", "particles", "shot.exr", "-o", "smoke.exr", "--set", few});
    ASSERT_EQ(done.code, 0) << done.error;
    EXPECT_GT(difference(load(path("shot.exr")), load(path("smoke.exr"))), 0.001);
}

} // namespace sfumato::cli_tests
