// Key and number of each particle that is to be sorted, packed in the order of the particles' slots: equal keys keep
// the same order from frame to frame.

layout(local_size_x = 256) in;

layout(constant_id = 0) const bool float_keys = false; // 32 bits: the float itself

layout(set = 0, binding = 0) readonly buffer Sprites { vec4 data[]; } sprites;
layout(set = 0, binding = 1) readonly buffer Facts { uint data[]; } facts;
layout(set = 0, binding = 2) readonly buffer Flags { uint data[]; } flags;
layout(set = 0, binding = 3) readonly buffer Places { uint data[]; } places; // exclusive sums of the flags
layout(set = 0, binding = 4) writeonly buffer Keys { uint data[]; } keys;
layout(set = 0, binding = 5) writeonly buffer Values { uint data[]; } values;

void main() {
    const uint index = gl_GlobalInvocationID.x;
    if (index >= constants.capacity || flags.data[index] == 0u)
        return;
    const float offset = uintBitsToFloat(facts.data[fact_key_offset]);
    const float scale = uintBitsToFloat(facts.data[fact_key_scale]);
    const float distance_along = max(sort_depth(sprites.data[3u * index].xyz) - offset, 0.0);
    const uint place = places.data[index];
    keys.data[place] = float_keys ? floatBitsToUint(distance_along)
                                  : uint(min(distance_along * scale, constants.key_range));
    values.data[place] = index;
}
