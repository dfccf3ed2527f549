// passes: gather geometry values
// From what the rasteriser left to the images of a frame, the sky included.
//   gather    the running mean of direct and ambient light over the samples of a pixel
//   geometry  depth, normal, velocities and shadow through the pixel's centre
//   values    visibility and bent normals that the CPU has traced
#version 450
#extension GL_GOOGLE_include_directive : require
#include "scene_shared.h"
#include "mesh_shared.h"

layout(local_size_x = 8, local_size_y = 8) in;

#ifdef PASS_gather
layout(set = 0, binding = 0) uniform sampler2D direct_in; // a: 1 where a surface is
layout(set = 0, binding = 1) uniform sampler2D ambient_in;
layout(set = 0, binding = 2) uniform sampler2D direct_mean; // not looked at by the first sample
layout(set = 0, binding = 3) uniform sampler2D ambient_mean;
layout(set = 0, binding = 4) uniform writeonly image2D direct_out;
layout(set = 0, binding = 5) uniform writeonly image2D ambient_out;
layout(set = 1, binding = 0, std140) uniform Constants {
    SceneConstants scene;
    MeshSample place;
};
#include "ray_cast.glsl"
#include "surface.glsl"
#include "view.glsl"

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(direct_out))))
        return;
    vec4 direct = texelFetch(direct_in, pixel, 0);
    vec4 ambient = texelFetch(ambient_in, pixel, 0);
    if (direct.a == 0.0) {
        direct = vec4(sky_colour(camera_ray(vec2(pixel) + vec2(place.x, place.y)).direction), 1.0);
        ambient = vec4(0.0);
    }
    if (place.share < 1.0) {
        vec4 mean = texelFetch(direct_mean, pixel, 0);
        direct = mean + (direct - mean) * place.share;
        mean = texelFetch(ambient_mean, pixel, 0);
        ambient = mean + (ambient - mean) * place.share;
    }
    imageStore(direct_out, pixel, direct);
    imageStore(ambient_out, pixel, ambient);
}
#endif

#ifdef PASS_geometry
layout(set = 0, binding = 0) uniform sampler2D normal_in; // the three targets of mesh_surface.frag
layout(set = 0, binding = 1) uniform sampler2D before_in;
layout(set = 0, binding = 2) uniform sampler2D after_in;
layout(set = 0, binding = 3) uniform writeonly image2D depth_image;
layout(set = 0, binding = 4) uniform writeonly image2D normal_image;
layout(set = 0, binding = 5) uniform writeonly image2D velocity_image;
layout(set = 0, binding = 6) uniform writeonly image2D next_velocity_image;
layout(set = 0, binding = 7) uniform writeonly image2D shadow_image;
layout(set = 1, binding = 0, std140) uniform Constants {
    SceneConstants scene;
};
#include "ray_cast.glsl"
#include "view.glsl"
#include "image_values.glsl"

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(depth_image))))
        return;
    vec4 surface = texelFetch(normal_in, pixel, 0);
    Ray ray = camera_ray(vec2(pixel) + 0.5);
    // The sky is at infinity (w = 0): only the camera's rotation moves it.
    vec3 here = ray.direction, before = ray.direction, after = ray.direction;
    float w = 0.0, depth = 1.0, distance = SCENE_SKY_DEPTH, shadow = 1.0;
    vec3 normal = vec3(0.0);
    bool stood = (scene.flags & SCENE_SKY_STILL_PREVIOUS) != 0u;
    bool stays = (scene.flags & SCENE_SKY_STILL_NEXT) != 0u;
    if (surface.w > 0.0) {
        vec4 past = texelFetch(before_in, pixel, 0);
        vec4 future = texelFetch(after_in, pixel, 0);
        w = 1.0;
        depth = distance = surface.w;
        here = ray.origin + depth * ray.direction;
        before = here + past.xyz;
        after = here + future.xyz;
        normal = normalize(mat3(scene.view) * surface.xyz);
        shadow = past.w;
        stood = past.xyz == vec3(0.0) && (scene.flags & SCENE_CAMERA_STILL_PREVIOUS) != 0u;
        stays = future.xyz == vec3(0.0) && (scene.flags & SCENE_CAMERA_STILL_NEXT) != 0u;
    }
    vec2 now = project(view_position(scene.view, here, w), depth);
    // Exactly zero where nothing moves, whatever the rounding.
    vec2 velocity = stood ? vec2(0.0) : now - project(view_position(scene.previous_view, before, w), depth);
    vec2 next_velocity = stays ? vec2(0.0) : project(view_position(scene.next_view, after, w), depth) - now;
    imageStore(depth_image, pixel, vec4(depth_value(distance), 0.0, 0.0, 1.0));
    imageStore(normal_image, pixel, vec4(normal, 0.0));
    imageStore(velocity_image, pixel, vec4(velocity, 0.0, 1.0));
    imageStore(next_velocity_image, pixel, vec4(next_velocity, 0.0, 1.0));
    imageStore(shadow_image, pixel, vec4(shadow, 0.0, 0.0, 1.0));
}
#endif

#ifdef PASS_values
layout(set = 0, binding = 0) uniform sampler2D values_in; // xyz: bent normal, view space; w: visibility
layout(set = 0, binding = 1) uniform writeonly image2D visibility_image;
layout(set = 0, binding = 2) uniform writeonly image2D bent_normal_image;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(visibility_image))))
        return;
    vec4 values = texelFetch(values_in, pixel, 0);
    imageStore(visibility_image, pixel, vec4(values.w, 0.0, 0.0, 1.0));
    imageStore(bent_normal_image, pixel, values);
}
#endif
