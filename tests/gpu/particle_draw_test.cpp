// Drawing particles: order and blend, slices, scattering, edges at reduced resolution, shadows on the scene, velocity.
#include "tests/gpu/particle_draw_support.h"

#include <cmath>

namespace sfumato::test {
namespace {

class ParticleDraw : public ParticleDrawTest {};

// Four discs one behind the other, each seen through the one before.
ParticleShot stack(std::array<float, 3> to_light) {
    ParticleShot shot;
    shot.extent = {64, 48};
    shot.camera = shot.previous_camera = look_at({0, 0, 4}, {0, 0, 0}, 1.5, shot.extent);
    shot.sprites = {sprite({0, 0, -0.6f}, 0.4f, 1.6f, {0, 0, 1}), sprite({0.1f, 0, 0.6f}, 0.4f, 1.6f, {1, 0, 0}),
                    sprite({0, 0.1f, -0.2f}, 0.4f, 1.6f, {1, 1, 0}), sprite({0, 0, 0.2f}, 0.4f, 1.6f, {0, 1, 0})};
    shot.lights = {white_light(to_light)};
    return shot;
}

TEST_F(ParticleDraw, order_and_blend_follow_the_truth_on_both_sides_of_the_view_plane) {
    for (const float z : {0.2f, -0.2f, 1.0f, -1.0f, 0.0f})
        for (const auto mode : {ParticleMode::light_volume, ParticleMode::half_angle}) {
            ParticleShot shot = stack({std::abs(z) == 1.0f ? 0.0f : 0.9f, 0.1f, z});
            shot.parameters.mode = mode;
            shot.parameters.slices = 4;
            shot.parameters.layers = 128;
            // Seen in the wrong order the colours change places. Shadows with rims are not for four large spheres.
            const scene::ParticleTruth truth = shot.truth();
            const FloatImage picture = shot.draw().output;
            double sum = 0.0;
            for (size_t i = 0; i < truth.transmittance.size(); ++i)
                for (size_t c = 0; c < 3; ++c)
                    sum += std::pow(truth.colour[3 * i + c] - double{picture.values[4 * i + c]}, 2);
            const double rmse = std::sqrt(sum / static_cast<double>(truth.colour.size()));
            std::printf("  z %+.1f mode %d: RMSE %.4f\n", double{z}, static_cast<int>(mode), rmse);
            EXPECT_LT(rmse, 0.03) << z << " " << static_cast<int>(mode);
        }
}

TEST_F(ParticleDraw, a_slice_is_shadowed_by_earlier_slices_alone) {
    // Two spheres in the light's way to a third; slices of two: the second gets full light, the third both shadows.
    ParticleShot shot = stack({0, 1, 0.001f});
    shot.sprites = {sprite({0, 0.9f, 0}, 0.15f, 2.0f), sprite({0, 0.45f, 0}, 0.15f, 2.0f),
                    sprite({0, 0, 0}, 0.15f, 2.0f), sprite({0, -0.45f, 0}, 0.15f, 2.0f)};
    shot.parameters.mode = ParticleMode::half_angle;
    shot.parameters.slices = 2;
    const auto middle = [&](const FloatImage& image, double y) {
        const auto row = static_cast<uint32_t>(24.0 - y * 18.0);
        return double{image.at(31, row)[0]} / double{image.at(31, row)[3]};
    };
    const FloatImage two = shot.draw().output;
    EXPECT_NEAR(middle(two, 0.9), 1.0, 0.01);
    EXPECT_NEAR(middle(two, 0.45), 1.0, 0.01);
    EXPECT_NEAR(middle(two, 0.0), std::exp(-1.2), 0.04);
    EXPECT_NEAR(middle(two, -0.45), std::exp(-1.2), 0.04);
    shot.parameters.slices = 4;
    const FloatImage four = shot.draw().output;
    EXPECT_NEAR(middle(four, 0.45), std::exp(-0.6), 0.04);
    EXPECT_NEAR(middle(four, 0.0), std::exp(-1.2), 0.04);
    EXPECT_NEAR(middle(four, -0.45), std::exp(-1.8), 0.04);
}

TEST_F(ParticleDraw, extinction_can_differ_by_colour) {
    ParticleShot shot = cloud_shot(110.0, 1500);
    shot.parameters.shadow_colour_r = 0.5f;
    shot.parameters.shadow_colour_b = 2.0f;
    shot.parameters.scattering_octaves = 3;
    shot.parameters.phase = 0.4f;
    shot.parameters.ambient = 0.1f;
    EXPECT_LT(shot.error().rmse, 0.03);
    const FloatImage image = shot.draw().output;
    EXPECT_GT(image.at(64, 36)[0], 1.3f * image.at(64, 36)[2]);
}

TEST_F(ParticleDraw, several_lights_add_up) {
    ParticleShot shot = cloud_shot(110.0, 1500);
    shot.lights.push_back(white_light({-0.7f, 0.4f, 0.5f}));
    shot.lights.push_back(white_light({0.1f, 1.0f, 0.0f}));
    shot.lights[1].radiance = {3, 1, 0.5f};
    EXPECT_LT(shot.error().rmse, 0.03);
    shot.parameters.mode = ParticleMode::half_angle;
    shot.parameters.slices = 128;
    EXPECT_LT(shot.error().rmse, 0.03);
}

TEST_F(ParticleDraw, scattering_spreads_light_and_keeps_its_sum) {
    // All in one layer: what the layer leaves is blurred once for each layer behind it.
    ParticleShot shot = stack({0, 0, 1});
    shot.extent = {64, 64};
    shot.sprites = {sprite({-1, -1, 0.5f}, 0.01f, 0.01f), sprite({1, 1, -0.5f}, 0.01f, 0.01f),
                    sprite({0.1f, 0.2f, 0.5f}, 0.3f, 9.0f)};
    shot.parameters.shadow_resolution = 64;
    shot.parameters.layers = 16;
    shot.parameters.debug_view = ParticleView::shadow;
    const auto sum = [](const FloatImage& image) {
        double total = 0.0;
        for (size_t i = 0; i < image.values.size(); i += 4)
            total += 1.0 - double{image.values[i]};
        return total;
    };
    const FloatImage sharp = shot.draw().output;
    shot.parameters.scattering_blur = 0.02f;
    const FloatImage soft = shot.draw().output;
    EXPECT_NEAR(sum(soft), sum(sharp), 0.005 * sum(sharp));
    EXPECT_GT(rms_difference(soft, sharp), 0.03);
    // Variance by the metre, whatever the number of layers.
    shot.parameters.layers = 64;
    EXPECT_LT(rms_difference(soft, shot.draw().output), 0.012);
}

// A cloud behind and before bars at two depths.
ParticleShot barred_shot(double angle = 60.0) {
    ParticleShot shot = cloud_shot(angle, 2500);
    shot.depth = make_image(shot.extent, 1, [](uint32_t x, uint32_t y, float* p) {
        *p = x / 9 % 3 == 0 ? 3.2f : y / 11 % 2 == 0 ? 4.3f : 1e10f;
    });
    shot.colour = make_image(shot.extent, 4, [&](uint32_t x, uint32_t y, float* p) {
        const float z = *shot.depth.at(x, y);
        p[0] = z < 4.0f ? 0.1f : 0.3f, p[1] = 0.1f, p[2] = z > 100.0f ? 0.4f : 0.2f, p[3] = 1.0f;
    });
    return shot;
}

// Root mean square differences of two pictures where the depth has an edge beside the pixel, and elsewhere.
struct EdgeDifference {
    double edges = 0.0, rest = 0.0;
};
EdgeDifference edge_difference(const FloatImage& a, const FloatImage& b, const FloatImage& depth) {
    EdgeDifference sum, count;
    for (uint32_t y = 1; y + 1 < depth.extent.height; ++y)
        for (uint32_t x = 1; x + 1 < depth.extent.width; ++x) {
            const float z = *depth.at(x, y);
            const bool is_edge = *depth.at(x - 1, y) != z || *depth.at(x + 1, y) != z || *depth.at(x, y - 1) != z ||
                                 *depth.at(x, y + 1) != z;
            for (size_t c = 0; c < 3; ++c)
                (is_edge ? sum.edges : sum.rest) += std::pow(double{a.at(x, y)[c]} - double{b.at(x, y)[c]}, 2);
            (is_edge ? count.edges : count.rest) += 3.0;
        }
    return {std::sqrt(sum.edges / count.edges), std::sqrt(sum.rest / count.rest)};
}

TEST_F(ParticleDraw, reduced_resolution_is_like_full_even_at_edges) {
    struct Case {
        ParticleResolution resolution;
        ParticleMode mode;
        double angle, most;
    };
    for (const Case& c : {Case{ParticleResolution::half, ParticleMode::light_volume, 60.0, 0.02},
                          {ParticleResolution::quarter, ParticleMode::light_volume, 60.0, 0.04},
                          {ParticleResolution::half, ParticleMode::half_angle, 120.0, 0.02}}) {
        ParticleShot shot = barred_shot(c.angle);
        shot.parameters.mode = c.mode;
        const FloatImage full = shot.draw().output;
        shot.parameters.resolution = c.resolution;
        const FloatImage reduced = shot.draw().output;
        const EdgeDifference difference = edge_difference(full, reduced, shot.depth);
        std::printf("  1/%d: RMSE %.4f, at edges %.4f, elsewhere %.4f\n", 1 << static_cast<int>(c.resolution),
                    rms_difference(full, reduced), difference.edges, difference.rest);
        EXPECT_LT(rms_difference(full, reduced), c.most);
        EXPECT_LT(difference.edges, 1.8 * difference.rest + 0.004); // no halo
    }
}

TEST_F(ParticleDraw, surfaces_cut_spheres_softly) {
    ParticleShot shot = barred_shot();
    shot.colour = {};
    EXPECT_LT(shot.error().rmse, 0.03);
    // A wall through a sphere's middle leaves half of its depth.
    shot = stack({0, 0, 1});
    shot.sprites = {sprite({0, 0, 0}, 0.5f, 1.5f)};
    shot.optional_outputs = true;
    const std::pair<float, double> walls[] = {{4.0f, 0.5}, {3.4f, 0.0}, {4.6f, 1.0}, {3.75f, 0.25}};
    for (const std::pair<float, double>& pair : walls) {
        const float wall = pair.first;
        const double share = pair.second;
        shot.depth = make_image(shot.extent, 1, [&](uint32_t, uint32_t, float* p) { *p = wall; });
        EXPECT_NEAR(-std::log(shot.draw().transmittance.at(32, 24)[0]), 1.5 * share, 0.01) << wall;
    }
}

TEST_F(ParticleDraw, particles_shadow_what_lies_behind_them_for_the_light) {
    ParticleShot shot = stack({0, 0, 1});
    shot.sprites = {sprite({0, 0, 0.5f}, 0.3f, 2.0f), sprite({0, 0, -0.5f}, 0.3f, 2.0f)};
    shot.parameters.scene_shadow = 1.0f;
    shot.optional_outputs = true;
    shot.colour = make_image(shot.extent, 4, [](uint32_t, uint32_t, float* p) { std::fill_n(p, 4, 1.0f); });
    const auto scene_at = [&](float wall) {
        shot.depth = make_image(shot.extent, 1, [&](uint32_t, uint32_t, float* p) { *p = wall; });
        shot.parameters.light_strength = 0.0f;
        shot.lights[0].radiance = {0, 0, 0}; // the particles themselves are black
        const ParticleImages images = shot.draw();
        return double{images.output.at(32, 24)[0]} / double{images.transmittance.at(32, 24)[0]};
    };
    EXPECT_NEAR(scene_at(3.1f), 1.0, 0.01);            // before both
    EXPECT_NEAR(scene_at(4.0f), std::exp(-1.2), 0.03); // between them
    EXPECT_NEAR(scene_at(5.0f), std::exp(-2.4), 0.02); // behind both
    shot.direct = make_image(shot.extent, 3, [](uint32_t, uint32_t, float* p) { std::fill_n(p, 3, 0.6f); });
    EXPECT_NEAR(scene_at(5.0f), 0.4 + 0.6 * std::exp(-2.4), 0.02);
    shot.parameters.mode = ParticleMode::half_angle;
    EXPECT_NEAR(scene_at(5.0f), 0.4 + 0.6 * std::exp(-2.4), 0.02);
    shot.parameters.scene_shadow = 0.0f;
    EXPECT_NEAR(scene_at(5.0f), 1.0, 0.01);
}

TEST_F(ParticleDraw, the_scene_shadows_particles_through_the_shadow_map) {
    ParticleShot shot = stack({0, 0, 1});
    shot.sprites = {sprite({-0.5f, 0, 0}, 0.3f, 2.0f), sprite({0.5f, 0, 0}, 0.3f, 2.0f)};
    // x and y of the map are world x and -y from -1 to 1, depth falls from 1 to 0 as z goes from -1 to 1.
    shot.lights[0].world_to_shadow = {1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -0.5f, 0, 0, 0, 0.5f, 1};
    shot.shadow_map = make_image({32, 32}, 1, [](uint32_t x, uint32_t, float* p) { *p = x < 16 ? 0.1f : 1.0f; });
    const FloatImage image = shot.draw().output;
    EXPECT_LT(image.at(32 - 9, 24)[0], 1e-3f);
    EXPECT_GT(image.at(32 + 9, 24)[0], 0.5f);
}

TEST_F(ParticleDraw, velocity_is_that_of_what_is_seen) {
    ParticleShot shot = stack({0, 0, 1});
    shot.sprites = {sprite({0, 0, 0}, 0.5f, 30.0f)};
    shot.sprites[0].velocity = {6.0f, -3.0f, 0.0f}; // a tenth and a twentieth of a unit a frame
    shot.velocity = make_image(shot.extent, 2, [](uint32_t, uint32_t, float* p) { p[0] = -7.0f, p[1] = 2.0f; });
    shot.optional_outputs = true;
    for (const auto resolution : {ParticleResolution::full, ParticleResolution::half}) {
        shot.parameters.resolution = resolution;
        const ParticleImages images = shot.draw();
        EXPECT_NEAR(images.velocity.at(32, 24)[0], 1.8, 0.02);
        EXPECT_NEAR(images.velocity.at(32, 24)[1], 0.9, 0.02);
        EXPECT_NEAR(images.velocity.at(3, 3)[0], -7.0, 1e-3);
    }
    shot.sprites[0].velocity = {0, 0, 0};
    shot.previous_camera = look_at({-0.1, 0, 4}, {-0.1, 0, 0}, 1.5, shot.extent);
    EXPECT_NEAR(shot.draw().velocity.at(32, 24)[0], -1.8, 0.02);
}

TEST_F(ParticleDraw, debug_views_show_something) {
    ParticleShot shot = cloud_shot(60.0, 800);
    const FloatImage plain = shot.draw().output;
    for (const auto view : {ParticleView::order, ParticleView::slices, ParticleView::shadow, ParticleView::layers,
                            ParticleView::tiles, ParticleView::overflow}) {
        shot.parameters.debug_view = view;
        const FloatImage image = shot.draw().output;
        EXPECT_TRUE(all_finite(image));
        EXPECT_GT(rms_difference(image, plain), 0.02) << static_cast<int>(view);
    }
}

} // namespace
} // namespace sfumato::test
