// Constants of the analytic scene's shaders, for C++ and GLSL: 4-byte scalars, vec4 and mat4 only, so that the uniform
// block has the same layout as the C++ struct.
#ifndef SFUMATO_SCENE_SHARED_H
#define SFUMATO_SCENE_SHARED_H

#ifdef __cplusplus
#include <cstdint>
namespace sfumato::scene::shared {
using uint = uint32_t;
struct alignas(16) vec4 {
    float x = 0.0f, y = 0.0f, z = 0.0f, w = 0.0f;
};
struct alignas(16) mat4 {
    float elements[16] = {}; // column-major
};
#endif

#define SCENE_MOST_PRIMITIVES 64
#define SCENE_MOST_MATERIALS 16

// Shapes, in their local space around the origin.
#define SHAPE_SPHERE 0   // radius x
#define SHAPE_BOX 1      // half extents x y z
#define SHAPE_CYLINDER 2 // along y: radius x, half height y
#define SHAPE_PLANE 3    // y = 0, endless, seen from both sides
#define SHAPE_DISC 4     // y = 0, radius x, seen from both sides

// Patterns mix the two colours of a material.
#define PATTERN_SOLID 0
#define PATTERN_CHECKER 1
#define PATTERN_STRIPES 2 // across local x
#define PATTERN_RINGS 3   // across local y
#define PATTERN_SECTORS 4 // around local y, `scale` sectors of each colour
#define PATTERN_BRICKS 5  // with joints of the second colour
#define PATTERN_TILES 6   // checker with joints and a tone of its own for each tile
#define PATTERN_NOISE 7

#define PRIMITIVE_STILL_PREVIOUS 1 // same pose as in the previous frame
#define PRIMITIVE_STILL_NEXT 2
#define PRIMITIVE_CASTS_SHADOW 4

#define SCENE_CAMERA_STILL_PREVIOUS 1
#define SCENE_CAMERA_STILL_NEXT 2
#define SCENE_SKY_STILL_PREVIOUS 4 // the camera has not turned
#define SCENE_SKY_STILL_NEXT 8
#define SCENE_ORTHOGRAPHIC 16
#define SCENE_DEVICE_DEPTH 32 // the depth image holds 0…1 as the projection makes it, not view depth

// What an occluder at t = distance / radius takes away, t in 0…1.
#define FALLOFF_HARD 0      // 1
#define FALLOFF_LINEAR 1    // 1 - t
#define FALLOFF_QUADRATIC 2 // 1 - t²
#define FALLOFF_SAO 3       // (1 - t²)³
#define FALLOFF_CONTACT 4   // (1 - t)²
#define FALLOFF_WIDE 5      // 1 - t⁴

// What depth images hold where nothing was hit.
#define SCENE_SKY_DEPTH 1e10f

struct SceneMaterial {
    vec4 colour_a; // w: strength of the fine detail
    vec4 colour_b; // w: emission, times the pattern's colour
    uint pattern;
    float scale; // cells a metre; PATTERN_SECTORS: sectors a turn
    float unused_0;
    float unused_1;
};

// Poses are the upper three rows of the matrix from local to world space; rigid.
struct ScenePrimitive {
    vec4 size; // w: radius of the bounding sphere, negative for none
    uint shape;
    uint material;
    uint flags;
    uint unused;
    vec4 now[3];
    vec4 previous[3];
    vec4 next[3];
};

struct SceneConstants {
    mat4 view; // world to view, rigid
    mat4 previous_view;
    mat4 next_view;
    vec4 eye;          // xyz: the camera's place in the world
    vec4 lens;         // xy: tangents of half the angles of view, or half the image's sides; zw: extent in pixels
    vec4 frustum;      // xy: off-centre, added to places -1…1 in the image; z: far plane; w: scene units a metre
    vec4 depth_range;  // xy: elements 10 and 14 of the projection, z: its value where nothing is
    vec4 sun;          // xyz: direction to the sun
    vec4 sun_colour;   // w: share of clouds in the sky
    vec4 sky_zenith;   // rgb
    vec4 sky_horizon;  // rgb
    vec4 ambient_up;   // rgb: ambient light from above
    vec4 ambient_down; // rgb: from below
    uint primitive_count;
    uint samples; // a side of the grid of colour samples in a pixel
    uint flags;
    // Ground truth of ambient occlusion.
    float radius;
    uint falloff;
    uint first_ray; // of this pass
    uint ray_count; // of this pass
    uint all_rays;
    uint seed;
    uint unused_0;
    uint unused_1;
    uint unused_2;
    SceneMaterial materials[SCENE_MOST_MATERIALS];
    ScenePrimitive primitives[SCENE_MOST_PRIMITIVES];
};

// One step of the running mean over sub-frames.
struct AccumulateConstants {
    float share; // weight of this sub-frame over the weights so far, this one included
    float unused_0;
    float unused_1;
    float unused_2;
};

#ifdef __cplusplus
} // namespace sfumato::scene::shared
#endif
#endif
