// Renders what a request asks for: the scene's images and the chain of effects on them, on one device.
#pragma once

#include "apps/cli/effect_runner.h"
#include "apps/cli/render_file.h"
#include "apps/viewer/model.h"
#include "apps/viewer/open_scene.h"
#include "apps/viewer/statistics.h"

#include <memory>

namespace sfumato::viewer {

class PictureRenderer {
  public:
    static Result<std::unique_ptr<PictureRenderer>> create(apps::Device& device, const SceneOpener& open);
    ~PictureRenderer();

    scene::SceneSource& source() { return *source_; }
    Context& context() { return *context_; }
    apps::Device& device() { return device_; }

    // The picture as the command line makes it: histories begin anew, `preroll` frames before. Waits for the device.
    Result<void> settle(const PictureRequest& request);
    // One more frame of a stream: histories go on, or begin anew with `cut`. `previous` is where a camera that is moved
    // by hand was the frame before. Waits for the device.
    Result<void> follow(const PictureRequest& request, const std::optional<scene::View>& previous, bool cut);

    // By id, see Model::pictures; without effects the result is what was before. Absent if it was not rendered.
    Image picture(const std::string& id) const;
    // The picture's values, interleaved; none if it was not rendered.
    Result<std::vector<float>> read(const std::string& id);
    Result<void> freeze(); // keeps a copy of the result as "frozen"

    std::vector<NamedTime> times();
    // What the result that was rendered last lacks.
    std::vector<cli::EffectShortfall> shortfalls() const;

    // Everything that was rendered last, for a file.
    Result<cli::RenderedFrame> read_back();
    const cli::EffectChain& chain() const { return chain_; }

  private:
    PictureRenderer(apps::Device& device, std::unique_ptr<Context> context)
        : device_(device), context_(std::move(context)) {}
    Result<void> prepare(const PictureRequest& request);
    Result<void> make_images(const PictureRequest& request);
    Result<void> render(const PictureRequest& request, int frame, uint64_t index);
    const apps::HostImage* find(const std::string& id) const;
    Image image(const char* name) const;
    const apps::HostImage* result() const; // after the effects, or null
    Result<void> read_pass(cli::RenderedFrame& frame, const std::string& name, const apps::HostImage& image);

    apps::Device& device_;
    std::unique_ptr<Context> context_;
    std::unique_ptr<scene::SceneSource> source_;
    cli::EffectChain chain_; // the runner looks at the links here
    std::unique_ptr<cli::EffectRunner> runner_;
    cli::FrameReport report_;
    std::map<std::string, apps::HostImage> images_; // of the scene, by pass
    apps::HostImage sun_map_;                       // where an effect asks for one and the scene has it
    apps::HostImage frozen_;
    std::string structure_;
    Extent extent_;
    int frame_ = 0;
    uint64_t count_ = 0;  // frames recorded
    uint64_t stream_ = 0; // of a stream whose time stands still
};

} // namespace sfumato::viewer
