// Weights of the depth-aware enlargement of a half-resolution signal. After the listing in Frictional Games, SSAO and
// Temporal Blur, 2014; its bilinear factor (x - w.x)(y - w.y) is negative for two of four taps as printed, and the
// absolute value is meant.
#ifndef UPSAMPLE_GLSL
#define UPSAMPLE_GLSL

const uint upsample_nearest = 0, upsample_bilinear = 1, upsample_soma = 2, upsample_relative = 3;

// Of four texels; `differences` of depth in units of what counts as an edge.
vec4 upsample_weights(vec4 bilinear, vec4 differences, uint kind) {
    if (kind == upsample_soma) // max(0.00001, 0.1 m - |dz|) * 30 a metre
        return bilinear + 3.0 * max(vec4(0.0001), 1.0 - differences);
    const vec4 alike = clamp(1.0 - 0.5 * differences, 0.0, 1.0); // half as alike at one, not at all at two
    return bilinear * alike * alike;
}

#endif
