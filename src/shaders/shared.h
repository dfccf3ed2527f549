// Types for headers that C++ and GLSL both include: constants structs are laid out alike in both (std140 agrees with
// C++ for 4-byte scalars, vec2, vec4 and mat4; arrays and vec3 do not, and are not used).
#ifndef SFUMATO_SHARED_H
#define SFUMATO_SHARED_H

#ifdef __cplusplus
#include <array>
#include <cstdint>

namespace sfumato::gpu {
struct alignas(8) vec2 {
    float x, y;
};
struct alignas(16) vec4 {
    float x, y, z, w;
};
struct alignas(16) mat4 {
    std::array<float, 16> columns;
};
} // namespace sfumato::gpu
#endif

#endif
