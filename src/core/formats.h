// The image formats that effects read and write.
#pragma once

#include <cstdint>
#include <vulkan/vulkan_core.h>

namespace sfumato {

struct FormatInfo {
    VkFormat format;
    const char* name;
    uint32_t components;
    uint32_t bytes; // per texel
    bool is_signed; // can hold negative values
    bool is_depth;  // depth attachment format: an input, never an output
};

// nullptr for a format that no effect takes.
const FormatInfo* find_format(VkFormat format);

} // namespace sfumato
