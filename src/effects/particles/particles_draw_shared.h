// Constants of the passes that shadow and draw particles, shared by particles_draw.cpp and the shaders.
#ifndef SFUMATO_PARTICLES_DRAW_SHARED_H
#define SFUMATO_PARTICLES_DRAW_SHARED_H

#include "shared.h"

#ifdef __cplusplus
namespace sfumato::gpu {
using uint = uint32_t;
#endif

struct ParticleDrawConstants {
    mat4 view_from_world;
    mat4 projection;
    mat4 previous_clip_from_world;
    // Of each light, columns: two axes across its rays, the unit vector towards it, its radiance (w: whether it has a
    // shadow map). World space.
    mat4 light_0;
    mat4 light_1;
    mat4 light_2;
    mat4 light_3;
    mat4 shadow_map_from_world; // clip space of the first light's shadow map
    mat4 world_from_view;
    vec4 sort_axis;      // key = dot(xyz, position) + w, smallest first
    vec4 shadow_colour;  // factor on optical depth towards a light; w: share of the shadow that falls on the scene
    vec4 ambient;        // w: factor of the host's picture before particles are laid over it
    vec4 pixel_to_view;  // full resolution: view xy = (pixel * xy + zw) times depth where the camera is perspective
    vec4 octaves;        // of multiple scattering: number, factor on light, on optical depth, on the phase's g
    vec2 size;           // of the picture, pixels
    vec2 working_size;   // of the picture that particles are drawn at
    float scale;         // working pixels a pixel
    float pixels;        // working pixels that one scene unit takes at depth 1 (perspective) or anywhere (orthographic)
    float near_start;    // view depth before which nothing is drawn
    float near_range;    // over which particles fade in after it
    float phase;         // Henyey-Greenstein g
    float soft_distance; // least depth over which a particle fades into a surface; spheres fade over their own
    float key_range;     // largest key
    float layer_spread;  // blur variance per layer over that per metre: scattering per metre
    float shadow_map_bias;
    float depth_tolerance; // relative difference of depth that enlarging takes for one surface
    float time_step;
    uint capacity;          // sprites
    uint room;              // for pairs of tile and particle
    uint layers;            // of the shadow buffer, or slices
    uint side;              // texels
    uint step_light;        // of one step of scattering
    uint step_layer;        // or the number of layers after the last
    uint area;              // words of a layer in the shadow buffer: its texels, rounded up to a multiple of four
    uint planes;            // layers that there is room for: rounded up likewise
    float row_shift;        // of the layers in every second row of texels, by the layer
    float profile_strength; // how far a disc's profile goes from the sphere's chord, 0 to 1
    float profile_reach;    // a disc's radius in the profile's table, whose side is 1
    float profile_least;    // radius below which the sphere's chord is drawn, pixels; from twice as much on the profile
    float simplification;   // variance that drawing fewer particles may add to their optical depth, over it; 0: none
};

#ifdef __cplusplus
static_assert(sizeof(ParticleDrawConstants) % 16 == 0);
} // namespace sfumato::gpu
#endif

#endif
