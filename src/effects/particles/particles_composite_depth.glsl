// Nearest and farthest view depth of the pixels that one working pixel stands for. Particles are drawn against the
// farthest, so that none is missing, and against the nearest where there is an edge.

layout(local_size_x = 16, local_size_y = 8) in;

layout(constant_id = 0) const bool device_depth = false;
layout(constant_id = 1) const int factor = 1;

layout(set = 0, binding = 0) uniform sampler2D depth_image;
layout(set = 0, binding = 1) uniform writeonly image2D target;

float scene_depth(ivec2 pixel) {
    const vec2 ratio = vec2(textureSize(depth_image, 0)) / constants.size;
    const float value = texelFetch(depth_image, ivec2((vec2(pixel) + 0.5) * ratio), 0).x;
    const float z = device_depth ? view_depth_of(value, constants.projection) : value;
    return is_sky(z) || !(z > 0.0) ? sky_depth : z; // what is behind the eye or nowhere hides nothing
}

void main() {
    const ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(vec2(texel), constants.working_size)))
        return;
    float nearest = 3e38, farthest = 0.0;
    for (int y = 0; y < factor; ++y)
        for (int x = 0; x < factor; ++x) {
            const float z = scene_depth(min(texel * factor + ivec2(x, y), ivec2(constants.size) - 1));
            nearest = min(nearest, z);
            farthest = max(farthest, z);
        }
    // Nothing is gained by telling apart what differs less than the enlarging does.
    if (farthest - nearest < 0.25 * constants.depth_tolerance * nearest)
        nearest = farthest;
    imageStore(target, texel, vec4(nearest, farthest, 0, 0));
}
