// What goes wrong in particle renderers: no particles, broken ones, large and tiny ones, lights from above, equal keys,
// slices that do not divide, too many pairs.
#include "tests/gpu/particle_draw_support.h"

#include <cmath>
#include <limits>

namespace sfumato::test {
namespace {

class ParticleDrawTraps : public ParticleDrawTest {};

constexpr float nan = std::numeric_limits<float>::quiet_NaN();
constexpr float infinity = std::numeric_limits<float>::infinity();

ParticleShot empty_shot() {
    ParticleShot shot;
    shot.extent = {64, 48};
    shot.camera = shot.previous_camera = look_at({0, 0, 4}, {0, 0, 0}, 1.5, shot.extent);
    shot.lights = {white_light({0.3f, 0.8f, 0.5f})};
    return shot;
}

FloatImage gradient(Extent extent) {
    return make_image(extent, 4, [](uint32_t x, uint32_t y, float* p) {
        p[0] = 0.01f * static_cast<float>(x), p[1] = 0.02f * static_cast<float>(y), p[2] = 0.7f, p[3] = 0.5f;
    });
}

TEST_F(ParticleDrawTraps, without_live_particles_the_picture_stays_as_it_is) {
    ParticleShot shot = empty_shot();
    shot.colour = gradient(shot.extent);
    shot.parameters.scene_shadow = 1.0f;
    shot.optional_outputs = true;
    shot.depth = make_image(shot.extent, 1, [](uint32_t, uint32_t, float* p) { *p = 5.0f; });
    shot.sprites = {sprite({0, 0, 0}, 0.0f, 1.0f),
                    sprite({0, 0, 0}, -1.0f, 1.0f),
                    sprite({nan, 0, 0}, 1.0f, 1.0f),
                    sprite({0, infinity, 0}, 1.0f, 1.0f),
                    sprite({0, 0, 0}, nan, 1.0f),
                    sprite({0, 0, 0}, 1.0f, infinity),
                    sprite({0, 0, 0}, 1.0f, 1.0f, {1, nan, 1})};
    for (const auto mode : {ParticleMode::light_volume, ParticleMode::half_angle}) {
        shot.parameters.mode = mode;
        const ParticleImages images = shot.draw(0xff);
        EXPECT_EQ(first_difference(images.output, shot.colour), "");
        EXPECT_EQ(images.transmittance.at(9, 9)[0], 1.0f);
        const ParticleStatistics& s = images.statistics;
        EXPECT_EQ(s.alive + s.drawn + s.pairs + s.pairs_wanted + s.overflow + s.reserved_0, 0u);
    }
}

TEST_F(ParticleDrawTraps, one_particle_is_a_sphere_in_full_light) {
    ParticleShot shot = empty_shot();
    shot.optional_outputs = true;
    shot.sprites = {sprite({0, 0, 0}, 0.5f, 1.5f, {0.9f, 0.6f, 0.3f})};
    for (const auto mode : {ParticleMode::light_volume, ParticleMode::half_angle}) {
        shot.parameters.mode = mode;
        const ParticleImages images = shot.draw();
        // The middle lies between four pixels, half a pixel of 18 off in x and y.
        const double alpha = 1.0 - std::exp(-1.5 * std::sqrt(1.0 - 0.5 / 324.0));
        EXPECT_NEAR(images.transmittance.at(32, 24)[0], 1.0 - alpha, 1e-3);
        EXPECT_NEAR(images.output.at(32, 24)[0], 0.9 * alpha, 2e-3);
        EXPECT_NEAR(images.output.at(32, 24)[2], 0.3 * alpha, 2e-3);
        EXPECT_NEAR(images.output.at(32, 24)[3], alpha, 1e-3);
        EXPECT_EQ(images.transmittance.at(2, 24)[0], 1.0f);
        EXPECT_LT(shot.error().rmse, 1e-3);
        EXPECT_EQ(images.statistics.alive, 1u);
        EXPECT_EQ(images.statistics.drawn, 1u);
    }
}

TEST_F(ParticleDrawTraps, broken_particles_change_nothing) {
    ParticleShot shot = cloud_shot(70.0, 300);
    shot.extent = {64, 36};
    const FloatImage expected = shot.draw().output;
    size_t field = 0;
    std::vector<ParticleSprite> mixed;
    for (const ParticleSprite& s : shot.sprites) {
        mixed.push_back(s);
        ParticleSprite broken = s;
        float* numbers = reinterpret_cast<float*>(&broken);
        numbers[field % 12] = field % 2 == 0 ? nan : -infinity;
        ++field;
        mixed.push_back(broken);
    }
    shot.sprites = mixed;
    const ParticleImages images = shot.draw(0xff);
    EXPECT_EQ(first_difference(images.output, expected), "");
    EXPECT_EQ(images.statistics.alive, 300u);
}

TEST_F(ParticleDrawTraps, behind_the_camera_and_before_the_near_plane_nothing_is_drawn) {
    ParticleShot shot = empty_shot();
    shot.optional_outputs = true;
    shot.sprites = {sprite({0, 0, 4.5f}, 0.3f, 1.0f), sprite({0, 0, 4.0f}, 1.0f, 1.0f),
                    sprite({0, 0, 3.96f}, 1.0f, 1.0f), sprite({0, 0, 400.0f}, 100.0f, 1.0f)};
    const ParticleImages images = shot.draw();
    for (size_t i = 0; i < images.transmittance.values.size(); i += 4)
        ASSERT_EQ(images.transmittance.values[i], 1.0f);
    EXPECT_EQ(images.statistics.alive, 4u);
    EXPECT_EQ(images.statistics.drawn, 0u);
}

TEST_F(ParticleDrawTraps, particles_larger_than_the_screen_and_near_ones_follow_the_truth) {
    ParticleShot shot = empty_shot();
    shot.sprites = {sprite({0.2f, 0.1f, 0}, 9.0f, 0.05f), sprite({0, 0, 3.9f}, 0.4f, 0.5f, {1, 0.5f, 0.2f}),
                    sprite({-3.0f, 0, -8.0f}, 30.0f, 0.01f), sprite({0, 0, 3.94f}, 20.0f, 0.01f)};
    for (const float fade : {0.0f, 0.5f}) {
        shot.parameters.near_fade = fade;
        const ParticleImages images = shot.draw();
        EXPECT_TRUE(all_finite(images.output));
        EXPECT_EQ(images.statistics.drawn, 4u);
        // Light on one that fills the screen many times is known at five places alone.
        EXPECT_LT(shot.error().rmse, 0.05);
    }
}

TEST_F(ParticleDrawTraps, particles_smaller_than_a_pixel_keep_their_mass) {
    ParticleShot shot = empty_shot();
    shot.optional_outputs = true;
    const double pixels = 1.5 * 48 / 4.0; // a scene unit's at the particle
    for (const float radius : {0.003f, 0.02f, 0.05f, 0.1f})
        for (const float shift : {0.0f, 0.011f, 0.031f}) {
            const float extinction = 0.0005f / (radius * radius * radius);
            shot.sprites = {sprite({shift, 0.7f * shift, 0}, radius, extinction)};
            const double mass = 4.0 / 3.0 * 3.14159265 * double{radius} * radius * radius * extinction;
            EXPECT_NEAR(optical_mass(shot.draw().transmittance) / (mass * pixels * pixels), 1.0, 0.02)
                << radius << " " << shift;
        }
}

// Sum of optical depth over the shadow buffer, in square scene units: the debug view shows a texel a pixel.
double shadow_mass(ParticleShot shot, uint32_t side, double width) {
    shot.extent = {side, side};
    shot.camera = shot.previous_camera = look_at({0, 0, 4}, {0, 0, 0}, 1.5, shot.extent);
    shot.parameters.shadow_resolution = static_cast<int>(side);
    shot.parameters.debug_view = ParticleView::shadow;
    const double texel = std::exp2(std::ceil(std::log2(width / (side - 4.0)) * 8.0) / 8.0);
    return optical_mass(shot.draw().output) * texel * texel;
}

TEST_F(ParticleDrawTraps, the_shadow_buffer_holds_the_particles_mass_at_any_resolution_and_slice_count) {
    ParticleShot shot = empty_shot();
    shot.lights = {white_light({0, 0, 1})};
    // The outer ones set the bounds; below a texel, some texels, many.
    shot.sprites = {sprite({-1, -1, 0.1f}, 0.004f, 1000.0f), sprite({0.9f, 0.9f, -0.3f}, 0.1f, 1.0f),
                    sprite({0.3f, 0.2f, 0.8f}, 0.05f, 9.0f), sprite({-0.2f, 0.2f, 0.5f}, 0.02f, 8.0f),
                    sprite({-0.21f, 0.37f, -0.5f}, 0.012f, 30.0f)};
    double mass = 0.0;
    for (const ParticleSprite& s : shot.sprites)
        mass += 4.0 / 3.0 * 3.14159265 * std::pow(double{s.radius}, 3) * double{s.extinction};
    for (const uint32_t side : {64u, 128u})
        for (const auto mode : {ParticleMode::light_volume, ParticleMode::half_angle})
            for (const int layers : {4, 31}) {
                shot.parameters.mode = mode;
                shot.parameters.layers = shot.parameters.slices = layers;
                EXPECT_NEAR(shadow_mass(shot, side, 2.004) / mass, 1.0, 0.01) << side << " " << layers;
            }
}

TEST_F(ParticleDrawTraps, light_from_straight_above_and_below_and_across_the_view) {
    for (const auto& light : {std::array{0.0f, 1.0f, 0.0f}, {0.0f, -1.0f, 0.0f}, {1.0f, 0.0f, 0.0f}})
        for (const auto mode : {ParticleMode::light_volume, ParticleMode::half_angle}) {
            ParticleShot shot = cloud_shot(0.0, 1500);
            shot.extent = {64, 36};
            shot.lights = {white_light(light)};
            shot.parameters.mode = mode;
            shot.parameters.slices = 256;
            EXPECT_LT(shot.error().rmse, 0.025) << light[0] << light[1];
        }
}

TEST_F(ParticleDrawTraps, equal_keys_keep_the_order_of_their_slots) {
    ParticleShot shot = empty_shot();
    for (int i = 0; i < 200; ++i)
        shot.sprites.push_back(sprite({0, 0, 0}, 0.6f, i == 0 ? 20.0f : 3.0f,
                                      i == 0 ? std::array{1.0f, 0.0f, 0.0f} : std::array{0.0f, 1.0f, 0.0f}));
    shot.lights = {white_light({0, 0, 1})};
    for (const auto bits : {ParticleSortBits::bits_16, ParticleSortBits::bits_24, ParticleSortBits::bits_32}) {
        shot.parameters.sort_bits = bits;
        const FloatImage first = shot.draw(0).output;
        EXPECT_EQ(first_difference(first, shot.draw(0x45).output), "");
        EXPECT_GT(first.at(32, 24)[0], 0.99f); // the first slot lies in front
    }
}

TEST_F(ParticleDrawTraps, no_particle_is_left_out_where_slices_do_not_divide_their_number) {
    ParticleShot shot = cloud_shot(60.0, 301);
    shot.extent = {64, 36};
    shot.optional_outputs = true;
    shot.parameters.mode = ParticleMode::half_angle;
    shot.parameters.slices = 7; // of 43
    const ParticleImages seven = shot.draw();
    shot.parameters.slices = 64; // of 5, the last ones empty
    const ParticleImages many = shot.draw();
    EXPECT_EQ(seven.statistics.drawn, 301u);
    EXPECT_EQ(first_difference(seven.transmittance, many.transmittance), "");
    const scene::ParticleTruth truth = shot.truth();
    double worst = 0.0;
    for (size_t i = 0; i < truth.transmittance.size(); ++i)
        worst = std::max(worst, std::abs(truth.transmittance[i] - double{many.transmittance.values[4 * i]}));
    EXPECT_LT(worst, 3e-3);
}

TEST_F(ParticleDrawTraps, too_many_pairs_are_left_out_from_the_far_end_and_reported) {
    ParticleShot shot = empty_shot();
    shot.extent = {128, 96};
    shot.camera = look_at({0, 0, 4}, {0, 0, 0}, 1.5, shot.extent);
    for (int i = 0; i < 200; ++i) // all over the screen; the near ones stand in the last slots
        shot.sprites.push_back(sprite({0, 0, -3.0f + 0.01f * static_cast<float>(i)}, 8.0f, 0.05f));
    shot.parameters.pairs_per_particle = 1;
    const ParticleImages images = shot.draw();
    const ParticleStatistics& s = images.statistics;
    EXPECT_EQ(s.pairs_wanted, 200u * 48u);
    EXPECT_EQ(s.pairs, 200u + 16u * 48u);
    EXPECT_EQ(s.overflow & 1u, 1u);
    EXPECT_TRUE(all_finite(images.output));
    shot.parameters.debug_view = ParticleView::overflow;
    EXPECT_EQ(shot.draw().output.at(64, 48)[0], 1.0f);
    // What is there is the nearest: the same as these alone, but for light.
    shot.parameters.debug_view = ParticleView::none;
    shot.optional_outputs = true;
    const FloatImage cut = shot.draw().transmittance;
    shot.sprites.erase(shot.sprites.begin(), shot.sprites.end() - 20);
    shot.parameters.pairs_per_particle = 64;
    EXPECT_NEAR(shot.draw().transmittance.at(20, 20)[0], cut.at(20, 20)[0], 0.02f);
}

TEST_F(ParticleDrawTraps, a_burst_at_one_place_does_not_overflow_the_shadow_buffer) {
    ParticleShot shot = empty_shot();
    for (int i = 0; i < 5000; ++i)
        shot.sprites.push_back(sprite({0, 0.3f, 0}, 0.2f, 100.0f));
    shot.sprites.push_back(sprite({0, -0.5f, 0}, 0.15f, 3.0f)); // in their shadow
    shot.lights = {white_light({0, 1, 0})};
    const ParticleImages images = shot.draw();
    EXPECT_EQ(images.statistics.overflow & 2u, 2u); // 40 through each
    EXPECT_LT(images.output.at(32, 33)[0], 1e-3f);
}

TEST_F(ParticleDrawTraps, equal_input_gives_equal_bits) {
    ParticleShot shot = cloud_shot(100.0, 1000);
    shot.optional_outputs = true;
    shot.parameters.resolution = ParticleResolution::half;
    for (const auto mode : {ParticleMode::light_volume, ParticleMode::half_angle}) {
        shot.parameters.mode = mode;
        const ParticleImages a = shot.draw(0), b = shot.draw(0x3d);
        EXPECT_EQ(first_difference(a.output, b.output), "");
        EXPECT_EQ(first_difference(a.velocity, b.velocity), "");
    }
}

} // namespace
} // namespace sfumato::test
