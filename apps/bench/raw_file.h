// Frames rendered elsewhere, in a container that needs no library:
//   SFRAW1\n
//   a line for each image: NAME WIDTH HEIGHT CHANNELS float32 little-endian\n
//   an empty line
//   the images' values in the order of the lines, row by row from the top, channels interleaved
// Names: colour (3 or 4 channels, linear), depth (1, linear view depth), velocity and next_velocity (2, pixels a frame,
// +x right, +y down), normal (3, view space), truth (3 or 4; true motion blur), true_visibility (1; true ambient
// occlusion, hard, within truth_radius), and any other name, which is kept but not used.
// Facts are images as well, of one channel: world_to_view and projection are 4x4, row by row, for column vectors, with
// view and clip space as in sfumato/frame.h; previous_world_to_view and previous_projection too; truth_radius is 1x1.
#pragma once

#include "sfumato/image.h"
#include "sfumato/plan.h"
#include "sfumato/result.h"

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace sfumato::bench {

struct RawImage {
    std::string name;
    Extent extent;
    uint32_t channels = 0;
    std::vector<float> values;
};

struct RawFrame {
    std::string path;
    std::vector<RawImage> images;

    const RawImage* find(std::string_view name) const;
};

// Errors (input): not such a file, cut short, sizes out of range, no colour, an image with too few channels.
Result<RawFrame> read_raw_frame(const std::string& path);

// The texel at the nearest place; `factors` (one a channel, or empty) scale the values.
RawImage resized_nearest(const RawImage& image, Extent extent, const std::vector<float>& factors = {});

} // namespace sfumato::bench
