// passes: rays average
// Ground truth for ambient occlusion: rays from the surface at each pixel's centre, cosine-weighted about its normal,
// stopped by what lies within the radius.
//   rays     casts a share of each pixel's rays and adds them to the sums so far
//   average  visibility and the mean open direction from the sums
// The directions are a Sobol' sequence in two dimensions with Owen's scrambling, another one in each pixel, by the hash of
// Laine and Karras 2011 as Burley refined it in "Practical Hash-based Owen Scrambling" (JCGT 2020). Any number of rays is
// fine; powers of two are the most even.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "scene_shared.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 1, binding = 0, std140) uniform Constants {
    SceneConstants scene;
};
#include "ray_cast.glsl"
#include "view.glsl"

#ifdef PASS_rays
layout(set = 0, binding = 0) uniform sampler2D sums_in; // not looked at by the first pass
layout(set = 0, binding = 1) uniform writeonly image2D sums_out; // xyz: world directions × openness, w: occlusion

uint mixed(uint x) {
    x = (x ^ (x >> 16)) * 0x7feb352du;
    x = (x ^ (x >> 15)) * 0x846ca68bu;
    return x ^ (x >> 16);
}

// Owen's scrambling of a number whose bits are in reverse order.
uint scrambled_reversed(uint x, uint seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

// The second dimension of the sequence, bits in reverse order.
uint sobol_reversed(uint index) {
    uint result = 0u;
    // The matrix's columns are Pascal's triangle modulo 2; in reverse order the first has its bit at the right.
    for (uint column = 1u; index != 0u; index >>= 1, column ^= column << 1)
        if ((index & 1u) != 0u)
            result ^= column;
    return result;
}

// A point of the unit square, below 1 in both coordinates.
vec2 sample_point(uint index, uint seed) {
    // The first dimension is the index in reverse order.
    uint x = bitfieldReverse(scrambled_reversed(index, mixed(seed ^ 0x9e3779b9u)));
    uint y = bitfieldReverse(scrambled_reversed(sobol_reversed(index), mixed(seed ^ 0x85ebca6bu)));
    return vec2(uvec2(x, y) >> 8) * (1.0 / 16777216.0);
}

// Share of the light that a hit at `t` radii takes away, 0…1 for t in 0…1.
float falloff(float t) {
    float square = t * t;
    switch (scene.falloff) {
    case FALLOFF_LINEAR:
        return 1.0 - t;
    case FALLOFF_QUADRATIC:
        return 1.0 - square;
    case FALLOFF_SAO:
        return (1.0 - square) * (1.0 - square) * (1.0 - square);
    case FALLOFF_CONTACT:
        return (1.0 - t) * (1.0 - t);
    case FALLOFF_WIDE:
        return 1.0 - square * square;
    default:
        return 1.0;
    }
}

// One bit for each primitive that a ray from the surface can meet within the radius.
uvec2 primitives_near(Surface s) {
    uvec2 near = uvec2(0u);
    for (uint i = 0u; i < scene.primitive_count; ++i) {
        // Every primitive is convex: no ray that leaves it meets it again. So it needs no offset from the surface, which
        // would be too small far away and too large in crevices.
        if (i == s.index)
            continue;
        vec3 away = primitive_position(i) - s.position;
        float size = scene.primitives[i].size.w;
        bool reached = size < 0.0 ? abs(to_local_direction(i, away).y) <= scene.radius
                                  : length(away) <= scene.radius + size && dot(away, s.normal) > -size;
        if (reached)
            near[i >> 5] |= 1u << (i & 31u);
    }
    return near;
}

// Distance to the nearest of these primitives along a unit direction, at most the radius.
float occluder_distance(uvec2 near, vec3 origin, vec3 direction) {
    float nearest = scene.radius;
    for (uint word = 0u; word < 2u; ++word)
        for (uint bits = near[word]; bits != 0u; bits &= bits - 1u)
            nearest = hit_primitive(uint(findLSB(bits)) + 32u * word, origin, direction, 0.0, nearest);
    return nearest;
}

// Two vectors that make a right-handed basis with n (Duff et al., JCGT 2017).
void basis(vec3 n, out vec3 u, out vec3 v) {
    float side = n.z >= 0.0 ? 1.0 : -1.0;
    float a = -1.0 / (side + n.z);
    float b = n.x * n.y * a;
    u = vec3(1.0 + side * n.x * n.x * a, side * b, -side * n.x);
    v = vec3(b, side + n.y * n.y * a, -n.y);
}

vec4 cast_rays(Surface s, uint seed) {
    uvec2 near = primitives_near(s);
    vec3 u, v;
    basis(s.normal, u, v);
    vec4 sums = vec4(0.0);
    for (uint i = 0u; i < scene.ray_count; ++i) {
        vec2 point = sample_point(scene.first_ray + i, seed);
        float angle = 6.2831853 * point.y;
        float side = sqrt(point.x);
        vec3 direction = (cos(angle) * u + sin(angle) * v) * side + s.normal * sqrt(1.0 - point.x);
        float t = occluder_distance(near, s.position, direction) / scene.radius;
        float occlusion = t < 1.0 ? falloff(t) : 0.0;
        sums += vec4(direction * (1.0 - occlusion), occlusion);
    }
    return sums;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(sums_out))))
        return;
    vec4 sums = scene.first_ray == 0u ? vec4(0.0) : texelFetch(sums_in, pixel, 0);
    Ray ray = camera_ray(vec2(pixel) + 0.5);
    Hit hit = camera_hit(ray);
    uint seed = mixed(uint(pixel.x) + mixed(uint(pixel.y) + mixed(scene.seed)));
    if (hit.t < SCENE_SKY_DEPTH)
        sums += cast_rays(surface_at(hit, ray), seed);
    imageStore(sums_out, pixel, sums);
}
#endif

#ifdef PASS_average
layout(set = 0, binding = 0) uniform sampler2D sums_in;
layout(set = 0, binding = 1) uniform writeonly image2D visibility_image;
layout(set = 0, binding = 2) uniform writeonly image2D bent_normal_image;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(visibility_image))))
        return;
    vec4 sums = texelFetch(sums_in, pixel, 0);
    // Sums of ones are exact: visibility is exactly 1 where no ray is stopped, exactly 0 where all are at once.
    float visibility = 1.0 - sums.w / float(scene.all_rays);
    vec3 bent = vec3(0.0);
    Ray ray = camera_ray(vec2(pixel) + 0.5);
    Hit hit = camera_hit(ray);
    if (hit.t < SCENE_SKY_DEPTH) {
        // Where nothing is open there is no mean: the normal stands for it.
        vec3 direction = dot(sums.xyz, sums.xyz) > 1e-12 ? sums.xyz : surface_at(hit, ray).normal;
        bent = normalize(mat3(scene.view) * direction);
    }
    imageStore(visibility_image, pixel, vec4(visibility, 0.0, 0.0, 1.0));
    imageStore(bent_normal_image, pixel, vec4(bent, visibility));
}
#endif
