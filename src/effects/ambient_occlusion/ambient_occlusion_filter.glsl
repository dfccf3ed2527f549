// The cross-bilateral filter, both axes in one dispatch: a workgroup loads its tile with a border, filters rows, then
// columns. The temporal filter works on what comes out, and the last filter hands the result to the host.

layout(local_size_x = 16, local_size_y = 16) in;

layout(constant_id = 3) const int filter_radius = 4;
layout(constant_id = 4) const int filter_step = 1;
layout(constant_id = 5) const uint weight_kind = 0;
layout(constant_id = 6) const bool relative = true;
layout(constant_id = 7) const bool continue_slope = true;
layout(constant_id = 8) const bool use_normals = false;
layout(constant_id = 9) const int normal_encoding = 1;
layout(constant_id = 10) const bool temporal = false;
layout(constant_id = 11) const bool has_velocity = false;
layout(constant_id = 12) const bool is_last = false;    // finishes, at full resolution
layout(constant_id = 13) const bool keeps = true;       // writes the signal
layout(constant_id = 14) const bool enlarges = false;   // reads half resolution
layout(constant_id = 15) const bool shows_weight = false;
layout(constant_id = 16) const int tile_side = 32;
layout(constant_id = 17) const int border = 4; // radius times step, at least 1

layout(set = 0, binding = 2) uniform usampler2D history;
layout(set = 0, binding = 3) uniform sampler2D velocity_image;
layout(set = 0, binding = 4) uniform sampler2D normal_image;
layout(set = 0, binding = 5) uniform writeonly uimage2D kept_image;

const int loaded_side = tile_side + 2 * border;
shared uvec2 loaded[wide ? loaded_side * loaded_side : 1];
shared uint loaded_narrow[wide ? 1 : loaded_side * loaded_side];
shared uint row_values[tile_side * loaded_side];

ivec2 result_size() { return ivec2(enlarges ? constants.size : constants.working_size); }

uvec2 load(ivec2 p) {
    if (!enlarges)
        return texelFetch(signal_image, p, 0).xy;
    return pack_signal(upsampled(p, full_planar(p)));
}

Signal loaded_at(int index) {
    return unpack_signal(wide ? loaded[index] : uvec2(loaded_narrow[index], 0));
}

vec3 normal_at(ivec2 p) {
    const ivec2 pixel = half_resolution && !enlarges ? 2 * p : p;
    return decode_normal(texelFetch(normal_image, scaled(pixel, constants.normal_ratio), 0), normal_encoding);
}

float normal_weight(vec3 a, ivec2 p) {
    const vec3 b = normal_at(p);
    return pow(clamp(dot(a, b) * inversesqrt(max(dot(a, a) * dot(b, b), 1e-12)), 0.0, 1.0), constants.filter_normal);
}

// 1 over the difference of planar depth that counts as an edge.
float per_difference(float w) {
    if (relative)
        return constants.filter_scale / w;
    // dz = dw / w² in perspective.
    return constants.filter_scale * (perspective ? 1.0 / (w * w) : 1.0);
}

// The value (visibility, shadow) at `index`, averaged along the axis whose neighbours are `stride` apart.
vec2 averaged(int index, int stride, ivec2 p, ivec2 axis, bool rows) {
    const Signal centre = loaded_at(index);
    const float edge = centre.w == 0.0 ? 0.0 : per_difference(centre.w);
    float slope = 0.0;
    if (continue_slope)
        slope = continued_slope(loaded_at(index - stride).w, centre.w, loaded_at(index + stride).w);
    vec3 normal = vec3(0);
    if (use_normals)
        normal = normal_at(p);
    vec2 total = vec2(0);
    float weights = 0.0;
    const ivec2 last = result_size() - 1;
    for (int k = -filter_radius; k <= filter_radius; ++k) {
        const int offset = k * filter_step;
        const ivec2 q = p + offset * axis;
        if (any(lessThan(q, ivec2(0))) || any(greaterThan(q, last)))
            continue;
        const int at = index + offset * stride;
        const Signal s = loaded_at(at);
        float weight = bilateral_weight(float(offset), s.w, centre.w, slope, edge, constants.filter_gaussian, weight_kind);
        if (use_normals && k != 0)
            weight *= normal_weight(normal, q);
        vec2 value = vec2(s.visibility, s.shadow);
        if (!rows) // rows are done: their averages
            value = unpackHalf2x16(row_values[at / loaded_side * tile_side + at % loaded_side - border]);
        total += weight * value;
        weights += weight;
    }
    return total / weights;
}

#include "ambient_occlusion_temporal.glsl"

void store(ivec2 p, Signal s) {
    if (temporal)
        s = blended(p, s);
    if (keeps)
        imageStore(kept_image, p, uvec4(pack_signal(s), 0, 0));
    if (is_last)
        finish(p, s.w == 0.0 ? 1.0 : s.visibility, s.shadow);
}

void main() {
    const ivec2 origin = ivec2(gl_WorkGroupID.xy) * tile_side;
    const ivec2 last = result_size() - 1;
    const int thread = int(gl_LocalInvocationIndex);
    for (int i = thread; i < loaded_side * loaded_side; i += 256) {
        const ivec2 p = origin - border + ivec2(i % loaded_side, i / loaded_side);
        const uvec2 code = load(clamp(p, ivec2(0), last));
        if (wide)
            loaded[i] = code;
        else
            loaded_narrow[i] = code.x;
    }
    barrier();
    if (filter_radius > 0) {
        for (int i = thread; i < tile_side * loaded_side; i += 256) {
            const ivec2 local = ivec2(i % tile_side + border, i / tile_side);
            const ivec2 p = origin - border + local;
            vec2 value = vec2(1);
            if (p.y >= 0 && p.y <= last.y && p.x <= last.x)
                value = averaged(local.y * loaded_side + local.x, 1, p, ivec2(1, 0), true);
            row_values[i] = packHalf2x16(value);
        }
        barrier();
    }
    for (int i = thread; i < tile_side * tile_side; i += 256) {
        const ivec2 local = ivec2(i % tile_side, i / tile_side) + border;
        const ivec2 p = origin - border + local;
        if (any(greaterThan(p, last)))
            continue;
        const int index = local.y * loaded_side + local.x;
        Signal s = loaded_at(index);
        if (filter_radius > 0) {
            const vec2 value = averaged(index, loaded_side, p, ivec2(0, 1), false);
            s.visibility = value.x;
            s.shadow = value.y;
        }
        store(p, s);
    }
}
