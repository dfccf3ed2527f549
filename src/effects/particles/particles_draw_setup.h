// The numbers that drawing of particles rests on, as functions of frame, parameters and sizes alone.
#pragma once

#include "effects/particles/particles_draw_shared.h"
#include "sfumato/effects/particles.h"

#include <array>
#include <vector>

namespace sfumato {

using Direction = std::array<float, 3>;

// Whether slices go front to back for the eye (blend under), and the axis they are perpendicular to. `to_eye` and
// `to_light` are unit vectors. Slices always go front to back for the light: keys are smallest at the light's end.
struct HalfAngle {
    Direction axis; // unit, towards the light
    bool front_to_back;
};
HalfAngle half_angle(const Direction& to_eye, const Direction& to_light);

// Two unit vectors across `to_light`, for any direction, straight up and down included.
struct LightAxes {
    Direction right, up;
};
LightAxes light_axes(const Direction& to_light);

// The frame's lights with unit directions; the parameters' one where the frame has none.
std::vector<Light> particle_lights(const Frame& frame, const ParticleVolumeParameters& parameters);

// The projection's near plane as view depth; 0 where it has none.
float near_depth(const Matrix4& projection);

uint32_t resolution_factor(ParticleResolution resolution); // 1, 2, 4
uint32_t layer_count(const ParticleVolumeParameters& parameters);
uint32_t key_bits(const ParticleVolumeParameters& parameters);
// Whether particles are drawn by a profile of their own, and which: a sphere's, where its strength is 0.
ParticleProfile drawn_profile(const ParticleVolumeParameters& parameters);
Extent working_extent(Extent extent, ParticleResolution resolution);

// Whether particles are drawn from far to near.
bool draws_backward(const Frame& frame, const ParticleVolumeParameters& parameters);

gpu::ParticleDrawConstants particle_draw_constants(const Frame& frame, const ParticleVolumeParameters& parameters,
                                                   Extent extent);

} // namespace sfumato
