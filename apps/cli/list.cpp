// sfumato list: what there is.
#include "apps/cli/command.h"
#include "apps/common/device.h"
#include "scene/scene.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <memory>
#include <nlohmann/json.hpp>

namespace sfumato::cli {

namespace {

using Json = nlohmann::ordered_json;

struct ListOptions {
    std::string what;
    std::string effect; // presets and parameters: of this one only
    bool markdown = false;
};

const char* const kinds[] = {"real", "integer", "boolean", "choice"};
const char* const uses[] = {"input", "optional input", "output", "optional output"};

Result<std::vector<const EffectInfo*>> chosen_effects(const std::string& name) {
    if (name.empty())
        return std::vector<const EffectInfo*>(effects().begin(), effects().end());
    if (const EffectInfo* effect = find_effect(name))
        return std::vector<const EffectInfo*>{effect};
    return unknown_effect(name);
}

Result<Json> list_effects(const ListOptions& options) {
    auto chosen = chosen_effects(options.effect);
    if (!chosen)
        return chosen.error();
    Json list = Json::array();
    for (const EffectInfo* effect : *chosen) {
        Json images = Json::array();
        for (const ImageRole& role : effect->images)
            images.push_back({{"name", role.name}, {"use", uses[static_cast<int>(role.use)]}, {"doc", role.doc}});
        list.push_back(
            {{"name", effect->name}, {"summary", effect->summary}, {"source", effect->source}, {"images", images}});
    }
    return list;
}

Result<Json> list_presets(const ListOptions& options) {
    auto chosen = chosen_effects(options.effect);
    if (!chosen)
        return chosen.error();
    Json list = Json::array();
    for (const EffectInfo* effect : *chosen) {
        for (const Preset& preset : effect->parameters->presets) {
            Json overrides = Json::object();
            for (const PresetOverride& item : preset.overrides)
                overrides[item.parameter] = item.value;
            list.push_back(
                {{"effect", effect->name}, {"name", preset.name}, {"doc", preset.doc}, {"overrides", overrides}});
        }
    }
    return list;
}

Result<Json> list_parameters(const ListOptions& options) {
    auto chosen = chosen_effects(options.effect);
    if (!chosen)
        return chosen.error();
    Json list = Json::array();
    for (const EffectInfo* effect : *chosen) {
        const ParameterSet defaults(*effect->parameters);
        for (const ParameterInfo& info : effect->parameters->parameters) {
            Json row = {{"effect", effect->name},
                        {"name", info.name},
                        {"kind", kinds[static_cast<int>(info.kind)]},
                        {"default", parameter_text(info, defaults.data())},
                        {"minimum", info.minimum},
                        {"maximum", info.maximum},
                        {"unit", info.unit},
                        {"doc", info.doc}};
            for (const char* choice : info.choices)
                row["choices"].push_back(choice);
            list.push_back(std::move(row));
        }
    }
    return list;
}

Result<Json> list_devices(const ListOptions&) {
    auto devices = apps::list_devices();
    if (!devices)
        return as_device(devices.error());
    Json list = Json::array();
    for (const apps::DeviceDescription& device : *devices)
        list.push_back({{"index", device.index},
                        {"name", device.name},
                        {"type", device.type},
                        {"vulkan", device.api_version},
                        {"driver", device.driver},
                        {"memory_bytes", device.memory_bytes},
                        {"timestamps", device.timestamps},
                        {"why_not_usable", device.why_not_usable}});
    return list;
}

Result<Json> list_scenes(const ListOptions&) {
    Json list = Json::array();
    for (const scene::Scene& one : scene::scenes())
        list.push_back({{"name", one.info.name},
                        {"doc", one.info.doc},
                        {"frames", one.info.frames},
                        {"key_frame", one.info.key_frame},
                        {"frames_per_second", one.info.frames_per_second},
                        {"effects", one.info.effects}});
    return list;
}

std::string text_of(const Json& row, const char* key) {
    return row.at(key).get<std::string>();
}

std::string effect_line(const Json& row) {
    return fmt::format("{:<20} {}", text_of(row, "name"), text_of(row, "summary"));
}

std::string preset_line(const Json& row) {
    return fmt::format("{:<20} {:<14} {}", text_of(row, "effect"), text_of(row, "name"), text_of(row, "doc"));
}

std::string parameter_line(const Json& row) {
    std::string allowed = "true, false";
    if (row.contains("choices"))
        allowed = fmt::format("{}", fmt::join(row["choices"].get<std::vector<std::string>>(), ", "));
    else if (row["kind"] != "boolean")
        allowed = fmt::format("{} to {}{}{}", row["minimum"].get<double>(), row["maximum"].get<double>(),
                              text_of(row, "unit").empty() ? "" : " ", text_of(row, "unit"));
    return fmt::format("{:<38} {:<15} {}  [{}]", text_of(row, "effect") + "." + text_of(row, "name"),
                       text_of(row, "default"), text_of(row, "doc"), allowed);
}

std::string device_line(const Json& row) {
    const std::string why = text_of(row, "why_not_usable");
    return fmt::format("{}  {}  ({}, Vulkan {}, {}, {:.1f} GiB){}", row["index"].get<int>(), text_of(row, "name"),
                       text_of(row, "type"), text_of(row, "vulkan"), text_of(row, "driver"),
                       static_cast<double>(row["memory_bytes"].get<uint64_t>()) / (1024.0 * 1024.0 * 1024.0),
                       why.empty() ? "" : "  not usable: " + why);
}

std::string scene_line(const Json& row) {
    return fmt::format("{:<20} {} frames  {}", text_of(row, "name"), row["frames"].get<int>(), text_of(row, "doc"));
}

// A cell of a Markdown table: no line break, and no bar that would end it.
std::string cell(const std::string& text) {
    std::string result;
    for (const char c : one_line(text))
        result += c == '|' ? "\\|" : std::string(1, c);
    return result;
}

// What a parameter may be, without its unit.
std::string allowed_cell(const ParameterInfo& info) {
    if (info.kind == ParameterKind::boolean)
        return "`true`, `false`";
    if (info.kind != ParameterKind::choice)
        return fmt::format("{} to {}", info.minimum, info.maximum);
    std::string text;
    for (const char* choice : info.choices)
        text += fmt::format("{}`{}`", text.empty() ? "" : ", ", choice);
    return text;
}

std::string parameter_rows(const EffectInfo& effect) {
    std::string text = "| parameter | default | range or choices | unit | what it does |\n|---|---|---|---|---|\n";
    const ParameterSet defaults(*effect.parameters);
    for (const ParameterInfo& info : effect.parameters->parameters)
        text += fmt::format("| `{}` | `{}` | {} | {} | {} |\n", info.name, parameter_text(info, defaults.data()),
                            allowed_cell(info), cell(info.unit), cell(info.doc));
    return text;
}

std::string preset_rows(const EffectInfo& effect) {
    std::string text = "| preset | what it is | overrides of the defaults |\n|---|---|---|\n";
    for (const Preset& preset : effect.parameters->presets) {
        std::string overrides;
        for (const PresetOverride& item : preset.overrides)
            overrides += fmt::format("{}`{}={}`", overrides.empty() ? "" : " ", item.parameter, item.value);
        text += fmt::format("| `{}` | {} | {} |\n", preset.name, cell(preset.doc), overrides);
    }
    return text;
}

// The tables of an effect's page in the documentation: parameters, then presets.
Outcome run_markdown(const ListOptions& options, Console& console) {
    if (options.what != "parameters")
        return usage_error(fmt::format("--markdown is for 'parameters', not for '{}'", options.what));
    const auto chosen = chosen_effects(options.effect);
    if (!chosen)
        return chosen.error();
    std::string text;
    for (const EffectInfo* effect : *chosen) {
        if (chosen->size() > 1)
            text += fmt::format("## {}\n", effect->name);
        text += fmt::format("\n{}\n{}", parameter_rows(*effect), preset_rows(*effect));
    }
    console.result(text);
    return exit_done;
}

struct Listing {
    const char* name;
    Result<Json> (*make)(const ListOptions&);
    std::string (*line)(const Json&);
};

constexpr Listing listings[] = {
    {"effects", list_effects, effect_line},
    {"presets", list_presets, preset_line},
    {"parameters", list_parameters, parameter_line},
    {"devices", list_devices, device_line},
    {"scenes", list_scenes, scene_line},
};

Outcome run(const ListOptions& options, const Invocation& invocation, Console& console) {
    if (options.markdown && invocation.verbosity.json)
        return usage_error("--json and --markdown exclude each other");
    std::vector<std::string> names;
    for (const Listing& listing : listings) {
        names.emplace_back(listing.name);
        if (options.what != listing.name)
            continue;
        if (options.markdown)
            return run_markdown(options, console);
        const auto list = listing.make(options);
        if (!list)
            return list.error();
        if (invocation.verbosity.json)
            console.result(list->dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
        else
            for (const Json& row : *list)
                console.result(one_line(listing.line(row)));
        return exit_done;
    }
    const std::string hint = did_you_mean(options.what, names);
    return usage_error(fmt::format("cannot list '{}'{}", options.what,
                                   hint.empty() ? fmt::format("; there are {}", fmt::join(names, ", ")) : hint));
}

} // namespace

Command make_list(CLI::App& app) {
    auto options = std::make_shared<ListOptions>();
    app.add_option("WHAT", options->what, "effects, presets, parameters, devices or scenes")->required();
    app.add_option("EFFECT", options->effect, "Only of this effect");
    app.add_flag("--markdown", options->markdown, "Parameters and presets as Markdown tables");
    return [options](const Invocation& invocation, Console& console) { return run(*options, invocation, console); };
}

} // namespace sfumato::cli
