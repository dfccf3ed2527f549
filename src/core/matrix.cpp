// The few matrix operations that plans need.
#include "core/matrix.h"

#include <cmath>

namespace sfumato {

Matrix4 multiply(const Matrix4& a, const Matrix4& b) {
    Matrix4 result{};
    for (size_t column = 0; column < 4; ++column)
        for (size_t row = 0; row < 4; ++row) {
            double sum = 0.0;
            for (size_t k = 0; k < 4; ++k)
                sum += double{a[k * 4 + row]} * double{b[column * 4 + k]};
            result[column * 4 + row] = static_cast<float>(sum);
        }
    return result;
}

Matrix4 inverse(const Matrix4& m) {
    const auto at = [&](size_t row, size_t column) { return double{m[column * 4 + row]}; };
    const auto minor = [&](size_t row, size_t column) {
        const size_t r0 = (row + 1) % 3, r1 = (row + 2) % 3, c0 = (column + 1) % 3, c1 = (column + 2) % 3;
        return at(r0, c0) * at(r1, c1) - at(r0, c1) * at(r1, c0); // cyclic, so the sign is right
    };
    const double determinant = at(0, 0) * minor(0, 0) + at(0, 1) * minor(0, 1) + at(0, 2) * minor(0, 2);
    if (determinant == 0.0 || !std::isfinite(determinant))
        return identity_matrix;
    Matrix4 result = identity_matrix;
    for (size_t row = 0; row < 3; ++row) {
        double translation = 0.0;
        for (size_t column = 0; column < 3; ++column) {
            const double value = minor(column, row) / determinant;
            result[column * 4 + row] = static_cast<float>(value);
            translation -= value * at(column, 3);
        }
        result[12 + row] = static_cast<float>(translation);
    }
    return result;
}

Matrix4 unjittered_projection(const Camera& camera, Extent extent) {
    Matrix4 result = camera.projection;
    const float shift_x = 2.0f * camera.jitter[0] / static_cast<float>(extent.width);
    const float shift_y = 2.0f * camera.jitter[1] / static_cast<float>(extent.height);
    for (size_t column = 0; column < 4; ++column) {
        result[column * 4] -= shift_x * result[column * 4 + 3];
        result[column * 4 + 1] -= shift_y * result[column * 4 + 3];
    }
    return result;
}

} // namespace sfumato
