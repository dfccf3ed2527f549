// The image formats that effects read and write.
#include "core/formats.h"

#include <algorithm>
#include <iterator>

namespace sfumato {

namespace {
constexpr FormatInfo formats[] = {
    {VK_FORMAT_R8_UNORM, "R8_UNORM", 1, 1, false, false},
    {VK_FORMAT_R8G8_UNORM, "R8G8_UNORM", 2, 2, false, false},
    {VK_FORMAT_R8G8_SNORM, "R8G8_SNORM", 2, 2, true, false},
    {VK_FORMAT_R8G8B8A8_UNORM, "R8G8B8A8_UNORM", 4, 4, false, false},
    {VK_FORMAT_R8G8B8A8_SNORM, "R8G8B8A8_SNORM", 4, 4, true, false},
    {VK_FORMAT_R8G8B8A8_SRGB, "R8G8B8A8_SRGB", 4, 4, false, false},
    {VK_FORMAT_B8G8R8A8_UNORM, "B8G8R8A8_UNORM", 4, 4, false, false},
    {VK_FORMAT_B8G8R8A8_SRGB, "B8G8R8A8_SRGB", 4, 4, false, false},
    {VK_FORMAT_A2B10G10R10_UNORM_PACK32, "A2B10G10R10_UNORM", 4, 4, false, false},
    {VK_FORMAT_B10G11R11_UFLOAT_PACK32, "B10G11R11_UFLOAT", 3, 4, false, false},
    {VK_FORMAT_R16_UNORM, "R16_UNORM", 1, 2, false, false},
    {VK_FORMAT_R16_SFLOAT, "R16_SFLOAT", 1, 2, true, false},
    {VK_FORMAT_R16G16_SNORM, "R16G16_SNORM", 2, 4, true, false},
    {VK_FORMAT_R16G16_SFLOAT, "R16G16_SFLOAT", 2, 4, true, false},
    {VK_FORMAT_R16G16B16A16_UNORM, "R16G16B16A16_UNORM", 4, 8, false, false},
    {VK_FORMAT_R16G16B16A16_SNORM, "R16G16B16A16_SNORM", 4, 8, true, false},
    {VK_FORMAT_R16G16B16A16_SFLOAT, "R16G16B16A16_SFLOAT", 4, 8, true, false},
    {VK_FORMAT_R32_SFLOAT, "R32_SFLOAT", 1, 4, true, false},
    {VK_FORMAT_R32G32_SFLOAT, "R32G32_SFLOAT", 2, 8, true, false},
    {VK_FORMAT_R32G32B32A32_SFLOAT, "R32G32B32A32_SFLOAT", 4, 16, true, false},
    {VK_FORMAT_D16_UNORM, "D16_UNORM", 1, 2, false, true},
    {VK_FORMAT_X8_D24_UNORM_PACK32, "X8_D24_UNORM", 1, 4, false, true},
    {VK_FORMAT_D24_UNORM_S8_UINT, "D24_UNORM_S8_UINT", 1, 4, false, true},
    {VK_FORMAT_D32_SFLOAT, "D32_SFLOAT", 1, 4, true, true},
    {VK_FORMAT_D32_SFLOAT_S8_UINT, "D32_SFLOAT_S8_UINT", 1, 4, true, true},
};
} // namespace

const FormatInfo* find_format(VkFormat format) {
    const auto* found =
        std::find_if(std::begin(formats), std::end(formats), [&](const FormatInfo& f) { return f.format == format; });
    return found == std::end(formats) ? nullptr : found;
}

} // namespace sfumato
