// The `coverage` weighting: which surface is seen at the pixel for what share of the time that the shutter is open? The
// shares sum to one, so there is no centre weight and no renormalisation.
//  1. Surfaces that pass in front. A search along the dominant vector fetches no colour: it looks for nearer taps that
//     move unlike the pixel. Where there are none, which is nearly everywhere, that is all. Where those found move like
//     n, the taps of the search serve; where they do not (a rotating thing, a slower thing in a fast thing's tile), the
//     mean of their vectors takes the place of n and the line is walked again. A tap counts if its own path passes over
//     the pixel while the shutter is open, and stands for (spacing of taps) / (its speed) of the time.
//  2. In the rest of the time, the pixel's own surface. Taps run along its own path. A tap that moves like the pixel, or
//     lies at like depth, is carried over the pixel at that moment, so the surface is seen; a nearer one hides what was
//     there and says nothing; one behind shows that the surface has moved away.
//  3. When it has moved away, the background. Of the taps behind, the ones closest to the pixel weigh most.
//
// Paths bend where velocity changes over the surface. What is at X at time s came from Y with Y + s v(Y) = X; to second
// order Y = X - s v + s² a, where a is the change of v along v. Two taps measure it.

const float alike = 0.3;         // of the longer vector: closer vectors move together
const float steady = 0.1;        // of n: vectors this close to n need no second walk
const float curved_above = 2.0;  // pixels: shorter paths are taken as straight
const float across_least = 1.0;  // pixels that the second vector must reach to the side of n
const float clear_of_edge = 0.5; // pixels
const int least_hits = 2;        // one hit alone says too little of its surface's motion

struct Share {
    Sum sum;
    float share; // without the HDR weight
};

const Share no_share = Share(Sum(vec4(0), 0.0), 0.0);

void add(inout Share part, Tap tap, Tap here, float w) {
    add(part.sum, tap, here, w);
    part.share += w;
}

bool moves_alike(Tap a, Tap b) {
    const vec2 d = a.v - b.v;
    const float limit = alike * max(a.speed, b.speed);
    return dot(d, d) <= limit * limit;
}

bool passes_in_front(Tap tap, Tap here) {
    return tap.speed >= still_length && tap.z < here.z - soft(here.z, tap.z) && !moves_alike(tap, here);
}

struct Arrival {
    float u;    // place in the shutter at which the tap is closest to the pixel
    float miss; // how far it passes from it, pixels
    float over; // how much of it passes over the pixel, [0, 1]
};

Arrival arrival(Tap tap, vec2 offset) {
    const float s = -dot(offset, tap.v) / (tap.speed * tap.speed);
    Arrival a;
    a.u = s - constants.centre;
    a.miss = length(offset + s * tap.v);
    // Both edges are a pixel wide. The farther away, the less straight the way can be expected to be.
    a.over = clamp((1.0 - abs(a.u)) * tap.speed + 0.5, 0.0, 1.0) *
             clamp(1.5 + 0.3 * length(offset) - a.miss, 0.0, 1.0);
    return a;
}

// Share of the time for which a tap covers the pixel, where taps are `spacing` apart along the line.
float front_share(Tap tap, Arrival a, float spacing) {
    const float mean_weight = curve == 0 ? 1.0 : curve == 1 ? 0.5 : 8.0 / 15.0;
    return a.over * shutter_weight(clamp(a.u, -1.0, 1.0)) / mean_weight * spacing / (2.0 * tap.speed);
}

// `phase` is a second jitter, so that the search and the walks do not fall on the same places.
Share walk_front(vec2 pixel, Tap here, vec2 n, float j, float phase) {
    Share front = no_share;
    // Both ways along n, whatever the shutter position: there may be things that move against it.
    const float reach = 1.0 + abs(constants.centre);
    const float n_length = length(n);
    const int count = tap_count(n_length, search_taps);
    vec2 mean = vec2(0);
    float weight = 0.0;
    float deviation = 0.0;
    int hits = 0;
    for (int first = 0; first < count; first += 2) { // two under way at once
        Tap pair[2];
        [[unroll]] for (int k = 0; k < 2; ++k)
            if (first + k < count)
                pair[k] = surface_tap(pixel, -(reach * tap_place(first + k, count, phase)) * n);
        [[unroll]] for (int k = 0; k < 2; ++k) {
            if (first + k >= count || !passes_in_front(pair[k], here))
                continue;
            const Tap tap = pair[k];
            const vec2 offset = -(reach * tap_place(first + k, count, phase)) * n;
            const Arrival a = arrival(tap, offset);
            // Taps whose paths come close to the pixel tell most of what passes over it. The line has no sign.
            const float w = clamp(3.0 * (1.2 - abs(a.u)), 0.0, 1.0) *
                                clamp(2.0 - a.miss / (1.0 + 0.5 * length(offset)), 0.0, 1.0) +
                            1e-6;
            const vec2 v = dot(tap.v, n) < 0.0 ? -tap.v : tap.v;
            mean += w * v;
            weight += w;
            deviation = max(deviation, distance(v, n));
            ++hits;
        }
    }
    used_taps += float(count);
    if (hits == 0)
        return front;
    mean /= weight;
    const bool again = hits >= least_hits && deviation > steady * n_length && length(mean) >= still_length;
    const vec2 line = again ? mean : n;
    const int walk_count = again ? tap_count(length(line), taps) : count;
    const float spacing = 2.0 * reach * length(line) / float(walk_count);
    for (int i = 0; i < walk_count; ++i) {
        const vec2 offset = -(reach * tap_place(i, walk_count, again ? j : phase)) * line;
        Tap tap = surface_tap(pixel, offset);
        if (!passes_in_front(tap, here))
            continue;
        const float share = front_share(tap, arrival(tap, offset), spacing);
        if (share <= 0.0)
            continue;
        fetch_colour(tap, pixel, offset);
        add(front, tap, here, share);
    }
    used_taps += float(walk_count);
    return front;
}

// The change of velocity along the pixel's own path, from the surface half way along it on both sides.
vec2 bend(vec2 pixel, Tap here) {
    vec2 sum = vec2(0);
    float count = 0.0;
    for (int side = 0; side < 2; ++side) {
        const float s = constants.centre + (side == 0 ? -0.5 : 0.5);
        const Tap tap = surface_tap(pixel, -s * here.v);
        if (distance(tap.v, here.v) > 0.5 * here.speed)
            continue; // another surface
        sum += (here.v - tap.v) / s;
        count += 1.0;
    }
    return count > 0.0 ? sum / count : vec2(0);
}

void mix_in(inout vec4 difference, inout float total, Share part, float share) {
    if (part.share <= 0.0 || share <= 0.0)
        return;
    const float scale = share / part.share;
    total += scale * part.sum.weight;
    difference += scale * part.sum.difference;
}

vec4 gather_coverage(vec2 pixel, Tap here, vec2 n, vec2 second, float j, float phase) {
    Share front = no_share, own = no_share, back = no_share;
    float own_time = 0.0, back_time = 0.0;
    const float n_length = length(n);
    // Where nothing in reach is faster than the pixel or moves otherwise, its own path meets whatever there is.
    const bool search = distance(n, here.v) > steady * n_length && n_length >= still_length;
    if (search)
        front = walk_front(pixel, here, n, j, phase);
    // Something that passes across the dominant vector is met by none of its taps.
    const bool search_second = second_direction && front.share <= 0.0 &&
                               abs(cross_product(second, n)) > across_least * n_length &&
                               distance(second, here.v) > steady * length(second);
    if (search_second)
        front = walk_front(pixel, here, second, j, phase);
    if (here.speed >= still_length) {
        const int count = tap_count(here.speed, taps);
        const vec2 a = here.speed > curved_above ? bend(pixel, here) : vec2(0);
        used_taps += float(count);
        for (int i = 0; i < count; ++i) {
            const float u = tap_place(i, count, j);
            const float s = constants.centre + u;
            const vec2 offset = -s * here.v + s * s * a;
            if (!is_inside(pixel, offset))
                continue; // unknown, as if hidden
            Tap tap = tap_at(pixel, offset); // most need the colour: both are under way at once
            const float open = shutter_weight(u);
            const float away = (tap.z - here.z) / soft(here.z, tap.z);
            if (moves_alike(tap, here) || abs(away) <= 1.0) {
                own_time += open;
                add(own, tap, here, open);
            } else if (away > 1.0) {
                // The pixels next to a silhouette hold some of both colours; take it from a little farther out.
                const float d = length(offset);
                fetch_colour(tap, pixel, (1.0 + clear_of_edge / max(d, 0.5)) * offset);
                const float near = max(d * d, 0.25);
                back_time += open;
                add(back, tap, here, open / (near * near));
            } else if (!search && !search_second && passes_in_front(tap, here)) {
                const float spacing = 2.0 * here.speed / float(count);
                add(front, tap, here, front_share(tap, arrival(tap, offset), spacing));
            }
        }
    }
    const float covered = min(front.share, 1.0);
    const float known = own_time + back_time;
    const float left = 1.0 - covered;
    other_share = covered;
    vec4 difference = vec4(0);
    float total = 0.0;
    mix_in(difference, total, front, covered);
    if (known > 0.0) {
        mix_in(difference, total, own, left * own_time / known);
        mix_in(difference, total, back, left * back_time / known);
    } else {
        total += left * here.hdr; // still, or hidden at every other moment: the pixel's own colour
    }
    return total > 0.0 ? here.colour + difference / total : here.colour;
}
