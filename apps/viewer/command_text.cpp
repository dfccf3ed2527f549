// The command line that makes what is seen.
#include "apps/viewer/model.h"

#include <algorithm>
#include <fmt/format.h>

namespace sfumato::viewer {

namespace {

std::string shell_word(const std::string& text) {
    const bool plain = !text.empty() && text.find_first_of(" \t\n\"'\\$`*?;&|<>()[]{}~!#") == std::string::npos;
    if (plain)
        return text;
    std::string result = "'";
    for (const char letter : text)
        result += letter == '\'' ? std::string("'\\''") : std::string(1, letter);
    return result + "'";
}

// What render may choose by the scene unless it is told.
bool depends_on_scene(const ParameterInfo& info) {
    const std::string_view name = info.name;
    return name == "application" || name == "radius";
}

// --effects, --preset and as few --set as there can be.
std::string effects_text(const cli::EffectChain& chain) {
    std::string names, presets, settings;
    for (const cli::ChainLink& link : chain) {
        names += (names.empty() ? "" : ",") + std::string(link.effect->name);
        if (!link.preset.empty())
            presets += fmt::format("{}{}={}", presets.empty() ? "" : ",", link.effect->name, link.preset);
        ParameterSet base(*link.effect->parameters);
        static_cast<void>(static_cast<bool>(apply_preset(base.table(), base.data(), link.preset)));
        for (const ParameterInfo& info : link.effect->parameters->parameters)
            if (depends_on_scene(info) || info.get(base.data()) != info.get(link.parameters.data()))
                settings += fmt::format(" --set {}.{}={}", link.effect->name, info.name,
                                        parameter_text(info, link.parameters.data()));
    }
    return fmt::format(" --effects {}{}{}", names, presets.empty() ? "" : " --preset " + presets, settings);
}

} // namespace

std::string Model::command_line(Extent extent, const std::string& output) const {
    const PictureChoice shown = picture(right);
    std::string outputs;
    const PictureRequest wanted = request(extent);
    static_cast<void>(enabled_chain(&outputs));
    // A PNG holds the picture, or one plane that takes its place; everything else goes into an EXR.
    bool png = shown.id == "result" || shown.id == "before" || shown.id == "frozen";
    for (const cli::ChainLink& link : wanted.chain)
        for (const ImageRole& role : link.effect->images)
            if (shown.id == fmt::format("{}.{}", link.effect->name, role.name)) {
                png = shown.kind == PictureKind::grey || shown.kind == PictureKind::colour;
                outputs = shown.kind == PictureKind::grey ? std::string(role.name) : outputs;
            }
    std::string text = fmt::format("sfumato render {} --frames {} --size {}x{}", shell_word(scene_name), frame_,
                                   extent.width, extent.height);
    if (!scene_options.animation.empty())
        text += " --animation " + shell_word(scene_options.animation);
    if (scene_options.no_ground)
        text += " --no-ground";
    if (samples != 2)
        text += fmt::format(" --samples {}", samples);
    if (wanted.viewpoint)
        text += " --viewpoint " + wanted.viewpoint_text;
    if (!wanted.chain.empty() && shown.id != "before") {
        text += effects_text(wanted.chain) + " --outputs " + outputs;
        if (wanted.preroll > 0)
            text += fmt::format(" --preroll {}", wanted.preroll);
    }
    if (shown.id == "truth" || shown.id == "difference")
        text += truth.kind == TruthKind::occlusion
                    ? fmt::format(" --truth ambient-occlusion --truth-rays {}", truth.rays)
                    : fmt::format(" --truth {}", truth.sub_frames);
    else if (!png)
        text += " --passes";
    std::string path = output;
    if (!png && path.ends_with(".png"))
        path.replace(path.size() - 3, 3, "exr");
    return text + " -o " + shell_word(path);
}

} // namespace sfumato::viewer
