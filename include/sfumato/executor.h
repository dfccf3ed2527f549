// Turns plans into Vulkan commands: one executor for one stream of frames (it owns the histories of that stream).
#pragma once

#include "sfumato/context.h"
#include "sfumato/plan.h"

#include <memory>
#include <span>

namespace sfumato {

struct ExecutorState;

class Executor {
  public:
    static Result<std::unique_ptr<Executor>> create(Context& context);
    ~Executor();
    Executor(const Executor&) = delete;
    Executor& operator=(const Executor&) = delete;

    // Records the plan into `commands` (recording, outside a render pass, for a queue with compute). Resource{host, i}
    // is images[i], Resource{host_buffer, i} is buffers[i]. Plans executed with the same `frame_index` share one slot;
    // a new frame_index takes the next slot, whose frame must have finished on the device (Context's frames_in_flight
    // frames ago). Histories swap with frame_index and are cleared when `reset` is set or their extent or format
    // changes; so are states, which do not swap. Earlier compute writes in the same queue are made visible to the plan.
    // Afterwards the outputs are written by the compute stage with shader write access: the host's own barrier to
    // whatever reads them follows from that. Errors: a defective plan, a shader whose bindings do not fit the pass, out
    // of memory. Nothing is recorded then.
    Result<void> execute(VkCommandBuffer commands, const Plan& plan, std::span<const Image> images,
                         uint64_t frame_index, bool reset = false, std::span<const Buffer> buffers = {});

    // GPU times of the newest frame that has finished, in the order of execution; empty until there is one, or without
    // ContextInfo::timestamps. Never waits. Times of neighbouring passes with no barrier between them overlap.
    std::vector<PassTime> times();

  private:
    explicit Executor(std::unique_ptr<ExecutorState> state);
    std::unique_ptr<ExecutorState> state_;
};

} // namespace sfumato
