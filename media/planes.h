// A picture as separate planes of floats, row after row from the top: what metrics and checks work on.
#pragma once

#include <cstddef>
#include <vector>

namespace sfumato::media {

struct Planes {
    int width = 0;
    int height = 0;
    std::vector<std::vector<float>> channels; // each width * height values

    size_t pixel_count() const { return static_cast<size_t>(width) * static_cast<size_t>(height); }
};

} // namespace sfumato::media
