// The few matrix operations that plans need, in double inside: reprojection takes small differences of large numbers.
#pragma once

#include "sfumato/frame.h"
#include "sfumato/image.h"

namespace sfumato {

Matrix4 multiply(const Matrix4& a, const Matrix4& b);

// Inverse of an affine matrix (last row 0 0 0 1), as world_to_view is; identity where it has none.
Matrix4 inverse(const Matrix4& matrix);

// The camera's projection with its jitter taken out.
Matrix4 unjittered_projection(const Camera& camera, Extent extent);

} // namespace sfumato
