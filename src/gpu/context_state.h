// What a Context owns: the function table, pipelines, pooled images and buffers, and the rules of when they may go.
#pragma once

#include "gpu/functions.h"
#include "gpu/spirv.h"
#include "sfumato/plan.h"

#include <map>
#include <memory>
#include <unordered_map>
#include <vector>

namespace sfumato {

struct Pipeline {
    VkDescriptorSetLayout set_layout = VK_NULL_HANDLE;
    VkPipelineLayout layout = VK_NULL_HANDLE;
    VkPipeline pipeline = VK_NULL_HANDLE;
    std::array<uint32_t, 3> local_size = {1, 1, 1};
    uint64_t integer_samplers = 0; // a bit for every binding
};

// The last frame in which something was used: frame number `serial` of executor `executor`.
struct LastUse {
    uint64_t executor = 0;
    uint64_t serial = 0;
};

struct DeviceImage {
    VkFormat format = VK_FORMAT_UNDEFINED;
    Extent extent;
    uint32_t mips = 1;
    VkImage image = VK_NULL_HANDLE;
    VkDeviceMemory memory = VK_NULL_HANDLE;
    uint64_t bytes = 0;
    std::vector<VkImageView> mip_views;
    VkImageView view = VK_NULL_HANDLE; // all mips
    LastUse last_use;
    bool acquired = false; // by the plan that is being recorded
};

struct DeviceBuffer {
    VkBuffer buffer = VK_NULL_HANDLE;
    VkDeviceMemory memory = VK_NULL_HANDLE;
    uint64_t bytes = 0;
    void* mapped = nullptr;
    LastUse last_use;
    bool acquired = false;
};

struct ContextState {
    ContextInfo info;
    Functions vk;
    VkPhysicalDeviceMemoryProperties memory{};
    float timestamp_period = 1.0f; // nanoseconds a tick
    uint32_t max_side = 4096;      // of a 2D image
    uint64_t uniform_alignment = 256;
    uint64_t largest_buffer = 1 << 27; // that a binding may have
    // What one shader may bind: at the least what Vulkan guarantees.
    struct {
        uint32_t storage_buffers = 4;
        uint32_t storage_images = 4;
        uint32_t sampled_images = 16;
        uint32_t all = 128;
    } most_bindings;
    bool subgroups = false; // arithmetic and ballots in compute shaders, four wide or more
    VkSampler nearest = VK_NULL_HANDLE;
    VkSampler linear = VK_NULL_HANDLE;
    VkDescriptorSetLayout constants_layout = VK_NULL_HANDLE;
    // Bound where an optional input is absent: texels of numbers, of integers.
    std::unique_ptr<DeviceImage> zeros[2];
    bool zeros_are_clear = false;
    std::map<VkFormat, VkFormatFeatureFlags> format_features;
    std::map<std::vector<uint64_t>, Pipeline> pipelines;
    std::vector<std::unique_ptr<DeviceImage>> transients;
    std::vector<std::unique_ptr<DeviceBuffer>> buffers;
    // Histories and states that were replaced but may still be in flight.
    std::vector<std::unique_ptr<DeviceImage>> retired;
    std::vector<std::unique_ptr<DeviceBuffer>> retired_buffers;
    std::unordered_map<uint64_t, uint64_t> executors; // id to the serial of its frame at hand
    uint64_t next_executor = 1;
    uint64_t history_bytes = 0; // states included
    uint64_t constant_bytes = 0;

    ~ContextState();

    Result<void> create();
    Result<std::unique_ptr<DeviceImage>> create_image(const char* name, VkFormat format, Extent extent, uint32_t mips);
    void destroy(DeviceImage& image);
    Result<std::unique_ptr<DeviceBuffer>> create_buffer(uint64_t bytes, VkBufferUsageFlags usage, bool host_visible);
    void destroy(DeviceBuffer& buffer);
    Result<const Pipeline*> pipeline(const Plan& plan, const Pass& pass);
    const Shader& shader_of(const Pass& pass) const {
        return subgroups && !pass.subgroup_shader.code.empty() ? pass.subgroup_shader : pass.shader;
    }

    // What images of the format can be used for, asked of the device once.
    VkFormatFeatureFlags features(VkFormat format);

    // True when the device can no longer be using it.
    bool is_idle(const LastUse& use) const;
    // Destroys idle transients that were not used for `patience` more frames, and idle retired histories.
    void evict(uint64_t patience);
    void name_object(VkObjectType type, uint64_t handle, const std::string& name) const;

  private:
    Result<VkDeviceMemory> allocate(const VkMemoryRequirements& needs, VkMemoryPropertyFlags preferred,
                                    VkMemoryPropertyFlags required);
    Result<void> check_limits(const Pass& pass) const;
    Result<Pipeline> create_pipeline(const Plan& plan, const Pass& pass);
    Result<void> create_views(DeviceImage& image);
    Result<void> create_samplers();
};

VkDescriptorType descriptor_type(AccessKind kind);

} // namespace sfumato
