// Particles as drawn on the device against the brute-force truth: both modes, both sides of v·l = 0.
#include "tests/gpu/particle_draw_support.h"

namespace sfumato::test {
namespace {

class ParticleDrawTruth : public ParticleDrawTest {};

double error_of(double angle, ParticleMode mode, int layers) {
    ParticleShot shot = cloud_shot(angle);
    shot.parameters.mode = mode;
    (mode == ParticleMode::half_angle ? shot.parameters.slices : shot.parameters.layers) = layers;
    const scene::ParticleError error = shot.error();
    std::printf("  %3.0f degrees, %s %3d: RMSE %.4f, bias %+.3f, P99 %.4f\n", angle,
                mode == ParticleMode::half_angle ? "half-angle  " : "light-volume", layers, error.rmse, error.bias,
                error.p99);
    return error.rmse;
}

TEST_F(ParticleDrawTruth, sixteen_layers_beat_64_half_angle_slices_on_both_sides) {
    for (const double angle : {40.0, 110.0, 150.0}) {
        const double volume = error_of(angle, ParticleMode::light_volume, 16);
        EXPECT_LT(volume, 0.85 * error_of(angle, ParticleMode::half_angle, 64)) << angle;
        EXPECT_LT(volume, 0.015) << angle;
    }
}

TEST_F(ParticleDrawTruth, more_slices_approach_the_truth) {
    for (const double angle : {60.0, 130.0}) {
        const double few = error_of(angle, ParticleMode::half_angle, 16);
        const double more = error_of(angle, ParticleMode::half_angle, 64);
        const double many = error_of(angle, ParticleMode::half_angle, 256);
        EXPECT_LT(more, 0.6 * few) << angle;
        EXPECT_LT(many, more) << angle;
        EXPECT_LT(many, 0.03) << angle;
    }
}

} // namespace
} // namespace sfumato::test
