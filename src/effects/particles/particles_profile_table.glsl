// Three levels of the table at a time: the first from its source, the others as means of four.

layout(local_size_x = 16, local_size_y = 16) in;

layout(constant_id = 0) const uint source = 0u; // ParticleProfile, or 0: the level above

layout(set = 0, binding = 0) uniform sampler2D source_image; // the host's, or the level above
layout(set = 0, binding = 1) uniform writeonly image2D level_0;
layout(set = 0, binding = 2) uniform writeonly image2D level_1;
layout(set = 0, binding = 3) uniform writeonly image2D level_2;

shared float values[16][16];

// Gradient noise: 0 at the corners of a lattice, with a slope there of length 1 in a direction by chance.
float corner_part(ivec2 corner, vec2 from, uint salt) {
    const uint h = mix_bits(uint(corner.x) * 0x9e3779b1u ^ uint(corner.y) * 0x85ebca77u ^ salt);
    const float angle = float(h >> 8) * (6.2831853 / 16777216.0);
    return dot(vec2(cos(angle), sin(angle)), from);
}

float lattice_noise(vec2 p, uint salt) {
    const vec2 floored = floor(p);
    const vec2 f = p - floored;
    const ivec2 cell = ivec2(floored);
    const vec2 fade = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    const float above = mix(corner_part(cell, f, salt), corner_part(cell + ivec2(1, 0), f - vec2(1, 0), salt), fade.x);
    const float below = mix(corner_part(cell + ivec2(0, 1), f - vec2(0, 1), salt),
                            corner_part(cell + ivec2(1, 1), f - vec2(1, 1), salt), fade.x);
    return mix(above, below, fade.y);
}

// Smoke's density varies by factors: it is the exponential of noise. `p` in the table's largest cells, of which it has
// 16 on a side.
float smoke(vec2 p) {
    float sum = 0.0, share = 1.0;
    for (uint octave = 0u; octave < 3u; ++octave) {
        sum += share * lattice_noise(p * float(1u << octave), octave);
        share *= 0.5;
    }
    return exp2(3.5 * sum);
}

// Neither negative nor so large that halves get inexact.
float clean(float x) { return clamp(sane(x), 0.0, 4096.0); }

// The texture's mean over a square around `at` (0 to 1): as large as this texel, but no smaller than the texture's, which
// is the same as to interpolate.
float texture_mean(vec2 at) {
    const ivec2 size = textureSize(source_image, 0);
    const vec2 reach = max(vec2(size) / profile_side, 1.0) * 0.5;
    const vec2 low = at * vec2(size) - reach, high = at * vec2(size) + reach;
    float sum = 0.0;
    for (float y = floor(low.y); y < high.y; ++y)
        for (float x = floor(low.x); x < high.x; ++x) {
            const vec2 part = min(vec2(x, y) + 1.0, high) - max(vec2(x, y), low);
            const ivec2 texel = clamp(ivec2(x, y), ivec2(0), size - 1);
            sum += part.x * part.y * clean(texelFetch(source_image, texel, 0).x);
        }
    return sum / (4.0 * reach.x * reach.y);
}

float value_of(ivec2 texel) {
    const vec2 at = (vec2(texel) + 0.5) / profile_side;
    if (source == profile_noise)
        return smoke(16.0 * at);
    if (source == profile_texture)
        return texture_mean(at);
    float sum = 0.0;
    [[unroll]] for (int i = 0; i < 4; ++i)
        sum += texelFetch(source_image, 2 * texel + ivec2(i & 1, i >> 1), 0).x;
    return 0.25 * sum;
}

float mean_of_four(uvec2 first, uint step) {
    return 0.25 * (values[first.y][first.x] + values[first.y][first.x + step] + values[first.y + step][first.x] +
                   values[first.y + step][first.x + step]);
}

void main() {
    const uvec2 within = gl_LocalInvocationID.xy;
    const ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    const float value = value_of(texel);
    imageStore(level_0, texel, vec4(value));
    values[within.y][within.x] = value;
    barrier();
    float mean = 0.0;
    const bool is_first = all(equal(within & 1u, uvec2(0)));
    if (is_first) {
        mean = mean_of_four(within, 1u);
        imageStore(level_1, texel / 2, vec4(mean));
    }
    barrier();
    if (is_first)
        values[within.y][within.x] = mean;
    barrier();
    if (all(equal(within & 3u, uvec2(0))))
        imageStore(level_2, texel / 4, vec4(mean_of_four(within, 2u)));
}
