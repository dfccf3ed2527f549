// Obscurance: what lies in front of the surface near the pixel. Vicarious Visions (SIGGRAPH 2012 course), SAO (HPG
// 2012) and SOMA differ in falloff and in where taps lie.

layout(constant_id = 19) const uint spiral_turns = 2;

// Distance (share of the radius) and direction of tap i.
vec2 tap_offset(uint i, float turn) {
    if (pattern == 2) {
        // SOMA: four at a time, offsets 2, 3, 4, 5 … of half a step/(2 + 16), every second one mirrored, and a rotation
        // after every pair. Its matrix is not given; 137.5° spreads the directions.
        const float at = float(i + 2) / float(taps + 2);
        const float angle = 2.0 * pi * turn + float(i / 2) * 2.39996323 + float(i & 1) * pi;
        return at * vec2(cos(angle), sin(angle));
    }
    const uint count = pattern == 0 ? (taps + 1) / 2 : taps;
    const uint number = pattern == 0 ? i / 2 : i;
    const float at = (float(number) + 0.5) / float(count);
    const float angle = 2.0 * pi * (float(spiral_turns) * at + turn) + (pattern == 0 ? float(i & 1) * pi : 0.0);
    return at * vec2(cos(angle), sin(angle));
}

float obscurance_of(Centre c, vec3 d) {
    const float squared = dot(d, d);
    const float inverse_length = inversesqrt(max(squared, 1e-30));
    const float t = squared * inverse_length / c.radius;
    const float elevation = dot(d, c.n) * inverse_length;
    if (falloff_kind == 3) {
        // SAO: (r² - d²)³ max(v·n - bias, 0) / (d² + ε), lengths in radii.
        return falloff(t) * max(elevation * t - constants.bias, 0.0) / (t * t + 0.01);
    }
    return falloff(t) * max(elevation - constants.bias, 0.0);
}

void add_obscurance(Centre c, vec2 noise, inout Sum sum) {
    float total = 0.0, count = 0.0;
    vec3 hidden = vec3(0);
    float danger = 0.0;
    const float shift = pattern == 1 ? noise.y - 0.5 : 0.0;
    for (uint i = 0; i < taps; ++i) {
        vec2 offset = tap_offset(i, noise.x);
        if (pattern == 1)
            offset *= (float(i) + 0.5 + shift) / (float(i) + 0.5); // jitters the distance within its ring
        offset *= c.radius_pixels;
        // Nearer than a pixel there is the pixel itself.
        const float away = length(offset);
        if (away < working_pixel)
            offset *= working_pixel / max(away, 1e-6);
        const vec2 at = c.pixel + offset;
        if (!on_screen(at))
            continue;
        count += 1.0;
        const vec3 d = tap_position(at, max(away, working_pixel)) - c.p;
        if (is_pyramid_sky(-d.z))
            continue;
        const float share = obscurance_of(c, d);
        total += share;
        if (want_bent_normal)
            hidden += share * d * inversesqrt(max(dot(d, d), 1e-30));
        if (test_occluders && share > 0.0 && !was_there(c.p + d))
            danger += share;
    }
    if (count == 0.0)
        return;
    float occlusion = constants.strength * total / count;
    if (normalisation == 1)
        occlusion *= occlusion;
    sum.visible += 1.0 - occlusion;
    sum.weight += 1.0;
    sum.hidden += hidden * constants.strength / count;
    sum.danger += danger * constants.strength / count;
}
