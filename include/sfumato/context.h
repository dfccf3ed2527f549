// Sfumato on one device of the host: pipelines, image pool and function table, shared by all effects of that device.
#pragma once

#include "sfumato/result.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>
#include <vulkan/vulkan_core.h>

namespace sfumato {

#define SFUMATO_VERSION_MAJOR 0
#define SFUMATO_VERSION_MINOR 1
#define SFUMATO_VERSION_PATCH 0
inline constexpr uint32_t version = SFUMATO_VERSION_MAJOR << 20 | SFUMATO_VERSION_MINOR << 10 | SFUMATO_VERSION_PATCH;

// What the host's device must have: the library asks for nothing else.
struct Requirements {
    uint32_t api_version;                // least VkApplicationInfo::apiVersion and device version
    VkPhysicalDeviceFeatures features;   // to be enabled at vkCreateDevice
    VkQueueFlags queue_flags;            // of the queue that executes the command buffers
    std::vector<const char*> extensions; // device extensions: none
};
Requirements requirements();

// The host's Vulkan objects. All must outlive the Context.
struct ContextInfo {
    VkInstance instance = VK_NULL_HANDLE;
    VkPhysicalDevice physical_device = VK_NULL_HANDLE;
    VkDevice device = VK_NULL_HANDLE;
    PFN_vkGetInstanceProcAddr get_instance_proc_addr = nullptr; // for queries of the physical device
    PFN_vkGetDeviceProcAddr get_device_proc_addr = nullptr;     // for everything else
    uint32_t frames_in_flight = 2;                              // 1…16 frames recorded before the first has finished
    VkPipelineCache pipeline_cache = VK_NULL_HANDLE;            // optional, the host's
    bool timestamps = false;                                    // measure every pass; needs timestampValidBits > 0
    bool labels = false;   // VK_EXT_debug_utils is enabled: name passes and objects for RenderDoc and the like
    bool subgroups = true; // use subgroup arithmetic where the device has it; results are the same bits without
    // For tests: fills new transients and histories with this byte instead of leaving them undefined. -1: off.
    int poison = -1;
    uint32_t header_version = version; // checked against the library that was linked
};

// Device memory held at the moment, in bytes.
struct MemoryUsage {
    uint64_t transients = 0;
    uint64_t histories = 0; // and states
    uint64_t constants = 0; // uniform buffers and other small things
};

// GPU time of one pass in milliseconds.
struct PassTime {
    std::string pass;
    double milliseconds = 0.0;
};

struct ContextState;

// Externally synchronised: one thread at a time, and all its effects are recorded for one queue, in the order of their
// submission. Two contexts are independent. Must outlive its effects; the device must be idle when it is destroyed.
class Context {
  public:
    // Errors: null handles, a missing function, another header version, a device older than Vulkan 1.1.
    static Result<std::unique_ptr<Context>> create(const ContextInfo& info);
    ~Context();
    Context(const Context&) = delete;
    Context& operator=(const Context&) = delete;

    MemoryUsage memory_usage() const;

    // Frees transients that no recorded frame in flight can use. Call after a lasting change of resolution.
    void trim();

    ContextState& state() { return *state_; }

  private:
    explicit Context(std::unique_ptr<ContextState> state);
    std::unique_ptr<ContextState> state_;
};

} // namespace sfumato
