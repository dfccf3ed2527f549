// Horizons: lines across the screen through the pixel ("slices", each a plane through the eye), marched both ways.
//
// hbao: Bavoil, Sainz, Dimitrov 2008. Elevation angles; each tap that raises the horizon adds (sin h - sin t) by its
// falloff.
// cosine: the cosine-weighted sky that the horizon hides (Jimenez et al., Practical Realtime Strategies for Accurate
// Indirect Occlusion, 2016).
// bitmask: the same sky in 32 sectors of equal weight, of which a tap hides those between its visible face and what lies
// `thickness` behind it (Therrien, Levesque, Gilbert, Screen Space Indirect Lighting with Visibility Bitmask, 2023).
//
// Angles θ in a slice count from the eye to one side; γ is the normal's. What of the sky lies between 0 and θ is
//   S(θ) = ∫ cos(t - γ) sin t dt = (cos γ - cos θ cos(θ - γ) + θ sin γ) / 2,
// up to θ = γ + π/2. The other side is the same with -γ.

struct Side {
    float way;        // 1 or -1 along the slice
    float sin_normal; // of γ, counted towards this side
    float sky;        // S at its end
    float room;       // texels from the pixel to the edge of the screen
};

struct Slice {
    vec2 step_direction; // texels
    vec3 across;         // unit, in the slice, at a right angle to the eye's direction
    float cos_normal;
    Side right, left;
    float weight; // length of the normal's projection
};

// 3e-4 radians at worst (Abramowitz and Stegun 4.4.45).
float arc_cosine(float x) {
    const float a = min(abs(x), 1.0);
    const float b = sqrt(1.0 - a) * (1.5707288 + a * (-0.2121144 + a * (0.0742610 - 0.0187293 * a)));
    return x >= 0.0 ? b : pi - b;
}

// How far the screen reaches from `at` in a direction, a hair less, so that no rounding leads off it.
float room(vec2 at, vec2 direction) {
    const vec2 way = mix(at, screen() - at, greaterThan(direction, vec2(0)));
    const vec2 steps_to_edge = way / max(abs(direction), vec2(1e-6));
    return min(steps_to_edge.x, steps_to_edge.y) * 0.9999 - 1e-3;
}

Slice make_slice(Centre c, float turn) {
    Slice s;
    s.step_direction = vec2(cos(turn * pi), sin(turn * pi));
    const vec3 along = vec3(s.step_direction * constants.pixel_to_view.xy, 0);
    const vec3 in_plane = along - c.v * dot(along, c.v);
    s.across = in_plane * inversesqrt(dot(in_plane, in_plane));
    const vec2 in_slice = vec2(dot(c.n, s.across), dot(c.n, c.v));
    const float inverse_weight = inversesqrt(max(dot(in_slice, in_slice), 1e-12));
    s.weight = dot(in_slice, in_slice) * inverse_weight;
    const float sin_normal = in_slice.x * inverse_weight;
    s.cos_normal = in_slice.y * inverse_weight;
    const float both = 0.5 * (s.cos_normal + arc_cosine(s.cos_normal) * abs(sin_normal)), lean = 0.25 * pi * sin_normal;
    s.right = Side(1.0, sin_normal, both + lean, room(c.working, s.step_direction));
    s.left = Side(-1.0, -sin_normal, both - lean, room(c.working, -s.step_direction));
    return s;
}

// S in the direction (away from the eye's line, towards the eye); all of the side where it is below the surface.
float sky_until(Slice s, Side side, vec2 direction) {
    const float inverse_length = inversesqrt(max(dot(direction, direction), 1e-30));
    const float c = direction.y * inverse_length;
    const float to_normal = c * s.cos_normal + direction.x * inverse_length * side.sin_normal;
    const float sky = 0.5 * (s.cos_normal - c * to_normal + arc_cosine(c) * side.sin_normal);
    return to_normal > 0.0 ? sky : side.sky;
}

// What one slice has found so far.
struct Found {
    uint hidden_sectors;
    vec2 hidden; // right and left, weighted by falloff, in units of S (bitmask: of sectors)
    vec3 hidden_direction;
    float danger;
};

void add_hidden(Side side, float share, inout Found found) {
    if (side.way > 0.0)
        found.hidden.x += share;
    else
        found.hidden.y += share;
}

void add_tap(Centre c, Slice s, Side side, vec3 d, inout float horizon, inout Found found) {
    const float squared = dot(d, d);
    const float rise = dot(d, c.n);
    // Beyond the radius, or lower than the bias.
    if (!(squared < c.radius * c.radius && rise > 0.0 && rise * rise > constants.bias * constants.bias * squared))
        return;
    const vec2 direction = vec2(side.way * dot(d, s.across), dot(d, c.v));
    const float weight = falloff_kind == 0 ? 1.0 : falloff(squared * c.inverse_radius * c.inverse_radius);
    float share = 0.0;
    if (kind == 1) {
        const float sine = direction.y * inversesqrt(max(dot(direction, direction), 1e-30));
        share = max(sine - horizon, 0.0) * weight;
        horizon = max(horizon, sine);
        add_hidden(side, share, found);
    } else if (kind == 2) {
        const float sky = sky_until(s, side, direction);
        share = max(horizon - sky, 0.0) * weight;
        horizon = min(horizon, sky);
        add_hidden(side, share, found);
    } else {
        // Sectors count across the slice from the left end to the right one.
        const float scale = 32.0 / (s.left.sky + s.right.sky);
        const float front = sky_until(s, side, direction) * side.way;
        const float back = (endless ? side.sky : sky_until(s, side, direction - vec2(0, constants.thickness))) * side.way;
        const vec2 range = (side.way > 0.0 ? vec2(front, back) : vec2(back, front)) + s.left.sky;
        const uvec2 bits = uvec2(clamp(range * scale + 0.5, 0.0, 32.0));
        const uint sectors = bits.y > bits.x ? bitfieldInsert(0u, ~0u, int(bits.x), int(bits.y - bits.x)) : 0u;
        if (falloff_kind != 0 || want_bent_normal || test_occluders) {
            share = float(bitCount(sectors & ~found.hidden_sectors)) * weight;
            add_hidden(side, share, found);
        }
        found.hidden_sectors |= sectors;
    }
    if (want_bent_normal)
        found.hidden_direction += share * d * inversesqrt(max(squared, 1e-30));
    if (test_occluders && share > 0.0 && !was_there(c.p + d))
        found.danger += share;
}

// Texels from the pixel to a step of the march, counted with its offset.
float step_away(float number, float radius) {
    const float share = number / float(steps);
    return max((even_steps ? share : pow(share, constants.step_power)) * radius, 1.0);
}

// Marches both sides, two steps at a time.
void march(Centre c, Slice s, float radius, float offset, inout Found found) {
    // Of the tangent plane.
    vec2 horizon = kind == 1 ? vec2(-s.right.sin_normal, -s.left.sin_normal) : vec2(s.right.sky, s.left.sky);
    for (uint k = 0; k < steps; k += 2) {
        Aim aims[4];
        float z[4];
        [[unroll]] for (uint j = 0; j < 4; ++j) {
            const float away = step_away(float(k + j / 2) + offset, radius);
            // What lies off the screen is fetched at its edge and not looked at.
            const float limit = (j & 1) == 0 ? s.right.room : s.left.room;
            const float inside = min(away, limit);
            aims[j] = aim(c.working + ((j & 1) == 0 ? inside : -inside) * s.step_direction, away);
            aims[j].on_screen = away <= limit && (steps % 2 == 0 || k + j / 2 < steps);
        }
        [[unroll]] for (uint j = 0; j < 4; ++j)
            z[j] = depth_at(aims[j].texel, aims[j].level);
        [[unroll]] for (uint j = 0; j < 4; ++j) {
            if (!aims[j].on_screen)
                continue;
            const vec3 d = way_to(c, aims[j], z[j]);
            if ((j & 1) == 0)
                add_tap(c, s, s.right, d, horizon.x, found);
            else
                add_tap(c, s, s.left, d, horizon.y, found);
        }
    }
}

// How much a side counts that the edge of the screen cuts off. What lies beyond is left out, and the other side stands
// for it. Near steps tell the most: a side that is seen for half its length counts for seven eighths. Not so in HBAO's
// measure, whose every tap hides too much for the other side to stand in: there it makes the error larger.
float seen_share(Side side, float radius, float offset) {
    const float unseen = 1.0 - min(side.room / max(radius, 1.0), 1.0);
    return side.room < step_away(offset, radius) ? 0.0 : kind == 1 ? 1.0 : 1.0 - unseen * unseen * unseen;
}

void add_horizons(Centre c, vec2 noise, inout Sum sum) {
    for (uint i = 0; i < slices; ++i) {
        const Slice s = make_slice(c, (float(i) + noise.x) / float(slices));
        // The radius in texels along this line: pixels need not be square.
        const vec2 along = s.step_direction * constants.pixel_to_view.xy * working_pixel;
        const float radius = c.radius * inversesqrt(dot(along, along)) * c.inverse_depth;
        Found found = Found(0u, vec2(0), vec3(0), 0.0);
        march(c, s, radius, noise.y, found);
        const float whole_sky = s.right.sky + s.left.sky;
        const float unit = kind == 3 ? whole_sky / 32.0 : 1.0; // of `hidden`
        if (kind == 3 && falloff_kind == 0) {
            const int of_left = int(s.left.sky * 32.0 / max(whole_sky, 1e-12) + 0.5);
            const uint left = of_left >= 32 ? ~0u : (1u << of_left) - 1u;
            found.hidden = vec2(bitCount(found.hidden_sectors & ~left), bitCount(found.hidden_sectors & left));
        }
        const vec2 seen = vec2(seen_share(s.right, radius, noise.y), seen_share(s.left, radius, noise.y));
        const vec2 sky = kind == 1 ? vec2(1) : vec2(s.right.sky, s.left.sky);
        const float weight = kind == 1 ? 1.0 : s.weight;
        sum.weight += weight * dot(sky, seen);
        sum.visible += weight * dot(sky - constants.strength * unit * found.hidden, seen);
        sum.hidden += weight * unit * found.hidden_direction;
        sum.danger += weight * unit * found.danger;
    }
}
