// passes: nothing copy
// What the device itself can do: a dispatch that does nothing, and a copy of an image.
#version 450

layout(set = 0, binding = 0) uniform writeonly image2D target_image;

#ifdef PASS_nothing
layout(local_size_x = 1) in;

void main() {
    // Never true, but the compiler cannot know: the binding stays, and no memory is touched.
    if (gl_WorkGroupID.x > 0xffffu)
        imageStore(target_image, ivec2(0), vec4(0));
}
#endif

#ifdef PASS_copy
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 1) uniform sampler2D source_image;

void main() {
    const ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (all(lessThan(pixel, imageSize(target_image))))
        imageStore(target_image, pixel, texelFetch(source_image, pixel, 0));
}
#endif
