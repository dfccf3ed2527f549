// Analytic scenes as sources of frames.
#include "scene/scene_source.h"
#include "scene/surroundings.h"
#include "scene/vec3.h"

#include <cmath>

namespace sfumato::scene {
namespace {

class AnalyticSource final : public SceneSource {
  public:
    AnalyticSource(std::unique_ptr<SceneRenderer> renderer, const Scene& scene)
        : renderer_(std::move(renderer)), scene_(scene) {}

    const SceneInfo& info() const override { return scene_.info; }
    const Lens& lens() const override { return scene_.camera.lens; }
    Vec3 to_sun() const override { return normalised(scene_.light.to_sun); }
    Vec3 sun() const override { return scene_.light.sun; }
    std::vector<Collider> colliders(double frame) const override { return colliders_of(scene_, frame); }
    View view(double frame) const override { return view_at(scene_, frame); }
    void set_camera(CameraPath path) override { scene_.camera_path = std::move(path); }

    // About the point that the scene's own camera looks at; planes have no end, so distance is the only measure.
    Bounds bounds() const override {
        const Vec3 ahead = scene_.camera.target - scene_.camera.eye;
        return {scene_.camera.target, std::sqrt(dot(ahead, ahead)) * std::sin(radians(scene_.camera.view_angle) / 2.0)};
    }

    Result<void> record(VkCommandBuffer commands, double frame, const RenderOptions& options, const SceneImages& images,
                        uint64_t index) override {
        return renderer_->record(commands, scene_, frame, options, images, index);
    }
    std::vector<PassTime> times() override { return renderer_->times(); }

    bool has_sun_map() const override { return true; }
    Result<void> record_sun_map(VkCommandBuffer commands, double frame, const Image& map, uint64_t index) override {
        const SunCamera sun = sun_camera(scene_.light.to_sun, bounds().centre, bounds().radius);
        Scene seen = scene_;
        seen.camera_path = [view = sun.view](double) { return view; };
        seen.camera.lens = sun.lens;
        SceneImages images;
        images.depth = map;
        return renderer_->record(commands, seen, frame, {}, images, index);
    }

  private:
    std::unique_ptr<SceneRenderer> renderer_;
    Scene scene_;
};

} // namespace

Result<std::unique_ptr<SceneSource>> make_source(Context& context, const Scene& scene) {
    auto renderer = SceneRenderer::create(context);
    if (!renderer)
        return renderer.error();
    return std::unique_ptr<SceneSource>(new AnalyticSource(std::move(*renderer), scene));
}

} // namespace sfumato::scene
