// One estimate of the visibility at every pixel of the working resolution.

layout(local_size_x = 256) in;

layout(constant_id = 3) const uint kind = 3; // obscurance, hbao, cosine, bitmask
layout(constant_id = 4) const uint falloff_kind = 0;
layout(constant_id = 5) const uint pattern = 1;
layout(constant_id = 6) const uint taps = 9;
layout(constant_id = 7) const uint slices = 2;
layout(constant_id = 8) const uint steps = 6;
layout(constant_id = 9) const uint normalisation = 0;
layout(constant_id = 10) const uint noise_kind = 1;
layout(constant_id = 11) const uint iterations = 1;
layout(constant_id = 12) const uint mip_mode = 1; // none, rotated, farthest, centre
layout(constant_id = 13) const int normal_encoding = 0; // 0: derived from depth
layout(constant_id = 14) const bool endless = false;    // thickness
layout(constant_id = 15) const bool has_shadow = false;
layout(constant_id = 16) const bool want_bent_normal = false;
layout(constant_id = 17) const bool test_occluders = false;
layout(constant_id = 18) const bool even_steps = true;

layout(constant_id = 20) const uint view = 0; // none, depth, normal, mip, radius
layout(constant_id = 21) const bool direct = false; // from the host's depth instead of the pyramid
layout(constant_id = 22) const bool device_depth = false;
layout(constant_id = 23) const bool same_size = false; // normals and depth
layout(constant_id = 24) const bool moving_noise = false;
layout(constant_id = 25) const bool in_middle = false; // the depth that filters compare

layout(set = 0, binding = 0) uniform sampler2D pyramid;
layout(set = 0, binding = 1) uniform sampler2D normal_image;
layout(set = 0, binding = 2) uniform sampler2D shadow_image;
layout(set = 0, binding = 3) uniform usampler2D history;
layout(set = 0, binding = 4) uniform writeonly uimage2D signal_image;
layout(set = 0, binding = 5) uniform writeonly image2D bent_image;

const float pi = 3.14159265358979;
const float working_pixel = half_resolution ? 2.0 : 1.0; // in pixels of the full resolution

// The full-resolution pixel, at its middle, that a texel of the finest level was taken from.
vec2 pixel_of(ivec2 q, float z) { return vec2(half_resolution ? 2 * q + choice_of(z) : q) + 0.5; }

float depth_at(ivec2 q, int m) {
    const float z = texelFetch(pyramid, q, m).x;
    return direct ? usable_depth(device_depth ? view_depth_of(z, constants.projection) : z) : z;
}

struct Centre {
    vec2 pixel; // at full resolution
    vec3 p; // view position
    vec3 n; // normal
    vec3 v; // towards the eye
    float radius, inverse_radius; // scene units
    float radius_pixels; // vertically, at full resolution
    float inverse_depth; // 1 for parallel rays
    vec2 working;        // the pixel in texels of the finest level
    vec2 ray_scale, ray_offset; // view xy over depth of a texel of the finest level
};

// Per axis the shorter of the two one-sided differences: the other may cross an edge. At half resolution neighbours lie
// askew, and the shorter ones of both axes may run along the same line of equal depth: they span no plane then, but the next ones do.
vec3 derived_normal(ivec2 p, vec2 pixel, vec3 centre) {
    vec3 difference[2] = vec3[2](vec3(0), vec3(0));
    vec2 first = vec2(0); // the chosen difference of the first axis, in pixels
    for (int axis = 0; axis < 2; ++axis) {
        const ivec2 unit = axis == 0 ? ivec2(1, 0) : ivec2(0, 1);
        const ivec2 last = ivec2(constants.working_size) - 1;
        float shortest = 3e38;
        vec2 chosen = vec2(0);
        for (int way = 0; way < 4; ++way) {
            const int sign = 2 * (way & 1) - 1;
            if (way == 2 && (!half_resolution || shortest < 3e38))
                break;
            const ivec2 q = p + sign * (1 + way / 2) * unit;
            if (any(lessThan(q, ivec2(0))) || any(greaterThan(q, last)))
                continue;
            const float z = depth_at(q, 0);
            const vec2 at = pixel_of(q, z);
            const vec2 step_to = float(sign) * (at - pixel);
            const vec3 d = float(sign) * (view_position(at, z) - centre);
            const bool spans = axis == 0 || abs(first.x * step_to.y - first.y * step_to.x) > 0.5;
            if (!is_pyramid_sky(z) && spans && abs(d.z) < shortest) {
                shortest = abs(d.z);
                difference[axis] = d;
                chosen = step_to;
            }
        }
        first = chosen;
    }
    const vec3 n = cross(difference[1], difference[0]);
    const float squared = dot(n, n);
    if (squared <= 0.0 || !is_finite(squared))
        return vec3(0, 0, 1);
    const bool away = (perspective ? -dot(n, centre) : n.z) < 0.0;
    return (away ? -n : n) * inversesqrt(squared);
}

Centre make_centre(ivec2 p, float z) {
    Centre c;
    const ivec2 full_pixel = half_resolution ? 2 * p + choice_of(z) : p;
    const vec2 pixel = vec2(full_pixel) + 0.5;
    c.pixel = pixel;
    const float pulled = z * (1.0 - constants.depth_bias);
    const vec3 position = view_position(pixel, z);
    c.p = view_position(pixel, pulled);
    c.v = perspective ? -normalize(position) : vec3(0, 0, 1);
    bool found = false;
    if (normal_encoding != 0) {
        c.n = decode_normal(texelFetch(normal_image, same_size ? full_pixel : scaled(full_pixel, constants.normal_ratio), 0), normal_encoding);
        const float squared = dot(c.n, c.n);
        found = squared > 0.01 && is_finite(squared);
        c.n *= inversesqrt(max(squared, 0.01));
    }
    // Deriving them takes so many registers that having it at hand costs a third of the time: not for single pixels.
    if (normal_encoding == 0)
        c.n = derived_normal(p, pixel, position);
    else
        c.n = found ? c.n : c.v;
    // Interpolated normals may face away at silhouettes.
    // No branch: taps are aimed and fetched while the normal is still under way.
    const vec3 turned = c.n + max(0.01 - dot(c.n, c.v), 0.0) * c.v;
    c.n = turned * inversesqrt(max(dot(turned, turned), 1e-12));
    c.working = pixel / working_pixel;
    c.ray_scale = constants.pixel_to_view.xy * working_pixel;
    c.ray_offset = constants.pixel_to_view.zw + 0.5 * constants.pixel_to_view.xy;
    // Where the limit shortens the radius on the screen it shortens it in the scene as well.
    const float inverse_depth = perspective ? 1.0 / pulled : 1.0;
    const float unlimited = constants.radius * constants.pixels * inverse_depth;
    const float excess = max(unlimited / constants.radius_limit, 1.0); // by a uniform
    c.radius_pixels = min(unlimited, constants.radius_limit);
    c.inverse_radius = excess / constants.radius;
    c.radius = excess > 1.0 ? 1.0 / c.inverse_radius : constants.radius;
    c.inverse_depth = inverse_depth;
    return c;
}

// Planar depth in the middle of the four pixels that a texel of half resolution stands for, on the surface's plane:
// filters compare texels as if they lay on a grid, and the pixels that were taken do not. Normals of shading may be far
// off the surface's own, hence the limit.
float planar_in_middle(Centre c, ivec2 p, float z) {
    const vec2 way = (vec2(2 * p + 1) - c.pixel) * constants.pixel_to_view.xy;
    if (!perspective)
        return z + clamp(dot(c.n.xy, way) / c.n.z, -0.1 * constants.radius, 0.1 * constants.radius);
    const vec2 ray = c.pixel * constants.pixel_to_view.xy + constants.pixel_to_view.zw;
    const float factor = 1.0 + dot(c.n.xy, way) / min(dot(c.n.xy, ray) - c.n.z, -1e-4);
    return clamp(factor, 0.8, 1.25) / z;
}

// Where a tap looks. Taps are aimed and fetched several at a time: what one of them waits for, all wait for at once.
struct Aim {
    ivec2 texel; // of level `level`
    int level;
    vec2 exact; // the texel of the finest level that it was picked from
    bool on_screen;
};

// At `at` (texels of the finest level, on the screen), from the level that suits a tap so many texels away.
Aim aim(vec2 at, float away) {
    Aim a;
    const ivec2 base = ivec2(at);
    a.on_screen = true;
    a.level = 0;
    if (mip_mode != 0)
        a.level = clamp((floatBitsToInt(away * constants.mip_scale) >> 23) - 127, 0, last_mip);
    a.texel = base >> a.level;
    if (mip_mode == 1) {
        a.exact = vec2(rotated_base(a.texel, a.level));
    } else if (mip_mode == 2) {
        // The middle of a block that was averaged; a texel of half resolution is the middle of four pixels.
        const float shift = half_resolution ? 0.25 : 0.0;
        a.exact = a.level > 0 ? (vec2(a.texel) + 0.5) * float(1 << a.level) - 0.5 + shift : vec2(a.texel);
    } else {
        a.exact = vec2((base & (-1 << a.level)) | ((1 << a.level) >> 1));
    }
    return a;
}

// Texels of the finest level that the screen has; half resolution may end in half a texel.
vec2 screen() { return constants.size / working_pixel; }

// The way from the centre to what was found at depth z; very long for sky.
vec3 way_to(Centre c, Aim a, float z) {
    vec2 ray = a.exact * c.ray_scale + c.ray_offset;
    if (half_resolution && (mip_mode != 2 || a.level == 0))
        ray += vec2(choice_of(z)) * constants.pixel_to_view.xy;
    return vec3((perspective ? ray * z : ray) - c.p.xy, -z - c.p.z);
}

// Of a length in radii, given its square: most need no root.
float falloff(float squared) {
    squared = min(squared, 1.0);
    const float left = 1.0 - squared;
    const float linear = 1.0 - squared * inversesqrt(max(squared, 1e-30));
    switch (falloff_kind) {
    case 0: return squared < 1.0 ? 1.0 : 0.0;
    case 1: return linear;
    case 2: return left;
    case 3: return left * left * left;
    case 4: return linear * linear;
    default: return 1.0 - squared * squared;
    }
}

// Turn and offset of the pattern, both 0…1. `blocks` holds all 16 pairs in any 4×4 pixels.
vec2 pattern_noise(ivec2 p, uint iteration) {
    const float number = float(iteration);
    if (noise_kind == 0)
        return fract(vec2(0.0, 0.5) + number * vec2(0.75487767, 0.56984029));
    if (noise_kind == 1) {
        const vec2 at = vec2(p) + constants.noise_shift + 5.588238 * number;
        return vec2(gradient_noise(at), gradient_noise(at + vec2(31, 71)));
    }
    if (noise_kind == 2) {
        // McGuire et al. 2012: (3x xor (y + xy)) * 10 radians.
        const float turn = float(((3 * p.x) ^ (p.y + p.x * p.y)) & 0xffff) * (10.0 / (2.0 * pi));
        return fract(vec2(turn, turn * 1.61803399) + (number + constants.block_shift) * vec2(0.75487767, 0.56984029));
    }
    const int x = p.x & 3, y = p.y & 3;
    const int order = ((x ^ y) & 1) * 8 + (y & 1) * 4 + (((x ^ y) >> 1) & 1) * 2 + (y >> 1);
    // Sixteenths, put into the bits of a float between 1 and 2.
    vec2 pair = uintBitsToFloat(uvec2(0x3f800000u) | (uvec2(order, order * 7 + 3) & 15u) << 19) - vec2(1.0, 1.0 - 1.0 / 32.0);
    if (moving_noise)
        pair = fract(pair + (number + constants.block_shift) * vec2(0.75487767, 0.56984029));
    return pair;
}

// What the taps add up to.
struct Sum {
    float visible; // weighted share of the sky that is open
    float weight;
    vec3 hidden; // directions of what hides, by its share
    float danger; // share hidden by things that were elsewhere in the previous frame
};

// Whether what is at `p` was seen there in the previous frame: an occluder that moved leaves a trail of wrong history.
bool was_there(vec3 p) {
    const vec4 before = constants.previous_view_from_view * vec4(p, 1);
    const vec4 clip = constants.previous_projection * before;
    const vec2 at = (clip.xy / clip.w * 0.5 + 0.5) * constants.working_size;
    if (!(clip.w > 0.0) || any(lessThan(at, vec2(0))) || any(greaterThanEqual(at, constants.working_size)))
        return false;
    const float w = uintBitsToFloat(texelFetch(history, ivec2(at), 0).x & ~31u);
    return w != 0.0 && abs(depth_of_planar(w) + before.z) * constants.history_position < 1.0;
}

#include "ambient_occlusion_obscurance.glsl"
#include "ambient_occlusion_horizon.glsl"

// Grey values that show the inside of the estimate.
float shown(Centre c, float z) {
    if (view == 1)
        return constants.radius / (constants.radius + 0.1 * z);
    if (view == 2) // lit from the upper left
        return 0.5 + 0.5 * dot(c.n, vec3(-0.57735027, 0.57735027, 0.57735027));
    if (view == 3)
        return clamp(log2(c.radius_pixels / working_pixel * constants.mip_scale), 0.0, float(last_mip)) / float(last_mip);
    return clamp(c.radius_pixels / constants.size.y, 0.0, 1.0);
}

Signal estimate(ivec2 p, float z, out vec3 bent) {
    const Centre c = make_centre(p, z);
    if (view != 0) {
        bent = c.n;
        return Signal(shown(c, z), planar(z), 1.0, 0.0);
    }
    Sum sum = Sum(0.0, 0.0, vec3(0), 0.0);
    for (uint i = 0; i < iterations; ++i) {
        if (kind == 0)
            add_obscurance(c, pattern_noise(p, i), sum);
        else
            add_horizons(c, pattern_noise(p, i), sum);
    }
    Signal s;
    float visibility = sum.weight > 0.0 ? sum.visible / sum.weight : 1.0;
    // The cosine-weighted mean of all directions is 2/3 of the normal.
    bent = c.n * (2.0 / 3.0) - (sum.weight > 0.0 ? sum.hidden / sum.weight : vec3(0));
    const float length_squared = dot(bent, bent);
    bent = length_squared > 1e-6 ? bent * inversesqrt(length_squared) : c.n;
    // A radius below a pixel finds nothing but rounding: it fades out.
    visibility = mix(1.0, visibility, clamp((c.radius_pixels / working_pixel - 1.0) * 0.5, 0.0, 1.0));
    s.visibility = visibility;
    s.w = in_middle ? planar_in_middle(c, p, z) : planar(z);
    s.shadow = 1.0;
    s.count = sum.weight > 0.0 ? clamp(sum.danger / sum.weight * 124.0, 0.0, 31.0) : 0.0;
    return s;
}

// A workgroup has 32×16 pixels, two for each thread. With the pattern of 4×4 pixels every 32 threads in a row have the
// pixels of one turn, four apart: their taps lie side by side in the coarser
// depths, where random turns would scatter them.
const ivec2 group_size = ivec2(32, 16);
const bool in_place = !(noise_kind == 3 && mip_mode != 0); // neighbours in the image are neighbours in the warp
shared uvec2 results[in_place ? 1 : group_size.x * group_size.y];

ivec2 local_pixel(int index) {
    const int lane = index & 31, row = index >> 5;
    if (!in_place)
        return ivec2((lane & 7) * 4 + (row & 3), (lane >> 3) * 4 + (row >> 2));
    return ivec2((lane & 7) + (row & 3) * 8, (lane >> 3) + (row >> 2) * 4);
}

Signal signal_at(ivec2 p, float z, out vec3 bent) {
    const vec2 pixel = pixel_of(p, z);
    Signal s = Signal(1.0, 0.0, 1.0, 0.0);
    bent = vec3(0, 0, 1);
    if (!is_pyramid_sky(z) && !in_guard_band(pixel))
        s = estimate(p, z, bent);
    if (has_shadow)
        s.shadow = clamp(sane(texelFetch(shadow_image, scaled(ivec2(pixel), constants.shadow_ratio), 0).x), 0.0, 1.0);
    return s;
}

void main() {
    const ivec2 origin = ivec2(gl_WorkGroupID.xy) * group_size;
    const ivec2 last = ivec2(constants.working_size) - 1;
    const int thread = int(gl_LocalInvocationIndex);
    // Both depths are under way before the first is used.
    float z[2];
    [[unroll]] for (int i = 0; i < 2; ++i)
        z[i] = depth_at(min(origin + local_pixel(thread + 256 * i), last), 0);
    [[dont_unroll]] for (int i = 0; i < 2; ++i) {
        const ivec2 local = local_pixel(thread + 256 * i);
        const ivec2 p = origin + local;
        if (any(greaterThan(p, last)))
            continue;
        vec3 bent;
        const Signal s = signal_at(p, i == 0 ? z[0] : z[1], bent);
        if (in_place)
            imageStore(signal_image, p, uvec4(pack_signal(s), 0, 0));
        else
            results[local.y * group_size.x + local.x] = pack_signal(s);
        if (want_bent_normal)
            imageStore(bent_image, p, vec4(bent, s.w));
    }
    if (in_place)
        return;
    // Written in whole rows.
    barrier();
    for (int i = 0; i < 2; ++i) {
        const int index = thread + 256 * i;
        const ivec2 p = origin + ivec2(index % group_size.x, index / group_size.x);
        if (all(lessThanEqual(p, last)))
            imageStore(signal_image, p, uvec4(results[index], 0, 0));
    }
}
