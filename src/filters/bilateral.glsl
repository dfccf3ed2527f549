// Weights of a cross-bilateral filter (Petschnigg et al. 2004, Eisemann and Durand 2004): near in the image and near in
// depth. Depths are planar (linear in screen space on a plane), so that the slope at the centre can be continued.
#ifndef BILATERAL_GLSL
#define BILATERAL_GLSL

// Stands for the planar depth of sky and of what is off the image, in full and in half precision: it differs from
// everything by more than any limit.
const float wide_no_planar = -1.2676506002282294e30; // -2^100: its lowest bits may carry something else

// `bell` is the share by distance in the image; `difference` that of depth in units of what counts as an edge.
float bilateral_weight(float bell, float difference, uint kind) {
    if (kind == 0) // bell
        return bell * exp2(-difference * difference);
    if (kind == 1) // limit
        return abs(difference) <= 1.0 ? bell : 0.0;
    return bell * clamp(1.0 - abs(difference), 0.0, 1.0); // tent
}

// The slope that continues best: the smaller of the two one-sided differences, so that an edge on one side is not taken
// for one.
float continued_slope(float before, float centre, float after, float no_planar) {
    const float a = centre - before, b = after - centre;
    const float slope = abs(a) < abs(b) ? a : b;
    return abs(slope) < -0.5 * no_planar ? slope : 0.0;
}

#endif
