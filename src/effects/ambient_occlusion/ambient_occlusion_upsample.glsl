// From half to full resolution.

layout(constant_id = 23) const bool device_depth = false;
layout(constant_id = 24) const uint upsample_kind = 3;

layout(set = 0, binding = 0) uniform usampler2D signal_image;
layout(set = 0, binding = 1) uniform sampler2D depth_image;

float full_planar(ivec2 pixel) {
    const float value = texelFetch(depth_image, pixel, 0).x;
    return planar(usable_depth(device_depth ? view_depth_of(value, constants.projection) : value));
}

// The difference in units of the tolerated one: of depth, or of the radius (soma).
float depth_difference(float w, float centre) {
    if (upsample_kind == upsample_soma)
        return abs(depth_of_planar(w) - depth_of_planar(centre)) * constants.upsample_scale;
    return abs(w - centre) / max(w, centre) * constants.upsample_scale;
}

// The signal at a pixel of the full resolution whose planar depth is `w`.
Signal upsampled(ivec2 pixel, float w) {
    const vec2 at = (vec2(pixel) + 0.5) * 0.5 - 0.5; // in texels, their middles at whole numbers
    const ivec2 first = ivec2(floor(at));
    const vec2 part = at - vec2(first);
    const ivec2 last = ivec2(constants.working_size) - 1;
    Signal best = Signal(1.0, w, 1.0, 0.0);
    vec2 total = vec2(0);
    float weights = 0.0, least = 3e38;
    for (int i = 0; i < 4; ++i) {
        const ivec2 step_to = ivec2(i & 1, i >> 1);
        const Signal s = unpack_signal(texelFetch(signal_image, clamp(first + step_to, ivec2(0), last), 0).xy);
        const vec2 factors = abs(vec2(1 - step_to) - part);
        const bool alike = (s.w == 0.0) == (w == 0.0);
        const float difference = w == 0.0 ? 0.0 : depth_difference(max(s.w, 1e-30), w);
        const float weight = alike ? upsample_weight(factors.x * factors.y, difference, upsample_kind) : 0.0;
        total += weight * vec2(s.visibility, s.shadow);
        weights += weight;
        // Where no tap is alike the nearest in depth stands for all: it takes the white from edges.
        const float distance_to = upsample_kind == upsample_nearest ? -factors.x * factors.y
                                  : alike                           ? difference
                                                                    : 1e30;
        if (distance_to < least) {
            least = distance_to;
            best.visibility = s.visibility;
            best.shadow = s.shadow;
        }
    }
    if (upsample_kind != upsample_nearest && weights > 0.01) {
        best.visibility = total.x / weights;
        best.shadow = total.y / weights;
    }
    if (w == 0.0 || in_guard_band(vec2(pixel) + 0.5))
        best.visibility = 1.0;
    return best;
}
