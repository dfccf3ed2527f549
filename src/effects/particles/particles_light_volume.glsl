// Reading and writing a light's shadow buffer: layers of optical depth as whole numbers, which sum alike in any order.

LightSpace space_of(uint light) {
    const uint at = fact_space + fact_space_words * light;
    return LightSpace(vec2(uintBitsToFloat(facts.data[at]), uintBitsToFloat(facts.data[at + 1u])),
                      uintBitsToFloat(facts.data[at + 2u]), uintBitsToFloat(facts.data[at + 3u]),
                      uintBitsToFloat(facts.data[at + 4u]));
}

// A particle on a light's texels.
struct Footprint {
    vec2 middle;  // texels
    float radius; // texels, at least 1
    float depth;  // optical, through the middle; the texels together hold what the sphere holds
};

Footprint footprint_of(LightSpace space, vec2 place, float radius, float optical_depth) {
    Footprint f;
    f.middle = (place - space.corner) / space.texel;
    const float texels = radius / space.texel;
    f.radius = max(texels, 1.0);
    f.depth = min(optical_depth, deepest) * (texels / f.radius) * (texels / f.radius);
    return f;
}

float footprint_chord(Footprint f, vec2 texel_middle) {
    const vec2 d = (texel_middle - f.middle) / f.radius;
    return chord(dot(d, d));
}

// Sum over one column of texels; columns are counted from the footprint's first.
float column_sum(Footprint f, int column) {
    const ivec2 first = ivec2(floor(f.middle - f.radius - 0.5)) + 1;
    const ivec2 last = ivec2(floor(f.middle + f.radius - 0.5));
    float sum = 0.0;
    if (first.x + column <= last.x)
        for (int y = first.y; y <= last.y; ++y)
            sum += footprint_chord(f, vec2(first.x + column, y) + 0.5);
    return sum;
}

// What the chords of so few texels must be multiplied by to hold 2/3 pi r².
float mass_factor(Footprint f, float chords) {
    return chords > 0.0 ? (2.0 / 3.0) * pi * f.radius * f.radius / chords : 1.0;
}
