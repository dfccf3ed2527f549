// How a particle's optical depth is spread over its disc: a table of 256×256 texels and its halvings, which particles show
// each a part of, turned by an angle of their own. scene/particle_profile.cpp says the same slowly.

#include "hash.glsl"

const uint profile_noise = 1u; // ParticleProfile
const uint profile_texture = 2u;

const float profile_side = 256.0; // texels of the table's largest level
const uint profile_levels = 6u;   // down to 8 texels
const float least_mass = 1e-4;    // below it a texture is taken for empty

// 16 bits of the particle's number: 256 places in the table, 256 angles.
uint pattern_of(uint index) { return mix_bits(index + 0x9e3779b9u) & 0xffffu; }
uint place_of(uint pattern) { return pattern & 255u; }

// Cosine and sine.
vec2 turn_of(uint pattern) {
    const float angle = float(pattern >> 8) * (6.2831853 / 256.0);
    return vec2(cos(angle), sin(angle));
}

// Of 16×16 places, evenly over those whose disc lies in the table. The table's side and so `reach`, the disc's radius,
// are in shares of 1.
vec2 place_middle(uint place, float reach) {
    return reach + (1.0 - 2.0 * reach) * vec2(place & 15u, place >> 4) / 15.0;
}
