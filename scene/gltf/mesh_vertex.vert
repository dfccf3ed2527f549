// passes: light geometry shadow
// Vertices that the CPU has posed, in world space.
//   light     for shading
//   geometry  with the places in the previous and the next frame
//   shadow    seen from the light
#version 450
#extension GL_GOOGLE_include_directive : require
#include "scene_shared.h"
#include "mesh_shared.h"

layout(push_constant) uniform Push {
    MeshDraw draw;
};

layout(location = MESH_POSITION) in vec3 position;
layout(location = MESH_TEXCOORD) in vec2 texcoord;
layout(location = MESH_COLOUR) in vec4 colour;
layout(location = MESH_TEXCOORD) out vec2 texcoord_out;
layout(location = MESH_COLOUR) out vec4 colour_out;
#ifndef PASS_shadow
layout(location = MESH_NORMAL) in vec3 normal;
layout(location = MESH_POSITION) out vec3 position_out;
layout(location = MESH_NORMAL) out vec3 normal_out;
#endif
#ifdef PASS_geometry
layout(location = MESH_PREVIOUS) in vec3 previous;
layout(location = MESH_NEXT) in vec3 next;
// Where the point comes from and goes to: exactly zero where it stays.
layout(location = MESH_PREVIOUS) out vec3 before_out;
layout(location = MESH_NEXT) out vec3 after_out;
#endif

void main() {
    gl_Position = draw.clip_from_world * vec4(position, 1.0);
    texcoord_out = texcoord;
    colour_out = colour;
#ifndef PASS_shadow
    position_out = position;
    normal_out = normal;
#endif
#ifdef PASS_geometry
    before_out = previous - position;
    after_out = next - position;
#endif
}
