// How a particle's optical depth is spread over its disc: by noise and by a texture, with a sphere's mass, the same in
// every frame and at every size.
#include "tests/gpu/particle_draw_support.h"

#include <cmath>
#include <limits>

namespace sfumato::test {
namespace {

class ParticleProfileTest : public ParticleDrawTest {};

constexpr float nan = std::numeric_limits<float>::quiet_NaN();
constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr double pi = 3.14159265358979;

// A blob off the middle, and a bright corner that only the disc's rim sees: no turn leaves it as it is.
FloatImage lopsided(Extent extent = {64, 64}, float scale = 1.0f) {
    return make_image(extent, 1, [&](uint32_t x, uint32_t y, float* p) {
        const double u = 2.0 * (x + 0.5) / extent.width - 1.0, v = 2.0 * (y + 0.5) / extent.height - 1.0;
        const double blob = std::exp(-8.0 * ((u - 0.35) * (u - 0.35) + (v + 0.1) * (v + 0.1)));
        *p = scale * static_cast<float>(blob + (u < -0.4 && v > 0.4 ? 0.5 : 0.0));
    });
}

ParticleShot profile_shot(ParticleProfile profile) {
    ParticleShot shot;
    shot.extent = {192, 108};
    shot.camera = shot.previous_camera = look_at({0, 0, 4}, {0, 0, 0}, 1.5, shot.extent);
    shot.lights = {white_light({0.2f, 0.3f, 1.0f})};
    shot.parameters.profile = profile;
    shot.parameters.profile_strength = 1.0f;
    shot.optional_outputs = true;
    if (profile == ParticleProfile::texture)
        shot.profile = lopsided();
    return shot;
}

// Six in two rows that touch nowhere and shadow each other nowhere.
std::vector<ParticleSprite> six() {
    std::vector<ParticleSprite> sprites;
    for (int i = 0; i < 6; ++i)
        sprites.push_back(sprite({-1.45f + 1.45f * static_cast<float>(i % 3), i < 3 ? 0.62f : -0.62f, 0}, 0.55f, 0.8f,
                                 {0.9f, 0.6f, 0.3f}));
    return sprites;
}

// A sphere's optical depth over its disc, in pixels.
double sphere_mass(const ParticleSprite& s, const ParticleShot& shot) {
    const double pixels = 1.5 * shot.extent.height / (4.0 - double{s.position[2]});
    return 4.0 / 3.0 * pi * std::pow(double{s.radius}, 3) * double{s.extinction} * pixels * pixels;
}

double transmittance_error(const ParticleShot& shot) {
    const scene::ParticleTruth truth = shot.truth();
    const FloatImage picture = shot.draw().transmittance;
    double sum = 0.0;
    for (size_t i = 0; i < truth.transmittance.size(); ++i)
        sum += std::pow(truth.transmittance[i] - double{picture.values[4 * i]}, 2);
    return std::sqrt(sum / static_cast<double>(truth.transmittance.size()));
}

TEST_F(ParticleProfileTest, without_strength_it_is_the_sphere_to_the_bit) {
    for (const auto profile : {ParticleProfile::noise, ParticleProfile::texture}) {
        ParticleShot shot = profile_shot(profile);
        shot.sprites = six();
        shot.parameters.profile_strength = 0.0f;
        const ParticleImages none = shot.draw();
        shot.parameters.profile_strength = 1.0f;
        EXPECT_GT(rms_difference(none.output, shot.draw().output), 0.02);
        shot.parameters.profile = ParticleProfile::sphere; // whose strength means nothing, and which leaves its image
        const ParticleImages sphere = shot.draw();
        EXPECT_EQ(first_difference(none.output, sphere.output), "");
        EXPECT_EQ(first_difference(none.transmittance, sphere.transmittance), "");
        shot.profile = {};
        EXPECT_EQ(first_difference(none.output, shot.draw().output), "");
    }
}

TEST_F(ParticleProfileTest, every_particle_holds_a_spheres_mass) {
    for (const auto profile : {ParticleProfile::noise, ParticleProfile::texture})
        for (const float scale : {1.0f, 2.0f, 6.0f}) {
            ParticleShot shot = profile_shot(profile);
            shot.parameters.profile_scale = scale;
            double worst = 0.0;
            for (int number = 0; number < 12; ++number) {
                shot.sprites.assign(static_cast<size_t>(number), sprite({0, 0, 0}, 0.0f, 0.0f)); // dead
                shot.sprites.push_back(sprite({0.01f, 0.02f, 0}, 1.2f, 0.3f));
                const double mass = optical_mass(shot.draw().transmittance) / sphere_mass(shot.sprites.back(), shot);
                worst = std::max(worst, std::abs(mass - 1.0));
            }
            std::printf("  profile %d, scale %.0f: %.2f %% off\n", static_cast<int>(profile), double{scale},
                        100.0 * worst);
            EXPECT_LT(worst, 0.01) << static_cast<int>(profile) << " " << scale;
        }
}

// Few pixels sample a pattern coarsely; the mean over particles is right all the same.
TEST_F(ParticleProfileTest, small_ones_hold_it_on_the_mean) {
    for (const auto profile : {ParticleProfile::noise, ParticleProfile::texture})
        for (const float radius : {0.1f, 0.2f, 0.4f}) { // 4, 8, 16 pixels
            ParticleShot shot = profile_shot(profile);
            double worst = 0.0, sum = 0.0;
            for (int number = 0; number < 24; ++number) {
                shot.sprites.assign(static_cast<size_t>(number), sprite({0, 0, 0}, 0.0f, 0.0f));
                shot.sprites.push_back(sprite({0.013f * static_cast<float>(number), 0.02f, 0}, radius, 0.4f / radius));
                const double mass = optical_mass(shot.draw().transmittance) / sphere_mass(shot.sprites.back(), shot);
                worst = std::max(worst, std::abs(mass - 1.0));
                sum += mass;
            }
            std::printf("  profile %d, radius %.1f: %+.2f %% on the mean, %.2f %% at most\n", static_cast<int>(profile),
                        double{radius}, 100.0 * (sum / 24.0 - 1.0), 100.0 * worst);
            EXPECT_NEAR(sum / 24.0, 1.0, 0.01) << static_cast<int>(profile) << " " << radius;
            EXPECT_LT(worst, 0.08) << static_cast<int>(profile) << " " << radius;
        }
}

TEST_F(ParticleProfileTest, a_texture_holds_a_spheres_mass_whatever_its_size_and_scale) {
    ParticleShot shot = profile_shot(ParticleProfile::texture);
    shot.sprites = {sprite({0.01f, 0.02f, 0}, 1.2f, 0.3f)};
    const double mass = sphere_mass(shot.sprites[0], shot);
    for (const auto& [size, scale] :
         {std::pair{Extent{64, 64}, 0.01f}, {{64, 64}, 500.0f}, {{1, 1}, 1.0f}, {{7, 300}, 1.0f}, {{700, 500}, 1.0f}}) {
        shot.profile = lopsided(size, scale);
        EXPECT_NEAR(optical_mass(shot.draw().transmittance) / mass, 1.0, 0.01) << size.width << " " << scale;
    }
    shot.parameters.profile_strength = 0.5f;
    EXPECT_NEAR(optical_mass(shot.draw().transmittance) / mass, 1.0, 0.01);
    // Nothing cannot be made to hold anything.
    shot.profile = make_image({8, 8}, 1, [](uint32_t, uint32_t, float* p) { *p = 0.0f; });
    EXPECT_NEAR(optical_mass(shot.draw().transmittance) / mass, 0.5, 0.005);
}

TEST_F(ParticleProfileTest, a_cloud_holds_its_mass) {
    ParticleShot shot = cloud_shot(60.0, 300);
    shot.optional_outputs = true;
    for (ParticleSprite& s : shot.sprites)
        s.radius = 0.3f, s.extinction = 0.1f;
    const double sphere = optical_mass(shot.draw().transmittance);
    shot.parameters.profile_strength = 1.0f;
    shot.profile = lopsided();
    for (const auto profile : {ParticleProfile::noise, ParticleProfile::texture}) {
        shot.parameters.profile = profile;
        EXPECT_NEAR(optical_mass(shot.draw().transmittance) / sphere, 1.0, 0.01) << static_cast<int>(profile);
    }
}

TEST_F(ParticleProfileTest, follows_the_truth_where_nothing_is_shadowed) {
    for (const auto profile : {ParticleProfile::noise, ParticleProfile::texture})
        for (const float strength : {1.0f, 0.4f})
            for (const auto mode : {ParticleMode::light_volume, ParticleMode::half_angle}) {
                ParticleShot shot = profile_shot(profile);
                shot.parameters.profile_strength = strength;
                shot.parameters.mode = mode;
                shot.sprites = six();
                const scene::ParticleError error = shot.error();
                const double through = transmittance_error(shot);
                std::printf("  profile %d, strength %.1f: RMSE %.5f, of transmittance %.5f\n",
                            static_cast<int>(profile), double{strength}, error.rmse, through);
                EXPECT_LT(error.rmse, 1e-3);
                EXPECT_LT(through, 1e-3);
            }
}

TEST_F(ParticleProfileTest, follows_the_truth_at_every_size_of_the_disc) {
    for (const auto profile : {ParticleProfile::noise, ParticleProfile::texture}) {
        ParticleShot shot = profile_shot(profile);
        shot.parameters.profile_scale = 2.0f;
        for (const float radius : {0.03f, 0.06f, 0.1f, 0.3f, 1.2f}) { // 1.2 to 49 pixels
            shot.sprites = six();
            for (ParticleSprite& s : shot.sprites) {
                s.radius = radius;
                s.extinction = 0.5f / radius;
                s.position[2] = radius > 1.0f ? s.position[0] : 0.0f; // a definite order
            }
            EXPECT_LT(transmittance_error(shot), 1e-3) << static_cast<int>(profile) << " " << radius;
        }
    }
}

TEST_F(ParticleProfileTest, a_cloud_that_shadows_itself_follows_the_truth) {
    for (const auto profile : {ParticleProfile::sphere, ParticleProfile::noise, ParticleProfile::texture})
        for (const double angle : {60.0, 130.0}) {
            ParticleShot shot = cloud_shot(angle, 700);
            for (ParticleSprite& s : shot.sprites)
                s.radius = 0.25f, s.extinction = 0.7f;
            shot.parameters.profile = profile;
            shot.parameters.profile_strength = 1.0f;
            shot.profile = lopsided();
            const scene::ParticleError error = shot.error();
            std::printf("  profile %d, %3.0f degrees: RMSE %.4f, bias %+.3f\n", static_cast<int>(profile), angle,
                        error.rmse, error.bias);
            EXPECT_LT(error.rmse, 0.03);
        }
}

// The part of a picture about a particle of six().
FloatImage about(const FloatImage& image, int number) {
    const Extent size{60, 48};
    const auto left = static_cast<uint32_t>(96.0 + 40.5 * (-1.45 + 1.45 * (number % 3))) - size.width / 2;
    const auto top = static_cast<uint32_t>(54.0 - 40.5 * (number < 3 ? 0.62 : -0.62)) - size.height / 2;
    return make_image(size, image.components, [&](uint32_t x, uint32_t y, float* p) {
        std::copy_n(image.at(x + left, y + top), image.components, p);
    });
}

TEST_F(ParticleProfileTest, the_pattern_stays_with_its_particle) {
    for (const auto profile : {ParticleProfile::noise, ParticleProfile::texture}) {
        ParticleShot shot = profile_shot(profile);
        shot.sprites = six();
        const FloatImage first = shot.draw().transmittance;
        // The others change their order in depth, and one of them dies.
        shot.sprites[0].position[2] = -0.5f;
        shot.sprites[3].position[2] = 0.5f;
        shot.sprites[5].position[2] = 0.2f;
        shot.sprites[2].radius = 0.0f;
        const FloatImage second = shot.draw().transmittance;
        for (const int same : {1, 4})
            EXPECT_EQ(first_difference(about(first, same), about(second, same)), "") << same;
        // Among the same particles in other slots it is another's.
        std::swap(shot.sprites[1], shot.sprites[4]);
        std::swap(shot.sprites[1].position, shot.sprites[4].position);
        EXPECT_EQ(first_difference(second, shot.draw().transmittance), ""); // alike but for their places
        std::swap(shot.sprites[1].position, shot.sprites[4].position);
        EXPECT_GT(rms_difference(about(second, 1), about(shot.draw().transmittance, 1)), 0.05);
    }
}

TEST_F(ParticleProfileTest, looks_alike_at_half_the_size) {
    for (const auto profile : {ParticleProfile::noise, ParticleProfile::texture}) {
        ParticleShot shot = profile_shot(profile);
        shot.extent = {256, 144};
        shot.sprites = six();
        const FloatImage large = shot.draw().transmittance;
        shot.extent = {128, 72};
        const FloatImage small = shot.draw().transmittance;
        const FloatImage halved = make_image(shot.extent, 4, [&](uint32_t x, uint32_t y, float* p) {
            for (uint32_t i = 0; i < 4; ++i)
                p[i] = 0.25f * (large.at(2 * x, 2 * y)[i] + large.at(2 * x + 1, 2 * y)[i] +
                                large.at(2 * x, 2 * y + 1)[i] + large.at(2 * x + 1, 2 * y + 1)[i]);
        });
        shot.parameters.profile = ParticleProfile::sphere;
        const double pattern = rms_difference(small, shot.draw().transmittance);
        std::printf("  profile %d: %.4f of a pattern of %.4f\n", static_cast<int>(profile),
                    rms_difference(small, halved), pattern);
        EXPECT_LT(rms_difference(small, halved), 0.15 * pattern);
    }
}

TEST_F(ParticleProfileTest, small_discs_are_spheres) {
    for (const auto profile : {ParticleProfile::noise, ParticleProfile::texture}) {
        ParticleShot shot = profile_shot(profile);
        shot.parameters.profile_scale = 3.0f;
        shot.sprites = six();
        for (ParticleSprite& s : shot.sprites)
            s.radius = 0.048f, s.extinction = 5.0f; // 1.9 pixels
        const FloatImage patterned = shot.draw().transmittance;
        shot.parameters.profile = ParticleProfile::sphere;
        EXPECT_LT(rms_difference(patterned, shot.draw().transmittance), 1e-6);
    }
}

// Where the optical depth about a particle of six() lies, as an angle about its middle.
double heavy_side(const FloatImage& transmittance, int number) {
    const FloatImage part = about(transmittance, number);
    double x_sum = 0.0, y_sum = 0.0;
    for (uint32_t y = 0; y < part.extent.height; ++y)
        for (uint32_t x = 0; x < part.extent.width; ++x) {
            const double depth = -std::log(double{part.at(x, y)[0]});
            x_sum += depth * (x + 0.5 - 0.5 * part.extent.width);
            y_sum += depth * (y + 0.5 - 0.5 * part.extent.height);
        }
    return std::atan2(y_sum, x_sum);
}

TEST_F(ParticleProfileTest, every_particle_turns_its_texture) {
    ParticleShot shot = profile_shot(ParticleProfile::texture);
    shot.profile = make_image({32, 32}, 1, [](uint32_t x, uint32_t, float* p) { *p = x < 16 ? 0.0f : 1.0f; });
    shot.sprites = six();
    const FloatImage picture = shot.draw().transmittance;
    std::vector<double> angles;
    for (int i = 0; i < 6; ++i)
        angles.push_back(heavy_side(picture, i));
    double nearest = 10.0;
    for (size_t i = 0; i < 6; ++i)
        for (size_t j = 0; j < i; ++j)
            nearest = std::min(nearest, std::abs(std::remainder(angles[i] - angles[j], 2.0 * pi)));
    EXPECT_GT(nearest, 0.03); // no two of these six are alike
    EXPECT_LT(transmittance_error(shot), 2e-3);
}

TEST_F(ParticleProfileTest, wild_texels_are_tamed) {
    ParticleShot shot = profile_shot(ParticleProfile::texture);
    shot.sprites = six();
    const FloatImage good = shot.profile;
    const auto with = [&](float value) {
        shot.profile = good;
        for (uint32_t y = 20; y < 24; ++y)
            std::fill_n(shot.profile.at(17, y), 3, value);
        return shot.draw().output;
    };
    const FloatImage zeros = with(0.0f), most = with(4096.0f);
    for (const float value : {nan, -infinity, -1.0f, -1e30f})
        EXPECT_EQ(first_difference(with(value), zeros), "") << value;
    for (const float value : {infinity, 1e30f, 65504.0f})
        EXPECT_EQ(first_difference(with(value), most), "") << value;
    EXPECT_TRUE(all_finite(most));
    for (const float value : {nan, infinity, -1.0f}) {
        std::fill(shot.profile.values.begin(), shot.profile.values.end(), value);
        EXPECT_TRUE(all_finite(shot.draw().output)) << value;
    }
}

TEST_F(ParticleProfileTest, reduced_resolution_backward_order_and_debug_views_know_it) {
    for (const auto profile : {ParticleProfile::noise, ParticleProfile::texture}) {
        ParticleShot shot = profile_shot(profile);
        shot.sprites = six();
        const FloatImage full = shot.draw().transmittance;
        shot.parameters.resolution = ParticleResolution::half;
        EXPECT_LT(rms_difference(full, shot.draw().transmittance), 0.03);
        shot.parameters.resolution = ParticleResolution::full;
        shot.parameters.mode = ParticleMode::half_angle;
        shot.lights = {white_light({0, 0.2f, -1})}; // from far to near
        EXPECT_LT(rms_difference(full, shot.draw().transmittance), 1e-3);
        shot.optional_outputs = false; // no velocities beside the patterns
        const FloatImage alone = shot.draw().output;
        shot.optional_outputs = true;
        EXPECT_EQ(first_difference(alone, shot.draw().output), "");
    }
}

TEST_F(ParticleProfileTest, equal_input_gives_equal_bits) {
    for (const auto profile : {ParticleProfile::noise, ParticleProfile::texture}) {
        ParticleShot shot = profile_shot(profile);
        shot.sprites = six();
        EXPECT_EQ(first_difference(shot.draw(0).output, shot.draw(0x5c).output), "");
    }
}

TEST_F(ParticleProfileTest, a_texture_that_is_missing_is_an_error_of_one_line) {
    ParticleVolumeParameters parameters;
    ParticleVolumeImages images{};
    images.colour = {.format = VK_FORMAT_R16G16B16A16_SFLOAT, .extent = {64, 36}};
    images.output = images.colour;
    images.depth = {.format = VK_FORMAT_R32_SFLOAT, .extent = {64, 36}};
    Frame frame;
    frame.camera = look_at({0, 0, 4}, {0, 0, 0}, 1.5, {64, 36});
    const auto planned = [&] { return plan_effect(ParticleVolume::info(), frame, &parameters, &images); };
    ASSERT_TRUE(planned());
    parameters.profile = ParticleProfile::texture;
    const auto refused = planned();
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::invalid_argument);
    EXPECT_EQ(refused.error().message, "particles: profile is texture, but image 'profile' is missing");
    images.profile = images.depth;
    EXPECT_TRUE(planned());
}

} // namespace
} // namespace sfumato::test
