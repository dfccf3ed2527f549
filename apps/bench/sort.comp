// passes: make show
// What `sort` feeds its building blocks with, made on the device, and the way back of their results.
#version 450

layout(local_size_x = 64) in;

const uint row = 4096u; // words of a row of invocations, and of the image

#ifdef PASS_make
// base + (i & index_mask) + (hash of i & hash_mask); sort.cpp has the same.
layout(constant_id = 0) const uint number = 0;
layout(constant_id = 1) const uint base = 0;
layout(constant_id = 2) const uint index_mask = 0;
layout(constant_id = 3) const uint hash_mask = 0;
layout(set = 0, binding = 0) writeonly buffer Words { uint words[]; };

// PCG, RXS-M-XS variant (O'Neill 2014), of one step.
uint hash(uint i) {
    const uint state = i * 747796405u + 2891336453u;
    const uint word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

void main() {
    const uint i = gl_GlobalInvocationID.y * row + gl_GlobalInvocationID.x;
    if (i < number)
        words[i] = base + (i & index_mask) + (hash(i) & hash_mask);
}
#endif

#ifdef PASS_show
layout(constant_id = 0) const uint number = 0;
layout(set = 0, binding = 0) readonly buffer Words { uint words[]; };
layout(set = 0, binding = 1) uniform writeonly image2D target;

void main() {
    const uint i = gl_GlobalInvocationID.y * row + gl_GlobalInvocationID.x;
    if (i >= number)
        return;
    const uvec4 bytes = uvec4(words[i], words[i] >> 8, words[i] >> 16, words[i] >> 24) & 255u;
    imageStore(target, ivec2(gl_GlobalInvocationID.xy), vec4(bytes) / 255.0);
}
#endif
