// IEC 61966-2-1 transfer curve.
#include "colour.h"

#include <algorithm>
#include <cmath>

namespace sfumato::media {

float srgb_encode(float linear) {
    return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1.0f / 2.4f) - 0.055f;
}

float srgb_decode(float encoded) {
    return encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
}

namespace {

float display_value(float linear, float stops, float maximum) {
    const float encoded = srgb_encode(stops == 0.0f ? linear : linear * std::exp2(stops));
    if (std::isnan(encoded))
        return 0.0f;
    return std::round(std::clamp(encoded, 0.0f, 1.0f) * maximum);
}

} // namespace

uint8_t display_8bit(float linear, float stops) {
    return static_cast<uint8_t>(display_value(linear, stops, 255.0f));
}

uint16_t display_16bit(float linear, float stops) {
    return static_cast<uint16_t>(display_value(linear, stops, 65535.0f));
}

} // namespace sfumato::media
