// Finding scenes by name or path, and what suits them.
#include "apps/cli/render_scene.h"

#include "apps/cli/exit_code.h"
#include "apps/cli/viewpoint.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sfumato::cli {

namespace {

constexpr double default_view_angle = 40.0;
constexpr double turntable_view_angle = 30.0, turntable_elevation = 15.0; // degrees

bool has_model_extension(const std::filesystem::path& path) {
    std::string extension = path.extension().string();
    std::ranges::transform(extension, extension.begin(),
                           [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return extension == ".gltf" || extension == ".glb";
}

// For a file that is not there: the nearest name among the models of its folder.
Error no_such_file(const std::string& name) {
    std::vector<std::string> models;
    std::error_code failed;
    const std::filesystem::path path = name;
    const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
    for (const auto& entry : std::filesystem::directory_iterator(folder, failed))
        if (has_model_extension(entry.path()))
            models.push_back(entry.path().filename().string());
    return input_error(fmt::format("{}: no such file{}", name, did_you_mean(path.filename().string(), models)));
}

Result<SceneChoice> choose_builtin(const SceneOptions& options, const scene::Scene& found) {
    for (const auto& [given, name] :
         {std::pair{!options.animation.empty(), "--animation"},
          std::pair{!options.camera_name.empty(), "--camera-name"}, std::pair{options.no_ground, "--no-ground"}})
        if (given)
            return usage_error(fmt::format("{} is for glTF models, and {} is a built-in scene", name, options.scene));
    SceneChoice choice;
    choice.builtin = &found;
    choice.info = found.info;
    return choice;
}

Error no_such_scene(const std::string& name) {
    std::vector<std::string> names;
    for (const scene::Scene& one : scene::scenes())
        names.push_back(one.info.name);
    const std::string hint = did_you_mean(name, names);
    return usage_error(fmt::format(
        "no scene is called '{}'{}", name,
        hint.empty() ? fmt::format("; there are {}, and paths of .gltf and .glb", fmt::join(names, ", ")) : hint));
}

Result<SceneChoice> choose_model(const SceneOptions& options) {
    if (!options.camera_name.empty() && options.turntable)
        return usage_error("--camera-name and --turntable are two cameras; name one");
    std::error_code failed;
    if (!std::filesystem::exists(options.scene, failed))
        return no_such_file(options.scene);
    auto model = scene::load_model(options.scene);
    if (!model)
        return as_input(model.error());
    SceneChoice choice;
    choice.model = std::move(*model);
    // Messages name the path.
    choice.model.name = options.scene;
    if (options.animation == "none") {
        choice.gltf.animation = scene::none;
    } else if (!options.animation.empty()) {
        const auto found = scene::find_animation(choice.model, options.animation);
        if (!found)
            return found.error();
        choice.gltf.animation = *found;
    }
    choice.gltf.camera = options.camera_name;
    choice.gltf.use_file_camera = !options.turntable;
    if (options.no_ground)
        choice.gltf.ground = false;
    auto facts = scene::gltf_facts(choice.model, choice.gltf);
    if (!facts)
        return facts.error();
    choice.info = facts->info;
    choice.bounds = facts->bounds;
    choice.warnings = facts->warnings;
    return choice;
}

} // namespace

Result<SceneChoice> choose_scene(const SceneOptions& options) {
    const scene::Scene* builtin = scene::find_scene(options.scene);
    if (!builtin && !has_model_extension(options.scene)) {
        std::error_code failed;
        return std::filesystem::is_regular_file(options.scene, failed)
                   ? input_error(fmt::format("{}: models are .gltf or .glb files", options.scene))
                   : no_such_scene(options.scene);
    }
    if (!options.viewpoint.empty()) {
        if (options.turntable || !options.camera_name.empty())
            return usage_error("--viewpoint is a camera, as --turntable and --camera-name are; name one");
        if (auto checked = parse_viewpoint(options.viewpoint, default_view_angle); !checked)
            return checked.error();
    }
    auto choice = builtin ? choose_builtin(options, *builtin) : choose_model(options);
    if (choice)
        choice->viewpoint = options.viewpoint;
    if (choice && options.turntable) {
        choice->turntable_frames = options.turntable_frames;
        choice->info.frames = options.turntable_frames;
        choice->info.key_frame = std::clamp(choice->info.key_frame, 1, options.turntable_frames);
    }
    return choice;
}

Result<std::unique_ptr<scene::SceneSource>> open_scene(SceneChoice& choice, const apps::Device& device,
                                                       Context& context) {
    auto source = choice.builtin ? scene::make_source(context, *choice.builtin)
                                 : scene::make_source(context, device.context_info(), device.queue_flags(),
                                                      std::move(choice.model), choice.gltf);
    if (source && choice.turntable_frames > 0.0)
        (*source)->set_camera(
            scene::turntable((*source)->bounds(), turntable_view_angle, choice.turntable_frames, turntable_elevation));
    if (source && !choice.viewpoint.empty()) {
        const auto view = parse_viewpoint(choice.viewpoint, (*source)->view((*source)->info().key_frame).view_angle);
        if (!view)
            return view.error();
        (*source)->set_camera(standing_at(*view));
    }
    return source;
}

SceneFit fit_of(const SceneChoice& scene) {
    SceneFit fit;
    if (scene.is_model())
        fit.model_radius = scene.bounds.radius;
    return fit;
}

double occlusion_radius(const SceneFit& fit) {
    return fit.model_radius ? 0.5 * *fit.model_radius : scene::OcclusionTruth{}.radius;
}

bool adapt_link(ChainLink& link, const SceneFit& fit) {
    const ParameterSet defaults(*link.effect->parameters);
    const auto adapt = [&](const char* name, const std::string& value) {
        const ParameterInfo* info = link.effect->parameters->find(name);
        if (!info || contains(link.set_by_hand, name) ||
            info->get(link.parameters.data()) != info->get(defaults.data()))
            return false;
        // In range by construction, but for models beyond all measure, whose default stays.
        return static_cast<bool>(set_parameter(*link.effect->parameters, link.parameters.data(), name, value));
    };
    adapt("application", "ambient");
    return fit.model_radius && link.effect->parameters->find("falloff") &&
           adapt("radius", fmt::format("{:.4g}", occlusion_radius(fit)));
}

bool adapt_chain(EffectChain& chain, const ChainOptions& given, const SceneFit& fit) {
    bool chose_radius = false;
    if (given.config.empty())
        for (ChainLink& link : chain)
            chose_radius = adapt_link(link, fit) || chose_radius;
    return chose_radius;
}

} // namespace sfumato::cli
