// Conversion between floats and the bytes of pixel formats.
#include "apps/common/pixels.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

namespace sfumato::apps {
namespace {

constexpr PixelFormat pixel_formats[] = {
    {VK_FORMAT_R8_UNORM, "R8_UNORM", 1, ChannelKind::unorm8},
    {VK_FORMAT_R8G8_UNORM, "R8G8_UNORM", 2, ChannelKind::unorm8},
    {VK_FORMAT_R8G8B8A8_UNORM, "R8G8B8A8_UNORM", 4, ChannelKind::unorm8},
    {VK_FORMAT_R8G8B8A8_SNORM, "R8G8B8A8_SNORM", 4, ChannelKind::snorm8},
    {VK_FORMAT_R16_UNORM, "R16_UNORM", 1, ChannelKind::unorm16},
    {VK_FORMAT_R16G16_UNORM, "R16G16_UNORM", 2, ChannelKind::unorm16},
    {VK_FORMAT_R16G16B16A16_UNORM, "R16G16B16A16_UNORM", 4, ChannelKind::unorm16},
    {VK_FORMAT_R16_SFLOAT, "R16_SFLOAT", 1, ChannelKind::half},
    {VK_FORMAT_R16G16_SFLOAT, "R16G16_SFLOAT", 2, ChannelKind::half},
    {VK_FORMAT_R16G16B16A16_SFLOAT, "R16G16B16A16_SFLOAT", 4, ChannelKind::half},
    {VK_FORMAT_R32_SFLOAT, "R32_SFLOAT", 1, ChannelKind::real},
    {VK_FORMAT_R32G32_SFLOAT, "R32G32_SFLOAT", 2, ChannelKind::real},
    {VK_FORMAT_R32G32B32A32_SFLOAT, "R32G32B32A32_SFLOAT", 4, ChannelKind::real},
};

uint32_t channel_bytes(ChannelKind kind) {
    switch (kind) {
    case ChannelKind::unorm8:
    case ChannelKind::snorm8:
        return 1;
    case ChannelKind::unorm16:
    case ChannelKind::half:
        return 2;
    case ChannelKind::real:
        break;
    }
    return 4;
}

uint32_t unorm_from_float(float value, float steps) {
    if (!(value > 0.0f)) // NaN as well
        return 0;
    return static_cast<uint32_t>(std::lround(std::min(value, 1.0f) * steps));
}

int8_t snorm_from_float(float value) {
    return std::isnan(value) ? int8_t{0} : static_cast<int8_t>(std::lround(std::clamp(value, -1.0f, 1.0f) * 127.0f));
}

template <class Channel>
void store(std::byte* target, Channel value) {
    std::memcpy(target, &value, sizeof value);
}

template <class Channel>
Channel load(const std::byte* source) {
    Channel value;
    std::memcpy(&value, source, sizeof value);
    return value;
}

void store_channel(ChannelKind kind, std::byte* target, float value) {
    switch (kind) {
    case ChannelKind::unorm8:
        return store(target, static_cast<uint8_t>(unorm_from_float(value, 255.0f)));
    case ChannelKind::snorm8:
        return store(target, snorm_from_float(value));
    case ChannelKind::unorm16:
        return store(target, static_cast<uint16_t>(unorm_from_float(value, 65535.0f)));
    case ChannelKind::half:
        return store(target, half_from_float(value));
    case ChannelKind::real:
        return store(target, value);
    }
}

// All 65536 halves: reading back is then one look-up a channel.
const std::array<float, 65536>& half_table() {
    static const auto table = [] {
        std::array<float, 65536> values{};
        for (uint32_t half = 0; half < 65536; ++half) {
            const uint32_t sign = (half & 0x8000u) << 16, exponent = half >> 10 & 31u, fraction = half & 1023u;
            uint32_t bits = 0;
            if (exponent == 31) // infinity, NaN
                bits = sign | 0x7f800000u | fraction << 13;
            else if (exponent != 0)
                bits = sign | (exponent + 112u) << 23 | fraction << 13;
            else // zero and denormals: fraction * 2^-24
                bits = sign | std::bit_cast<uint32_t>(std::ldexp(static_cast<float>(fraction), -24));
            values[half] = std::bit_cast<float>(bits);
        }
        return values;
    }();
    return table;
}

float load_channel(ChannelKind kind, const std::byte* source) {
    switch (kind) {
    case ChannelKind::unorm8:
        return static_cast<float>(load<uint8_t>(source)) / 255.0f;
    case ChannelKind::snorm8: // both of the lowest values are -1
        return std::max(static_cast<float>(load<int8_t>(source)) / 127.0f, -1.0f);
    case ChannelKind::unorm16:
        return static_cast<float>(load<uint16_t>(source)) / 65535.0f;
    case ChannelKind::half:
        return float_from_half(load<uint16_t>(source));
    case ChannelKind::real:
        break;
    }
    return load<float>(source);
}

} // namespace

uint32_t PixelFormat::bytes() const {
    return components * channel_bytes(kind);
}

const PixelFormat* find_pixel_format(VkFormat format) {
    const auto* found = std::ranges::find(pixel_formats, format, &PixelFormat::format);
    return found == std::end(pixel_formats) ? nullptr : found;
}

uint16_t half_from_float(float value) {
    const auto bits = std::bit_cast<uint32_t>(value);
    const auto sign = static_cast<uint16_t>(bits >> 16 & 0x8000u);
    const uint32_t magnitude = bits & 0x7fffffffu;
    if (magnitude > 0x7f800000u) // a quiet NaN that keeps the upper bits
        return static_cast<uint16_t>(sign | 0x7e00u | (magnitude >> 13 & 0x3ffu));
    if (magnitude >= 0x477ff000u) // rounds to 65536 or more
        return static_cast<uint16_t>(sign | 0x7c00u);
    if (magnitude < 0x38800000u) { // below 2^-14: a multiple of 2^-24, rounded by the addition
        const float sum = std::bit_cast<float>(magnitude) + 0.5f;
        return static_cast<uint16_t>(sign | (std::bit_cast<uint32_t>(sum) - 0x3f000000u));
    }
    const uint32_t rounded = magnitude + 0xfffu + (magnitude >> 13 & 1u);
    return static_cast<uint16_t>(sign | (rounded - 0x38000000u) >> 13);
}

float float_from_half(uint16_t half) {
    return half_table()[half];
}

void encode_pixels(const PixelFormat& format, std::span<const float> values, uint32_t components,
                   std::span<std::byte> bytes) {
    const uint32_t step = channel_bytes(format.kind);
    const size_t pixels = std::min(values.size() / components, bytes.size() / format.bytes());
    std::byte* target = bytes.data();
    for (size_t pixel = 0; pixel < pixels; ++pixel) {
        const float* source = values.data() + pixel * components;
        for (uint32_t channel = 0; channel < format.components; ++channel, target += step)
            store_channel(format.kind, target, channel < components ? source[channel] : channel == 3 ? 1.0f : 0.0f);
    }
}

std::vector<float> decode_pixels(const PixelFormat& format, std::span<const std::byte> bytes) {
    const uint32_t step = channel_bytes(format.kind);
    std::vector<float> values(bytes.size() / step);
    for (size_t i = 0; i < values.size(); ++i)
        values[i] = load_channel(format.kind, bytes.data() + i * step);
    return values;
}

} // namespace sfumato::apps
