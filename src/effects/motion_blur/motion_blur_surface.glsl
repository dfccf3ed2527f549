// How a pixel's half displacement and depth are stored: in 32 bits as in the talk (velocity in two 8-bit channels, depth
// in two more), or in 64 (two half floats and the depth as it is).

const float still_length = 0.5; // pixels; shorter half displacements are not blurred
const float no_length = 1.0 / 64.0; // pixels; shorter ones are rounding, and count as zero

struct Surface {
    vec2 v;  // half displacement, pixels
    float z; // view depth; sky_depth for sky
};

// 128 is zero and decodes to exactly zero; 1 and 255 are the ends. Depth: 16 bits of its logarithm from 2^-12 to 2^20;
// the step is 0.034 % of the depth anywhere, which is what a relative comparison wants. 65535 is sky.
uint pack_8_bit(Surface s, float radius) {
    const vec2 scaled = radius > 0.0 ? s.v / radius : vec2(0);
    const uvec2 velocity = uvec2(clamp(ivec2(floor(scaled * 127.0 + 0.5)) + 128, ivec2(1), ivec2(255)));
    uint depth = 65535u;
    if (!is_sky(s.z)) {
        const float octave = s.z > 0.0 ? log2(s.z) : -12.0;
        depth = uint(clamp(floor((octave + 12.0) / 32.0 * 65534.0 + 0.5), 0.0, 65534.0));
    }
    return velocity.x | velocity.y << 8 | depth << 16;
}

vec2 unpack_vector_8_bit(uint code, float radius) {
    return (vec2(code & 255u, code >> 8 & 255u) - 128.0) * (radius / 127.0);
}

Surface unpack_8_bit(uint code, float radius) {
    Surface s;
    s.v = unpack_vector_8_bit(code, radius);
    const uint depth = code >> 16;
    s.z = depth == 65535u ? sky_depth : exp2(float(depth) * (32.0 / 65534.0) - 12.0);
    return s;
}

uvec2 pack_half(Surface s) { return uvec2(packHalf2x16(s.v), floatBitsToUint(s.z)); }

Surface unpack_half(uvec2 code) { return Surface(unpackHalf2x16(code.x), uintBitsToFloat(code.y)); }

// An order without ties, so that a reduction in any order finds the same vector: by length, then x, then y.
bool longer(vec2 a, vec2 b) {
    const float la = dot(a, a), lb = dot(b, b);
    return la > lb || (la == lb && (a.x > b.x || (a.x == b.x && a.y > b.y)));
}

float cross_product(vec2 a, vec2 b) { return a.x * b.y - a.y * b.x; }

// Likewise by how far a vector reaches to the side of the longest.
bool wider(vec2 a, vec2 b, vec2 longest) {
    const float wa = abs(cross_product(a, longest)), wb = abs(cross_product(b, longest));
    return wa > wb || (wa == wb && (a.x > b.x || (a.x == b.x && a.y > b.y)));
}
