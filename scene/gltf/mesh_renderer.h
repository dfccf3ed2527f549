// Draws a glTF model with everything that SceneImages asks for: rasterised, then brought into the images by compute
// passes that it shares with the analytic scenes. Posing is done on the CPU in double precision.
#pragma once

#include "scene/gltf/mesh_renderer_frame.h"
#include "scene/gltf/mesh_renderer_lights.h"
#include "scene/gltf/mesh_renderer_model.h"
#include "scene/scene_source.h"

#include <functional>

namespace sfumato::scene {

// A model in its surroundings.
struct MeshScene {
    Model model;
    std::function<ModelPose(double frame)> pose; // of the model's nodes
    bool is_still = false;                       // every pose is the same
    Scene view;                                  // name, camera path, lens and light; no primitives
    Bounds casters;                              // of what casts shadows, at every moment
    double reach = 1.0;                          // from their middle to what is farthest, the ground included
    uint32_t ground = none;                      // a node that is below everything and casts no shadow
    bool normals_have_detail = false;            // the normal image shows normal maps
};

// Externally synchronised, for one queue with graphics and compute.
class MeshRenderer {
  public:
    // `scene` is kept by reference. Errors (unsupported): a queue without graphics, a device without the formats;
    // out of memory.
    static Result<std::unique_ptr<MeshRenderer>> create(Context& context, const ContextInfo& info,
                                                        VkQueueFlags queue_flags, const MeshScene& scene);

    // As SceneSource::record, but for the traced images, which record_traced fills in; the options are checked already.
    // The commands of the first call bring the textures to the device: they must be submitted.
    Result<void> record(VkCommandBuffer commands, double frame, const RenderOptions& options, const SceneImages& images,
                        uint64_t index);

    // Copies what the CPU has traced, a pixel each row by row: bent normal in view space and visibility.
    Result<void> record_traced(VkCommandBuffer commands, std::span<const std::array<float, 4>> values,
                               const SceneImages& images, uint64_t index);

    Vec3 to_sun() const { return lights_.to_sun(first_pose_); }
    std::vector<PassTime> times() { return executor_->times(); }

  private:
    // The model at one time, on the device.
    struct Posed {
        double frame = 0.0;
        MeshSlice vertices, lights;
        shared::mat4 shadow_from_world;
        bool has_shadow = false;
    };
    // One frame being recorded.
    struct Recording;

    MeshRenderer(const MeshScene& scene, ModelPose first_pose);
    Result<void> prepare(Context& context, const ContextInfo& info);
    MeshArena& begin(uint64_t index);
    Result<const Posed*> posed(Recording& recording, double frame);
    Result<void> ensure_target(Recording& recording, MeshPass pass);
    Result<void> ensure_means(Recording& recording, size_t count);
    void clear_layouts(const Recording& recording, std::span<const MeshImage> images) const;
    void draw(const Recording& recording, MeshPass pass, const MeshTarget& target, const shared::MeshDraw& constants,
              const std::array<const Posed*, 3>& moments) const;
    shared::MeshDraw draw_constants(const Recording& recording, double frame, double x, double y) const;
    void draw_shadow(Recording& recording, const Posed& moment);
    Result<void> geometry(Recording& recording);
    Result<uint32_t> radiance(Recording& recording, double frame);
    Result<void> sharp(Recording& recording);
    Result<void> truth(Recording& recording);
    Image mean(uint32_t which) const { return means_[which].in(VK_IMAGE_LAYOUT_GENERAL); }

    const MeshScene* scene_;
    ModelPose first_pose_;
    MeshLightRig lights_;
    std::unique_ptr<Executor> executor_;
    // Destroyed from below: what is made from the device goes before it.
    std::unique_ptr<MeshDevice> device_;
    MeshPipelines pipelines_;
    MeshObject<VkSampler> nearest_;
    MeshTarget shadow_map_, light_, geometry_;
    std::vector<MeshImage> means_; // direct and ambient, twice; then colour, twice
    std::unique_ptr<MeshModel> model_;
    std::vector<MeshArena> arenas_; // one a frame in flight
    uint64_t serial_ = 0;
    uint64_t index_ = ~uint64_t{0};
};

} // namespace sfumato::scene
