// A host's image as an effect sees it.
#pragma once

#include <cstdint>
#include <vulkan/vulkan_core.h>

namespace sfumato {

// Width and height in pixels.
struct Extent {
    uint32_t width = 0;
    uint32_t height = 0;

    friend bool operator==(const Extent&, const Extent&) = default;
    explicit operator bool() const { return width != 0 && height != 0; }
};

// A plain view of a host image; owns nothing. The view covers one mip level and one array layer of a 2D image.
// Inputs need VK_IMAGE_USAGE_SAMPLED_BIT and a layout of SHADER_READ_ONLY_OPTIMAL, GENERAL or, for depth,
// DEPTH_STENCIL_READ_ONLY_OPTIMAL (view of the depth aspect alone); outputs need STORAGE usage and GENERAL.
// The library never changes the layout: it finds the image in `layout` and leaves it there.
// An image with an extent of 0×0 counts as absent.
struct Image {
    VkImage handle = VK_NULL_HANDLE;
    VkImageView view = VK_NULL_HANDLE;
    VkFormat format = VK_FORMAT_UNDEFINED;
    Extent extent;
    VkImageLayout layout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;

    explicit operator bool() const { return static_cast<bool>(extent); }
};

} // namespace sfumato
