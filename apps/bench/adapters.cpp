// One adapter an effect.
#include "apps/bench/adapters.h"

#include "apps/bench/sources.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

namespace sfumato::bench {
namespace {

double value_of(const ParameterTable& table, const void* parameters, const char* name) {
    const ParameterInfo* info = table.find(name);
    return info ? info->get(parameters) : 0.0;
}

std::string choice_of(const ParameterTable& table, const void* parameters, const char* name) {
    const ParameterInfo* info = table.find(name);
    return info ? parameter_text(*info, parameters) : "";
}

// The shutter's curves as the effect documents them, over 0…1 of the open time.
double triangle(double place) {
    return 1.0 - std::abs(2.0 * place - 1.0);
}
double smooth(double place) {
    const double a = 2.0 * place - 1.0;
    return (1.0 - a * a) * (1.0 - a * a);
}

std::string motion_blur_truth(const ParameterTable& table, const void* parameters, const TruthRequest& request,
                              scene::RenderOptions& options) {
    const auto number = [&](const char* name) { return value_of(table, parameters, name); };
    const auto choice = [&](const char* name) { return choice_of(table, parameters, name); };
    scene::Shutter& shutter = options.shutter;
    const double native = number("shutter");
    const double fixed = native / (number("reference_frame_rate") * static_cast<double>(request.time_step));
    const std::string mode = choice("frame_rate_mode");
    shutter.open = mode == "fixed" ? fixed : mode == "reference" ? std::min(native, fixed) : native;
    shutter.open /= number("generated_frames");
    const std::string position = choice("shutter_position"), curve = choice("shutter_curve");
    shutter.position = position == "start" ? scene::ShutterPosition::start
                       : position == "end" ? scene::ShutterPosition::end
                                           : scene::ShutterPosition::centre;
    shutter.curve = curve == "triangle" ? triangle : curve == "smooth" ? smooth : nullptr;
    if (shutter.open == 0.5 && position == "centre" && curve == "box")
        return "";
    return fmt::format("shutter {:g} {} {}", shutter.open, position, curve);
}

// The view tints still tiles blue, uniform ones green, the rest red.
std::vector<TileClassShare> motion_blur_classes(std::span<const float> rgba) {
    std::array<size_t, 3> counts = {0, 0, 0};
    for (size_t i = 0; i + 3 < rgba.size(); i += 4) {
        const float r = rgba[i], g = rgba[i + 1], b = rgba[i + 2];
        ++counts[b > r && b > g ? 0 : g > r ? 1 : 2];
    }
    const double all = std::max<double>(1.0, static_cast<double>(rgba.size()) / 4.0);
    return {{"still", static_cast<double>(counts[0]) / all},
            {"uniform", static_cast<double>(counts[1]) / all},
            {"full", static_cast<double>(counts[2]) / all}};
}

// One falloff for all presets, so that they are compared with each other and not each with its own idea of the truth.
std::string occlusion_truth(const ParameterTable& table, const void* parameters, const TruthRequest& request,
                            scene::RenderOptions& options) {
    const std::string falloff = request.falloff == "own" ? choice_of(table, parameters, "falloff") : request.falloff;
    options.occlusion.radius = value_of(table, parameters, "radius");
    options.occlusion.falloff = scene::find_falloff(falloff).value_or(scene::Falloff::hard);
    const double usual = value_of(table, ParameterSet(table).data(), "radius");
    std::string text;
    if (options.occlusion.radius != usual)
        text = fmt::format("radius {:g}", options.occlusion.radius);
    if (options.occlusion.falloff != scene::Falloff::hard)
        text += (text.empty() ? "" : " ") + falloff;
    return text;
}

constexpr const char* motion_blur_opt_in[] = {"next_velocity"};
constexpr const char* motion_blur_not_tuned[] = {
    "shutter",          "shutter_position", "shutter_curve", "frame_rate_mode",  "reference_frame_rate",
    "generated_frames", "hdr_weighting",    "layer_1_blend", "layer_1_strength", "layer_2_blend",
    "layer_2_strength", "animate_jitter",   "repair_edges"};

// What is left is what the visibility alone costs.
constexpr const char* occlusion_opt_in[] = {"shadow", "colour", "ambient", "soft_shadow", "bent_normal", "output"};
constexpr const char* occlusion_not_tuned[] = {
    "radius",           "intensity",          "power",         "falloff",        "normals",
    "normal_space",     "guard_band",         "animate_noise", "temporal",       "second_filter",
    "history_position", "history_visibility", "history_time",  "history_length", "history_occluders",
    "application"};

constexpr Adapter adapters[] = {
    {.effect = "motion-blur",
     .feeds = {},
     .opt_in = motion_blur_opt_in,
     .not_tuned = motion_blur_not_tuned,
     .truth = "truth",
     .do_nothing = "colour",
     .truth_options = motion_blur_truth,
     .class_parameter = "debug_view",
     .class_value = "tile-class",
     .classes = motion_blur_classes},
    {.effect = "ambient-occlusion",
     .feeds = {},
     .opt_in = occlusion_opt_in,
     .not_tuned = occlusion_not_tuned,
     .truth = "true_visibility",
     .display_encoded = false,
     .region = "occluded",
     .rest = "open",
     .history = "temporal",
     .truth_options = occlusion_truth},
};

} // namespace

const Adapter& adapter_of(const EffectInfo& effect) {
    static constexpr Adapter none{};
    const auto* found = std::ranges::find_if(
        adapters, [&](const Adapter& adapter) { return std::string_view(adapter.effect) == effect.name; });
    return found == std::end(adapters) ? none : *found;
}

bool is_bound(const Adapter& adapter, const ImageRole& role, std::span<const std::string> opted_in) {
    const std::string_view name = role.name;
    const bool is_opt_in = std::ranges::any_of(adapter.opt_in, [&](const char* optional) { return name == optional; });
    return !is_opt_in || std::ranges::find(opted_in, name) != opted_in.end();
}

std::string plane_of(const Adapter& adapter, const ImageRole& role, std::span<const std::string> opted_in) {
    const std::string_view name = role.name;
    if (!is_bound(adapter, role, opted_in))
        return "";
    for (const Feed& feed : adapter.feeds)
        if (name == feed.role)
            return feed.plane;
    return find_plane(name) ? std::string(name) : "";
}

} // namespace sfumato::bench
