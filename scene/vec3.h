// Arithmetic on Vec3, in double: poses are rounded to float only at the very end.
#pragma once

#include "scene/scene.h"

#include <cmath>
#include <numbers>

namespace sfumato::scene {

inline Vec3 operator+(Vec3 a, Vec3 b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vec3 operator-(Vec3 a, Vec3 b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vec3 operator*(Vec3 a, double s) {
    return {a.x * s, a.y * s, a.z * s};
}
inline double dot(Vec3 a, Vec3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vec3 cross(Vec3 a, Vec3 b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Vec3 normalised(Vec3 a) {
    return a * (1.0 / std::sqrt(dot(a, a)));
}

// Rows of a rotation.
struct Rotation {
    Vec3 x = {1, 0, 0}, y = {0, 1, 0}, z = {0, 0, 1};
};

inline Vec3 operator*(const Rotation& r, Vec3 v) {
    return {dot(r.x, v), dot(r.y, v), dot(r.z, v)};
}

inline Rotation operator*(const Rotation& a, const Rotation& b) {
    const auto row = [&](Vec3 r) { return b.x * r.x + b.y * r.y + b.z * r.z; };
    return {row(a.x), row(a.y), row(a.z)};
}

inline double radians(double degrees) {
    return degrees * (std::numbers::pi / 180.0);
}

// Counter-clockwise seen against the axis.
inline Rotation rotation(Vec3 axis, double degrees) {
    const Vec3 a = normalised(axis);
    const double c = std::cos(radians(degrees)), s = std::sin(radians(degrees)), k = 1.0 - c;
    return {{c + a.x * a.x * k, a.x * a.y * k - a.z * s, a.x * a.z * k + a.y * s},
            {a.y * a.x * k + a.z * s, c + a.y * a.y * k, a.y * a.z * k - a.x * s},
            {a.z * a.x * k - a.y * s, a.z * a.y * k + a.x * s, c + a.z * a.z * k}};
}

} // namespace sfumato::scene
