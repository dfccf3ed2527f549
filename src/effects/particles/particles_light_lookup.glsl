// Optical depth between a light and a place, read from the faces behind the light's layers.

// Both faces of one layer at a place.
struct Layer {
    vec2 start, end; // optical depth from the light, and its slope by the layer
};

// The four texels around a place, as the numbers of their first four faces.
struct Texels {
    uvec4 faces;
    vec2 part; // how far the place is from the first to the last of them
};

// `texel` in texels. Outside the buffer nothing is found: its rim is empty.
Texels texels_around(uint light, vec2 texel) {
    const vec2 corner = clamp(texel, vec2(-1), vec2(float(constants.side) + 1.0)) - 0.5;
    const ivec2 first = ivec2(floor(corner)), last = ivec2(constants.side) - 1;
    const uvec2 low = uvec2(clamp(first, ivec2(0), last)), high = uvec2(clamp(first + 1, ivec2(0), last));
    const uvec2 rows = uvec2(low.y, high.y) * constants.side;
    return Texels(uvec4(faces_of(light, rows.x + low.x), faces_of(light, rows.x + high.x),
                        faces_of(light, rows.y + low.x), faces_of(light, rows.y + high.x)),
                  corner - vec2(first));
}

// The curves between faces are linear in what the faces hold, so to interpolate that between texels is to interpolate
// the texels' own curves.
vec2 between(Texels at, vec2 a, vec2 b, vec2 c, vec2 d) {
    return mix(mix(a, b, at.part.x), mix(c, d, at.part.x), at.part.y);
}

// One component of four faces.
vec2 face(Texels at, uint quad, uint component) {
    const uvec4 faces = at.faces + quad * constants.area;
    return between(at, unpack_face(volume.data[faces.x][component]), unpack_face(volume.data[faces.y][component]),
                   unpack_face(volume.data[faces.z][component]), unpack_face(volume.data[faces.w][component]));
}

// Slices: everything in the layers before this one, as the document's alternation of picture and shadow buffer has it.
float depth_before_layer(uint light, vec2 texel, uint layer) {
    return layer == 0u ? 0.0 : face(texels_around(light, texel), (layer - 1u) / 4u, (layer - 1u) % 4u).x;
}

// Faces are read by fours: mostly both of a layer at once. Nothing is before the first.
Layer layer_at(uint light, vec2 texel, uint layer) {
    const Texels at = texels_around(light, texel);
    const uvec4 faces = at.faces + layer / 4u * constants.area;
    const uvec4 a = volume.data[faces.x], b = volume.data[faces.y], c = volume.data[faces.z], d = volume.data[faces.w];
    const uint i = layer % 4u;
    Layer found;
    found.end = between(at, unpack_face(a[i]), unpack_face(b[i]), unpack_face(c[i]), unpack_face(d[i]));
    if (i != 0u)
        found.start = between(at, unpack_face(a[i - 1u]), unpack_face(b[i - 1u]), unpack_face(c[i - 1u]),
                              unpack_face(d[i - 1u]));
    else
        found.start = layer == 0u ? vec2(0) : face(at, layer / 4u - 1u, 3u);
    return found;
}

struct DepthAlong {
    float depth; // optical, from the light
    float share; // of its layer's own depth that is in it
};

// Between the layers' faces optical depth grows along a monotone cubic: evenly inside a cloud, later where the cloud
// only begins in the layer.
DepthAlong depth_at(uint light, LightSpace space, vec2 texel, float along) {
    const float at = clamp((along - space.first) / space.spacing, 0.0, float(constants.layers));
    const uint number = uint(min(at, float(constants.layers) - 1.0));
    const float t = at - float(number);
    const Layer layer = layer_at(light, texel, number);
    const float rise = layer.end.x - layer.start.x;
    const float part = t * t * (3.0 - 2.0 * t) * rise + t * (1.0 - t) * ((1.0 - t) * layer.start.y - t * layer.end.y);
    return DepthAlong(layer.start.x + part, rise > 0.0 ? clamp(part / rise, 0.0, 1.0) : 0.0);
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
float own_factor(Footprint f) { return f.radius >= exact_radius ? 1.0 : mass_factor(f, chord_sum(f)); }

// For a particle: it does not shadow itself, though its layer holds it.
float depth_before(uint light, LightSpace space, Footprint f, vec2 texel, float along, float own) {
    const DepthAlong found = depth_at(light, space, texel, along);
    return max(found.depth - (scattering ? 0.0 : found.share * own_depth(f, texel, own)), 0.0);
}
