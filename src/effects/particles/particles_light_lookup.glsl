// Optical depth between a light and a place, read from the light's summed layers.

float layer_texel(uint start, ivec2 texel) {
    const ivec2 at = clamp(texel, ivec2(0), ivec2(constants.side) - 1);
    return float(volume.data[start + uint(at.y) * constants.side + uint(at.x)]);
}

// `texel` in texels; layer -1 is in front of everything. 0 outside the buffer: its rim is empty.
float summed_layer(uint light, int layer, vec2 texel) {
    if (layer < 0)
        return 0.0;
    const uint start = (light * constants.layers + uint(layer)) * constants.side * constants.side;
    const vec2 corner = clamp(texel, vec2(-1), vec2(float(constants.side) + 1.0)) - 0.5;
    const ivec2 first = ivec2(floor(corner));
    const vec2 part = corner - vec2(first);
    const float upper = mix(layer_texel(start, first), layer_texel(start, first + ivec2(1, 0)), part.x);
    const float lower = mix(layer_texel(start, first + ivec2(0, 1)), layer_texel(start, first + ivec2(1, 1)), part.x);
    return mix(upper, lower, part.y) * uintBitsToFloat(facts.data[fact_unit]);
}

// Slices: everything in the layers before this one, as the document's alternation of picture and shadow buffer has it.
float depth_before_layer(uint light, vec2 texel, uint layer) { return summed_layer(light, int(layer) - 1, texel); }

// Slope of a curve that never falls, where it rises by `before` up to a point and by `after` from it on (the harmonic
// mean of Fritsch and Butland, 1984): level where one of them is level, so that the curve does not overshoot.
float slope_between(float before, float after) { return before * after > 0.0 ? 2.0 * before * after / (before + after) : 0.0; }

struct DepthAlong {
    float depth; // optical, from the light
    float share; // of its layer's own depth that is in it
};

// Between the layers' faces optical depth grows along a monotone cubic: evenly inside a cloud, later where the cloud
// only begins in the layer.
DepthAlong depth_at(uint light, LightSpace space, vec2 texel, float along) {
    const float at = clamp((along - space.first) / space.spacing, 0.0, float(constants.layers));
    const int layer = int(min(at, float(constants.layers) - 1.0)), last = int(constants.layers) - 1;
    const float t = at - float(layer);
    const float start = summed_layer(light, layer - 1, texel);
    const float rise = summed_layer(light, layer, texel) - start;
    const float rise_before = start - summed_layer(light, layer - 2, texel);
    const float rise_after = layer < last ? summed_layer(light, layer + 1, texel) - start - rise : 0.0;
    const float slope_start = slope_between(rise_before, rise), slope_end = slope_between(rise, rise_after);
    const float part = t * t * (3.0 - 2.0 * t) * rise + t * (1.0 - t) * ((1.0 - t) * slope_start - t * slope_end);
    return DepthAlong(start + part, rise > 0.0 ? clamp(part / rise, 0.0, 1.0) : 0.0);
}

// A particle's own share of what is read at a place: that of the four texels it is interpolated from.
float own_depth(Footprint f, vec2 texel, float factor) {
    const vec2 corner = texel - 0.5;
    const vec2 first = floor(corner), part = corner - first;
    const float upper = mix(footprint_chord(f, first + 0.5), footprint_chord(f, first + vec2(1.5, 0.5)), part.x);
    const float lower = mix(footprint_chord(f, first + vec2(0.5, 1.5)), footprint_chord(f, first + 1.5), part.x);
    return f.depth * factor * mix(upper, lower, part.y);
}

// What the particle's chords on few texels were multiplied by.
float own_factor(Footprint f) {
    if (f.radius >= exact_radius)
        return 1.0;
    float chords = 0.0;
    for (int column = 0; column < 8; ++column)
        chords += column_sum(f, column);
    return mass_factor(f, chords);
}

// For a particle: it does not shadow itself, though its layer holds it.
float depth_before(uint light, LightSpace space, Footprint f, vec2 texel, float along, float own) {
    const DepthAlong found = depth_at(light, space, texel, along);
    return max(found.depth - (scattering ? 0.0 : found.share * own_depth(f, texel, own)), 0.0);
}
