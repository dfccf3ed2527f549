// Plans and executes a scene's frames.
#include "scene/scene.h"

namespace sfumato::scene {

SceneRenderer::SceneRenderer(std::unique_ptr<Executor> executor) : executor_(std::move(executor)) {}

Result<std::unique_ptr<SceneRenderer>> SceneRenderer::create(Context& context) {
    auto executor = Executor::create(context);
    if (!executor)
        return executor.error();
    return std::unique_ptr<SceneRenderer>(new SceneRenderer(std::move(*executor)));
}

Result<void> SceneRenderer::record(VkCommandBuffer commands, const Scene& scene, double frame,
                                   const RenderOptions& options, const SceneImages& images, uint64_t index) {
    const auto plan = plan_scene(scene, frame, options, images);
    if (!plan)
        return plan.error();
    return executor_->execute(commands, *plan, host_images(images), index);
}

} // namespace sfumato::scene
