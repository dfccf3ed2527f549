// Recording a resolved plan: one barrier where the plan has one, labels, timestamps, dispatches.
#include "sfumato/executor.h"

#include "gpu/executor_state.h"

#include <algorithm>
#include <limits>

namespace sfumato {

namespace {

constexpr uint32_t queries_per_slot = 256;
// A transient that no plan has asked for in this many frames is freed: long enough for alternating effects.
constexpr uint64_t frames_kept = 16;

VkImageMemoryBarrier to_general(VkImage image, VkAccessFlags access) {
    VkImageMemoryBarrier barrier{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER};
    // The transition itself is a write: what an earlier plan wrote to a pooled image must come first.
    barrier.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT;
    barrier.dstAccessMask = access;
    barrier.oldLayout = VK_IMAGE_LAYOUT_UNDEFINED;
    barrier.newLayout = VK_IMAGE_LAYOUT_GENERAL;
    barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.image = image;
    barrier.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, VK_REMAINING_MIP_LEVELS, 0, VK_REMAINING_ARRAY_LAYERS};
    return barrier;
}

} // namespace

ExecutorState::~ExecutorState() {
    const auto& vk = context->vk;
    const VkDevice device = context->info.device;
    for (FrameSlot& frame : slots) {
        for (VkDescriptorPool pool : frame.pools)
            vk.vkDestroyDescriptorPool(device, pool, nullptr);
        for (ConstantsChunk& chunk : frame.chunks) {
            context->constant_bytes -= chunk.buffer->bytes;
            context->destroy(*chunk.buffer);
        }
        vk.vkDestroyDescriptorPool(device, frame.chunk_pool, nullptr);
        vk.vkDestroyQueryPool(device, frame.queries, nullptr);
    }
    for (HistoryImages& history : histories)
        for (auto& image : history.images)
            if (image) {
                context->history_bytes -= image->bytes;
                context->destroy(*image);
            }
    for (StateBuffer& state : states)
        if (state.buffer) {
            context->history_bytes -= state.buffer->bytes;
            context->destroy(*state.buffer);
        }
    context->executors.erase(id);
}

Result<void> ExecutorState::begin_frame(uint64_t index) {
    if (has_frame && index == frame_index)
        return {};
    // What can fail comes first: a frame that could not begin is begun anew by the next call.
    FrameSlot& frame = slots[(serial + 1) % slots.size()];
    for (VkDescriptorPool pool : frame.pools)
        if (VkResult r = context->vk.vkResetDescriptorPool(context->info.device, pool, 0); r != VK_SUCCESS)
            return vulkan_error("vkResetDescriptorPool", r);
    if (context->info.timestamps && !frame.queries) {
        VkQueryPoolCreateInfo create{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
        create.queryType = VK_QUERY_TYPE_TIMESTAMP;
        create.queryCount = queries_per_slot;
        if (VkResult r = context->vk.vkCreateQueryPool(context->info.device, &create, nullptr, &frame.queries);
            r != VK_SUCCESS)
            return vulkan_error("vkCreateQueryPool", r);
    }
    has_frame = true;
    frame_index = index;
    context->executors[id] = ++serial;
    for (HistoryImages& history : histories)
        history.current = 1 - history.current;
    frame.pool = 0;
    frame.chunk = 0;
    for (ConstantsChunk& chunk : frame.chunks)
        chunk.used = 0;
    frame.query_count = 0;
    frame.timed.clear();
    context->evict(frames_kept);
    return {};
}

void ExecutorState::timestamp(VkCommandBuffer commands, const std::string& pass) {
    FrameSlot& frame = slot();
    if (!frame.queries || frame.query_count == queries_per_slot)
        return;
    context->vk.vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, frame.queries, frame.query_count);
    if (!pass.empty())
        frame.timed.emplace_back(pass, frame.query_count);
    ++frame.query_count;
}

// Brings the plan's images into GENERAL, orders the plan after everything earlier in the queue, clears histories.
void ExecutorState::record_opening(VkCommandBuffer commands, const Plan& plan, const ResolvedPlan& resolved) {
    const auto& vk = context->vk;
    constexpr VkAccessFlags access = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT;
    const bool clear_zeros = !std::exchange(context->zeros_are_clear, true);
    const bool poisons = context->info.poison >= 0;
    const bool clears =
        clear_zeros || poisons || !resolved.cleared_histories.empty() || !resolved.cleared_states.empty();
    const VkAccessFlags all_access = clears ? access | VK_ACCESS_TRANSFER_WRITE_BIT : access;
    std::vector<VkImageMemoryBarrier> images;
    std::vector<VkImage> to_poison;
    // Nothing in a transient outlives its plan, so each plan may discard: a command buffer that was recorded and never
    // submitted leaves no wrong layout behind.
    for (size_t i = 0; i < plan.resources.size(); ++i) {
        if (plan.resources[i].kind != ResourceKind::transient || !resolved.images[i])
            continue;
        const VkImage image = resolved.images[i]->image;
        if (std::find(to_poison.begin(), to_poison.end(), image) != to_poison.end())
            continue;
        to_poison.push_back(image);
        images.push_back(to_general(image, all_access));
    }
    for (const Resource& resource : plan.resources)
        if (resource.kind == ResourceKind::current) {
            HistoryImages& history = histories[resource.index];
            for (int side = 0; side < 2; ++side)
                if (!std::exchange(history.has_layout[side], true))
                    images.push_back(to_general(history.images[side]->image, all_access));
        }
    for (const auto& zero : context->zeros)
        if (clear_zeros)
            images.push_back(to_general(zero->image, all_access));
    // Buffers may have been read as commands by the plan before.
    constexpr VkPipelineStageFlags stages = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT;
    const VkMemoryBarrier memory{VK_STRUCTURE_TYPE_MEMORY_BARRIER, nullptr,
                                 VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT, all_access};
    vk.vkCmdPipelineBarrier(commands, stages | VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT,
                            clears ? stages : VkPipelineStageFlags{VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT}, 0, 1, &memory,
                            0, nullptr, static_cast<uint32_t>(images.size()), images.data());
    if (clears)
        record_clears(commands, plan, resolved, clear_zeros, to_poison);
}

// Zeros where zeros are promised, and with ContextInfo::poison noise in everything that a plan must write itself.
void ExecutorState::record_clears(VkCommandBuffer commands, const Plan& plan, const ResolvedPlan& resolved,
                                  bool clear_zeros, std::span<const VkImage> transients) {
    const auto& vk = context->vk;
    const VkImageSubresourceRange range{VK_IMAGE_ASPECT_COLOR_BIT, 0, VK_REMAINING_MIP_LEVELS, 0, 1};
    const auto clear = [&](VkImage image, float value) {
        VkClearColorValue colour{};
        std::fill(std::begin(colour.float32), std::end(colour.float32), value);
        vk.vkCmdClearColorImage(commands, image, VK_IMAGE_LAYOUT_GENERAL, &colour, 1, &range);
    };
    for (const auto& zero : context->zeros)
        if (clear_zeros)
            clear(zero->image, 0.0f);
    for (const uint32_t index : resolved.cleared_histories) {
        HistoryImages& history = histories[index];
        clear(history.images[1 - history.current]->image, 0.0f);
        history.clear_previous = false;
    }
    for (const uint32_t index : resolved.cleared_states) {
        vk.vkCmdFillBuffer(commands, states[index].buffer->buffer, 0, VK_WHOLE_SIZE, 0);
        states[index].clear = false;
    }
    if (context->info.poison >= 0) {
        // Even patterns are NaN, odd ones huge: what an effect reads without having written shows up as a difference.
        const float value = context->info.poison % 2 == 0 ? std::numeric_limits<float>::quiet_NaN() : 6.0e4f;
        for (const VkImage image : transients)
            clear(image, value);
        for (const Resource& resource : plan.resources)
            if (resource.kind == ResourceKind::current)
                clear(histories[resource.index].images[histories[resource.index].current]->image, value);
        for (size_t i = 0; i < plan.resources.size(); ++i)
            if (plan.resources[i].kind == ResourceKind::buffer && resolved.buffers[i])
                vk.vkCmdFillBuffer(commands, resolved.buffers[i]->buffer, 0, VK_WHOLE_SIZE,
                                   0x01010101u * static_cast<uint32_t>(context->info.poison & 0xff));
    }
    const VkMemoryBarrier cleared{VK_STRUCTURE_TYPE_MEMORY_BARRIER, nullptr, VK_ACCESS_TRANSFER_WRITE_BIT,
                                  VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT};
    vk.vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, 0, 1,
                            &cleared, 0, nullptr, 0, nullptr);
}

void ExecutorState::record_pass(VkCommandBuffer commands, const Plan& plan, const Pass& pass,
                                const ResolvedPlan& resolved, const ResolvedPass& state) {
    const auto& vk = context->vk;
    if (state.barrier != Barrier::none) {
        const bool indirect = state.barrier == Barrier::memory_and_indirect;
        const VkMemoryBarrier memory{
            VK_STRUCTURE_TYPE_MEMORY_BARRIER, nullptr, VK_ACCESS_SHADER_WRITE_BIT,
            VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT |
                (indirect ? VkAccessFlags{VK_ACCESS_INDIRECT_COMMAND_READ_BIT} : VkAccessFlags{0})};
        // The source includes reading commands: a buffer may be written again after it was dispatched from.
        vk.vkCmdPipelineBarrier(
            commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT,
            VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT |
                (indirect ? VkPipelineStageFlags{VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT} : VkPipelineStageFlags{0}),
            0, 1, &memory, 0, nullptr, 0, nullptr);
    }
    vk.vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, state.pipeline->pipeline);
    const VkDescriptorSet sets[] = {state.set, state.constants_set};
    const bool has_constants = state.constants_set != VK_NULL_HANDLE;
    vk.vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, state.pipeline->layout, 0,
                               has_constants ? 2 : 1, sets, has_constants ? 1 : 0, &state.constants_offset);
    if (pass.dispatch.kind == DispatchKind::indirect)
        vk.vkCmdDispatchIndirect(commands, resolved.buffers[pass.dispatch.target]->buffer, pass.dispatch.offset);
    else
        vk.vkCmdDispatch(commands, state.groups[0], state.groups[1], state.groups[2]);
    timestamp(commands, plan.effect + "/" + pass.name);
}

void ExecutorState::record(VkCommandBuffer commands, const Plan& plan, const ResolvedPlan& resolved) {
    const auto& vk = context->vk;
    const auto begin_label = [&](const std::string& name) {
        const VkDebugUtilsLabelEXT label{VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT, nullptr, name.c_str(), {}};
        if (vk.vkCmdBeginDebugUtilsLabelEXT && vk.vkCmdEndDebugUtilsLabelEXT)
            vk.vkCmdBeginDebugUtilsLabelEXT(commands, &label);
    };
    const auto end_label = [&] {
        if (vk.vkCmdBeginDebugUtilsLabelEXT && vk.vkCmdEndDebugUtilsLabelEXT)
            vk.vkCmdEndDebugUtilsLabelEXT(commands);
    };
    begin_label(plan.effect);
    if (slot().queries && slot().query_count == 0)
        vk.vkCmdResetQueryPool(commands, slot().queries, 0, queries_per_slot);
    record_opening(commands, plan, resolved);
    timestamp(commands, "");
    for (size_t i = 0; i < plan.passes.size(); ++i) {
        begin_label(plan.passes[i].name);
        record_pass(commands, plan, plan.passes[i], resolved, resolved.passes[i]);
        end_label();
    }
    end_label();
}

Executor::Executor(std::unique_ptr<ExecutorState> state) : state_(std::move(state)) {}
Executor::~Executor() = default;

Result<std::unique_ptr<Executor>> Executor::create(Context& context) {
    auto state = std::make_unique<ExecutorState>();
    state->context = &context.state();
    state->id = state->context->next_executor++;
    state->slots.resize(state->context->info.frames_in_flight);
    state->context->executors[state->id] = 0;
    return std::unique_ptr<Executor>(new Executor(std::move(state)));
}

Result<void> Executor::execute(VkCommandBuffer commands, const Plan& plan, std::span<const Image> images,
                               uint64_t frame_index, bool reset, std::span<const Buffer> buffers) {
    if (commands == VK_NULL_HANDLE)
        return Error{ErrorCode::invalid_argument, plan.effect + ": the command buffer is null"};
    if (const std::string defect = check_plan(plan); !defect.empty())
        return Error{ErrorCode::internal, defect};
    if (auto begun = state_->begin_frame(frame_index); !begun)
        return begun.error();
    auto resolved = state_->resolve(plan, images, buffers, reset);
    if (!resolved)
        return resolved.error();
    state_->record(commands, plan, *resolved);
    state_->release(*resolved);
    return {};
}

std::vector<PassTime> Executor::times() {
    ExecutorState& state = *state_;
    const auto& vk = state.context->vk;
    // The newest slot whose queries are all there.
    for (uint64_t age = 0; age < state.slots.size() && age < state.serial; ++age) {
        FrameSlot& frame = state.slots[(state.serial - age) % state.slots.size()];
        if (!frame.queries || frame.timed.empty())
            continue;
        std::vector<uint64_t> ticks(frame.query_count);
        const VkResult r = vk.vkGetQueryPoolResults(state.context->info.device, frame.queries, 0, frame.query_count,
                                                    ticks.size() * 8, ticks.data(), 8, VK_QUERY_RESULT_64_BIT);
        if (r != VK_SUCCESS)
            continue;
        std::vector<PassTime> times;
        for (const auto& [pass, query] : frame.timed)
            times.push_back({pass, static_cast<double>(ticks[query] - ticks[query - 1]) *
                                       static_cast<double>(state.context->timestamp_period) * 1e-6});
        return times;
    }
    return {};
}

} // namespace sfumato
