// passes: fill copy accumulate combine command stamp large count_groups add_words
// Small passes for the executor's tests, each with an output that a few lines of C++ can predict.
#version 450

layout(constant_id = 0) const float factor = 1.0;

#ifdef PASS_fill
// value + x + 100 y
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform writeonly image2D target;
layout(set = 1, binding = 0) uniform Constants { vec4 value; };
void main() {
    const ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (all(lessThan(p, imageSize(target))))
        imageStore(target, p, vec4(factor * value.x + float(p.x) + 100.0 * float(p.y)));
}
#endif

#ifdef PASS_copy
layout(local_size_x = 4, local_size_y = 16) in;
layout(set = 0, binding = 0) uniform sampler2D source;
layout(set = 0, binding = 1) uniform writeonly image2D target;
void main() {
    const ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (all(lessThan(p, imageSize(target))))
        imageStore(target, p, factor * textureLod(source, (vec2(p) + 0.5) / vec2(imageSize(target)), 0.0));
}
#endif

#ifdef PASS_accumulate
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform sampler2D previous;
layout(set = 0, binding = 1) uniform writeonly image2D current;
layout(set = 0, binding = 2) uniform writeonly image2D shown;
layout(set = 1, binding = 0) uniform Constants { vec4 value; };
void main() {
    const ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, imageSize(current))))
        return;
    const vec4 sum = texelFetch(previous, p, 0) + value;
    imageStore(current, p, sum);
    imageStore(shown, p, sum);
}
#endif

#ifdef PASS_combine
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform sampler2D a;
layout(set = 0, binding = 1) uniform sampler2D b;
layout(set = 0, binding = 2) uniform writeonly image2D target;
void main() {
    const ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (all(lessThan(p, imageSize(target))))
        imageStore(target, p, texelFetch(a, p, 0) + texelFetch(b, p, 0));
}
#endif

#ifdef PASS_command
// A command of value.x × value.y groups behind four words of something else.
layout(local_size_x = 1) in;
layout(set = 0, binding = 0) buffer Commands { uint words[]; };
layout(set = 1, binding = 0) uniform Constants { vec4 value; };
void main() {
    words[4] = uint(value.x);
    words[5] = uint(value.y);
    words[6] = 1u;
}
#endif

#ifdef PASS_stamp
layout(local_size_x = 4, local_size_y = 4) in;
layout(set = 0, binding = 0) uniform writeonly image2D target;
void main() {
    const ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (all(lessThan(p, imageSize(target))))
        imageStore(target, p, vec4(factor));
}
#endif

#ifdef PASS_large
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform writeonly image2D target;
layout(set = 1, binding = 0) uniform Constants { vec4 values[256]; };
void main() {
    const ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (all(lessThan(p, imageSize(target))))
        imageStore(target, p, values[p.x + p.y * imageSize(target).x]);
}
#endif

#ifdef PASS_count_groups
// One workgroup a texel.
layout(local_size_x = 16) in;
layout(set = 0, binding = 0) uniform writeonly image2D target;
shared uint threads;
void main() {
    if (gl_LocalInvocationIndex == 0u)
        threads = 0u;
    barrier();
    atomicAdd(threads, 1u);
    barrier();
    if (gl_LocalInvocationIndex == 0u)
        imageStore(target, ivec2(gl_WorkGroupID.xy), vec4(float(threads)));
}
#endif

#ifdef PASS_add_words
// Each word of the target grows by the source's word and one.
layout(local_size_x = 64) in;
layout(std430, set = 0, binding = 0) readonly buffer Source { uint source[]; };
layout(std430, set = 0, binding = 1) buffer Target { uint target[]; };
void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i < uint(target.length()))
        target[i] += source[i] + 1u;
}
#endif
