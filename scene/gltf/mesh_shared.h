// Constants of the shaders that draw meshes, for C++ and GLSL: see scene_shared.h.
#ifndef SFUMATO_MESH_SHARED_H
#define SFUMATO_MESH_SHARED_H

#ifdef __cplusplus
#include "scene/scene_shared.h"
namespace sfumato::scene::shared {
#endif

#define MESH_MOST_LIGHTS 8

// Attributes of a vertex.
#define MESH_POSITION 0
#define MESH_NORMAL 1
#define MESH_TEXCOORD 2
#define MESH_COLOUR 3
#define MESH_PREVIOUS 4 // position in the previous frame
#define MESH_NEXT 5

#define MESH_DOUBLE_SIDED 1
#define MESH_UNLIT 2
#define MESH_NORMAL_MAP 4
#define MESH_BLENDED 8

#define MESH_DIRECTIONAL 0
#define MESH_POINT 1
#define MESH_SPOT 2

// Push constants: 128 bytes are guaranteed.
struct MeshDraw {
    mat4 clip_from_world;
    vec4 eye;     // xyz: the camera's place; w: far plane
    vec4 forward; // xyz: where it looks, unit; w: 1 if orthographic
    float bias;   // added to the mip levels of textures
    uint detail;  // normals with normal maps
    float cutoff; // of the alpha of blended materials, in place of their own
    uint unused;
};

struct MeshLight {
    vec4 colour;    // rgb: irradiance / π, at one metre but for directional lights; w: MESH_DIRECTIONAL …
    vec4 position;  // xyz; w: 1 / range, 0 for endless
    vec4 direction; // xyz: towards the light, or against the spot's axis; unit
    vec4 cone;      // x, y: cosine towards 0…1 by a scale and an offset
};

struct MeshLights {
    mat4 shadow_from_world;
    vec4 shadow; // x: texel in scene units; y: texels a side; z: 1 if the first light casts shadows; w: count of lights
    vec4 ambient_up;
    vec4 ambient_down;
    MeshLight lights[MESH_MOST_LIGHTS];
};

struct MeshMaterial {
    vec4 base_colour;
    vec4 emission; // w: scale of the normal map
    float metallic;
    float roughness;
    float cutoff; // of alpha; negative: all is opaque
    uint flags;
};

// One sample of the pixel's grid.
struct MeshSample {
    float share; // weight of this sample over those so far, this one included
    float x, y;  // its place in the pixel, 0…1
    float unused;
};

#ifdef __cplusplus
} // namespace sfumato::scene::shared
#endif
#endif
