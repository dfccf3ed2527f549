// passes: load store
// 32-bit words between buffers and images of four 8-bit channels, 1024 words a row: a way for tests to fill and read
// buffers of a plan.
#version 450

layout(local_size_x = 64) in;
layout(constant_id = 0) const uint first = 0; // word of the buffer that the image begins with
layout(constant_id = 1) const uint number = 0;

const uint row = 1024u;

#ifdef PASS_load
layout(set = 0, binding = 0) uniform sampler2D source;
layout(set = 0, binding = 1) buffer Words { uint words[]; };
void main() {
    const uvec2 p = gl_GlobalInvocationID.xy;
    const uint at = p.y * row + p.x;
    if (p.x >= row || at >= number)
        return;
    const uvec4 bytes = uvec4(round(texelFetch(source, ivec2(p), 0) * 255.0));
    words[first + at] = bytes.x | bytes.y << 8 | bytes.z << 16 | bytes.w << 24;
}
#endif

#ifdef PASS_store
layout(set = 0, binding = 0) readonly buffer Words { uint words[]; };
layout(set = 0, binding = 1) uniform writeonly image2D target;
void main() {
    const uvec2 p = gl_GlobalInvocationID.xy;
    const uint at = p.y * row + p.x;
    if (p.x >= row || at >= number)
        return;
    const uint word = words[first + at];
    const uvec4 bytes = uvec4(word, word >> 8, word >> 16, word >> 24) & 255u;
    imageStore(target, ivec2(p), vec4(bytes) / 255.0);
}
#endif
