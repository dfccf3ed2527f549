// Depth and reprojection, read off projection matrices alone: perspective, off-centre, orthographic, standard, reversed
// and infinite. View space looks along -Z; clip space is Vulkan's, y down, depth 0…1.
#ifndef CAMERA_GLSL
#define CAMERA_GLSL

// Renderers write 1e10 and the like where nothing was hit; NaN and infinity are sky as well.
const float sky_depth = 1e9;
bool is_sky(float view_depth) { return !(is_finite(view_depth) && view_depth < sky_depth); }

// View depth of a depth buffer's value: clip.z = d clip.w solved for -Z. Infinite where the plane at infinity is.
float view_depth_of(float device_depth, mat4 projection) {
    const float a = projection[2][2], b = projection[3][2]; // clip.z = a Z + b
    const float c = projection[2][3], d = projection[3][3]; // clip.w = c Z + d
    const float slope = a - device_depth * c;
    return slope == 0.0 ? 1e10 : (b - device_depth * d) / slope;
}

// Where the point seen at the middle of `pixel` lies at another time minus where it lies now, in pixels.
// `now` is this frame's projection, `other` takes this frame's view space to the other frame's clip space.
vec2 camera_displacement(mat4 now, mat4 other, float view_depth, ivec2 pixel, vec2 size) {
    const bool perspective = now[2][3] != 0.0;
    const bool sky = is_sky(view_depth);
    if (sky && !perspective)
        return vec2(0); // parallel rays: the sky has no position at all
    const float z = sky ? -1.0 : -view_depth;
    const float w = sky ? 0.0 : 1.0; // sky is a direction
    const vec2 ndc = (vec2(pixel) + 0.5) / size * 2.0 - 1.0;
    const float clip_w = now[2][3] * z + now[3][3] * w;
    const vec4 point = vec4((ndc.x * clip_w - now[2][0] * z - now[3][0] * w) / now[0][0],
                            (ndc.y * clip_w - now[2][1] * z - now[3][1] * w) / now[1][1], z, w);
    const vec4 here = now * point;
    vec4 there = other * point;
    // A point that was behind the camera would come out mirrored: its way is cut where it passes close in front of the
    // camera, and what is left stands in proportion to the time it takes.
    float part = 1.0;
    const float nearest_w = 0.01 * here.w;
    if (there.w < nearest_w) {
        part = (here.w - nearest_w) / (here.w - there.w);
        there = mix(here, there, part);
    }
    const vec2 moved = (there.xy / there.w - ndc) * 0.5 * size;
    return part > 0.0 && is_finite(moved) ? moved / part : vec2(0);
}

#endif
