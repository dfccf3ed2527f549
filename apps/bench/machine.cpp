// Copy bandwidth and the cost of an empty dispatch, measured through the library's own executor.
#include "apps/bench/machine.h"

#include "apps/bench/gpu_clock.h"
#include "apps/bench/stopwatch.h"
#include "shaders/machine.h"

#include <algorithm>

namespace sfumato::bench {
namespace {

constexpr VkFormat texel_format = VK_FORMAT_R32G32B32A32_SFLOAT;
constexpr int dispatches = 64;
constexpr int copies = 4;

// Larger than any cache, smaller than a small part of the memory.
Extent copy_extent(Rig& rig) {
    if (rig.is_cpu())
        return {1024, 512};
    const uint64_t row = 8192 * 16;
    const uint64_t rows = rig.device().description().memory_bytes / 24 / row;
    return {8192, static_cast<uint32_t>(std::clamp<uint64_t>(rows, 256, 4096))};
}

Plan copy_plan(const Image& source, const Image& target) {
    Planner planner("machine");
    const ResourceId from = planner.host("source", 0, source);
    const ResourceId to = planner.host("target", 1, target);
    for (int i = 0; i < copies; ++i) {
        Pass& pass = planner.pass("copy", shaders::machine::copy);
        pass.accesses = {{to, AccessKind::write}, {from, AccessKind::fetch}};
        pass.dispatch.target = to;
    }
    return std::move(planner).finish();
}

Plan dispatch_plan(const Image& target) {
    Planner planner("machine");
    const ResourceId to = planner.host("target", 0, target);
    for (int i = 0; i < dispatches; ++i) {
        Pass& pass = planner.pass("nothing", shaders::machine::nothing);
        pass.accesses = {{to, AccessKind::write}};
        pass.dispatch = {DispatchKind::groups, to, 0, 0};
    }
    return std::move(planner).finish();
}

// The median time of several command buffers that `record` fills in.
template <class Record>
Result<double> typical_time(Rig& rig, Record record) {
    auto clock = GpuClock::create(rig.device(), 2);
    if (!clock)
        return clock.error();
    std::vector<double> samples;
    for (uint64_t i = 0; i < (rig.is_cpu() ? 5 : 20); ++i) {
        auto commands = rig.device().begin();
        if (!commands)
            return commands.error();
        (*clock)->reset(*commands);
        (*clock)->stamp(*commands);
        if (auto recorded = record(*commands, i); !recorded)
            return recorded.error();
        (*clock)->stamp(*commands);
        if (auto done = rig.device().submit_and_wait(); !done)
            return done.error();
        const auto times = (*clock)->intervals();
        if (!times)
            return times.error();
        if (i > 0)
            samples.push_back(times->front());
    }
    return statistics(samples).median;
}

Result<double> plan_time(Rig& rig, const Plan& plan, const std::vector<Image>& images) {
    auto context = rig.create_context(2, false);
    if (!context)
        return context.error();
    auto executor = Executor::create(**context);
    if (!executor)
        return executor.error();
    return typical_time(rig, [&](VkCommandBuffer commands, uint64_t index) {
        return (*executor)->execute(commands, plan, images, index);
    });
}

Result<double> transfer_time(Rig& rig, const Image& source, const Image& target) {
    const auto& vk = rig.device().functions();
    return typical_time(rig, [&](VkCommandBuffer commands, uint64_t) -> Result<void> {
        VkImageCopy copy{};
        copy.srcSubresource = copy.dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
        copy.extent = {source.extent.width, source.extent.height, 1};
        VkMemoryBarrier between{};
        between.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
        between.srcAccessMask = between.dstAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
        for (int i = 0; i < copies; ++i) {
            vk.CmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 1,
                                  &between, 0, nullptr, 0, nullptr);
            vk.CmdCopyImage(commands, source.handle, VK_IMAGE_LAYOUT_GENERAL, target.handle, VK_IMAGE_LAYOUT_GENERAL, 1,
                            &copy);
        }
        return {};
    });
}

} // namespace

Result<Machine> measure_machine(Rig& rig) {
    const Extent extent = copy_extent(rig);
    auto source = rig.device().create_image(texel_format, extent);
    auto target = rig.device().create_image(texel_format, extent);
    auto small = rig.device().create_image(texel_format, {1, 1});
    for (const auto* image : {&source, &target, &small})
        if (!*image)
            return image->error();
    const auto compute =
        plan_time(rig, copy_plan(source->image(), target->image()), {source->image(), target->image()});
    if (!compute)
        return compute.error();
    const auto transfer = transfer_time(rig, source->image(), target->image());
    if (!transfer)
        return transfer.error();
    const auto dispatch = plan_time(rig, dispatch_plan(small->image()), {small->image()});
    if (!dispatch)
        return dispatch.error();
    const double bytes = 2.0 * 16.0 * extent.width * extent.height * copies;
    const auto rate = [&](double milliseconds) { return milliseconds > 0.0 ? bytes / (milliseconds * 1e-3) : 0.0; };
    return Machine{rate(*compute), rate(*transfer), *dispatch / dispatches};
}

} // namespace sfumato::bench
