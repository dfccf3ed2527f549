// Shows the inside of the effect: velocity, depth, tile maximum, neighbour maximum, tile class.

layout(local_size_x = 8, local_size_y = 8) in;

layout(constant_id = 0) const int tile_size = 32;
layout(constant_id = 1) const bool is_packed = false;
layout(constant_id = 2) const uint view = 0; // velocity, depth, tile maximum, neighbour maximum, tile class

layout(set = 0, binding = 0) uniform sampler2D colour_image;
layout(set = 0, binding = 1) uniform usampler2D surface_image;
layout(set = 0, binding = 2) uniform usampler2D tile_image;
layout(set = 0, binding = 3) readonly buffer Neighbours { uvec2 vectors[]; } neighbours;
layout(set = 0, binding = 4) uniform writeonly image2D output_image;

// Direction as hue, length against the maximum radius as brightness.
vec3 vector_colour(vec2 v) {
    const float l = length(v);
    const float hue = l > 0.0 ? atan(v.y, v.x) / 6.2831853 + 0.5 : 0.0;
    const vec3 tint = clamp(abs(fract(hue + vec3(0.0, 2.0, 1.0) / 3.0) * 6.0 - 3.0) - 1.0, 0.0, 1.0);
    return tint * min(l * constants.debug_scale, 1.0);
}

void main() {
    const ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(constants.size))))
        return;
    const uvec2 code = texelFetch(surface_image, pixel, 0).xy;
    const Surface s = is_packed ? unpack_8_bit(code.x, constants.radius) : unpack_half(code);
    const ivec2 tile = pixel / tile_size;
    const uvec2 codes = neighbours.vectors[tile.y * textureSize(tile_image, 0).x + tile.x];
    vec3 shown;
    if (view == 0)
        shown = vector_colour(s.v);
    else if (view == 1)
        shown = vec3(is_sky(s.z) ? 0.0 : 1.0 / (1.0 + 0.1 * s.z));
    else if (view == 2)
        shown = vector_colour(vector_of(texelFetch(tile_image, tile, 0).x, is_packed, constants.radius));
    else if (view == 3)
        shown = vector_colour(vector_of(codes.x, is_packed, constants.radius));
    else {
        const vec3 tint = codes.x == zero_vector(is_packed) ? vec3(0.1, 0.3, 1.0)
                          : codes.y == uniform_mark         ? vec3(0.1, 0.9, 0.2)
                                                            : vec3(1.0, 0.2, 0.1);
        const float grey = luminance(sane(texelFetch(colour_image, pixel, 0)).rgb);
        shown = tint * (0.25 + 0.75 * grey / (1.0 + grey));
    }
    imageStore(output_image, pixel, vec4(shown, 1));
}
