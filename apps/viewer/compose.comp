// passes: compose
// Two pictures on either side of a divider, each made visible as its kind asks for.
#version 450
#extension GL_GOOGLE_include_directive : require

#include "compose_shared.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform sampler2D left_picture;
layout(set = 0, binding = 1) uniform sampler2D right_picture;
layout(set = 0, binding = 2) uniform sampler2D compared_picture; // of differences
layout(set = 0, binding = 3) uniform sampler2D true_picture;
layout(set = 0, binding = 4) uniform writeonly image2D canvas;
layout(set = 1, binding = 0) uniform Constants { ComposeConstants constants; };

// The sRGB transfer curve; NaN becomes black.
vec3 encoded(vec3 linear) {
    vec3 result;
    for (int c = 0; c < 3; ++c) {
        float v = linear[c] > 0.0 ? min(linear[c], 1.0) : 0.0;
        result[c] = v <= 0.0031308 ? 12.92 * v : 1.055 * pow(v, 1.0 / 2.4) - 0.055;
    }
    return result;
}

vec4 texel(sampler2D picture, vec2 place) {
    ivec2 size = textureSize(picture, 0);
    return texelFetch(picture, clamp(ivec2(floor(place * vec2(size))), ivec2(0), size - 1), 0);
}

vec3 shown(uint kind, vec4 value, vec2 place) {
    switch (kind) {
    case PICTURE_GREY:
        return encoded(vec3(value.x * constants.exposure));
    case PICTURE_DEPTH:
        return vec3(constants.near_depth / (constants.near_depth + max(value.x, 0.0)));
    case PICTURE_NORMAL:
        return clamp(value.xyz * 0.5 + 0.5, 0.0, 1.0);
    case PICTURE_VELOCITY:
        return clamp(vec3(0.5 + value.xy * constants.gain / 128.0, 0.5), 0.0, 1.0);
    case PICTURE_DIFFERENCE: {
        vec3 a = encoded(texel(compared_picture, place).rgb), b = encoded(texel(true_picture, place).rgb);
        return clamp(abs(a - b) * constants.gain, 0.0, 1.0);
    }
    case PICTURE_GREY_DIFFERENCE: {
        float a = texel(compared_picture, place).x, b = texel(true_picture, place).x;
        return vec3(clamp(abs(a - b) * constants.gain, 0.0, 1.0));
    }
    }
    return encoded(value.rgb * constants.exposure);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(canvas))))
        return;
    vec2 centre = vec2(pixel) + 0.5;
    vec2 place = (centre - constants.area.xy) / constants.area.zw;
    vec3 colour = constants.surroundings.rgb;
    if (all(greaterThanEqual(place, vec2(0.0))) && all(lessThan(place, vec2(1.0)))) {
        bool is_left = centre.x < constants.divider;
        vec4 value = is_left ? texel(left_picture, place) : texel(right_picture, place);
        colour = shown(is_left ? constants.left_kind : constants.right_kind, value, place);
        float distance = abs(centre.x - constants.divider);
        if (distance < constants.divider_width)
            colour = distance < constants.divider_width * 0.5 ? vec3(1.0) : vec3(0.0);
    }
    imageStore(canvas, pixel, vec4(colour, 1.0));
}
