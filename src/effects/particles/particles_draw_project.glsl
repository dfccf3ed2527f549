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
    const float reach = max(disc.radius, 1.0);
    disc.in_view = is_finite(disc.middle) && is_finite(disc.radius) && all(greaterThan(disc.middle, vec2(-reach))) &&
                   all(lessThan(disc.middle, constants.working_size + reach));
    return disc;
}

float sort_depth(vec3 position) { return dot(constants.sort_axis.xyz, position) + constants.sort_axis.w; }
