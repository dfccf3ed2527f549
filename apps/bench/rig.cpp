// Opens the device once for all measurements.
#include "apps/bench/rig.h"

namespace sfumato::bench {
namespace {

template <class Function>
Function device_function(const apps::Device& device, const char* name) {
    return reinterpret_cast<Function>(device.functions().GetDeviceProcAddr(device.handle(), name));
}

} // namespace

Result<std::unique_ptr<Rig>> Rig::create(const RigOptions& options) {
    auto device = apps::Device::create({options.device, options.validation, false});
    if (!device)
        return device.error();
    std::unique_ptr<Rig> rig(new Rig(std::move(*device)));
    // Without it every context would compile the same shaders again; a failure only costs time.
    VkPipelineCacheCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO;
    const auto create = device_function<PFN_vkCreatePipelineCache>(*rig->device_, "vkCreatePipelineCache");
    if (create == nullptr || create(rig->device_->handle(), &info, nullptr, &rig->pipelines_) != VK_SUCCESS)
        rig->pipelines_ = VK_NULL_HANDLE;
    auto context = rig->create_context(2, false);
    if (!context)
        return context.error();
    rig->context_ = std::move(*context);
    auto renderer = scene::SceneRenderer::create(*rig->context_);
    if (!renderer)
        return renderer.error();
    rig->renderer_ = std::move(*renderer);
    return rig;
}

Rig::~Rig() {
    (void)device_->wait_idle();
    renderer_.reset();
    context_.reset();
    const auto destroy = device_function<PFN_vkDestroyPipelineCache>(*device_, "vkDestroyPipelineCache");
    if (pipelines_ != VK_NULL_HANDLE && destroy != nullptr)
        destroy(device_->handle(), pipelines_, nullptr);
}

Result<std::unique_ptr<Context>> Rig::create_context(uint32_t frames_in_flight, bool timestamps, bool subgroups) {
    ContextInfo info = device_->context_info();
    info.frames_in_flight = frames_in_flight;
    info.timestamps = timestamps;
    info.subgroups = subgroups;
    info.pipeline_cache = pipelines_;
    return Context::create(info);
}

Result<void> Rig::render(const scene::Scene& scene, double frame, const scene::RenderOptions& options,
                         const scene::SceneImages& images) {
    auto commands = device_->begin();
    if (!commands)
        return commands.error();
    if (auto recorded = renderer_->record(*commands, scene, frame, options, images, ++rendered_); !recorded)
        return recorded;
    return device_->submit_and_wait();
}

Result<void> Rig::check_validation() const {
    const auto messages = device_->validation_messages();
    if (messages.empty())
        return {};
    return Error{ErrorCode::internal, "the validation layer complains " + std::to_string(messages.size()) +
                                          " times, first: " + messages.front()};
}

} // namespace sfumato::bench
