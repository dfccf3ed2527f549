// Bent normals at full resolution: the estimate's, averaged over like depths with the filter's weights.

layout(local_size_x = 8, local_size_y = 8) in;

layout(constant_id = 3) const bool device_depth = false;
layout(constant_id = 4) const int filter_radius = 4;

layout(set = 0, binding = 0) uniform sampler2D bent_image; // direction, planar depth
layout(set = 0, binding = 1) uniform sampler2D depth_image;
layout(set = 0, binding = 2) uniform writeonly image2D result_image;

void main() {
    const ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(vec2(pixel), constants.size)))
        return;
    const float value = texelFetch(depth_image, pixel, 0).x;
    const float w = planar(usable_depth(device_depth ? view_depth_of(value, constants.projection) : value));
    const ivec2 centre = half_resolution ? pixel / 2 : pixel;
    const ivec2 last = ivec2(constants.working_size) - 1;
    vec3 total = vec3(0), nearest = vec3(0, 0, 1);
    float least = 3e38;
    for (int y = -filter_radius; y <= filter_radius; ++y)
        for (int x = -filter_radius; x <= filter_radius; ++x) {
            const ivec2 q = centre + ivec2(x, y);
            if (w == 0.0 || any(lessThan(q, ivec2(0))) || any(greaterThan(q, last)))
                continue;
            const vec4 texel = texelFetch(bent_image, q, 0);
            const float difference = texel.w == 0.0 ? 1e6 : abs(texel.w - w) / w * 50.0;
            const float distance_squared = float(x * x + y * y);
            total += exp2(-constants.filter_gaussian * distance_squared - difference * difference) * texel.xyz;
            if (difference + 1e-3 * distance_squared < least) {
                least = difference + 1e-3 * distance_squared;
                nearest = texel.xyz;
            }
        }
    const float squared = dot(total, total);
    imageStore(result_image, pixel, vec4(squared > 1e-6 ? total * inversesqrt(squared) : nearest, 0));
}
