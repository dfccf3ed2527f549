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
layout(constant_id = 14) const bool enlarges = false; // reads half resolution
layout(constant_id = 15) const bool shows_weight = false;
layout(constant_id = 16) const int tile_width = 32;
layout(constant_id = 17) const int tile_height = 16;
layout(constant_id = 18) const int border = 4; // radius times step, at least 1
layout(constant_id = 19) const bool has_shadow = false;

layout(set = 0, binding = 2) uniform usampler2D history;
layout(set = 0, binding = 3) uniform sampler2D velocity_image;
layout(set = 0, binding = 4) uniform sampler2D normal_image;
layout(set = 0, binding = 5) uniform writeonly uimage2D kept_image;

const int threads = 256;
const int loaded_width = tile_width + 2 * border, loaded_height = tile_height + 2 * border;
const int loaded_count = loaded_width * loaded_height;
const int row_count = tile_width * loaded_height;
// Unpacked: every texel is looked at a dozen times. The planner sees to it that all fit into 16 KiB.
shared float planar_tile[loaded_count];
shared float value_tile[loaded_count];
shared float shadow_tile[has_shadow ? loaded_count : 1];
shared float value_rows[row_count];
shared float shadow_rows[has_shadow ? row_count : 1];

ivec2 result_size() { return ivec2(enlarges ? constants.size : constants.working_size); }

Signal load(ivec2 p) {
    if (!enlarges)
        return unpack_signal(texelFetch(signal_image, p, 0).xy);
    return upsampled(p, full_planar(p));
}

vec3 normal_at(ivec2 p) {
    const ivec2 pixel = half_resolution && !enlarges ? 2 * p : p;
    return decode_normal(texelFetch(normal_image, scaled(pixel, constants.normal_ratio), 0), normal_encoding);
}

float normal_weight(vec3 a, ivec2 p) {
    const vec3 b = normal_at(clamp(p, ivec2(0), result_size() - 1));
    return pow(clamp(dot(a, b) * inversesqrt(max(dot(a, a) * dot(b, b), 1e-12)), 0.0, 1.0), constants.filter_normal);
}

// 1 over the difference of planar depth that counts as an edge.
float per_difference(float w) {
    if (relative)
        return constants.filter_scale / w;
    // dz = dw / w² in perspective.
    return constants.filter_scale * (perspective ? 1.0 / (w * w) : 1.0);
}

// Visibility and shadow at `index` averaged along one axis: over rows of the tile, or over columns of averaged rows.
vec2 averaged(int index, ivec2 p, bool rows) {
    const int stride = rows ? 1 : loaded_width;
    const float centre = planar_tile[index];
    const float edge = per_difference(centre);
    float slope = 0.0;
    if (continue_slope)
        slope = continued_slope(planar_tile[index - stride], centre, planar_tile[index + stride]) * edge;
    vec3 normal = vec3(0);
    if (use_normals)
        normal = normal_at(p);
    const int row_index = (index / loaded_width) * tile_width + index % loaded_width - border;
    float total = 0.0, shadow = 0.0, weights = 0.0;
    for (int k = -filter_radius; k <= filter_radius; ++k) {
        const int offset = k * filter_step;
        const int at = index + offset * stride;
        const float difference = planar_tile[at] * edge - (centre * edge + slope * float(offset));
        // The same in all threads: computed once.
        const float bell = exp2(-constants.filter_gaussian * float(offset * offset));
        float weight = bilateral_weight(bell, difference, weight_kind);
        if (use_normals && k != 0)
            weight *= normal_weight(normal, p + (rows ? ivec2(offset, 0) : ivec2(0, offset)));
        const int row_at = row_index + offset * tile_width;
        total += weight * (rows ? value_tile[at] : value_rows[row_at]);
        if (has_shadow)
            shadow += weight * (rows ? shadow_tile[at] : shadow_rows[row_at]);
        weights += weight;
    }
    return vec2(total, shadow) / weights;
}

#include "ambient_occlusion_temporal.glsl"

void store(ivec2 p, Signal s) {
    if (wide && !enlarges)
        s.count = float(texelFetch(signal_image, p, 0).x & 31u);
    if (temporal)
        s = blended(p, s);
    if (keeps)
        imageStore(kept_image, p, uvec4(pack_signal(s), 0, 0));
    if (is_last)
        finish(p, s.w == 0.0 ? 1.0 : s.visibility, s.shadow);
}

void load_tile(ivec2 origin, int thread) {
    const ivec2 last = result_size() - 1;
    for (int y = thread / 32; y < loaded_height; y += threads / 32)
        for (int x = thread % 32; x < loaded_width; x += 32) {
            const ivec2 p = origin - border + ivec2(x, y);
            const bool inside = all(greaterThanEqual(p, ivec2(0))) && all(lessThanEqual(p, last));
            const Signal s = load(clamp(p, ivec2(0), last));
            const int at = y * loaded_width + x;
            planar_tile[at] = inside && s.w != 0.0 ? s.w : no_planar;
            value_tile[at] = s.visibility;
            if (has_shadow)
                shadow_tile[at] = s.shadow;
        }
}

void main() {
    const ivec2 origin = ivec2(gl_WorkGroupID.xy) * ivec2(tile_width, tile_height);
    const int thread = int(gl_LocalInvocationIndex);
    load_tile(origin, thread);
    barrier();
    const int x = thread % tile_width;
    const int rows_at_once = threads / tile_width;
    if (filter_radius > 0) {
        for (int y = thread / tile_width; y < loaded_height; y += rows_at_once) {
            const int index = y * loaded_width + x + border;
            const vec2 value = averaged(index, origin + ivec2(x, y - border), true);
            value_rows[y * tile_width + x] = value.x;
            if (has_shadow)
                shadow_rows[y * tile_width + x] = value.y;
        }
        barrier();
    }
    for (int y = thread / tile_width; y < tile_height; y += rows_at_once) {
        const ivec2 p = origin + ivec2(x, y);
        if (any(greaterThanEqual(p, result_size())))
            continue;
        const int index = (y + border) * loaded_width + x + border;
        const float w = planar_tile[index];
        Signal s = Signal(value_tile[index], w == no_planar ? 0.0 : w, 1.0, 0.0);
        if (has_shadow)
            s.shadow = shadow_tile[index];
        if (filter_radius > 0) {
            const vec2 value = averaged(index, p, false);
            if (w != no_planar)
                s.visibility = value.x;
            if (has_shadow)
                s.shadow = value.y;
        }
        store(p, s);
    }
}
