// GPU timestamps outside the library.
#include "apps/bench/gpu_clock.h"

#include "apps/common/device_choice.h"

namespace sfumato::bench {

Result<std::unique_ptr<GpuClock>> GpuClock::create(const apps::Device& device, uint32_t stamps) {
    if (!device.timestamps())
        return Error{ErrorCode::unsupported, device.name() + " has no timestamps on its compute queue: it cannot be "
                                                             "timed"};
    std::unique_ptr<GpuClock> clock(new GpuClock(device));
    const auto function = [&](const char* name) { return device.functions().GetDeviceProcAddr(device.handle(), name); };
    const auto create = reinterpret_cast<PFN_vkCreateQueryPool>(function("vkCreateQueryPool"));
    clock->destroy_ = reinterpret_cast<PFN_vkDestroyQueryPool>(function("vkDestroyQueryPool"));
    clock->reset_ = reinterpret_cast<PFN_vkCmdResetQueryPool>(function("vkCmdResetQueryPool"));
    clock->write_ = reinterpret_cast<PFN_vkCmdWriteTimestamp>(function("vkCmdWriteTimestamp"));
    clock->results_ = reinterpret_cast<PFN_vkGetQueryPoolResults>(function("vkGetQueryPoolResults"));
    if (!create || !clock->destroy_ || !clock->reset_ || !clock->write_ || !clock->results_)
        return Error{ErrorCode::unsupported, "the driver of " + device.name() + " lacks functions for timestamps"};
    VkPhysicalDeviceProperties properties{};
    device.functions().GetPhysicalDeviceProperties(device.physical_device(), &properties);
    clock->period_ = static_cast<double>(properties.limits.timestampPeriod);
    uint32_t families = 0;
    device.functions().GetPhysicalDeviceQueueFamilyProperties(device.physical_device(), &families, nullptr);
    std::vector<VkQueueFamilyProperties> family(families);
    device.functions().GetPhysicalDeviceQueueFamilyProperties(device.physical_device(), &families, family.data());
    clock->valid_bits_ = family[device.queue_family()].timestampValidBits;
    clock->most_ = stamps;
    VkQueryPoolCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO;
    info.queryType = VK_QUERY_TYPE_TIMESTAMP;
    info.queryCount = stamps;
    if (const VkResult result = create(device.handle(), &info, nullptr, &clock->queries_); result != VK_SUCCESS)
        return apps::vulkan_error(result, "vkCreateQueryPool");
    return clock;
}

GpuClock::~GpuClock() {
    if (queries_ != VK_NULL_HANDLE)
        destroy_(device_.handle(), queries_, nullptr);
}

void GpuClock::reset(VkCommandBuffer commands) {
    reset_(commands, queries_, 0, most_);
    used_ = 0;
}

void GpuClock::stamp(VkCommandBuffer commands) {
    // Bottom of pipe for starts as well: a stamp at the top would be taken while earlier frames still run.
    if (used_ < most_)
        write_(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, queries_, used_++);
}

Result<std::vector<double>> GpuClock::intervals() const {
    std::vector<uint64_t> ticks(used_);
    std::vector<double> times;
    if (used_ < 2)
        return times;
    const VkResult result = results_(device_.handle(), queries_, 0, used_, ticks.size() * 8, ticks.data(), 8,
                                     VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT);
    if (result != VK_SUCCESS)
        return apps::vulkan_error(result, "reading timestamps");
    const uint64_t mask = valid_bits_ >= 64 ? ~uint64_t{0} : (uint64_t{1} << valid_bits_) - 1;
    for (size_t i = 1; i < ticks.size(); ++i)
        times.push_back(static_cast<double>((ticks[i] - ticks[i - 1]) & mask) * period_ * 1e-6);
    return times;
}

} // namespace sfumato::bench
