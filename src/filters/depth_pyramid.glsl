// A pyramid of view depths, and the exact place on the screen that each of its texels was taken from.
//
// Mips pick one of four depths on a rotated grid (McGuire, Mara, Luebke, Scalable Ambient Obscurance, HPG 2012, 2.3): no
// depth is invented, and since the picked place is known, taps on a plane stay on that plane at any level. The child of
// texel q is 2q + (q.y & 1, q.x & 1), and the bits swap places from level to level: the texel at the bottom is
// q * 2^m + A (q.y & 1, q.x & 1) + B (q.x & 1, q.y & 1), with A = 1, 10, 101, 1010 … in binary and B what A lacks.
// A cheaper kind picks the texel right and below of the middle of its block, which is simply (q << m) + (1 << m >> 1).
#ifndef DEPTH_PYRAMID_GLSL
#define DEPTH_PYRAMID_GLSL

const int last_mip = 5;

// Sky in the pyramid, exact in half precision's range of exponents and beyond what cameras see.
const float pyramid_sky = 1073741824.0; // 2^30
bool is_pyramid_sky(float z) { return z >= sky_depth; }

// The texel of the finest level that texel q of level m was picked from.
ivec2 rotated_base(ivec2 q, int m) {
    const int all = (1 << m) - 1;
    const int a = ((m & 1) != 0 ? 0x15 : 0x2a) & all;
    const ivec2 bits = q & 1;
    return (q << m) + a * bits.yx + (all - a) * bits;
}

// Which of the four full-resolution depths a half-resolution texel stands for, kept in the two lowest bits.
float with_choice(float z, int choice) { return uintBitsToFloat((floatBitsToUint(z) & ~3u) | uint(choice)); }
ivec2 choice_of(float z) {
    const int choice = int(floatBitsToUint(z) & 3u);
    return ivec2(choice & 1, choice >> 1);
}

#endif
