// passes: radiance resolve accumulate geometry
// The analytic scene: rigidly moving primitives under a sun and a sky, ray-cast at any resolution and any time.
//   radiance    direct and ambient light of one moment, averaged over a grid of samples in the pixel
//   resolve     a sharp frame from it
//   accumulate  the running mean of such moments: ground truth for motion blur
//   geometry    depth, normal, velocities and shadow through the pixel's centre
// Sharp frames and truth share the radiance pass, so that they are the same bits wherever nothing changes.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "scene_shared.h"

layout(local_size_x = 8, local_size_y = 8) in;

#if defined(PASS_radiance) || defined(PASS_geometry)
layout(set = 1, binding = 0, std140) uniform Constants {
    SceneConstants scene;
};
#include "ray_cast.glsl"
#include "surface.glsl"
#include "view.glsl"

// Share of the sun's light that arrives, without its colour: cosine × shadow.
float sun_light(Surface s) {
    float cosine = dot(s.normal, scene.sun.xyz);
    if (cosine <= 0.0)
        return 0.0;
    // The offset grows with depth, as the rounding of the hit point does.
    return cosine * cast_shadow(s.position + s.normal * (1e-3 * scene.frustum.w + 1e-4 * s.depth), scene.sun.xyz);
}
#endif

#ifdef PASS_radiance
layout(set = 0, binding = 0) uniform writeonly image2D direct_image;
layout(set = 0, binding = 1) uniform writeonly image2D ambient_image;

void shade(Ray ray, inout vec3 direct, inout vec3 ambient) {
    Hit hit = camera_hit(ray);
    if (hit.t >= SCENE_SKY_DEPTH) {
        direct += sky_colour(ray.direction);
        return;
    }
    Surface s = surface_at(hit, ray);
    uint material = scene.primitives[s.index].material;
    // Width of the pixel on the surface, longer where the surface is seen at a flat angle.
    float pixel = 2.0 * scene.lens.y / scene.lens.w;
    float cosine = max(-dot(s.normal, normalize(ray.direction)), 0.1);
    float footprint = (is_orthographic() ? 1.0 : s.depth) * pixel / sqrt(cosine);
    // Patterns count in metres.
    float metre = scene.frustum.w;
    vec3 colour = surface_colour(material, s.local_position / metre, s.local_normal, footprint / metre);
    float emission = scene.materials[material].colour_b.w;
    direct += colour * (scene.sun_colour.rgb * sun_light(s) + emission);
    ambient += colour * mix(scene.ambient_down.rgb, scene.ambient_up.rgb, 0.5 + 0.5 * s.normal.y);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(direct_image);
    if (any(greaterThanEqual(pixel, size)))
        return;
    vec3 direct = vec3(0.0);
    vec3 ambient = vec3(0.0);
    uint count = scene.samples * scene.samples;
    for (uint i = 0u; i < count; ++i) {
        vec2 offset = (vec2(i % scene.samples, i / scene.samples) + 0.5) / float(scene.samples);
        shade(camera_ray(vec2(pixel) + offset), direct, ambient);
    }
    imageStore(direct_image, pixel, vec4(direct / float(count), 1.0));
    imageStore(ambient_image, pixel, vec4(ambient / float(count), 0.0));
}
#endif

#ifdef PASS_resolve
layout(set = 0, binding = 0) uniform sampler2D direct_in;
layout(set = 0, binding = 1) uniform sampler2D ambient_in;
layout(set = 0, binding = 2) uniform writeonly image2D colour_out;
layout(set = 0, binding = 3) uniform writeonly image2D direct_out;
layout(set = 0, binding = 4) uniform writeonly image2D ambient_out;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(colour_out))))
        return;
    vec4 direct = texelFetch(direct_in, pixel, 0);
    vec4 ambient = texelFetch(ambient_in, pixel, 0);
    imageStore(colour_out, pixel, direct + ambient);
    imageStore(direct_out, pixel, direct);
    imageStore(ambient_out, pixel, vec4(ambient.rgb, 1.0));
}
#endif

#ifdef PASS_accumulate
layout(set = 0, binding = 0) uniform sampler2D direct_in;
layout(set = 0, binding = 1) uniform sampler2D ambient_in;
layout(set = 0, binding = 2) uniform sampler2D mean_in; // of the sub-frames before; not looked at by the first
layout(set = 0, binding = 3) uniform writeonly image2D mean_out;
layout(set = 1, binding = 0, std140) uniform Constants {
    AccumulateConstants constants;
};

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(mean_out))))
        return;
    vec4 colour = texelFetch(direct_in, pixel, 0) + texelFetch(ambient_in, pixel, 0);
    // A running mean, not a sum: equal colours leave it untouched to the last bit.
    if (constants.share < 1.0) {
        vec4 mean = texelFetch(mean_in, pixel, 0);
        colour = mean + (colour - mean) * constants.share;
    }
    imageStore(mean_out, pixel, colour);
}
#endif

#ifdef PASS_geometry
layout(set = 0, binding = 0) uniform writeonly image2D depth_image;
layout(set = 0, binding = 1) uniform writeonly image2D normal_image;
layout(set = 0, binding = 2) uniform writeonly image2D velocity_image;
layout(set = 0, binding = 3) uniform writeonly image2D next_velocity_image;
layout(set = 0, binding = 4) uniform writeonly image2D shadow_image;

#include "image_values.glsl"

vec3 moved(vec4 x, vec4 y, vec4 z, vec3 local) {
    return vec3(dot(x.xyz, local) + x.w, dot(y.xyz, local) + y.w, dot(z.xyz, local) + z.w);
}

void store(ivec2 pixel, float depth, vec3 normal, vec2 velocity, vec2 next_velocity, float shadow) {
    imageStore(depth_image, pixel, vec4(depth, 0.0, 0.0, 1.0));
    imageStore(normal_image, pixel, vec4(normal, 0.0));
    imageStore(velocity_image, pixel, vec4(velocity, 0.0, 1.0));
    imageStore(next_velocity_image, pixel, vec4(next_velocity, 0.0, 1.0));
    imageStore(shadow_image, pixel, vec4(shadow, 0.0, 0.0, 1.0));
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(depth_image))))
        return;
    Ray ray = camera_ray(vec2(pixel) + 0.5);
    Hit hit = camera_hit(ray);
    // The sky is at infinity (w = 0): only the camera's rotation moves it.
    vec3 before = ray.direction;
    vec3 after = ray.direction;
    vec3 here = ray.direction;
    float w = 0.0;
    float depth = 1.0;
    bool stood = (scene.flags & SCENE_SKY_STILL_PREVIOUS) != 0u;
    bool stays = (scene.flags & SCENE_SKY_STILL_NEXT) != 0u;
    vec3 normal = vec3(0.0);
    float shadow = 1.0;
    if (hit.t < SCENE_SKY_DEPTH) {
        Surface s = surface_at(hit, ray);
        uint i = s.index;
        bool primitive_stood = (scene.primitives[i].flags & PRIMITIVE_STILL_PREVIOUS) != 0u;
        bool primitive_stays = (scene.primitives[i].flags & PRIMITIVE_STILL_NEXT) != 0u;
        here = before = after = s.position;
        if (!primitive_stood)
            before = moved(scene.primitives[i].previous[0], scene.primitives[i].previous[1],
                           scene.primitives[i].previous[2], s.local_position);
        if (!primitive_stays)
            after = moved(scene.primitives[i].next[0], scene.primitives[i].next[1], scene.primitives[i].next[2],
                          s.local_position);
        stood = primitive_stood && (scene.flags & SCENE_CAMERA_STILL_PREVIOUS) != 0u;
        stays = primitive_stays && (scene.flags & SCENE_CAMERA_STILL_NEXT) != 0u;
        w = 1.0;
        depth = s.depth;
        normal = normalize(mat3(scene.view) * s.normal);
        shadow = sun_light(s) > 0.0 ? 1.0 : 0.0;
    }
    vec2 now = project(view_position(scene.view, here, w), depth);
    // Exactly zero where nothing moves, whatever the rounding.
    vec2 velocity = stood ? vec2(0.0) : now - project(view_position(scene.previous_view, before, w), depth);
    vec2 next_velocity = stays ? vec2(0.0) : project(view_position(scene.next_view, after, w), depth) - now;
    store(pixel, depth_value(hit.t), normal, velocity, next_velocity, shadow);
}
#endif
