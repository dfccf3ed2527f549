// Where a particle lies in the picture that is drawn.

struct Disc {
    vec2 middle; // working pixels
    float radius;
    float depth; // of view
    bool in_view;
};

bool is_perspective() { return constants.projection[2][3] != 0.0; }

Disc project(vec3 position, float radius) {
    const vec3 view = (constants.view_from_world * vec4(position, 1)).xyz;
    const vec4 clip = constants.projection * vec4(view, 1);
    Disc disc;
    disc.depth = -view.z;
    disc.in_view = false;
    disc.middle = vec2(0);
    disc.radius = 0.0;
    // The whole of a particle fades before its middle comes to the eye: what is behind it is never projected.
    if (disc.depth <= constants.near_start || clip.w <= 0.0)
        return disc;
    disc.middle = (clip.xy / clip.w * 0.5 + 0.5) * constants.size * constants.scale;
    disc.radius = radius * constants.pixels / (is_perspective() ? disc.depth : 1.0);
    // A particle that stands for others is larger by up to the root of two.
    const float reach = max(disc.radius * (constants.simplification > 0.0 ? 1.4143 : 1.0), 1.0);
    disc.in_view = is_finite(disc.middle) && is_finite(disc.radius) && all(greaterThan(disc.middle, vec2(-reach))) &&
                   all(lessThan(disc.middle, constants.working_size + reach));
    return disc;
}

float sort_depth(vec3 position) { return dot(constants.sort_axis.xyz, position) + constants.sort_axis.w; }

// At half and quarter resolution what is small and thin is drawn by some of its number, which are larger and denser
// (Cook, Halstead, Planck, Ryu, Stochastic Simplification of Aggregate Detail, SIGGRAPH 2007): the mean optical depth
// stays. All are drawn of particles of that radius, in working pixels, and of those so dense that each can be seen.
const float full_detail_radius = 8.0;
const float full_detail_depth = 0.25;

// What a particle's optical depth and radius are multiplied by; nothing of it is left where others stand for it. The
// same ones stay as the camera moves, and they come and go by degrees.
struct StandIn {
    float depth;
    float radius;
};

StandIn stand_in(uint index, float radius, float optical_depth) {
    const float size = radius / full_detail_radius;
    if (constants.simplification <= 0.0 || size >= 1.0 || optical_depth >= full_detail_depth)
        return StandIn(1.0, 1.0);
    // Where particles of optical depth t overlap, to draw a share s of them adds t (1/s - 1) of their sum to its variance.
    const float variance = constants.simplification * (1.0 - optical_depth / full_detail_depth);
    const float share = max(max(size * size, optical_depth / (optical_depth + variance)), 1.0 / 16.0);
    if (share >= 1.0)
        return StandIn(1.0, 1.0);
    const float ramp = max(0.5 * share * (1.0 - share), 1e-6);
    const float place = float((index * 2654435769u) >> 8) * (1.0 / 16777216.0); // evenly spread among neighbours
    // Density makes up for most of what is missing, area for the rest: fewer pixels than before, yet no coarse grain.
    const float area = inversesqrt(sqrt(share));
    return StandIn(clamp((share - place) / ramp, 0.0, 1.0) / ((share - 0.5 * ramp) * area), sqrt(area));
}
