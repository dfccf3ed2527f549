// The gather: a workgroup takes 16×16 pixels, a thread several of them, and what is done with a pixel hangs on the class of
// its tile: still tiles are copied, in uniform ones no tap is compared, the others run in full. Sums are kept as
// differences from the pixel's own colour where taps are weighted: where none weighs anything, the pixel comes out bit
// for bit.

layout(local_size_x_id = 17) in; // 256 over the pixels of a thread

layout(constant_id = 0) const uint tile_size = 32;
layout(constant_id = 1) const bool is_packed = false;
layout(constant_id = 2) const uint weighting = 3; // talk, guertin, jimenez, coverage
layout(constant_id = 3) const int taps = 15;
layout(constant_id = 4) const bool taps_follow_length = false;
layout(constant_id = 5) const bool alternate = false;
layout(constant_id = 6) const bool tile_jitter = false;
layout(constant_id = 7) const uint jitter_kind = 3; // none, checkerboard, ordered, gradient noise
layout(constant_id = 8) const uint curve = 0;       // box, triangle, smooth
layout(constant_id = 9) const bool hdr_weighting = false;
layout(constant_id = 10) const bool soft_extent_is_absolute = false;
layout(constant_id = 11) const bool accumulates = false; // not the first iteration
layout(constant_id = 12) const uint debug_view = 0;      // 1 taps, 2 share of other surfaces
layout(constant_id = 13) const bool filter_taps = true;  // bilinear colour
layout(constant_id = 14) const int search_taps = 12;     // coverage: of velocity and depth only
layout(constant_id = 15) const int least_taps = 6;       // below which taps_per_pixel does not go
layout(constant_id = 16) const bool second_direction = false;
layout(constant_id = 18) const bool is_steady = true; // no other noise will follow, of iterations or frames

const uint threads = gl_WorkGroupSize.x;
const uint pixels = 256u / threads; // of a thread

layout(set = 0, binding = 0) uniform sampler2D colour_image;
layout(set = 0, binding = 1) uniform usampler2D surface_image;
layout(set = 0, binding = 2) uniform sampler2D mean_image; // of the iterations before
layout(set = 0, binding = 3) readonly buffer Neighbours { uvec2 vectors[]; } neighbours; // longest, widest or mark
layout(set = 0, binding = 4) uniform writeonly image2D output_image;

struct Tap {
    vec2 v;
    float speed;
    float z;
    vec4 colour;
    float hdr; // weight by brightness
};

Surface surface_of(uvec2 code) {
    if (is_packed)
        return unpack_8_bit(code.x, constants.radius);
    return unpack_half(code);
}

// Positions of taps are those of textures, from 0 to 1: the nearest texel and the image's edge are the sampler's work.
vec2 place(vec2 pixel, vec2 offset) { return (pixel + 0.5 + offset) * constants.inverse_size; }

vec4 colour_at(vec2 pixel, vec2 offset) {
    if (filter_taps)
        return sane(textureLod(colour_image, place(pixel, offset), 0.0));
    const ivec2 position = ivec2(floor(pixel + 0.5 + offset));
    return sane(texelFetch(colour_image, clamp(position, ivec2(0), ivec2(constants.size) - 1), 0));
}

// Velocity and depth are those of one pixel.
Tap surface_tap(vec2 pixel, vec2 offset) {
    const Surface s = surface_of(textureLod(surface_image, place(pixel, offset), 0.0).xy);
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
Tap centre_tap(uvec2 code, vec4 colour) {
    const Surface s = surface_of(code);
    Tap tap = Tap(s.v, length(s.v), s.z, sane(colour), 1.0);
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
float cylinder(float d, float speed) {
    return speed > 0.0 ? 1.0 - smoothstep(0.95 * speed, 1.05 * speed, streak_distance(d, speed)) : 0.0;
}

bool is_inside(vec2 pixel, vec2 offset) {
    const vec2 position = pixel + 0.5 + offset;
    return all(greaterThanEqual(position, vec2(0))) && all(lessThan(position, constants.size));
}

int tap_count(float blur_length, int most) {
    const int wanted = int(ceil(blur_length * constants.taps_per_pixel));
    return taps_follow_length ? clamp(wanted, min(least_taps, most), most) : most;
}

// Tap i of n as a place u in [-1, 1] of the shutter, moved by j in [-0.5, 0.5) of the spacing.
float tap_place(int i, int n, float j) { return (float(i) + 0.5 + j) * (2.0 / float(n)) - 1.0; }

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
    const float even_length = length(even), odd_length = length(odd);
    const float inverse_speed = here.speed > 0.0 ? 1.0 / here.speed : 0.0;
    Sum sum = Sum(vec4(0), 0.0);
    for (int i = 0; i < count; i += 2) { // an even and an odd tap are under way at once
        Tap pair[2];
        [[unroll]] for (int k = 0; k < 2; ++k)
            if (i + k < count)
                pair[k] = tap_at(pixel, -(constants.centre + tap_place(i + k, count, j)) * (k == 1 ? odd : even));
        [[unroll]] for (int k = 0; k < 2; ++k) {
            if (i + k >= count)
                break;
            const Tap tap = pair[k];
            const float u = tap_place(i + k, count, j);
            const float d = abs(constants.centre + u) * (k == 1 ? odd_length : even_length);
            const float nearer = (here.z - tap.z) / soft(here.z, tap.z);
            const float background = clamp(1.0 - nearer, 0.0, 1.0);
            const float foreground = clamp(1.0 + nearer, 0.0, 1.0);
            // What is left of the cones' height at d; not negative where it is within the streak.
            const float here_left = here.speed - streak_distance(d, here.speed);
            const float tap_left = tap.speed - streak_distance(d, tap.speed);
            const float here_cone = clamp(here_left * inverse_speed, 0.0, 1.0);
            const float tap_cone = clamp(tap_left / max(tap.speed, 1e-6), 0.0, 1.0);
            float w = constants.weight_background * background * here_cone +
                      constants.weight_foreground * foreground * tap_cone;
            if (min(here_left, tap_left) >= 0.0)
                w += constants.weight_mutual;
            add(sum, tap, here, w * shutter_weight(u));
        }
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

// All vectors in reach are nearly equal: the plain mean along the pixel's own, for all pixels of the thread at once, where
// nothing is in the way: the taps of all are under way together.
struct Line {
    vec2 next, step; // of taps
    float count, spacing;
    vec4 sum;
};

// Taps along a pixel's vector, from `first` of the shutter.
Line line_of(ivec2 at, vec2 v, out float first) {
    Line line;
    const float squared = dot(v, v);
    const float most = float(taps);
    const float speed = sqrt(squared);
    const float wanted = ceil(speed * constants.taps_per_pixel);
    line.count = taps_follow_length ? clamp(wanted, float(min(least_taps, taps)), most) : most;
    line.spacing = 2.0 / line.count;
    // Bilinear taps up to two pixels apart leave nothing out, so that noise has nothing to hide.
    first = 0.5;
    if (!is_steady || line.spacing * speed > 2.0)
        first += constants.jitter_amount * tap_jitter(at);
    first = constants.centre - 1.0 + line.spacing * first;
    line.next = place(vec2(at), -first * v);
    line.step = (-line.spacing * v) * constants.inverse_size;
    line.sum = vec4(0);
    if (squared < still_length * still_length)
        line.count = 0.0;
    return line;
}

// Two taps at a time.
void walk(inout Line line, float i) {
    vec4 a = vec4(0), b = vec4(0);
    if (i < line.count)
        a = textureLod(colour_image, line.next, 0.0);
    if (i + 1.0 < line.count)
        b = textureLod(colour_image, line.next + line.step, 0.0);
    line.next += 2.0 * line.step;
    line.sum += a + b;
}

bool is_finite(vec4 v) { return is_finite(abs(v.x) + abs(v.y) + abs(v.z) + abs(v.w)); }

// All vectors in reach are nearly equal: the plain mean along the pixel's own. `is_far` from the image's edge no tap leaves
// it.
vec4 gather_uniform(ivec2 at, vec4 colour, uvec2 code) {
    const vec2 v = vector_of(code.x, is_packed, constants.radius);
    const vec2 pixel = vec2(at);
    float first;
    const Line line = line_of(at, v, first);
    used_taps = line.count;
    other_share = line.count > 0.0 ? 1.0 : 0.0;
    const Tap here = centre_tap(code, colour);
    Sum sum = Sum(vec4(0), 0.0);
    for (float i = 0.0; i < line.count; i += 1.0) {
        const float s = first + line.spacing * i;
        if (!is_inside(pixel, -s * v))
            continue; // unknown, as if hidden
        Tap tap = here;
        fetch_colour(tap, pixel, -s * v);
        add(sum, tap, here, shutter_weight(s - constants.centre));
    }
    return over(sum, here, sum.weight);
}

ivec2 tiles() { return (ivec2(constants.size) + int(tile_size) - 1) / int(tile_size); }
uint tile_index(ivec2 tile) { return uint(tile.y * tiles().x + tile.x); }

// The dominant vector, looked up up to a quarter of a tile away so that no tile's border shows. A neighbour that has
// nothing to say, or less than the pixel itself, is not taken.
vec2 dominant(ivec2 pixel, vec2 n, float own_speed) {
    if (!tile_jitter)
        return n;
    const vec2 shifted = vec2(pixel) + constants.noise_shift;
    const vec2 noise = vec2(gradient_noise(shifted + vec2(47, 17)), gradient_noise(shifted + vec2(131, 71))) - 0.5;
    const ivec2 jittered = ivec2(floor((vec2(pixel) + 0.5 + noise * 0.5 * float(tile_size)) / float(tile_size)));
    const uint code = neighbours.vectors[tile_index(clamp(jittered, ivec2(0), tiles() - 1))].x;
    const vec2 other = vector_of(code, is_packed, constants.radius);
    return length(other) >= max(still_length, own_speed) ? other : n;
}

vec4 gather_full(ivec2 pixel, vec4 colour, uvec2 surface, uvec2 codes) {
    const Tap here = centre_tap(surface, colour);
    const float j = constants.jitter_amount * tap_jitter(pixel);
    const vec2 n = dominant(pixel, vector_of(codes.x, is_packed, constants.radius), here.speed);
    if (weighting == 0)
        return gather_talk(vec2(pixel), here, n, j);
    if (weighting == 1)
        return gather_guertin(vec2(pixel), here, n, j);
    if (weighting == 2)
        return gather_jimenez(vec2(pixel), here, n, j);
    return gather_coverage(vec2(pixel), here, n, vector_of(codes.y, is_packed, constants.radius), j,
                           constants.jitter_amount * tap_jitter(pixel + ivec2(47, 17)));
}

// The 16×16 pixels are four blocks of 8×8, so that the threads of a subgroup lie close together.
ivec2 pixel_of(uint number) {
    const uint block = number / 64u;
    return ivec2(gl_WorkGroupID.xy * 16u + uvec2(8u * (block & 1u) + number % 8u, 8u * (block / 2u) + number / 8u % 8u));
}

void main() {
    const ivec2 last = ivec2(constants.size) - 1;
    // One tile for the whole workgroup where tiles are that large.
    const bool is_shared = tile_size % 16u == 0u;
    const vec2 corner = vec2(gl_WorkGroupID.xy * 16u);
    uvec2 codes = uvec2(0);
    if (is_shared)
        codes = neighbours.vectors[tile_index(ivec2(gl_WorkGroupID.xy * 16u / tile_size))];
    vec4 colours[pixels];
    [[unroll]] for (uint k = 0u; k < pixels; ++k) // all under way at once, before anything is known of the tile
        colours[k] = texelFetch(colour_image, min(pixel_of(gl_LocalInvocationIndex + k * threads), last), 0);
    if (is_shared && codes.x == zero_vector(is_packed) && debug_view == 0) {
        // A still tile comes out bit for bit, in every iteration.
        [[unroll]] for (uint k = 0u; k < pixels; ++k) {
            const ivec2 pixel = pixel_of(gl_LocalInvocationIndex + k * threads);
            if (all(lessThanEqual(pixel, last)))
                imageStore(output_image, pixel, colours[k]);
        }
        return;
    }
    uvec2 surfaces[pixels];
    [[unroll]] for (uint k = 0u; k < pixels; ++k)
        surfaces[k] = texelFetch(surface_image, min(pixel_of(gl_LocalInvocationIndex + k * threads), last), 0).xy;
    // Far from the image's edge no tap leaves it: no vector of the tile is longer than the longest in reach.
    const float reach = length(vector_of(codes.x, is_packed, constants.radius)) * (1.0 + abs(constants.centre)) + 1.0;
    const bool is_far =
        all(greaterThan(corner, vec2(reach))) && all(lessThan(corner + (16.0 + reach), constants.size));
    if (is_shared && curve == 0 && !hdr_weighting && filter_taps && !accumulates && debug_view == 0 && is_far &&
        codes.y == uniform_mark) {
        Line lines[pixels];
        float most = 0.0;
        [[unroll]] for (uint k = 0u; k < pixels; ++k) {
            float first;
            lines[k] = line_of(pixel_of(gl_LocalInvocationIndex + k * threads),
                               vector_of(surfaces[k].x, is_packed, constants.radius), first);
            most = max(most, lines[k].count);
        }
        for (float i = 0.0; i < most; i += 2.0)
            [[unroll]] for (uint k = 0u; k < pixels; ++k)
                walk(lines[k], i);
        bool is_done = true;
        [[unroll]] for (uint k = 0u; k < pixels; ++k) {
            const vec4 mean = lines[k].count > 0.0 ? lines[k].sum * (0.5 * lines[k].spacing) : colours[k];
            is_done = is_done && is_finite(mean);
            imageStore(output_image, pixel_of(gl_LocalInvocationIndex + k * threads), mean);
        }
        if (is_done)
            return;
    }
    [[dont_unroll]] for (uint k = 0u; k < pixels; ++k) {
        const ivec2 pixel = pixel_of(gl_LocalInvocationIndex + k * threads);
        if (any(greaterThan(pixel, last)))
            continue;
        if (!is_shared)
            codes = neighbours.vectors[tile_index(pixel / int(tile_size))];
        vec4 colour = colours[0];
        uvec2 surface = surfaces[0];
        [[unroll]] for (uint i = 1u; i < pixels; ++i) {
            colour = i == k ? colours[i] : colour;
            surface = i == k ? surfaces[i] : surface;
        }
        const bool is_still = codes.x == zero_vector(is_packed);
        vec4 result = colour;
        used_taps = other_share = 0.0;
        if (!is_still)
            result = codes.y == uniform_mark ? gather_uniform(pixel, colour, surface)
                                             : gather_full(pixel, colour, surface, codes);
        if (debug_view == 1)
            result = vec4(vec3(used_taps / 64.0), 1);
        else if (debug_view == 2)
            result = vec4(vec3(other_share), 1);
        else if (accumulates && !is_still) {
            // The running mean, in this form, leaves equal iterations exactly as they are.
            const vec4 mean = texelFetch(mean_image, pixel, 0);
            result = mean + (result - mean) / (constants.iteration + 1.0);
        }
        imageStore(output_image, pixel, result);
    }
}
