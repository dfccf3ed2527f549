// Sums the layers of each texel from the light on; each word then tells of the face behind its layer. One thread takes
// four texels, four layers at a time, and leaves the four faces of a texel side by side in the same place.

layout(local_size_x = 64) in;

layout(constant_id = 0) const uint light_count = 1u;
layout(constant_id = 1) const bool is_summed = false; // by scattering; light that spreads may also fill up a shadow

layout(set = 0, binding = 0) readonly buffer Facts { uint data[]; } facts;
layout(set = 0, binding = 1) buffer Volume { uvec4 data[]; } volume;

#include "particles_light_volume.glsl"

// Of four texels, by the layer.
struct Layers {
    vec4 rises[4];
};

// From layer `first` on; `sums` are of the layers before it and become those of the layers before the next four.
Layers read_layers(uint start, uint first, inout uvec4 sums, out uvec4 depths[4]) {
    Layers found;
    [[unroll]] for (uint i = 0u; i < 4u; ++i) {
        const bool is_there = first + i < constants.layers;
        const uvec4 words = is_there ? volume.data[start + (first + i) * (constants.area / 4u)] : uvec4(0);
        found.rises[i] = is_there ? is_summed ? vec4(words) - vec4(sums) : vec4(words) : vec4(0);
        if (is_there)
            sums = is_summed ? words : sums + words;
        depths[i] = sums;
    }
    return found;
}

// Slope between the second and the third of four layers, given what optical depth rises by in each: exact for cubics,
// but such that the curve neither falls nor overshoots (Fritsch and Carlson, 1980: three times the smaller rise). It is
// level where a layer beside it is empty.
vec4 slope_between(vec4 a, vec4 b, vec4 c, vec4 d) {
    const vec4 most = 3.0 * min(b, c);
    return clamp((7.0 * (b + c) - a - d) / 12.0, vec4(0), max(most, vec4(0)));
}

void main() {
    const uint quarter = constants.area / 4u;
    if (gl_GlobalInvocationID.x >= quarter * light_count)
        return;
    const uint light = gl_GlobalInvocationID.x / quarter;
    const uint start = layer_start(light, 0u) / 4u + gl_GlobalInvocationID.x % quarter;
    const float unit = uintBitsToFloat(facts.data[fact_unit]);
    uvec4 sums = uvec4(0), depths[4], next_depths[4];
    Layers here = read_layers(start, 0u, sums, depths);
    vec4 before = vec4(0); // rise of the layer before these four
    for (uint first = 0u; first < constants.layers; first += 4u) {
        const Layers next = read_layers(start, first + 4u, sums, next_depths);
        uvec4 faces[4]; // of the texels
        [[unroll]] for (uint i = 0u; i < 4u; ++i) {
            const vec4 after = i < 3u ? here.rises[(i + 1u) % 4u] : next.rises[0];
            const vec4 later = i < 2u ? here.rises[(i + 2u) % 4u] : next.rises[i % 2u];
            const vec4 depth = vec4(depths[i]) * unit;
            const vec4 slope = slope_between(before, here.rises[i], after, later) * unit;
            before = here.rises[i];
            [[unroll]] for (uint texel = 0u; texel < 4u; ++texel)
                faces[texel][i] = pack_face(vec2(depth[texel], slope[texel]));
        }
        [[unroll]] for (uint texel = 0u; texel < 4u; ++texel)
            volume.data[start + (first + texel) * quarter] = faces[texel];
        here = next;
        depths = next_depths;
    }
}
