// Zeros.

layout(local_size_x = 256) in;

layout(set = 0, binding = 0) writeonly buffer Target { uint data[]; } target;

const uint per_thread = 16u;

void main() {
    const uint first = gl_WorkGroupID.x * 256u * per_thread + gl_LocalInvocationIndex;
    [[unroll]] for (uint i = 0u; i < per_thread; ++i) {
        const uint word = first + i * 256u;
        if (word < uint(target.data.length()))
            target.data[word] = 0u;
    }
}
