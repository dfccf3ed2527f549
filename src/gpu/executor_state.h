// One executor's per-frame slots and histories, and the resolution of a plan's resources to device objects.
#pragma once

#include "gpu/context_state.h"
#include "sfumato/executor.h"

namespace sfumato {

// Uniform buffer memory of one slot, with the descriptor set that binds it at a dynamic offset.
struct ConstantsChunk {
    std::unique_ptr<DeviceBuffer> buffer;
    VkDescriptorSet set = VK_NULL_HANDLE;
    uint64_t used = 0;
};

// What one frame in flight uses: reset when its turn comes again.
struct FrameSlot {
    std::vector<VkDescriptorPool> pools;
    size_t pool = 0; // being allocated from
    std::vector<ConstantsChunk> chunks;
    size_t chunk = 0;
    VkDescriptorPool chunk_pool = VK_NULL_HANDLE; // sets of the chunks live as long as the chunks
    VkQueryPool queries = VK_NULL_HANDLE;
    uint32_t query_count = 0;
    std::vector<std::pair<std::string, uint32_t>> timed; // pass, number of the query at its end
};

struct HistoryImages {
    std::unique_ptr<DeviceImage> images[2];
    uint32_t current = 0;
    bool has_layout[2] = {false, false};
    bool clear_previous = true;
};

// A storage buffer that outlives its frame.
struct StateBuffer {
    std::unique_ptr<DeviceBuffer> buffer;
    bool clear = true;
};

// A plan with its resources resolved, ready to be recorded without anything left that can fail.
struct ResolvedPass {
    const Pipeline* pipeline = nullptr;
    VkDescriptorSet set = VK_NULL_HANDLE;
    VkDescriptorSet constants_set = VK_NULL_HANDLE;
    uint32_t constants_offset = 0;
    Barrier barrier = Barrier::none;
    std::array<uint32_t, 3> groups = {0, 0, 0};
};

struct ResolvedPlan {
    std::vector<DeviceImage*> images;   // by resource
    std::vector<DeviceBuffer*> buffers; // by resource; of the host's there is none
    std::vector<ResolvedPass> passes;
    std::vector<uint32_t> cleared_histories;
    std::vector<uint32_t> cleared_states;
};

struct ExecutorState {
    ContextState* context = nullptr;
    uint64_t id = 0;
    uint64_t serial = 0; // frames begun
    uint64_t frame_index = 0;
    bool has_frame = false;
    std::vector<FrameSlot> slots;
    std::vector<HistoryImages> histories;
    std::vector<StateBuffer> states;

    ~ExecutorState();

    FrameSlot& slot() { return slots[serial % slots.size()]; }
    LastUse use() const { return {id, serial}; }

    Result<void> begin_frame(uint64_t index);
    Result<ResolvedPlan> resolve(const Plan& plan, std::span<const Image> images, std::span<const Buffer> buffers,
                                 bool reset);
    void release(const ResolvedPlan& resolved);
    void record(VkCommandBuffer commands, const Plan& plan, const ResolvedPlan& resolved);

  private:
    Result<void> resolve_history(const Resource& resource, bool reset, ResolvedPlan& resolved);
    Result<void> resolve_state(const Resource& resource, bool reset, ResolvedPlan& resolved);
    Result<void> check_host(const Plan& plan, std::span<const Image> images, std::span<const Buffer> buffers) const;
    Result<void> resolve_transients(const Plan& plan, ResolvedPlan& resolved);
    Result<DeviceImage*> acquire_image(const Resource& resource);
    Result<DeviceBuffer*> acquire_buffer(const Resource& resource);
    Result<void> write_set(const Plan& plan, const Pass& pass, std::span<const Image> images,
                           std::span<const Buffer> buffers, const ResolvedPlan& resolved, ResolvedPass& out);
    Result<VkDescriptorSet> allocate_set(VkDescriptorSetLayout layout);
    Result<void> write_constants(const Pass& pass, ResolvedPass& out);
    Result<void> add_chunk(FrameSlot& slot);
    Result<void> dispatch_size(const Plan& plan, const Pass& pass, ResolvedPass& out) const;
    void record_opening(VkCommandBuffer commands, const Plan& plan, const ResolvedPlan& resolved);
    void record_clears(VkCommandBuffer commands, const Plan& plan, const ResolvedPlan& resolved, bool clear_zeros,
                       std::span<const VkImage> transients);
    void record_pass(VkCommandBuffer commands, const Plan& plan, const Pass& pass, const ResolvedPlan& resolved,
                     const ResolvedPass& pass_state);
    void timestamp(VkCommandBuffer commands, const std::string& pass);
};

} // namespace sfumato
