// Frames of a scene on the device: rendered, given to the effects, read back.
#pragma once

#include "apps/cli/effect_runner.h"
#include "apps/cli/render_file.h"
#include "apps/cli/render_particles.h"
#include "apps/cli/render_scene.h"

namespace sfumato::cli {

// The ground truths that are wanted.
struct TruthRequest {
    int sub_frames = 0; // of motion blur; 0: not wanted
    bool occlusion = false;
    scene::OcclusionTruth rays;
};

struct RenderRequest {
    Extent extent;
    TruthRequest truths;
    int samples = 2;
    bool all_passes = false;
    std::string device;
    RolePicture particle_texture; // where the chain uses one
};

class SceneFrames {
  public:
    // All three are kept by reference; opening takes the scene's model.
    SceneFrames(const RenderRequest& request, const EffectChain& chain, SceneChoice& scene)
        : request_(request), chain_(chain), scene_(scene), extent_(request.extent) {}
    ~SceneFrames();

    // Errors are the device's.
    Result<void> open();
    // `restarts`: the frame does not follow on the one before.
    Result<RenderedFrame> render(int number, bool restarts);
    // Of the frame that was rendered last.
    std::vector<EffectShortfall> shortfalls() const { return runner_->shortfalls(report_); }
    const std::string& device_name() const { return device_->name(); }

  private:
    Result<void> make_images();
    Result<void> make_profile();
    Image image(const char* name) const;
    scene::SceneImages scene_images() const;
    RoleImages role_images() const;
    Result<void> read_pass(RenderedFrame& frame, const std::string& name, const apps::HostImage& image);
    Result<RenderedFrame> read_back(int number);

    const RenderRequest& request_;
    const EffectChain& chain_;
    SceneChoice& scene_;
    Extent extent_;
    uint64_t count_ = 0;
    std::unique_ptr<apps::Device> device_;
    std::unique_ptr<EffectRunner> runner_;
    FrameReport report_;
    std::unique_ptr<scene::SceneSource> source_;
    std::map<std::string, apps::HostImage> images_;
    apps::HostImage sun_map_; // where an effect asks for one and the scene has it
    apps::HostImage profile_; // of particles, where they are asked for with one
};

} // namespace sfumato::cli
