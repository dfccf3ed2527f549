// Ground truth of particles, computed on the CPU in double precision without slices, layers or tiles; and the clouds
// that it is compared on.
#pragma once

#include "scene/particle_profile.h"
#include "sfumato/effects/particles.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace sfumato::scene {

// What of ParticleVolumeParameters the truth follows: shadow colour, phase, octaves, ambient, soft distance, near fade,
// the light where the frame has none, the profile. Sprites are drawn as discs that face the camera at their middle's
// depth, with a sphere's optical depth or the profile's; they shadow as spheres.
struct ParticleTruth {
    Extent extent;
    std::vector<double> colour;        // rgb, premultiplied: the light of the particles alone
    std::vector<double> transmittance; // share of what lies behind that is seen
    uint64_t fragments = 0;            // that were lit
};

// For every pixel, from near to far: C = Σ T α (albedo L + glow), with α = 1 - exp(-2 r σ √(1 - ρ²)), and L at the
// fragment's own place: every particle whose middle is nearer the light takes away exp(-c τ), τ its optical depth along
// the light's ray through that place. `depth`: linear view depth of the scene, extent's size, or empty for none.
// `threads`: 1 and more; the result does not depend on it. `texture`: for the profile of that name.
ParticleTruth particle_truth(std::span<const ParticleSprite> sprites, const Frame& frame,
                             const ParticleVolumeParameters& parameters, Extent extent,
                             std::span<const float> depth = {}, unsigned threads = 2,
                             const ParticleTexture& texture = {});

// Root mean square, mean difference in shares of the truth's mean, and the 99th percentile of the absolute difference,
// of the luminance of colours without alpha in rows of `stride` values a pixel.
struct ParticleError {
    double rmse = 0.0;
    double bias = 0.0;
    double p99 = 0.0;
};
ParticleError particle_error(const ParticleTruth& truth, std::span<const float> picture, size_t stride);

struct ParticleCloud {
    uint32_t count = 4096;
    float size = 1.0f; // radius of the ball that is warped, scene units
    float radius = 0.1f;
    float extinction = 0.5f;
    float variation = 0.0f; // of radius and albedo, 0…1
    uint32_t seed = 1;
};

// A ball about the origin with lobes and hollows, the same bits everywhere.
std::vector<ParticleSprite> particle_cloud(const ParticleCloud& cloud);

// A camera at `eye` that looks at `target`; `focal` in image heights. Reversed infinite depth, near plane at 0.05.
Camera look_at(std::array<double, 3> eye, std::array<double, 3> target, double focal, Extent extent);

} // namespace sfumato::scene
