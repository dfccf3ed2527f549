// Weights of a cross-bilateral filter (Petschnigg et al. 2004, Eisemann and Durand 2004): near in the image and near in
// depth. Depths are planar (linear in screen space on a plane), so that the slope at the centre can be continued.
#ifndef BILATERAL_GLSL
#define BILATERAL_GLSL

// `offset` in pixels; `w` the tap's and `centre` the pixel's planar depth, `slope` what the pixel's own plane adds a
// pixel; `per_difference` is 1 over the difference that counts as an edge. 0 is sky, which mixes with nothing else.
float bilateral_weight(float offset, float w, float centre, float slope, float per_difference, float gaussian,
                       uint kind) {
    if (w == 0.0 || centre == 0.0)
        return w == centre ? exp2(-gaussian * offset * offset) : 0.0;
    const float difference = abs(w - centre - slope * offset) * per_difference;
    if (kind == 0) // bell
        return exp2(-gaussian * offset * offset - difference * difference);
    const float bell = exp2(-gaussian * offset * offset);
    return bell * (kind == 1 ? float(difference <= 1.0) : max(0.0, 1.0 - difference));
}

// The slope that continues best: the smaller of the two one-sided differences, so that an edge on one side is not taken
// for one.
float continued_slope(float before, float centre, float after) {
    const float a = before == 0.0 ? 3e38 : centre - before, b = after == 0.0 ? 3e38 : after - centre;
    const float slope = abs(a) < abs(b) ? a : b;
    return abs(slope) < 1e38 ? slope : 0.0;
}

#endif
