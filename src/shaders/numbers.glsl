// Tests and noise that shaders share.
#ifndef NUMBERS_GLSL
#define NUMBERS_GLSL

// isnan and isinf may be optimised away where a compiler assumes finite maths: look at the bits.
bool is_finite(float x) { return (floatBitsToUint(x) & 0x7f800000u) != 0x7f800000u; }
bool is_finite(vec2 v) { return is_finite(v.x) && is_finite(v.y); }
bool is_nan(float x) { return (floatBitsToUint(x) & 0x7fffffffu) > 0x7f800000u; }

// NaN becomes 0, infinity the largest half float; everything finite stays as it is.
float sane(float x) {
    return is_finite(x) ? x : is_nan(x) ? 0.0 : x > 0.0 ? 65504.0 : -65504.0;
}
vec4 sane(vec4 v) {
    const uvec4 exponent = floatBitsToUint(v) & 0x7f800000u;
    if (any(equal(exponent, uvec4(0x7f800000u))))
        v = vec4(sane(v.x), sane(v.y), sane(v.z), sane(v.w));
    return v;
}

float luminance(vec3 colour) { return dot(colour, vec3(0.2126, 0.7152, 0.0722)); }

// Interleaved gradient noise, Jimenez 2014: [0, 1), every 3×3 block holds near all ninths.
float gradient_noise(vec2 p) { return fract(52.9829189 * fract(dot(p, vec2(0.06711056, 0.00583715)))); }

#endif
