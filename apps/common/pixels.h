// Conversion between floats and the bytes of the pixel formats that images are uploaded and read back in.
#pragma once

#include "sfumato/result.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>
#include <vulkan/vulkan_core.h>

namespace sfumato::apps {

enum class ChannelKind { unorm8, snorm8, unorm16, half, real };

struct PixelFormat {
    VkFormat format;
    const char* name; // "R16G16_SFLOAT"
    uint32_t components;
    ChannelKind kind;

    uint32_t bytes() const; // of one pixel
};

// One, two and four channels of 8 and 16 bits unorm, half and float, four of 8 bits snorm; nullptr for any other
// format.
const PixelFormat* find_pixel_format(VkFormat format);

// Round to nearest even; infinities and NaN stay what they are, finite values beyond the range become infinity.
uint16_t half_from_float(float value);
float float_from_half(uint16_t half);

// `values` has `components` (1…4) channels a pixel. Channels that the format lacks are dropped, channels that the data
// lack become 0, alpha 1. Unorm clamps to 0…1, snorm to -1…1; both store NaN as 0.
void encode_pixels(const PixelFormat& format, std::span<const float> values, uint32_t components,
                   std::span<std::byte> bytes);

// Interleaved, with the format's own number of channels.
std::vector<float> decode_pixels(const PixelFormat& format, std::span<const std::byte> bytes);

} // namespace sfumato::apps
