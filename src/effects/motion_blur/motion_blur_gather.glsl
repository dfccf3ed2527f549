// The gather: a workgroup is four 8×8 blocks of a tile from the list of the class at hand, or copies four rows of blocks.
// Sums are kept as differences
// from the pixel's own colour: where no tap weighs anything, the pixel comes out bit for bit.

layout(local_size_x = 8, local_size_y = 8, local_size_z = 4) in;

layout(constant_id = 0) const uint tile_size = 32;
layout(constant_id = 1) const bool is_packed = false;
layout(constant_id = 2) const uint tile_class = 2; // still, uniform, full
layout(constant_id = 3) const uint weighting = 3;  // talk, guertin, jimenez, coverage
layout(constant_id = 4) const int taps = 15;
layout(constant_id = 5) const bool taps_follow_length = false;
layout(constant_id = 6) const bool alternate = false;
layout(constant_id = 7) const bool tile_jitter = false;
layout(constant_id = 8) const uint jitter_kind = 3; // none, checkerboard, ordered, gradient noise
layout(constant_id = 9) const uint curve = 0;       // box, triangle, smooth
layout(constant_id = 10) const bool hdr_weighting = false;
layout(constant_id = 11) const bool soft_extent_is_absolute = false;
layout(constant_id = 12) const bool accumulates = false; // not the first iteration
layout(constant_id = 13) const uint debug_view = 0;      // 1 taps, 2 share of other surfaces
layout(constant_id = 14) const bool filter_taps = true;  // bilinear colour
layout(constant_id = 15) const int search_taps = 12;     // coverage: of velocity and depth only
layout(constant_id = 16) const int least_taps = 6;       // below which taps_per_pixel does not go
layout(constant_id = 17) const bool second_direction = false;

layout(set = 0, binding = 0) uniform sampler2D colour_image;
layout(set = 0, binding = 1) uniform usampler2D surface_image;
layout(set = 0, binding = 2) uniform sampler2D neighbour_image;
layout(set = 0, binding = 3) uniform sampler2D mean_image; // of the iterations before
layout(set = 0, binding = 4) readonly buffer TileLists { uint words[]; } lists;
layout(set = 0, binding = 5) uniform writeonly image2D output_image;

struct Tap {
    vec2 v;
    float speed;
    float z;
    vec4 colour;
    float hdr; // weight by brightness
};

Surface surface_at(ivec2 pixel) {
    const uvec2 code = texelFetch(surface_image, pixel, 0).xy;
    return is_packed ? unpack_8_bit(code.x, constants.radius) : unpack_half(code);
}

vec4 colour_at(vec2 pixel, vec2 offset) {
    if (filter_taps)
        return sane(textureLod(colour_image, (pixel + 0.5 + offset) / constants.size, 0.0));
    const ivec2 position = ivec2(floor(pixel + 0.5 + offset));
    return sane(texelFetch(colour_image, clamp(position, ivec2(0), ivec2(constants.size) - 1), 0));
}

// Velocity and depth are those of one pixel.
Tap surface_tap(vec2 pixel, vec2 offset) {
    const ivec2 position = ivec2(floor(pixel + 0.5 + offset));
    const Surface s = surface_at(clamp(position, ivec2(0), ivec2(constants.size) - 1));
    return Tap(s.v, length(s.v), s.z, vec4(0), 1.0);
}

void fetch_colour(inout Tap tap, vec2 pixel, vec2 offset) {
    tap.colour = colour_at(pixel, offset);
    if (hdr_weighting)
        tap.hdr = 1.0 / (1.0 + max(luminance(tap.colour.rgb), 0.0));
}

Tap tap_at(vec2 pixel, vec2 offset) {
    Tap tap = surface_tap(pixel, offset);
    fetch_colour(tap, pixel, offset);
    return tap;
}

// The pixel itself, with its own colour whatever the filter.
Tap centre_tap(ivec2 pixel) {
    Tap tap = surface_tap(vec2(pixel), vec2(0));
    tap.colour = sane(texelFetch(colour_image, pixel, 0));
    if (hdr_weighting)
        tap.hdr = 1.0 / (1.0 + max(luminance(tap.colour.rgb), 0.0));
    return tap;
}

float soft(float a, float b) { // the extent of a soft comparison of two depths
    return max(soft_extent_is_absolute ? constants.soft_extent : constants.soft_extent * min(a, b), 1e-6);
}

float shutter_weight(float u) {
    const float a = abs(u);
    if (a > 1.0)
        return 0.0;
    if (curve == 1)
        return 1.0 - a;
    if (curve == 2)
        return (1.0 - a * a) * (1.0 - a * a); // close to a Gaussian of deviation 0.4, and zero at the ends
    return 1.0;
}

// Distance from the middle of the streak of a surface of this speed, in pixels.
float streak_distance(float d, float speed) { return abs(d - abs(constants.centre) * speed); }
float cone(float d, float speed) {
    return speed > 0.0 ? clamp(1.0 - streak_distance(d, speed) / speed, 0.0, 1.0) : 0.0;
}
bool within(float d, float speed) { return streak_distance(d, speed) <= speed; }
float cylinder(float d, float speed) {
    return speed > 0.0 ? 1.0 - smoothstep(0.95 * speed, 1.05 * speed, streak_distance(d, speed)) : 0.0;
}

bool is_inside(vec2 pixel, vec2 offset) {
    const vec2 position = floor(pixel + 0.5 + offset);
    return all(greaterThanEqual(position, vec2(0))) && all(lessThan(position, constants.size));
}

int tap_count(float blur_length, int most) {
    const int wanted = int(ceil(blur_length * constants.taps_per_pixel));
    return taps_follow_length ? clamp(wanted, min(least_taps, most), most) : most;
}

// Tap i of n as a place u in [-1, 1] of the shutter, moved by j in [-0.5, 0.5) of the spacing.
float tap_place(int i, int n, float j) { return -1.0 + 2.0 * (float(i) + 0.5 + j) / float(n); }

float tap_jitter(ivec2 pixel) { // [-0.5, 0.5)
    if (jitter_kind == 1)
        return ((pixel.x + pixel.y + int(constants.parity)) & 1) != 0 ? 0.25 : -0.25;
    if (jitter_kind == 2) {
        // 4×4 Bayer ranks, four bits each.
        const uvec2 rows = (pixel.y & 3) < 2 ? uvec2(0xa280u, 0x6e4cu) : uvec2(0x91b3u, 0x5d7fu);
        const uint row = (pixel.y & 1) == 0 ? rows.x : rows.y;
        const uint rank = row >> ((pixel.x & 3) * 4) & 15u;
        return fract((float(rank) + 0.5) / 16.0 + constants.ordered_shift) - 0.5;
    }
    if (jitter_kind == 3)
        return gradient_noise(vec2(pixel) + constants.noise_shift) - 0.5;
    return constants.ordered_shift == 0.0 ? 0.0 : fract(0.5 + constants.ordered_shift) - 0.5;
}

struct Sum {
    vec4 difference;
    float weight;
};

void add(inout Sum sum, Tap tap, Tap here, float w) {
    w *= tap.hdr;
    sum.weight += w;
    sum.difference += w * (tap.colour - here.colour);
}

vec4 over(Sum sum, Tap here, float total) {
    return total > 0.0 ? here.colour + sum.difference / total : here.colour;
}

// Shown by the debug views.
float used_taps = 0.0;
float other_share = 0.0;

// The talk. Background taps are weighted by how far the pixel itself moves, foreground taps by how far they move; both
// moving adds more.
vec4 gather_talk(vec2 pixel, Tap here, vec2 n, float j) {
    const int count = tap_count(length(n), taps);
    // The directions of even and odd taps. A pixel nearly as fast as the fastest thing in reach has nothing to look for
    // along another vector than its own; one that hardly moves beside it has none of its own: half of the taps would
    // fall on itself, and what passes over it would be lost.
    const bool is_fast = here.speed >= 0.7 * length(n);
    const bool has_own = alternate && here.speed >= max(0.1 * length(n), still_length);
    const vec2 even = is_fast ? here.v : n;
    const vec2 odd = is_fast || has_own ? here.v : n;
    Sum sum = Sum(vec4(0), 0.0);
    for (int i = 0; i < count; ++i) {
        const float u = tap_place(i, count, j);
        const vec2 offset = -(constants.centre + u) * ((i & 1) != 0 ? odd : even);
        const Tap tap = tap_at(pixel, offset);
        const float d = length(offset);
        const float extent = soft(here.z, tap.z);
        const float background = clamp(1.0 - (here.z - tap.z) / extent, 0.0, 1.0);
        const float foreground = clamp(1.0 - (tap.z - here.z) / extent, 0.0, 1.0);
        const float both = within(d, tap.speed) && within(d, here.speed) ? 1.0 : 0.0;
        const float w = constants.weight_background * background * cone(d, here.speed) +
                        constants.weight_foreground * foreground * cone(d, tap.speed) +
                        constants.weight_mutual * both;
        add(sum, tap, here, w * shutter_weight(u));
    }
    used_taps = float(count);
    other_share = sum.weight / (sum.weight + constants.weight_centre * here.hdr);
    return over(sum, here, sum.weight + constants.weight_centre * here.hdr);
}

// Guertin, McGuire, Nowrouzezahrai 2014: depth compared relative to depth, directions compared, slow pixels look across
// the dominant direction.
vec4 gather_guertin(vec2 pixel, Tap here, vec2 n, float j) {
    const float gamma = 1.5; // pixels
    const float kappa = 40.0;
    const float reach = length(n);
    const int count = tap_count(reach, taps);
    const vec2 along = n / reach;
    vec2 across = vec2(-along.y, along.x);
    if (dot(across, here.v) < 0.0)
        across = -across;
    const vec2 unit = here.speed > 0.0 ? here.v / here.speed : across;
    const vec2 mixed = across + clamp((here.speed - still_length) / gamma, 0.0, 1.0) * (unit - across);
    const float mixed_length = length(mixed);
    const vec2 own = mixed_length > 1e-6 ? mixed / mixed_length : across;
    Sum sum = Sum(vec4(0), 0.0);
    for (int i = 0; i < count; ++i) {
        const float u = tap_place(i, count, 0.95 * j);
        const vec2 direction = (i & 1) != 0 ? own : along;
        const vec2 offset = -(constants.centre + u) * reach * direction;
        const Tap tap = tap_at(pixel, offset);
        const float d = length(offset);
        const float nearest_z = max(min(tap.z, here.z), 1e-6);
        const float foreground = clamp(1.0 - (tap.z - here.z) / nearest_z, 0.0, 1.0);
        const float background = clamp(1.0 - (here.z - tap.z) / nearest_z, 0.0, 1.0);
        const float agree_here = abs(dot(own, direction));
        const float agree_tap = tap.speed > 0.0 ? abs(dot(tap.v, direction)) / tap.speed : 0.0;
        const float w = foreground * cone(d, tap.speed) * agree_tap + background * cone(d, here.speed) * agree_here +
                        2.0 * cylinder(d, min(tap.speed, here.speed)) * max(agree_here, agree_tap);
        add(sum, tap, here, w * shutter_weight(u));
    }
    const float centre =
        constants.weight_centre * float(count) / (kappa * max(here.speed, still_length)) * here.hdr;
    used_taps = float(count);
    other_share = sum.weight / (sum.weight + centre);
    return over(sum, here, sum.weight + centre);
}

// Jimenez 2014: foreground and background shares sum to one; taps come in pairs and fill each other's background; what
// weight is missing stays with the pixel.
vec4 gather_jimenez(vec2 pixel, Tap here, vec2 n, float j) {
    const float reach = length(n);
    const int steps = max(tap_count(reach, taps) / 2, 1);
    const float steps_per_pixel = float(steps) / reach;
    Sum sum = Sum(vec4(0), 0.0);
    float total = 0.0;
    for (int i = 0; i < steps; ++i) {
        const float u = (float(i) + 0.5 + j) / float(steps);
        Tap pair[2];
        float weight[2];
        for (int side = 0; side < 2; ++side) {
            const vec2 offset = -(constants.centre + (side == 0 ? u : -u)) * n;
            pair[side] = tap_at(pixel, offset);
            const float d = length(offset);
            const float away = (pair[side].z - here.z) / soft(here.z, pair[side].z);
            const float background = clamp(0.5 + away, 0.0, 1.0);
            const float foreground = clamp(0.5 - away, 0.0, 1.0);
            const float tap_speed = pair[side].speed;
            const float here_spread =
                clamp(steps_per_pixel * (here.speed - streak_distance(d, here.speed)) + 1.0, 0.0, 1.0);
            const float tap_spread =
                clamp(steps_per_pixel * (tap_speed - streak_distance(d, tap_speed)) + 1.0, 0.0, 1.0);
            weight[side] = (here.speed < still_length ? 0.0 : background * here_spread) +
                           (tap_speed < still_length ? 0.0 : foreground * tap_spread);
        }
        const bool farther = pair[0].z > pair[1].z;
        const bool faster = pair[1].speed > pair[0].speed;
        if (farther && faster)
            weight[0] = weight[1];
        else if (farther || faster)
            weight[1] = weight[0];
        const float open = shutter_weight(u);
        total += 2.0 * open;
        add(sum, pair[0], here, weight[0] * open);
        add(sum, pair[1], here, weight[1] * open);
    }
    // With HDR weighting the missing weight is the pixel's own, which weighs less if it is bright.
    if (hdr_weighting)
        total = sum.weight + max(total - sum.weight / max(here.hdr, 1e-6), 0.0) * here.hdr;
    used_taps = float(2 * steps);
    other_share = total > 0.0 ? sum.weight / total : 0.0;
    return over(sum, here, total);
}

#include "motion_blur_coverage.glsl"

// All vectors in reach are nearly equal: the plain mean along the pixel's own.
vec4 gather_uniform(vec2 pixel, Tap here, float j) {
    if (here.speed < still_length)
        return here.colour;
    const int count = tap_count(here.speed, taps);
    Sum sum = Sum(vec4(0), 0.0);
    for (int i = 0; i < count; ++i) {
        const float u = tap_place(i, count, j);
        const vec2 offset = -(constants.centre + u) * here.v;
        if (!is_inside(pixel, offset))
            continue; // unknown, as if hidden
        Tap tap = here;
        fetch_colour(tap, pixel, offset);
        add(sum, tap, here, shutter_weight(u));
    }
    used_taps = float(count);
    other_share = 1.0;
    return over(sum, here, sum.weight);
}

// The dominant vector, looked up up to a quarter of a tile away so that no tile's border shows. A neighbour that has
// nothing to say, or less than the pixel itself, is not taken.
vec2 dominant(ivec2 pixel, vec2 n, float own_speed) {
    if (!tile_jitter)
        return n;
    const vec2 shifted = vec2(pixel) + constants.noise_shift;
    const vec2 noise = vec2(gradient_noise(shifted + vec2(47, 17)), gradient_noise(shifted + vec2(131, 71))) - 0.5;
    const ivec2 jittered = ivec2(floor((vec2(pixel) + 0.5 + noise * 0.5 * float(tile_size)) / float(tile_size)));
    const vec2 other =
        texelFetch(neighbour_image, clamp(jittered, ivec2(0), textureSize(neighbour_image, 0) - 1), 0).xy;
    return length(other) >= max(still_length, own_speed) ? other : n;
}

// A row of blocks at once: all loads are under way before the first store.
void copy_row(ivec2 first) {
    const int blocks = int(tile_size / 8u);
    vec4 colours[4];
    [[unroll]] for (int i = 0; i < blocks; ++i) {
        const ivec2 pixel = min(first + ivec2(8 * i, 0), ivec2(constants.size) - 1);
        colours[i] = accumulates ? texelFetch(mean_image, pixel, 0) : texelFetch(colour_image, pixel, 0);
    }
    [[unroll]] for (int i = 0; i < blocks; ++i)
        if (all(lessThan(first + ivec2(8 * i, 0), ivec2(constants.size))))
            imageStore(output_image, first + ivec2(8 * i, 0), debug_view != 0 ? vec4(0, 0, 0, 1) : colours[i]);
}

vec4 blurred(ivec2 pixel, ivec2 tile) {
    const Tap here = centre_tap(pixel);
    const float j = constants.jitter_amount * tap_jitter(pixel);
    if (tile_class == 1)
        return gather_uniform(vec2(pixel), here, j);
    const vec4 neighbour = texelFetch(neighbour_image, tile, 0);
    const vec2 n = dominant(pixel, neighbour.xy, here.speed);
    if (weighting == 0)
        return gather_talk(vec2(pixel), here, n, j);
    if (weighting == 1)
        return gather_guertin(vec2(pixel), here, n, j);
    if (weighting == 2)
        return gather_jimenez(vec2(pixel), here, n, j);
    return gather_coverage(vec2(pixel), here, n, neighbour.zw, j,
                           constants.jitter_amount * tap_jitter(pixel + ivec2(47, 17)));
}

void main() {
    const ivec2 tiles = textureSize(neighbour_image, 0);
    const uint tile_count = uint(tiles.x * tiles.y);
    const uint tile_index = lists.words[12u + tile_class * tile_count + gl_WorkGroupID.y];
    const ivec2 tile = ivec2(tile_index % uint(tiles.x), tile_index / uint(tiles.x));
    const ivec2 corner = tile * int(tile_size) + ivec2(gl_LocalInvocationID.xy);
    const uint blocks = tile_size / 8u;
    const uint number = gl_WorkGroupID.x * 4u + gl_LocalInvocationID.z;
    if (tile_class == 0) {
        if (number < blocks)
            copy_row(corner + ivec2(0, 8 * number));
        return;
    }
    const ivec2 pixel = corner + 8 * ivec2(number % blocks, number / blocks);
    if (number >= blocks * blocks || any(greaterThanEqual(pixel, ivec2(constants.size))))
        return;
    vec4 result = blurred(pixel, tile);
    if (debug_view == 1)
        result = vec4(vec3(used_taps / 64.0), 1);
    else if (debug_view == 2)
        result = vec4(vec3(other_share), 1);
    else if (accumulates) {
        // The running mean, in this form, leaves equal iterations exactly as they are.
        const vec4 mean = texelFetch(mean_image, pixel, 0);
        result = mean + (result - mean) / (constants.iteration + 1.0);
    }
    imageStore(output_image, pixel, result);
}
