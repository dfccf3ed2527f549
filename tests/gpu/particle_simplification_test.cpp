// Small, thin particles drawn by some of their number at reduced resolution: which ones, how much of them, and that the
// cloud stays what it is.
#include "tests/gpu/particle_draw_support.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sfumato::test {
namespace {

class ParticleSimplification : public ParticleDrawTest {};

// The documented share and ramp (docs/effects/particles.md), in double: by what the mass of a particle is multiplied.
double stood_for(uint32_t index, double working_radius, double optical_depth, double simplification) {
    const double variance = 0.12 * simplification * (1.0 - optical_depth / 0.25);
    if (working_radius >= 8.0 || variance <= 0.0)
        return 1.0;
    const double share = std::clamp(
        std::max(std::pow(working_radius / 8.0, 2), optical_depth / (optical_depth + variance)), 0.0625, 1.0);
    const double ramp = 0.5 * share * (1.0 - share);
    const double place = static_cast<double>(index * 2654435769u) / 4294967296.0;
    return std::clamp((share - place) / ramp, 0.0, 1.0) / (share - 0.5 * ramp);
}

// A cloud whose particles are small and thin at half resolution.
ParticleShot fine_cloud(double angle = 110.0) {
    ParticleShot shot = cloud_shot(angle, 20000);
    for (ParticleSprite& s : shot.sprites) {
        s.radius = 0.06f;
        s.extinction = 0.5f;
    }
    shot.extent = {192, 108};
    shot.parameters.resolution = ParticleResolution::half;
    shot.optional_outputs = true;
    return shot;
}

TEST_F(ParticleSimplification, each_particle_holds_what_the_formula_says) {
    constexpr uint32_t columns = 12, rows = 8, pitch = 20;
    ParticleShot shot;
    shot.extent = {columns * pitch, rows * pitch};
    shot.camera = shot.previous_camera = look_at({0, 0, 4}, {0, 0, 0}, 1.5, shot.extent);
    shot.lights = {white_light({0, 0, 1})};
    shot.parameters.resolution = ParticleResolution::half;
    shot.parameters.simplification = 0.8f;
    shot.optional_outputs = true;
    const double pixels = 1.5 * shot.extent.height / 4.0; // a scene unit
    constexpr double radius = 6.0, optical = 0.05;
    for (uint32_t i = 0; i < columns * rows; ++i) {
        const auto x = static_cast<float>((pitch * (i % columns + 0.5) - shot.extent.width / 2.0) / pixels);
        const auto y = static_cast<float>((shot.extent.height / 2.0 - pitch * (i / columns + 0.5)) / pixels);
        const auto r = static_cast<float>(radius / pixels);
        shot.sprites.push_back(sprite({x, y, 0}, r, static_cast<float>(optical) / (2.0f * r)));
    }
    const FloatImage left = shot.draw().transmittance;
    const double whole = 2.0 / 3.0 * std::numbers::pi * radius * radius * optical;
    double drawn = 0.0, ramped = 0.0;
    for (uint32_t i = 0; i < columns * rows; ++i) {
        double mass = 0.0;
        for (uint32_t y = 0; y < pitch; ++y)
            for (uint32_t x = 0; x < pitch; ++x)
                mass -= std::log(double{left.at(i % columns * pitch + x, i / columns * pitch + y)[0]});
        const double expected = stood_for(i, 0.5 * radius, optical, 0.8);
        EXPECT_NEAR(mass / whole, expected, 0.02 + 0.02 * expected) << i;
        drawn += expected > 0.0;
        ramped += expected > 0.0 && expected < 2.0;
    }
    // The test has particles of all three kinds: left out, on the ramp, and standing for others.
    EXPECT_GT(drawn, 20.0);
    EXPECT_LT(drawn, 60.0);
    EXPECT_GT(ramped, 2.0);
}

TEST_F(ParticleSimplification, the_cloud_stays_what_it_is_with_fewer_particles) {
    for (const auto mode : {ParticleMode::light_volume, ParticleMode::half_angle}) {
        ParticleShot shot = fine_cloud();
        shot.parameters.mode = mode;
        const ParticleImages fewer = shot.draw();
        shot.parameters.simplification = 0.0f;
        const ParticleImages all = shot.draw();
        EXPECT_LT(fewer.statistics.pairs, 0.7 * all.statistics.pairs);
        EXPECT_EQ(fewer.statistics.alive, all.statistics.alive);
        EXPECT_NEAR(optical_mass(fewer.transmittance) / optical_mass(all.transmittance), 1.0, 0.01);
        const double difference = rms_difference(fewer.output, all.output);
        std::printf("  mode %d: RMS difference %.4f, pairs %u of %u\n", static_cast<int>(mode), difference,
                    fewer.statistics.pairs, all.statistics.pairs);
        EXPECT_LT(difference, 0.02);
        EXPECT_GT(difference, 0.0);
    }
}

TEST_F(ParticleSimplification, what_is_large_or_dense_or_at_full_resolution_is_drawn_whole) {
    const auto same_bits = [](ParticleShot shot) {
        shot.parameters.simplification = 1.0f;
        const FloatImage a = shot.draw().output;
        shot.parameters.simplification = 0.0f;
        return a.values == shot.draw().output.values;
    };
    ParticleShot full = fine_cloud();
    full.parameters.resolution = ParticleResolution::full;
    EXPECT_TRUE(same_bits(full));
    ParticleShot dense = fine_cloud();
    for (ParticleSprite& s : dense.sprites)
        s.extinction = 0.26f / (2.0f * s.radius);
    EXPECT_TRUE(same_bits(dense));
    ParticleShot large = fine_cloud();
    large.sprites.resize(500);
    for (ParticleSprite& s : large.sprites)
        s.radius = 0.6f;
    EXPECT_TRUE(same_bits(large));
    // So dense that four times its optical depth overflows.
    ParticleShot heavy = fine_cloud();
    // The first one would be kept in any case; the second gives way where a share is drawn.
    heavy.sprites = {sprite({0, 0, 0}, 0.0f, 1.0f), sprite({0, 0, 0}, 0.2f, 3e38f)};
    EXPECT_TRUE(same_bits(heavy));
    EXPECT_GT(optical_mass(heavy.draw().transmittance), 10.0);
    heavy.parameters.resolution = ParticleResolution::full;
    EXPECT_GT(optical_mass(heavy.draw().transmittance), 10.0);
    EXPECT_FALSE(same_bits(fine_cloud()));
}

TEST_F(ParticleSimplification, particles_come_and_go_by_degrees_as_the_camera_comes_nearer) {
    ParticleShot shot = fine_cloud();
    const auto change = [&](float simplification) {
        shot.parameters.simplification = simplification;
        FloatImage before;
        double most = 0.0;
        for (int i = 0; i < 6; ++i) {
            shot.camera = shot.previous_camera = look_at({0, 0, 4.0 - 0.02 * i}, {0, 0, 0}, 1.5, shot.extent);
            const FloatImage now = shot.draw().output;
            if (i > 0)
                most = std::max(most, rms_difference(before, now));
            before = now;
        }
        return most;
    };
    const double fewer = change(0.5f), all = change(0.0f);
    std::printf("  greatest change from picture to picture: %.5f, with all particles %.5f\n", fewer, all);
    EXPECT_LT(fewer, 1.5 * all);
}

} // namespace
} // namespace sfumato::test
