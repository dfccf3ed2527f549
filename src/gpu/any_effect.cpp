// An effect instance: validate, plan, execute.
#include "gpu/context_state.h"
#include "sfumato/effect.h"

namespace sfumato {

AnyEffect::AnyEffect(const EffectInfo& effect, std::unique_ptr<Executor> executor)
    : info_(&effect), executor_(std::move(executor)) {}

Result<std::unique_ptr<AnyEffect>> AnyEffect::create(Context& context, const EffectInfo& effect) {
    auto executor = Executor::create(context);
    if (!executor)
        return executor.error();
    return std::unique_ptr<AnyEffect>(new AnyEffect(effect, std::move(*executor)));
}

Result<void> AnyEffect::record(VkCommandBuffer commands, const Frame& frame, const void* parameters,
                               const void* images) {
    if (auto valid = validate_effect(*info_, frame, parameters, images, true); !valid)
        return valid.error();
    const Plan plan = info_->plan(frame, parameters, images);
    host_images_.clear();
    for (const ImageRole& role : info_->images)
        host_images_.push_back(role.get(const_cast<void*>(images)));
    host_buffers_.clear();
    for (const BufferRole& role : info_->buffers)
        host_buffers_.push_back(role.get(const_cast<void*>(images)));
    return executor_->execute(commands, plan, host_images_, frame.index, frame.reset, host_buffers_);
}

} // namespace sfumato
