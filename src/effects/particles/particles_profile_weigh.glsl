// One workgroup a place of the table: what a disc there holds, over what a sphere's chords hold. A turn about the middle
// changes nothing of it, so that each particle can be given a sphere's mass.

layout(local_size_x = 128) in;

layout(constant_id = 0) const bool by_chord = true; // the table multiplies the chord; else it stands in its place

layout(set = 0, binding = 0) uniform sampler2D table; // its second level
layout(set = 0, binding = 1) buffer Facts { uint data[]; } facts;

shared vec2 sums[128];

void main() {
    const uint thread = gl_LocalInvocationIndex;
    const float side = 0.5 * profile_side;
    const float radius = constants.profile_reach * side;
    const vec2 middle = (by_chord ? place_middle(gl_WorkGroupID.x, constants.profile_reach) : vec2(0.5)) * side;
    const ivec2 first = ivec2(max(floor(middle - radius), 0.0));
    const ivec2 last = ivec2(min(ceil(middle + radius), side)) - 1;
    const int columns = last.x - first.x + 1;
    const int count = columns * (last.y - first.y + 1);
    vec2 sum = vec2(0);
    for (int i = int(thread); i < count; i += 128) {
        const ivec2 texel = first + ivec2(i % columns, i / columns);
        const vec2 d = (vec2(texel) + 0.5 - middle) / radius;
        // A texture ends at the disc's rim, which cuts texels.
        const float weight = by_chord ? chord(dot(d, d)) : clamp((1.0 - length(d)) * radius + 0.5, 0.0, 1.0);
        sum += weight * vec2(texelFetch(table, texel, 0).x, 1);
    }
    sums[thread] = sum;
    [[unroll]] for (uint step = 64u; step > 0u; step /= 2u) {
        barrier();
        if (thread < step)
            sums[thread] += sums[thread + step];
    }
    // The mean chord is 2/3.
    if (thread == 0u)
        facts.data[fact_profile + gl_WorkGroupID.x] =
            floatBitsToUint(sums[0].x / sums[0].y * (by_chord ? 1.0 : 1.5));
}
