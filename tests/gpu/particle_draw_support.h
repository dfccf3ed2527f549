// Clouds, cameras and lights for the tests of drawing particles, and the device's pictures of them.
#pragma once

#include "scene/particle_truth.h"
#include "tests/gpu/gpu_test.h"

#include <array>
#include <vector>

namespace sfumato::test {

using scene::look_at;

// Draws of one suite share a context, and so its pipelines.
class ParticleDrawTest : public GpuTest {
  public:
    static void TearDownTestSuite();
};

// What the device drew.
struct ParticleImages {
    FloatImage output, velocity, transmittance; // the latter two where they were asked for
    ParticleStatistics statistics{};
};

// Particles, camera and lights. The picture is black with nothing in it unless `colour` and `depth` are set.
struct ParticleShot {
    Extent extent{128, 72};
    std::vector<ParticleSprite> sprites;
    std::vector<Light> lights;
    Camera camera, previous_camera;
    ParticleVolumeParameters parameters;
    FloatImage colour, depth, direct, shadow_map, velocity, profile;
    bool optional_outputs = false;

    ParticleShot();
    Frame frame() const;
    scene::ParticleTruth truth() const;
    ParticleImages draw(int poison = -1) const; // poison: as in ContextInfo
    // Against the truth; the picture must be black.
    scene::ParticleError error() const { return scene::particle_error(truth(), draw().output.values, 4); }
};

// The standard cloud from z = 4, lit from `angle` degrees between the ways to the eye and to the light, 0…180: below
// 90 the light stands behind the camera. The light's radiance makes an isotropic, unshadowed particle white.
ParticleShot cloud_shot(double angle, uint32_t count = 3000);
Light white_light(std::array<float, 3> to_light);

ParticleSprite sprite(std::array<float, 3> position, float radius, float extinction,
                      std::array<float, 3> albedo = {1, 1, 1});

// Root mean square of the differences of the first three channels.
double rms_difference(const FloatImage& a, const FloatImage& b);
// Sum of all particles' optical depths over the picture, in pixels.
double optical_mass(const FloatImage& transmittance);

} // namespace sfumato::test
