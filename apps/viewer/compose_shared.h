// Constants of the viewer's composition, for C++ and GLSL: 4-byte scalars and vec4 only.
#ifndef SFUMATO_VIEWER_COMPOSE_SHARED_H
#define SFUMATO_VIEWER_COMPOSE_SHARED_H

#ifdef __cplusplus
#include <cstdint>
namespace sfumato::viewer::shared {
using uint = uint32_t;
struct alignas(16) vec4 {
    float x = 0.0f, y = 0.0f, z = 0.0f, w = 0.0f;
};
#endif

// As PictureKind counts them.
#define PICTURE_COLOUR 0u
#define PICTURE_GREY 1u
#define PICTURE_DEPTH 2u
#define PICTURE_NORMAL 3u
#define PICTURE_VELOCITY 4u
#define PICTURE_DIFFERENCE 5u
#define PICTURE_GREY_DIFFERENCE 6u

struct ComposeConstants {
    vec4 area;         // left, top, width and height of the picture on the canvas, pixels
    vec4 surroundings; // what the canvas shows beside it, as a display takes it
    float divider;     // canvas x of its middle; left of it is the left picture
    float divider_width;
    float exposure;   // factor on light
    float gain;       // factor on differences; velocities of 64 px over it are saturated
    float near_depth; // shown half as bright as what touches the eye
    uint left_kind;
    uint right_kind;
    uint unused;
};

#ifdef __cplusplus
}
#endif
#endif
