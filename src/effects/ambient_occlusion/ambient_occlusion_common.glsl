// What all passes share: positions, and the packed signal that travels from pass to pass.

layout(constant_id = 0) const bool perspective = true;
layout(constant_id = 1) const bool half_resolution = false;
layout(constant_id = 2) const bool wide = false; // 64-bit signals: full depth, a shadow, a count

// What is behind the eye, nowhere, not a number, or so close to the eye that its inverse overflows is sky.
float usable_depth(float z) { return z > 1e-12 && !is_sky(z) ? z : pyramid_sky; }

vec3 view_position(vec2 pixel, float z) {
    const vec2 xy = pixel * constants.pixel_to_view.xy + constants.pixel_to_view.zw;
    return vec3(perspective ? xy * z : xy, -z);
}

// What every filter compares: it is linear in screen space on a plane, so that a slope can be continued exactly. 0 is
// sky.
float planar(float z) { return is_pyramid_sky(z) ? 0.0 : perspective ? 1.0 / z : z; }
float depth_of_planar(float w) { return w == 0.0 ? pyramid_sky : perspective ? 1.0 / w : w; }

struct Signal {
    float visibility;
    float w; // planar depth
    float shadow;
    float count; // 0…31: danger before the temporal filter, length of history after it
};

uvec2 pack_signal(Signal s) {
    if (wide)
        return uvec2((floatBitsToUint(s.w) & ~31u) | uint(s.count), packHalf2x16(vec2(s.visibility, s.shadow)));
    return uvec2(packHalf2x16(vec2(s.visibility, min(s.w * constants.code_scale, 65504.0))), 0);
}

Signal unpack_signal(uvec2 code) {
    Signal s;
    if (wide) {
        const vec2 values = unpackHalf2x16(code.y);
        s = Signal(values.x, uintBitsToFloat(code.x & ~31u), values.y, float(code.x & 31u));
    } else {
        const vec2 values = unpackHalf2x16(code.x);
        s = Signal(values.x, values.y / constants.code_scale, 1.0, 0.0);
    }
    return s;
}

// The middle of a pixel of the border that is there for taps alone.
bool in_guard_band(vec2 pixel) {
    return constants.guard_band > 0.0 && (any(lessThan(pixel, vec2(constants.guard_band))) ||
                                          any(greaterThan(pixel, constants.size - constants.guard_band)));
}

ivec2 scaled(ivec2 pixel, vec2 ratio) { return ivec2((vec2(pixel) + 0.5) * ratio); }

// Vectors of three components, or octahedral ones of two (Cigolle et al., JCGT 2014).
const int normal_vector = 1, normal_octahedral = 2, normal_unsigned = 4, normal_world = 8;
vec3 decode_normal(vec4 texel, int encoding) {
    vec3 n = (encoding & normal_unsigned) != 0 ? texel.xyz * 2.0 - 1.0 : texel.xyz;
    if ((encoding & normal_octahedral) != 0) {
        n.z = 1.0 - abs(n.x) - abs(n.y);
        if (n.z < 0.0)
            n.xy = (1.0 - abs(n.yx)) * vec2(n.x >= 0.0 ? 1.0 : -1.0, n.y >= 0.0 ? 1.0 : -1.0);
    }
    if ((encoding & normal_world) != 0)
        n = mat3(constants.view_from_world) * n;
    return n;
}
