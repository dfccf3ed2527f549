// Obscurance: what lies in front of the surface near the pixel. Vicarious Visions (SIGGRAPH 2012 course), SAO (HPG
// 2012) and SOMA differ in falloff and in where taps lie.
//
// Taps lie on a spiral whose angle grows by the same step from tap to tap (`spiral`), or from pair to pair of opposite
// taps (`mirrored-spiral`, and SOMA's `growing-circle`: offsets 2, 3, 4, 5 … of half a step/(2 + 16), mirrored, its
// rotation matrix not given; 137.5° spreads the directions). So one rotation serves all.

layout(constant_id = 19) const bool in_pairs = false;
const uint at_once = taps % 4 == 0 || in_pairs ? 4 : 3;

float obscurance_of(Centre c, vec3 d) {
    const float squared = dot(d, d);
    const float inverse_length = inversesqrt(max(squared, 1e-30));
    const float elevation = dot(d, c.n) * inverse_length;
    const float t = squared * inverse_length * c.inverse_radius;
    if (falloff_kind == 1)
        return max(1.0 - t, 0.0) * max(elevation - constants.bias, 0.0);
    if (falloff_kind == 3) {
        // SAO: (r² - d²)³ max(v·n - bias, 0) / (d² + ε), lengths in radii.
        return falloff(t * t) * max(elevation * t - constants.bias, 0.0) / (t * t + 0.01);
    }
    return falloff(t * t) * max(elevation - constants.bias, 0.0);
}

void add_obscurance(Centre c, vec2 noise, inout Sum sum) {
    float total = 0.0, count = 0.0;
    vec3 hidden = vec3(0);
    float danger = 0.0;
    const float angle = constants.first_angle + 2.0 * pi * noise.x;
    const float radius = c.radius_pixels / working_pixel;
    const float spacing = radius * constants.tap_spacing;
    // A spiral's taps are jittered within their rings; the document's other patterns are as they are.
    const float first = radius * constants.first_tap + (pattern == 1 ? spacing * (noise.y - 0.5) : 0.0);
    vec2 direction = vec2(cos(angle), sin(angle));
    for (uint first_of_some = 0; first_of_some < taps; first_of_some += at_once) {
        Aim aims[at_once];
        float z[at_once];
        [[unroll]] for (uint j = 0; j < at_once; ++j) {
            const uint i = first_of_some + j;
            const uint number = pattern == 0 ? i / 2 : i;
            // Nearer than a pixel there is the pixel itself.
            const float away = max(first + spacing * float(number), 1.0);
            const vec2 offset = in_pairs && (j & 1) != 0 ? -direction : direction;
            if (!in_pairs || (j & 1) != 0)
                direction = vec2(direction.x * constants.turn.x - direction.y * constants.turn.y,
                                 direction.x * constants.turn.y + direction.y * constants.turn.x);
            const vec2 at = c.working + away * offset;
            const bool on_screen = all(greaterThanEqual(at, vec2(0))) && all(lessThan(at, screen()));
            aims[j] = aim(on_screen ? at : vec2(0), away);
            aims[j].on_screen = on_screen && (taps % at_once == 0 || i < taps);
        }
        [[unroll]] for (uint j = 0; j < at_once; ++j)
            z[j] = depth_at(aims[j].texel, aims[j].level);
        [[unroll]] for (uint j = 0; j < at_once; ++j) {
            const vec3 d = way_to(c, aims[j], z[j]);
            const float share = aims[j].on_screen ? obscurance_of(c, d) : 0.0;
            count += float(aims[j].on_screen);
            total += share;
            if (want_bent_normal)
                hidden += share * d * inversesqrt(max(dot(d, d), 1e-30));
            if (test_occluders && share > 0.0 && !was_there(c.p + d))
                danger += share;
        }
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
