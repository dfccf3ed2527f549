// The scene that render shows: a built-in one, or a glTF model from a file, by one face.
#pragma once

#include "apps/cli/effect_chain.h"
#include "apps/common/device.h"
#include "scene/gltf/gltf_source.h"
#include "scene/scene_source.h"

#include <memory>
#include <optional>
#include <string>

namespace sfumato::cli {

// As the user typed them.
struct SceneOptions {
    std::string scene;       // a name, or the path of a .gltf or .glb
    std::string animation;   // name, number or `none`; "": the first
    std::string camera_name; // of the file; "": the first, or a view of the bounds
    std::string viewpoint;   // "": the scene's own camera, see parse_viewpoint
    bool no_ground = false;
    bool turntable = false;
    int turntable_frames = 96;
};

// What is known without a device.
struct SceneChoice {
    const scene::Scene* builtin = nullptr;
    scene::Model model; // if it is no built-in one
    scene::GltfOptions gltf;
    scene::SceneInfo info;
    scene::Bounds bounds;              // of a model
    std::vector<std::string> warnings; // what of a model is not shown
    double turntable_frames = 0.0;
    std::string viewpoint;

    bool is_model() const { return builtin == nullptr; }
};

// Errors: usage for names that do not exist and options that do not fit, input for files.
Result<SceneChoice> choose_scene(const SceneOptions& options);

// On the device; takes the choice's model.
Result<std::unique_ptr<scene::SceneSource>> open_scene(SceneChoice& choice, const apps::Device& device,
                                                       Context& context);

// What of a scene decides over defaults.
struct SceneFit {
    std::optional<double> model_radius; // of a model's bounds, scene units
};
SceneFit fit_of(const SceneChoice& scene);

// What fits a rendered scene better than an effect's own defaults, which are for files: occlusion darkens the ambient
// light alone, since that is at hand, and reaches half of a model's radius, whatever its size. What was given by hand
// or by a preset stays. True if a radius was chosen.
bool adapt_link(ChainLink& link, const SceneFit& fit);
// The same for all of them; what comes from a configuration file is whole, and stays.
bool adapt_chain(EffectChain& chain, const ChainOptions& given, const SceneFit& fit);
double occlusion_radius(const SceneFit& fit); // scene units

} // namespace sfumato::cli
