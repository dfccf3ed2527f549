// GPU timestamps outside the library: stamps between commands, read as times between them.
#pragma once

#include "apps/common/device.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace sfumato::bench {

class GpuClock {
  public:
    // `stamps`: most that one command buffer takes. Errors (unsupported): the queue has no timestamps.
    static Result<std::unique_ptr<GpuClock>> create(const apps::Device& device, uint32_t stamps);
    ~GpuClock();
    GpuClock(const GpuClock&) = delete;
    GpuClock& operator=(const GpuClock&) = delete;

    // At the start of a command buffer, before any stamp.
    void reset(VkCommandBuffer commands);

    // The moment when all commands so far have finished.
    void stamp(VkCommandBuffer commands);

    // Milliseconds from each stamp to the next. The command buffer must have finished.
    Result<std::vector<double>> intervals() const;

  private:
    explicit GpuClock(const apps::Device& device) : device_(device) {}

    const apps::Device& device_;
    VkQueryPool queries_ = VK_NULL_HANDLE;
    uint32_t most_ = 0;
    uint32_t used_ = 0;
    uint32_t valid_bits_ = 64;
    double period_ = 1.0; // ns
    PFN_vkDestroyQueryPool destroy_ = nullptr;
    PFN_vkCmdResetQueryPool reset_ = nullptr;
    PFN_vkCmdWriteTimestamp write_ = nullptr;
    PFN_vkGetQueryPoolResults results_ = nullptr;
};

} // namespace sfumato::bench
