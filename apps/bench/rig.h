// The device with what every measurement shares: a renderer of scenes and a cache of pipelines.
#pragma once

#include "apps/common/device.h"
#include "scene/scene.h"
#include "sfumato/context.h"

#include <cstdint>
#include <memory>
#include <string>

namespace sfumato::bench {

struct RigOptions {
    std::string device;
    bool validation = false;
};

class Rig {
  public:
    static Result<std::unique_ptr<Rig>> create(const RigOptions& options);
    ~Rig();
    Rig(const Rig&) = delete;
    Rig& operator=(const Rig&) = delete;

    apps::Device& device() { return *device_; }
    bool is_cpu() const { return device_->description().type == "cpu"; }

    // A context of its own, so that its memory is that of one effect alone.
    Result<std::unique_ptr<Context>> create_context(uint32_t frames_in_flight, bool timestamps, bool subgroups = true);

    // Renders the images that are present, and waits.
    Result<void> render(const scene::Scene& scene, double frame, const scene::RenderOptions& options,
                        const scene::SceneImages& images);

    // Frees what rendering holds.
    void trim() { context_->trim(); }

    // Error (internal): the validation layer has complained.
    Result<void> check_validation() const;

  private:
    explicit Rig(std::unique_ptr<apps::Device> device) : device_(std::move(device)) {}

    std::unique_ptr<apps::Device> device_;
    VkPipelineCache pipelines_ = VK_NULL_HANDLE;
    std::unique_ptr<Context> context_;
    std::unique_ptr<scene::SceneRenderer> renderer_;
    uint64_t rendered_ = 0;
};

} // namespace sfumato::bench
