// Horizons: lines across the screen through the pixel ("slices", each a plane through the eye), marched both ways.
//
// hbao: Bavoil, Sainz, Dimitrov 2008. Elevation angles; each tap that raises the horizon adds (sin h - sin t) by its
// falloff.
// cosine: the cosine-weighted sky that the horizon hides (Jimenez et al., Practical Realtime Strategies for Accurate
// Indirect Occlusion, 2016).
// bitmask: the same sky in 32 sectors of equal weight, of which a tap hides those between its visible face and what lies
// `thickness` behind it (Therrien, Levesque, Gilbert, Screen Space Indirect Lighting with Visibility Bitmask, 2023).
//
// Angles θ in a slice count from the eye; γ is the normal's. What of the sky lies between 0 and θ is, for θ > 0,
//   S(θ) = ∫ cos(t - γ) |sin t| dt = (cos γ - cos(2θ - γ)) / 4 + θ sin γ / 2,
// and minus that for θ < 0. The visible sky runs from γ - π/2 to γ + π/2.

struct Slice {
    vec2 step_direction; // pixels
    vec3 across;         // unit, in the slice, at a right angle to the eye's direction
    float cos_normal, sin_normal;
    float low, high; // S at the ends of the sky
    float weight;    // length of the normal's projection
};

Slice make_slice(Centre c, float turn) {
    Slice s;
    s.step_direction = vec2(cos(turn * pi), sin(turn * pi));
    const vec3 along = vec3(s.step_direction * constants.pixel_to_view.xy, 0);
    s.across = normalize(along - c.v * dot(along, c.v));
    const vec2 in_slice = vec2(dot(c.n, s.across), dot(c.n, c.v));
    s.weight = length(in_slice);
    s.sin_normal = in_slice.x / s.weight;
    s.cos_normal = in_slice.y / s.weight;
    const float gamma = atan(s.sin_normal, s.cos_normal);
    const float shared_part = 0.5 * (s.cos_normal + gamma * s.sin_normal);
    s.high = shared_part + 0.25 * pi * s.sin_normal;
    s.low = -shared_part + 0.25 * pi * s.sin_normal;
    return s;
}

// 3e-4 radians at worst (Abramowitz and Stegun 4.4.45), for 0…1.
float arc_cosine(float x) {
    const float a = abs(x);
    const float b = sqrt(1.0 - min(a, 1.0)) * (1.5707288 + a * (-0.2121144 + a * (0.0742610 - 0.0187293 * a)));
    return x >= 0.0 ? b : pi - b;
}

// S at the direction (across, towards the eye), which lies to the side `way`; its ends where it is below the surface.
float sky_until(Slice s, vec2 direction, float way) {
    const float inverse_length = inversesqrt(max(dot(direction, direction), 1e-30));
    const float c = direction.y * inverse_length, d = direction.x * inverse_length;
    const float to_normal = c * s.cos_normal + d * s.sin_normal;
    if (to_normal <= 0.0)
        return way > 0.0 ? s.high : s.low;
    const float twice = (2.0 * c * c - 1.0) * s.cos_normal + 2.0 * c * d * s.sin_normal; // cos(2θ - γ)
    const float side = d >= 0.0 ? 1.0 : -1.0;
    return side * (0.25 * (s.cos_normal - twice) + 0.5 * side * arc_cosine(c) * s.sin_normal);
}

// Bits first … last - 1.
uint sectors(float first, float last) {
    const int from = int(clamp(first, 0.0, 32.0)), to = int(clamp(last, 0.0, 32.0));
    const int count = to - from;
    return count > 0 ? (0xffffffffu >> (32 - count)) << from : 0u;
}

// What one slice has found so far.
struct Found {
    uint hidden_sectors;
    vec2 horizon;  // S (cosine) or sine of the elevation (hbao), of both ways
    float hidden;  // weighted by falloff, in units of the slice's own sky (bitmask: sectors)
    vec3 hidden_direction;
    float danger;
};

void add_tap(Centre c, Slice s, vec3 d, float way, inout Found found) {
    const float squared = dot(d, d);
    const float inverse_length = inversesqrt(max(squared, 1e-30));
    const float t = squared * inverse_length / c.radius;
    const float elevation = dot(d, c.n) * inverse_length;
    if (t >= 1.0 || elevation <= constants.bias)
        return;
    const vec2 direction = vec2(dot(d, s.across), dot(d, c.v));
    float share = 0.0;
    if (kind == 1) {
        const float sine = direction.y * inversesqrt(max(dot(direction, direction), 1e-30));
        const float horizon = way > 0.0 ? found.horizon.x : found.horizon.y;
        share = max(sine - horizon, 0.0) * falloff(t);
        if (way > 0.0)
            found.horizon.x = max(horizon, sine);
        else
            found.horizon.y = max(horizon, sine);
        found.hidden += share;
    } else if (kind == 2) {
        const float sky = sky_until(s, direction, way);
        if (way > 0.0) {
            share = max(found.horizon.x - sky, 0.0) * falloff(t);
            found.horizon.x = min(found.horizon.x, sky);
        } else {
            share = max(sky - found.horizon.y, 0.0) * falloff(t);
            found.horizon.y = max(found.horizon.y, sky);
        }
        found.hidden += share;
    } else {
        const float front = sky_until(s, direction, way);
        const float back = endless ? (way > 0.0 ? s.high : s.low)
                                   : sky_until(s, direction - vec2(0, constants.thickness), way);
        const float scale = 32.0 / (s.high - s.low);
        const vec2 range = (vec2(min(front, back), max(front, back)) - s.low) * scale + 0.5;
        const uint fresh = sectors(range.x, range.y) & ~found.hidden_sectors;
        found.hidden_sectors |= fresh;
        share = float(bitCount(fresh)) * falloff(t);
        found.hidden += share;
    }
    if (want_bent_normal)
        found.hidden_direction += share * d * inverse_length;
    if (test_occluders && share > 0.0 && !was_there(c.p + d))
        found.danger += share;
}

// Marches one way. Returns whether any of it is on the screen.
bool march(Centre c, Slice s, float way, float radius_pixels, float offset, inout Found found) {
    bool any_seen = false;
    for (uint k = 0; k < steps; ++k) {
        float at = (float(k) + offset) / float(steps);
        if (!even_steps)
            at = pow(at, constants.step_power);
        const float away = max(at * radius_pixels, working_pixel);
        const vec2 pixel = c.pixel + way * away * s.step_direction;
        if (!on_screen(pixel))
            break;
        any_seen = true;
        add_tap(c, s, tap_position(pixel, away) - c.p, way, found);
    }
    return any_seen;
}

void add_horizons(Centre c, vec2 noise, inout Sum sum) {
    for (uint i = 0; i < slices; ++i) {
        const Slice s = make_slice(c, (float(i) + noise.x) / float(slices));
        // The radius in pixels along this line: pixels need not be square.
        const float pixel_length = length(s.step_direction * constants.pixel_to_view.xy);
        const float radius_pixels = c.radius / (pixel_length * (perspective ? -c.p.z : 1.0));
        Found found = Found(0u, vec2(s.high, s.low), 0.0, vec3(0), 0.0);
        if (kind == 1) // the tangent plane's elevation
            found.horizon = vec2(-s.sin_normal, s.sin_normal);
        const bool right = march(c, s, 1.0, radius_pixels, noise.y, found);
        const bool left = march(c, s, -1.0, radius_pixels, noise.y, found);
        // A way that leaves the screen at once tells nothing: the other one stands for both.
        float all = s.high - s.low;
        if (kind == 1)
            all = float(right) + float(left);
        else if (right != left)
            all = right ? s.high : -s.low;
        float unit = 1.0; // of `hidden`
        if (kind == 3)
            unit = (s.high - s.low) / 32.0;
        if (all <= 0.0)
            continue;
        const float weight = kind == 1 ? 1.0 : s.weight;
        sum.weight += weight * all;
        sum.visible += weight * max(all - constants.strength * found.hidden * unit, kind == 1 ? -1e3 : 0.0);
        sum.hidden += weight * unit * found.hidden_direction;
        sum.danger += weight * unit * found.danger;
    }
}
