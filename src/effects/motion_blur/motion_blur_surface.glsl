// How a pixel's half displacement and depth are stored: in 32 bits as in the talk (velocity in two 8-bit channels, depth
// in two more), or in 64 (two half floats and the depth as it is).

const float still_length = 0.5; // pixels; shorter half displacements are not blurred
const float no_length = 1.0 / 64.0; // pixels; shorter ones are rounding, and count as zero

struct Surface {
    vec2 v;  // half displacement, pixels
    float z; // view depth; sky_depth for sky
};

// 128 is zero and decodes to exactly zero; 1 and 255 are the ends. Depth: a float of five bits of exponent and eleven of
// mantissa, from 2^-12 to 2^20; the step is at most 0.05 % of the depth, which is what a relative comparison wants.
// 65535 is sky and whatever lies beyond.
const uint least_depth = 0x39800000u; // 2^-12 as bits
// Beside 2^23 a float has no fraction, and its low bits are the integer: rounding and conversion are one addition.
const float integer_base = 8388608.0;
const uint integer_base_bits = 0x4b000000u;

// A vector no longer than the radius in steps of 8 bits, -127 to 127.
vec2 steps_8_bit(vec2 v, float radius) {
    return (v * (radius > 0.0 ? 127.0 / radius : 0.0) + (integer_base + 128.0)) - (integer_base + 128.0);
}
vec2 steps_of_8_bit(uint code) {
    return uintBitsToFloat(uvec2(code & 255u, code >> 8 & 255u) | integer_base_bits) - (integer_base + 128.0);
}

// `steps` of steps_8_bit.
uint pack_8_bit(vec2 steps, float z) {
    const uvec2 velocity = floatBitsToUint(steps + (integer_base + 128.0)) - integer_base_bits;
    const uint depth =
        min(floatBitsToUint(max(z, uintBitsToFloat(least_depth))) - least_depth + 0x800u >> 12, 65535u);
    return velocity.x + velocity.y * 256u + depth * 65536u;
}

vec2 unpack_vector_8_bit(uint code, float radius) { return steps_of_8_bit(code) * (radius / 127.0); }

Surface unpack_8_bit(uint code, float radius) {
    Surface s;
    s.v = unpack_vector_8_bit(code, radius);
    const uint depth = code >> 16;
    s.z = depth == 65535u ? sky_depth : uintBitsToFloat((depth << 12) + least_depth);
    return s;
}

uvec2 pack_half(Surface s) { return uvec2(packHalf2x16(s.v), floatBitsToUint(s.z)); }

Surface unpack_half(uvec2 code) { return Surface(unpackHalf2x16(code.x), uintBitsToFloat(code.y)); }

float cross_product(vec2 a, vec2 b) { return a.x * b.y - a.y * b.x; }

// Vectors travel between passes as they are stored: in the low 16 bits packed, in 32 as half floats.
vec2 vector_of(uint code, bool packed, float radius) {
    return packed ? unpack_vector_8_bit(code, radius) : unpackHalf2x16(code);
}
uint zero_vector(bool packed) { return packed ? 0x8080u : 0u; }

// Stands for the second vector of a tile's neighbourhood where motion is even and none is needed. Never a vector: two NaN.
const uint uniform_mark = 0xffffffffu;

// ---- the best of many vectors ----
// Keys are squared lengths, areas and the like: not negative, so that their bits have their order, and the maximum of
// integers is one instruction of a subgroup where that of floats is many. Where vectors share the greatest key, the
// greatest code wins: the result does not depend on the order in which they are looked at.
struct Best {
    uint key;
    uint code;
};

Best better(Best a, Best b) { return b.key > a.key || (b.key == a.key && b.code > a.code) ? b : a; }

Best best_by_length(uint code, vec2 v) { return Best(floatBitsToUint(dot(v, v)), code); }
// By how far a vector reaches to the side of the longest.
Best best_by_width(uint code, vec2 v, vec2 longest) {
    return Best(floatBitsToUint(abs(cross_product(v, longest))), code);
}

// Where all keys are zero the result is `none`, the zero vector.
#ifdef SUBGROUPS
Best subgroup_best(Best mine, uint none) {
    const uint key = subgroupMax(mine.key);
    const uint code = subgroupMax(mine.key == key ? mine.code : 0u);
    return Best(key, key == 0u ? none : code);
}
#endif
