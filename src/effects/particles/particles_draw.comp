// passes: copy copy_velocity transmittance statistics
// Drawing of particles: nothing yet.
#version 450
#extension GL_GOOGLE_include_directive : require

#include "particles_shared.h"
#include "numbers.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

#ifdef PASS_copy
layout(set = 0, binding = 0) uniform sampler2D colour;
layout(set = 0, binding = 4) uniform writeonly image2D target;
void main() {
    const ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (all(lessThan(p, imageSize(target))))
        imageStore(target, p, sane(texelFetch(colour, p, 0)));
}
#endif

#ifdef PASS_copy_velocity
layout(set = 0, binding = 0) uniform sampler2D velocity;
layout(set = 0, binding = 1) uniform writeonly image2D target;
void main() {
    const ivec2 p = ivec2(gl_GlobalInvocationID.xy), size = imageSize(target);
    if (all(lessThan(p, size)))
        imageStore(target, p, sane(textureLod(velocity, (vec2(p) + 0.5) / vec2(size), 0.0)));
}
#endif

#ifdef PASS_transmittance
layout(set = 0, binding = 0) uniform writeonly image2D target;
void main() {
    const ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (all(lessThan(p, imageSize(target))))
        imageStore(target, p, vec4(1));
}
#endif

#ifdef PASS_statistics
layout(std430, set = 0, binding = 0) buffer Statistics { ParticleStatistics statistics; };
void main() {
    if (gl_GlobalInvocationID.xy == uvec2(0))
        statistics = ParticleStatistics(0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u);
}
#endif
