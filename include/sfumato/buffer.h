// A host's buffer as an effect sees it.
#pragma once

#include <cstdint>
#include <vulkan/vulkan_core.h>

namespace sfumato {

// What `Buffer::offset` must be a multiple of: the largest minStorageBufferOffsetAlignment that Vulkan allows.
inline constexpr VkDeviceSize buffer_alignment = 256;

// A plain view of a range of a host buffer; owns nothing. The buffer needs VK_BUFFER_USAGE_STORAGE_BUFFER_BIT.
// A buffer of 0 bytes counts as absent.
struct Buffer {
    VkBuffer handle = VK_NULL_HANDLE;
    VkDeviceSize offset = 0; // bytes, a multiple of buffer_alignment
    VkDeviceSize bytes = 0;

    explicit operator bool() const { return bytes != 0; }
};

} // namespace sfumato
