// From half to full resolution. A thread has the four pixels between four texels, which one gather brings.

layout(local_size_x = 16, local_size_y = 8) in;

layout(constant_id = 3) const bool device_depth = false;
layout(constant_id = 4) const uint upsample_kind = 3;
layout(constant_id = 5) const bool is_last = true; // finishes, or writes a signal of full resolution

layout(set = 0, binding = 0) uniform usampler2D signal_image;
layout(set = 0, binding = 1) uniform sampler2D depth_image;
layout(set = 0, binding = 2) uniform writeonly uimage2D kept_image;

// What one pixel sees of the four texels: `values` and `planars` from the upper left in rows; `factors` are bilinear.
vec4 texel_weights(vec4 planars, vec4 factors, float w) {
    if (upsample_kind == upsample_bilinear)
        return factors;
    vec4 differences;
    if (upsample_kind == upsample_soma) // of the radius
        differences = abs(1.0 / planars - 1.0 / w) * constants.upsample_scale;
    else
        differences = abs(planars - w) * (constants.upsample_scale / w);
    if (upsample_kind == upsample_soma && !perspective)
        differences = abs(planars - w) * constants.upsample_scale;
    vec4 weights = upsample_weights(factors, differences, upsample_kind);
    return mix(weights, vec4(0), equal(planars, vec4(0)));
}

// Where no texel is alike the nearest in depth stands for all: it takes the white from edges.
vec4 nearest_texel(vec4 planars, vec4 factors, float w) {
    const vec4 distances = upsample_kind == upsample_nearest ? -factors : abs(planars - w);
    const float least = min(min(distances.x, distances.y), min(distances.z, distances.w));
    return distances.x == least   ? vec4(1, 0, 0, 0)
           : distances.y == least ? vec4(0, 1, 0, 0)
           : distances.z == least ? vec4(0, 0, 1, 0)
                                  : vec4(0, 0, 0, 1);
}

void main() {
    const ivec2 texel = ivec2(gl_GlobalInvocationID.xy); // the lower right of the four
    if (any(greaterThan(vec2(texel), constants.working_size)))
        return;
    // Gathers begin at the lower left and go round.
    const vec2 corner = vec2(texel) / constants.working_size;
    const uvec4 x = textureGather(signal_image, corner, 0).wzxy;
    const uvec4 y = wide ? textureGather(signal_image, corner, 1).wzxy : uvec4(0);
    const vec4 depths = textureGather(depth_image, 2.0 * vec2(texel) / constants.size, 0).wzxy;
    vec4 values, planars, shadows;
    [[unroll]] for (int i = 0; i < 4; ++i) {
        const Signal s = unpack_signal(uvec2(x[i], y[i]));
        values[i] = s.visibility;
        planars[i] = s.w;
        shadows[i] = s.shadow;
    }
    [[unroll]] for (int i = 0; i < 4; ++i) {
        const ivec2 within = ivec2(i & 1, i >> 1);
        const ivec2 pixel = 2 * texel - 1 + within;
        if (any(lessThan(pixel, ivec2(0))) || any(greaterThanEqual(vec2(pixel), constants.size)))
            continue;
        const float w =
            planar(usable_depth(device_depth ? view_depth_of(depths[i], constants.projection) : depths[i]));
        const vec2 part = vec2(0.25) + 0.5 * vec2(within);
        const vec4 factors = vec4(1.0 - part.x, part.x, 1.0 - part.x, part.x) *
                             vec4(1.0 - part.y, 1.0 - part.y, part.y, part.y);
        vec4 weights = upsample_kind == upsample_nearest ? vec4(0) : texel_weights(planars, factors, w);
        float total = dot(weights, vec4(1));
        if (!(total > 0.01)) {
            weights = nearest_texel(planars, factors, w);
            total = 1.0;
        }
        const float inverse_total = 1.0 / total;
        const float visibility = w == 0.0 || in_guard_band(vec2(pixel) + 0.5) ? 1.0 : dot(weights, values) * inverse_total;
        const float shadow = dot(weights, shadows) * inverse_total;
        if (is_last)
            finish(pixel, visibility, shadow);
        else
            imageStore(kept_image, pixel, uvec4(pack_signal(Signal(visibility, w, shadow, 0.0)), 0, 0));
    }
}
