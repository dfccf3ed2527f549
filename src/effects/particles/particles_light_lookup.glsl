// Optical depth between a light and a place, read from the faces behind the light's layers.

// Two texels of a row beside a place, as the numbers of their first four faces.
struct Row {
    uvec2 faces;
    float part; // how far the place is from the left to the right one
    uint y;
};

// The two rows around a place, in texels, the upper one first. Outside the buffer nothing is found: its rim is empty.
Row[2] rows_around(uint light, vec2 texel, out float part) {
    const vec2 corner = clamp(texel, vec2(-1), vec2(float(constants.side) + 1.0)) - 0.5;
    const ivec2 first = ivec2(floor(corner)), last = ivec2(constants.side) - 1;
    const uvec2 low = uvec2(clamp(first, ivec2(0), last)), high = uvec2(clamp(first + 1, ivec2(0), last));
    const uvec2 starts = uvec2(low.y, high.y) * constants.side;
    const vec2 parts = corner - vec2(first);
    part = parts.y;
    return Row[](Row(uvec2(faces_of(light, starts.x + low.x), faces_of(light, starts.x + high.x)), parts.x, low.y),
                 Row(uvec2(faces_of(light, starts.y + low.x), faces_of(light, starts.y + high.x)), parts.x, high.y));
}

// One face at a place. The curves between faces are linear in what the faces hold, so to interpolate that between texels
// is to interpolate the texels' own curves.
vec2 face(Row row, uint number) {
    const uvec2 faces = row.faces + number / 4u * constants.area;
    return mix(unpack_face(volume.data[faces.x][number % 4u]), unpack_face(volume.data[faces.y][number % 4u]), row.part);
}

// Slices: everything in the layers before this one, as the document's alternation of picture and shadow buffer has it.
float depth_before_layer(uint light, vec2 texel, uint layer) {
    if (layer == 0u)
        return 0.0;
    float part;
    const Row rows[2] = rows_around(light, texel, part);
    return mix(face(rows[0], layer - 1u).x, face(rows[1], layer - 1u).x, part);
}

struct DepthAlong {
    float depth; // optical, from the light
    float share; // of its layer's own depth that is in it
};

// Between the layers' faces optical depth grows along a monotone cubic: evenly inside a cloud, later where the cloud
// only begins in the layer.
DepthAlong depth_in_row(LightSpace space, Row row, float along) {
    const float at = clamp(layers_along(space, row.y, along), 0.0, float(constants.layers));
    const uint layer = uint(min(at, float(constants.layers) - 1.0));
    const float t = at - float(layer);
    // Faces are read by fours: mostly both of a layer at once. Nothing is before the first.
    const uvec2 faces = row.faces + layer / 4u * constants.area;
    const uvec4 left = volume.data[faces.x], right = volume.data[faces.y];
    const uint i = layer % 4u;
    const vec2 end = mix(unpack_face(left[i]), unpack_face(right[i]), row.part);
    vec2 start = vec2(0);
    if (i != 0u)
        start = mix(unpack_face(left[i - 1u]), unpack_face(right[i - 1u]), row.part);
    else if (layer != 0u)
        start = face(row, layer - 1u);
    const float rise = end.x - start.x;
    const float part = t * t * (3.0 - 2.0 * t) * rise + t * (1.0 - t) * ((1.0 - t) * start.y - t * end.y);
    return DepthAlong(start.x + part, rise > 0.0 ? clamp(part / rise, 0.0, 1.0) : 0.0);
}

float depth_at(uint light, LightSpace space, vec2 texel, float along) {
    float part;
    const Row rows[2] = rows_around(light, texel, part);
    return mix(depth_in_row(space, rows[0], along).depth, depth_in_row(space, rows[1], along).depth, part);
}

// A particle's own share of what is read at a place: that of the texels it is interpolated from. Of the upper row and
// the lower one.
vec2 own_depth(Footprint f, vec2 texel, float factor) {
    const vec2 corner = texel - 0.5;
    const vec2 first = floor(corner);
    const float part = corner.x - first.x;
    return f.depth * factor *
           vec2(mix(footprint_chord(f, first + 0.5), footprint_chord(f, first + vec2(1.5, 0.5)), part),
                mix(footprint_chord(f, first + vec2(0.5, 1.5)), footprint_chord(f, first + 1.5), part));
}

// What the particle's chords on few texels were multiplied by.
float own_factor(Footprint f) { return f.radius >= exact_radius ? 1.0 : mass_factor(f, chord_sum(f)); }

// For a particle: it does not shadow itself, though its layer holds it.
float depth_before(uint light, LightSpace space, Footprint f, vec2 texel, float along, float own) {
    float part;
    const Row rows[2] = rows_around(light, texel, part);
    const DepthAlong upper = depth_in_row(space, rows[0], along), lower = depth_in_row(space, rows[1], along);
    const vec2 owned = scattering ? vec2(0) : own_depth(f, texel, own);
    return mix(max(upper.depth - upper.share * owned.x, 0.0), max(lower.depth - lower.share * owned.y, 0.0), part);
}
