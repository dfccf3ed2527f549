// The temporal filter of SOMA's listing, with a bilinear fetch whose taps are tested one by one, a mean over the frames
// that a pixel has been seen in, and a test of the occluders' own history.

// Remembered visibility, shadow, planar depth and length at `at` (working pixels), of taps that lie near `expected`
// (view depth). Length -1: nothing was found.
Signal remembered(vec2 at, float expected) {
    const vec2 corner = at - 0.5;
    const ivec2 first = ivec2(floor(corner));
    const vec2 part = corner - vec2(first);
    Signal sum = Signal(0.0, 0.0, 0.0, 0.0);
    float weights = 0.0;
    for (int i = 0; i < 4; ++i) {
        const ivec2 step_to = ivec2(i & 1, i >> 1);
        const ivec2 q = first + step_to;
        if (any(lessThan(q, ivec2(0))) || any(greaterThanEqual(vec2(q), constants.working_size)))
            continue;
        const Signal s = unpack_signal(texelFetch(history, q, 0).xy);
        if (s.w == 0.0 || abs(depth_of_planar(s.w) - expected) * constants.history_position >= 1.0)
            continue;
        const vec2 factors = abs(vec2(1 - step_to) - part);
        const float weight = factors.x * factors.y;
        sum.visibility += weight * s.visibility;
        sum.shadow += weight * s.shadow;
        sum.w += weight * s.w;
        sum.count += weight * s.count;
        weights += weight;
    }
    if (weights < 1e-3)
        return Signal(0.0, 0.0, 0.0, -1.0);
    return Signal(sum.visibility / weights, sum.w / weights, sum.shadow / weights, sum.count / weights);
}

Signal blended(ivec2 p, Signal s) {
    const float danger = s.count;
    s.count = 0.0;
    if (s.w == 0.0)
        return s;
    const float per_working = half_resolution ? 2.0 : 1.0;
    const vec2 pixel = (vec2(p) + 0.5) * per_working;
    const vec3 here = view_position(pixel, depth_of_planar(s.w));
    vec3 before = (constants.previous_view_from_view * vec4(here, 1)).xyz;
    const vec4 clip = constants.previous_projection * vec4(before, 1);
    vec2 at = (clip.xy / clip.w * 0.5 + 0.5) * constants.size;
    bool valid = clip.w > 0.0;
    if (has_velocity) {
        const vec2 velocity =
            texelFetch(velocity_image, scaled(ivec2(pixel), constants.velocity_ratio), 0).xy / constants.velocity_ratio;
        if (is_finite(velocity)) {
            at = pixel - velocity;
            valid = true;
        }
    }
    Signal old = Signal(0.0, 0.0, 0.0, -1.0);
    if (valid && all(greaterThanEqual(at, vec2(0))) && all(lessThan(at, constants.size)))
        old = remembered(at / per_working, -before.z);
    float share = 1.0;
    if (old.count >= 0.0) {
        const float z = depth_of_planar(old.w);
        const vec2 xy = at * constants.previous_pixel_to_view.xy + constants.previous_pixel_to_view.zw;
        const vec3 there = vec3(perspective ? xy * z : xy, -z);
        if (has_velocity) // a thing that moved: only its depth is known
            before.xy = there.xy;
        share = share_of_present(distance(there, before), constants.history_position, abs(old.visibility - s.visibility),
                                 constants.history_visibility, constants.history_least);
        if (constants.history_length > 0.0) {
            share = max(share, 1.0 / (old.count + 2.0));
            s.count = min(old.count + 1.0, constants.history_length);
        }
        share = max(share, danger / 31.0);
        s.visibility = mix(old.visibility, s.visibility, share);
        s.shadow = mix(old.shadow, s.shadow, share);
    }
    if (shows_weight) // in the place of the shadow: the history of what is shown stays what it is
        s.shadow = share;
    return s;
}
