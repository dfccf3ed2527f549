// Opening the Vulkan loader and choosing among the devices: shared by list_devices and Device::create.
#pragma once

#include "apps/common/device.h"

#include <optional>

namespace sfumato::apps {

// A table with GetInstanceProcAddr of libvulkan.so.1. The library stays open: drivers leave threads and exit handlers.
Result<VulkanFunctions> open_loader();

Error vulkan_error(VkResult result, std::string_view what);

// For vkCreateInstance, whose usual failure is a machine without any driver.
Error instance_error(VkResult result);

// Fills in the functions of an instance. Error: one is missing.
Result<void> load_instance_functions(VulkanFunctions& functions, VkInstance instance);

struct Candidate {
    VkPhysicalDevice handle = VK_NULL_HANDLE;
    VkPhysicalDeviceType type = VK_PHYSICAL_DEVICE_TYPE_OTHER;
    uint32_t queue_family = 0;
    DeviceDescription description;
};

// All devices of an instance with their descriptions; `more_flags`: what their queue must be able to do besides what
// the library needs. Error: there is none.
Result<std::vector<Candidate>> candidates(const VulkanFunctions& functions, VkInstance instance,
                                          VkQueueFlags more_flags = 0);

// The best usable candidate that `wanted` (index, part of the name, or empty) names.
Result<Candidate> choose(const std::vector<Candidate>& all, const std::string& wanted);

} // namespace sfumato::apps
