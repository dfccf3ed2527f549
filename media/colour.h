// From scene-linear light to what a display shows.
#pragma once

#include <cstdint>

namespace sfumato::media {

// The sRGB transfer curve, continued in a straight line below 0 and by its power above 1; NaN stays NaN.
float srgb_encode(float linear);
float srgb_decode(float encoded);

// Brightens by `stops` (+1 doubles), then encodes and rounds to 0...255 or 0...65535; NaN becomes 0.
uint8_t display_8bit(float linear, float stops = 0.0f);
uint16_t display_16bit(float linear, float stops = 0.0f);

} // namespace sfumato::media
