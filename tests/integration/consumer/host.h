// A small renderer as a host would have it: device, queue, images. Nothing here knows Sfumato.
#pragma once

#include <cstdint>
#include <vector>
#include <vulkan/vulkan.h>

struct HostImage {
    VkImage image = VK_NULL_HANDLE;
    VkImageView view = VK_NULL_HANDLE;
    VkDeviceMemory memory = VK_NULL_HANDLE;
    VkFormat format = VK_FORMAT_UNDEFINED;
    uint32_t channels = 0;
};

struct Host {
    static constexpr uint32_t width = 128, height = 72;
    VkInstance instance = VK_NULL_HANDLE;
    VkPhysicalDevice physical_device = VK_NULL_HANDLE;
    VkDevice device = VK_NULL_HANDLE;
    VkQueue queue = VK_NULL_HANDLE;
    VkCommandPool pool = VK_NULL_HANDLE;

    explicit Host(const VkPhysicalDeviceFeatures& features);
    ~Host();
    Host(const Host&) = delete;
    Host& operator=(const Host&) = delete;

    // 32-bit floats, in GENERAL.
    HostImage create_image(uint32_t channels, const std::vector<float>& values);
    std::vector<float> read(const HostImage& image);
    void destroy(HostImage& image);
    VkCommandBuffer begin();
    void submit_and_wait(VkCommandBuffer commands);

  private:
    struct Staging {
        VkBuffer buffer = VK_NULL_HANDLE;
        VkDeviceMemory memory = VK_NULL_HANDLE;
        float* values = nullptr;
    };
    Staging create_staging(VkDeviceSize bytes);
    void destroy(Staging& staging);
    VkDeviceMemory allocate(const VkMemoryRequirements& needs, VkMemoryPropertyFlags flags);
};
