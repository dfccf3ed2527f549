// Reading and writing a light's shadow buffer: layers of optical depth as whole numbers, which sum alike in any order.

LightSpace space_of(uint light) {
    const uint at = fact_space + fact_space_words * light;
    return LightSpace(vec2(uintBitsToFloat(facts.data[at]), uintBitsToFloat(facts.data[at + 1u])),
                      uintBitsToFloat(facts.data[at + 2u]), uintBitsToFloat(facts.data[at + 3u]),
                      uintBitsToFloat(facts.data[at + 4u]), uintBitsToFloat(facts.data[at + 5u]));
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

// Sum over all texels.
float chord_sum(Footprint f) {
    const ivec2 first = ivec2(floor(f.middle - f.radius - 0.5)) + 1;
    const ivec2 last = ivec2(floor(f.middle + f.radius - 0.5));
    float sum = 0.0;
    for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; ++x)
            sum += footprint_chord(f, vec2(x, y) + 0.5);
    return sum;
}

// What the chords of so few texels must be multiplied by to hold 2/3 pi r².
float mass_factor(Footprint f, float chords) {
    return chords > 0.0 ? (2.0 / 3.0) * pi * f.radius * f.radius / chords : 1.0;
}

// Words of a light's buffer while layers are filled: one a texel, layer after layer.
uint layer_start(uint light, uint layer) { return (light * constants.planes + layer) * constants.area; }

// How many layers lie before a depth, in a row of texels. Where in its layer a particle lies is not known, so that light
// is wrong by up to what a layer takes away. A particle covers several rows: where the faces of their layers lie at
// different depths, their errors differ, and to interpolate between rows takes them off each other.
float layers_along(LightSpace space, uint row, float along) {
    return (along - space.first) / space.spacing + ((row & 1u) != 0u ? space.shift : 0.0);
}

// What a word holds once the layers are summed: optical depth from the light to the face behind the layer, and how fast
// it grows there, by the layer. As halves: depth is known to a part in 4096, light so to a part in 10,000.
uint pack_face(vec2 depth_and_slope) { return packHalf2x16(min(depth_and_slope, vec2(60000.0))); }
vec2 unpack_face(uint word) { return unpackHalf2x16(word); }

// Where the four faces behind a texel's first four layers are then, in words by fours; those of the next four layers lie
// `area` of these farther on. They take the place of four texels in four layers: what each holds is transposed.
uint faces_of(uint light, uint texel) {
    return (light * constants.planes + texel % 4u) * (constants.area / 4u) + texel / 4u;
}
