// The cross-bilateral filter, both axes in one dispatch: a workgroup loads its tile with a border, filters rows, then
// columns. The temporal filter works on what comes out, and the last filter hands the result to the host.

layout(local_size_x = 256) in;

layout(constant_id = 3) const int filter_radius = 4;
layout(constant_id = 4) const int filter_step = 1;
layout(constant_id = 5) const uint weight_kind = 0;
layout(constant_id = 6) const bool relative = true;
layout(constant_id = 7) const bool continue_slope = true;
layout(constant_id = 8) const bool use_normals = false;
layout(constant_id = 9) const int normal_encoding = 1;
layout(constant_id = 10) const bool temporal = false;
layout(constant_id = 11) const bool has_velocity = false;
layout(constant_id = 12) const bool is_last = false;  // finishes, at full resolution
layout(constant_id = 13) const bool keeps = true;     // writes the signal
layout(constant_id = 14) const bool enlarged = false; // at full resolution, from a half one
layout(constant_id = 15) const bool shows_weight = false;
layout(constant_id = 16) const int tile_width = 32;
layout(constant_id = 17) const int tile_height = 16;
layout(constant_id = 18) const bool has_shadow = false;
layout(constant_id = 19) const int run = 4; // texels that a thread averages, one after the other: what they share is loaded once

layout(set = 0, binding = 0) uniform usampler2D signal_image;
layout(set = 0, binding = 2) uniform usampler2D history;
layout(set = 0, binding = 3) uniform sampler2D velocity_image;
layout(set = 0, binding = 4) uniform sampler2D normal_image;
layout(set = 0, binding = 5) uniform writeonly uimage2D kept_image;

const int threads = 256;
const int border = filter_radius > 0 ? filter_radius * filter_step : 1;
const int loaded_width = tile_width + 2 * border, loaded_height = tile_height + 2 * border;
const int pitch = loaded_width | 1; // odd, so that a column lies in all banks
const int loaded_count = pitch * loaded_height;
const int row_count = tile_width * loaded_height;
// Packed, as they travel: what a thread waits for most is shared memory. Narrow signals are one word, depth in the upper
// half; of wide ones the second word has visibility and shadow. The planner sees to it that all fit into 16 KiB.
shared uint tile[loaded_count];
shared uint wide_tile[wide ? loaded_count : 1];
shared uint rows[row_count]; // averaged along x; narrow ones with the depth that they belong to

// Stands for the planar depth of sky and of what is off the image: it differs from everything by more than any limit.
const uint no_planar_code = 0xfbff0000u; // the largest negative half
float planar_of(uint code) { return wide ? uintBitsToFloat(code & ~31u) : unpackHalf2x16(code).y; }
float no_planar() { return wide ? wide_no_planar : -65504.0; }

ivec2 result_size() { return ivec2(enlarged ? constants.size : constants.working_size); }

vec3 normal_at(ivec2 p) {
    const ivec2 pixel = half_resolution && !enlarged ? 2 * p : p;
    return decode_normal(texelFetch(normal_image, scaled(pixel, constants.normal_ratio), 0), normal_encoding);
}

float normal_weight(vec3 a, ivec2 p) {
    const vec3 b = normal_at(clamp(p, ivec2(0), result_size() - 1));
    return pow(clamp(dot(a, b) * inversesqrt(max(dot(a, a) * dot(b, b), 1e-12)), 0.0, 1.0), constants.filter_normal);
}

// 1 over the difference of planar depth that counts as an edge. Narrow depths are scaled.
float per_difference(float w) {
    if (relative)
        return constants.filter_scale / w;
    // dz = dw / w² in perspective.
    const float scale = wide ? 1.0 : constants.code_scale;
    return constants.filter_scale * (perspective ? scale / (w * w) : 1.0 / scale);
}

float bell_at(int k) {
    return k == 0 ? 1.0 : k < 5 ? constants.bells_near[k - 1] : constants.bells_far[k - 5];
}

// A run of texels along one axis with what lies within the filter's reach of it.
const int reach = run + 2 * border;
struct Window {
    float planar[reach];
    float value[reach];
    float shadow[has_shadow ? reach : 1];
};

// Visibility and shadow of texel `i` of the run, averaged along the axis.
vec2 averaged(Window window, int i, ivec2 p, ivec2 axis) {
    const int middle = border + i;
    const float centre = window.planar[middle];
    const float edge = per_difference(centre);
    float slope = 0.0;
    if (continue_slope)
        slope = continued_slope(window.planar[middle - 1], centre, window.planar[middle + 1], no_planar()) * edge;
    vec3 normal = vec3(0);
    if (use_normals)
        normal = normal_at(p);
    float total = 0.0, shadow = 0.0, weights = 0.0;
    [[unroll]] for (int k = -filter_radius; k <= filter_radius; ++k) {
        const int offset = k * filter_step;
        const float difference = window.planar[middle + offset] * edge - (centre * edge + slope * float(offset));
        float weight = bilateral_weight(bell_at(abs(k)), difference, weight_kind);
        if (use_normals && k != 0)
            weight *= normal_weight(normal, p + offset * axis);
        total += weight * window.value[middle + offset];
        if (has_shadow)
            shadow += weight * window.shadow[middle + offset];
        weights += weight;
    }
    return vec2(total, shadow) / weights;
}

void set(inout Window window, int k, uint code, uint values) {
    window.planar[k] = planar_of(code);
    const vec2 pair = unpackHalf2x16(wide ? values : code);
    window.value[k] = pair.x;
    if (has_shadow)
        window.shadow[k] = pair.y;
}

// Rows of the tile and of its border above and below. The threads of a warp take different rows, the same columns.
void average_rows(ivec2 origin, int thread) {
    const int runs = tile_width / run;
    for (int item = thread; item < loaded_height * runs; item += threads) {
        const int y = item % loaded_height, x = item / loaded_height * run;
        Window window;
        [[unroll]] for (int k = 0; k < reach; ++k)
            set(window, k, tile[y * pitch + x + k], wide ? wide_tile[y * pitch + x + k] : 0u);
        [[unroll]] for (int i = 0; i < run; ++i) {
            const vec2 value = averaged(window, i, origin + ivec2(x + i, y - border), ivec2(1, 0));
            rows[y * tile_width + x + i] = packHalf2x16(vec2(value.x, wide ? value.y : window.planar[border + i]));
        }
    }
}

#include "ambient_occlusion_temporal.glsl"

void store(ivec2 p, Signal s) {
    if (wide)
        s.count = float(texelFetch(signal_image, p, 0).x & 31u);
    if (temporal)
        s = blended(p, s);
    if (keeps)
        imageStore(kept_image, p, uvec4(pack_signal(s), 0, 0));
    if (is_last)
        finish(p, s.w == 0.0 ? 1.0 : s.visibility, s.shadow);
}

// All fetches of a thread are under way before the first is used.
void load_tile(ivec2 origin, int thread) {
    const ivec2 last = result_size() - 1;
    const int count = loaded_width * loaded_height;
    const int loads = (count + threads - 1) / threads;
    uvec2 fetched[loads];
    [[unroll]] for (int i = 0; i < loads; ++i) {
        const int index = min(thread + i * threads, count - 1);
        const ivec2 p = origin - border + ivec2(index % loaded_width, index / loaded_width);
        const ivec2 inside = clamp(p, ivec2(0), last);
        fetched[i] = texelFetch(signal_image, inside, 0).xy;
        if (p != inside)
            fetched[i].x = 0u;
    }
    [[unroll]] for (int i = 0; i < loads; ++i) {
        const int index = min(thread + i * threads, count - 1);
        const int at = index / loaded_width * pitch + index % loaded_width;
        if (wide) {
            tile[at] = (fetched[i].x & ~31u) == 0u ? floatBitsToUint(wide_no_planar) : fetched[i].x;
            wide_tile[at] = fetched[i].y;
        } else {
            tile[at] = fetched[i].x < 0x10000u ? no_planar_code | fetched[i].x : fetched[i].x;
        }
    }
}

void average_columns(ivec2 origin, int thread) {
    const ivec2 size = result_size();
    const int runs = tile_height / run;
    for (int item = thread; item < tile_width * runs; item += threads) {
        const int x = item % tile_width, y = item / tile_width * run;
        Window window;
        [[unroll]] for (int k = 0; k < reach; ++k) {
            const int at = (y + k) * pitch + x + border;
            const uint averaged_row = filter_radius > 0 ? rows[(y + k) * tile_width + x] : 0u;
            if (wide)
                set(window, k, tile[at], filter_radius > 0 ? averaged_row : wide_tile[at]);
            else
                set(window, k, filter_radius > 0 ? averaged_row : tile[at], 0u);
        }
        [[unroll]] for (int i = 0; i < run; ++i) {
            const ivec2 p = origin + ivec2(x, y + i);
            const float w = window.planar[border + i];
            const bool sky = w == no_planar();
            Signal s = Signal(1.0, sky ? 0.0 : wide ? w : w / constants.code_scale, 1.0, 0.0);
            const vec2 value = averaged(window, i, p, ivec2(0, 1));
            if (!sky)
                s.visibility = value.x;
            if (has_shadow)
                s.shadow = value.y;
            if (all(lessThan(p, size)))
                store(p, s);
        }
    }
}

void main() {
    const ivec2 origin = ivec2(gl_WorkGroupID.xy) * ivec2(tile_width, tile_height);
    const int thread = int(gl_LocalInvocationIndex);
    load_tile(origin, thread);
    barrier();
    if (filter_radius > 0) {
        average_rows(origin, thread);
        barrier();
    }
    average_columns(origin, thread);
}
