// The `coverage` weighting: which surface is seen at the pixel for what share of the shutter?
//  1. Others in front: taps along n that lie nearer and whose own path passes over the pixel while the shutter is open.
//     Each stands for a stretch of the line that takes (spacing of taps) / (its speed) of the time to pass.
//  2. Of the rest of the time, the pixel's own surface: taps along its own path. A tap of like depth is the same
//     surface, so at that moment it still covers the pixel; a nearer tap hides what was there and says nothing.
//  3. Of what is left, the background: the taps behind, found along the same path.
// The shares sum to one.
vec4 gather_coverage(vec2 pixel, Tap here, vec2 n, float j) {
    Sum front = Sum(vec4(0), 0.0);
    float front_share = 0.0;
    const float reach = length(n);
    const int front_taps = tap_count(reach);
    for (int i = 0; i < front_taps; ++i) {
        const vec2 offset = -(constants.centre + tap_place(i, front_taps, j)) * n;
        const Tap tap = tap_at(tap_position(pixel, offset));
        if (tap.speed < still_length || tap.z >= here.z - soft(here.z, tap.z))
            continue;
        const float s = -dot(offset, tap.v) / (tap.speed * tap.speed); // when it is closest to the pixel
        const vec2 miss = offset + s * tap.v;
        const float covers = clamp((1.0 - abs(s - constants.centre)) * tap.speed + 0.5, 0.0, 1.0) *
                             clamp(1.5 - length(miss), 0.0, 1.0);
        const float share = covers * reach / (tap.speed * float(front_taps)) * shutter_weight(s - constants.centre);
        front_share += share;
        add(front, tap, here, share);
    }
    Sum own = Sum(vec4(0), 0.0);
    Sum back = Sum(vec4(0), 0.0);
    float own_share = 0.0;
    float back_share = 0.0;
    used_taps = float(front_taps);
    if (here.speed >= still_length) {
        const int own_taps = tap_count(here.speed);
        used_taps += float(own_taps);
        for (int i = 0; i < own_taps; ++i) {
            const float u = tap_place(i, own_taps, j);
            const Tap tap = tap_at(tap_position(pixel, -(constants.centre + u) * here.v));
            const float away = (tap.z - here.z) / soft(here.z, tap.z);
            const float open = shutter_weight(u);
            if (abs(away) <= 1.0) {
                own_share += open;
                add(own, tap, here, open);
            } else if (away > 1.0) {
                back_share += open;
                add(back, tap, here, open);
            }
        }
    }
    const float known = own_share + back_share;
    const float covered = min(front_share, 1.0);
    other_share = covered;
    vec4 result = here.colour;
    if (front.weight > 0.0)
        result += covered * front.difference / front.weight;
    if (own.weight > 0.0)
        result += (1.0 - covered) * own_share / known * own.difference / own.weight;
    if (back.weight > 0.0)
        result += (1.0 - covered) * back_share / known * back.difference / back.weight;
    return result;
}
