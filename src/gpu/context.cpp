// The library on one device: creation, requirements, memory.
#include "sfumato/context.h"

#include "gpu/context_state.h"

#include <algorithm>

namespace sfumato {

Requirements requirements() {
    Requirements result{};
    result.api_version = VK_API_VERSION_1_1;
    // Outputs have whatever format the host likes: the shaders write without naming one.
    result.features.shaderStorageImageWriteWithoutFormat = VK_TRUE;
    result.queue_flags = VK_QUEUE_COMPUTE_BIT;
    return result;
}

Context::Context(std::unique_ptr<ContextState> state) : state_(std::move(state)) {}
Context::~Context() = default;

Result<std::unique_ptr<Context>> Context::create(const ContextInfo& info) {
    const auto invalid = [](std::string message) { return Error{ErrorCode::invalid_argument, std::move(message)}; };
    if (info.header_version != version)
        return invalid("the host was compiled with Sfumato headers of version " +
                       std::to_string(info.header_version >> 20) + "." +
                       std::to_string(info.header_version >> 10 & 1023) + " but linked to " +
                       std::to_string(SFUMATO_VERSION_MAJOR) + "." + std::to_string(SFUMATO_VERSION_MINOR));
    if (!info.instance || !info.physical_device || !info.device)
        return invalid(std::string("ContextInfo.") +
                       (!info.instance          ? "instance"
                        : !info.physical_device ? "physical_device"
                                                : "device") +
                       " is null");
    if (!info.get_instance_proc_addr || !info.get_device_proc_addr)
        return invalid(std::string("ContextInfo.") +
                       (!info.get_instance_proc_addr ? "get_instance_proc_addr" : "get_device_proc_addr") +
                       " is null: pass the loader's function");
    if (info.frames_in_flight < 1 || info.frames_in_flight > 16)
        return invalid("ContextInfo.frames_in_flight is " + std::to_string(info.frames_in_flight) +
                       "; allowed is 1 to 16");
    auto state = std::make_unique<ContextState>();
    state->info = info;
    auto functions = load_functions(info);
    if (!functions)
        return functions.error();
    state->vk = *functions;
    VkPhysicalDeviceProperties properties{};
    state->vk.vkGetPhysicalDeviceProperties(info.physical_device, &properties);
    if (properties.apiVersion < requirements().api_version)
        return Error{ErrorCode::unsupported, std::string(properties.deviceName) + " has Vulkan " +
                                                 std::to_string(VK_API_VERSION_MAJOR(properties.apiVersion)) + "." +
                                                 std::to_string(VK_API_VERSION_MINOR(properties.apiVersion)) +
                                                 "; Sfumato needs 1.1"};
    constexpr uint32_t invocations = 256; // of a workgroup; Vulkan itself guarantees 128
    if (properties.limits.maxComputeWorkGroupInvocations < invocations)
        return Error{ErrorCode::unsupported, std::string(properties.deviceName) + " runs workgroups of " +
                                                 std::to_string(properties.limits.maxComputeWorkGroupInvocations) +
                                                 "; Sfumato needs 256"};
    state->timestamp_period = properties.limits.timestampPeriod;
    state->max_side = properties.limits.maxImageDimension2D;
    state->largest_buffer = properties.limits.maxStorageBufferRange;
    state->most_bindings.storage_buffers = properties.limits.maxPerStageDescriptorStorageBuffers;
    state->most_bindings.storage_images = properties.limits.maxPerStageDescriptorStorageImages;
    state->most_bindings.sampled_images =
        std::min(properties.limits.maxPerStageDescriptorSampledImages, properties.limits.maxPerStageDescriptorSamplers);
    state->most_bindings.all = properties.limits.maxPerStageResources;
    state->uniform_alignment = std::max<uint64_t>(16, properties.limits.minUniformBufferOffsetAlignment);
    VkPhysicalDeviceSubgroupProperties subgroup{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES};
    VkPhysicalDeviceProperties2 more{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &subgroup};
    state->vk.vkGetPhysicalDeviceProperties2(info.physical_device, &more);
    constexpr VkSubgroupFeatureFlags operations =
        VK_SUBGROUP_FEATURE_BASIC_BIT | VK_SUBGROUP_FEATURE_BALLOT_BIT | VK_SUBGROUP_FEATURE_ARITHMETIC_BIT;
    state->subgroups = info.subgroups && (subgroup.supportedStages & VK_SHADER_STAGE_COMPUTE_BIT) != 0 &&
                       (subgroup.supportedOperations & operations) == operations && subgroup.subgroupSize >= 4;
    state->vk.vkGetPhysicalDeviceMemoryProperties(info.physical_device, &state->memory);
    if (auto created = state->create(); !created)
        return created.error();
    return std::unique_ptr<Context>(new Context(std::move(state)));
}

MemoryUsage Context::memory_usage() const {
    MemoryUsage usage;
    for (const auto& image : state_->transients)
        usage.transients += image->bytes;
    for (const auto& buffer : state_->buffers)
        usage.transients += buffer->bytes;
    usage.histories = state_->history_bytes;
    for (const auto& image : state_->retired)
        usage.histories += image->bytes;
    usage.constants = state_->constant_bytes;
    for (const auto& zero : state_->zeros)
        usage.constants += zero ? zero->bytes : 0;
    return usage;
}

void Context::trim() {
    state_->evict(0);
}

} // namespace sfumato
