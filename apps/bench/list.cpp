// What there is to measure, and on what.
#include "apps/bench/commands.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sfumato::bench {
namespace {

Json effect_json(const EffectInfo& effect) {
    Json presets = Json::array();
    for (const Preset& preset : effect.parameters->presets)
        presets.push_back({{"name", preset.name}, {"doc", preset.doc}});
    return {{"name", effect.name},
            {"summary", effect.summary},
            {"scored", adapter_of(effect).truth != nullptr},
            {"presets", presets}};
}

} // namespace

Result<void> list_all(const Output& output) {
    Json json = {{"program", "sfumato-bench"}, {"command", "list"}};
    Table effect_table({"effect", "preset", "what it is"}, 3);
    json["effects"] = Json::array();
    for (const EffectInfo* effect : effects()) {
        json["effects"].push_back(effect_json(*effect));
        for (const Preset& preset : effect->parameters->presets)
            effect_table.add({effect->name, preset.name, preset.doc});
    }
    Table scene_table({"scene", "for", "what it shows"}, 3);
    json["scenes"] = Json::array();
    for (const scene::Scene& scene : scene::scenes()) {
        json["scenes"].push_back({{"name", scene.info.name}, {"doc", scene.info.doc}, {"effects", scene.info.effects}});
        scene_table.add({scene.info.name, fmt::format("{}", fmt::join(scene.info.effects, ", ")), scene.info.doc});
    }
    output.print(effect_table.text() + "\n" + scene_table.text() + "\n");
    json["devices"] = Json::array();
    const auto devices = apps::list_devices();
    if (!devices) {
        // A machine without a device can still tell what the program knows.
        output.print("devices: " + devices.error().message + "\n");
        return output.write(json);
    }
    Table device_table({"device", "name", "type", "Vulkan", "driver", "usable"}, 6);
    for (const apps::DeviceDescription& device : *devices) {
        json["devices"].push_back({{"index", device.index},
                                   {"name", device.name},
                                   {"type", device.type},
                                   {"api_version", device.api_version},
                                   {"driver", device.driver},
                                   {"why_not_usable", device.why_not_usable}});
        device_table.add({std::to_string(device.index), device.name, device.type, device.api_version, device.driver,
                          device.why_not_usable.empty() ? "yes" : device.why_not_usable});
    }
    output.print(device_table.text());
    return output.write(json);
}

} // namespace sfumato::bench
