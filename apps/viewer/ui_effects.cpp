// Panels of effects, made from their parameter tables.
#include "apps/viewer/ui.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <imgui.h>

namespace sfumato::viewer {

namespace {

std::string range_text(const ParameterInfo& info) {
    if (info.kind == ParameterKind::choice)
        return fmt::format("One of {}.", fmt::join(info.choices, ", "));
    if (info.kind == ParameterKind::boolean)
        return "";
    return fmt::format("{} to {}{}{}. Ctrl+click to type a number.", info.minimum, info.maximum, *info.unit ? " " : "",
                       info.unit);
}

// Most values need three digits; small ones must not show as zero.
const char* number_format(double value) {
    return value != 0.0 && std::abs(value) < 1e-3 ? "%.3g" : "%.4g";
}

} // namespace

void Ui::draw_effects() {
    move_.reset();
    for (size_t place = 0; place < model_.effects().size(); ++place)
        draw_effect(place);
    if (move_)
        model_.move_effect(move_->first, move_->second);
}

void Ui::draw_effect(size_t place) {
    EffectSlot& slot = model_.effects()[place];
    const EffectInfo& effect = *slot.link.effect;
    const std::string name = effect.name;
    ImGui::PushID(name.c_str());
    ImGui::Checkbox("##enabled", &slot.enabled);
    log_.mark(name);
    tooltip("Whether the effect runs. Effects run from the top to the bottom.");
    ImGui::SameLine();
    if (ImGui::ArrowButton("##up", ImGuiDir_Up))
        move_ = {place, -1};
    log_.mark(name + " up");
    ImGui::SameLine();
    if (ImGui::ArrowButton("##down", ImGuiDir_Down))
        move_ = {place, 1};
    log_.mark(name + " down");
    ImGui::SameLine();
    ImGui::SetNextItemOpen(slot.enabled, ImGuiCond_Once);
    const bool open = ImGui::TreeNodeEx(name.c_str(), ImGuiTreeNodeFlags_SpanAvailWidth);
    log_.mark(name + " panel");
    tooltip(fmt::format("{}\n\n{}", effect.summary, effect.source));
    if (open) {
        draw_parameters(slot);
        ImGui::TreePop();
    }
    ImGui::PopID();
}

void Ui::draw_parameters(EffectSlot& slot) {
    const EffectInfo& effect = *slot.link.effect;
    const ParameterTable& table = *effect.parameters;
    const std::string shown = slot.link.preset.empty() ? "default" : slot.link.preset;
    ImGui::SetNextItemWidth(ImGui::GetFontSize() * 9.0f);
    if (ImGui::BeginCombo("preset", shown.c_str())) {
        const auto item = [&](const std::string& preset, const char* doc) {
            if (ImGui::Selectable(preset.c_str(), preset == shown))
                static_cast<void>(static_cast<bool>(model_.choose_preset(slot, preset == "default" ? "" : preset)));
            log_.mark(fmt::format("{} preset {}", effect.name, preset));
            tooltip(doc);
        };
        item("default", "What the parameters are without a preset.");
        for (const Preset& preset : table.presets)
            item(preset.name, preset.doc);
        ImGui::EndCombo();
    }
    log_.mark(fmt::format("{} preset", effect.name));
    ImGui::SameLine();
    if (ImGui::SmallButton("reset all"))
        static_cast<void>(static_cast<bool>(model_.choose_preset(slot, slot.link.preset)));
    log_.mark(fmt::format("{} reset all", effect.name));
    tooltip("Every parameter as the preset has it.");
    const auto draw_flagged = [&](uint32_t flag) {
        for (const ParameterInfo& info : table.parameters)
            if ((info.flags & (parameter_advanced | parameter_debug)) == flag)
                draw_parameter(slot, info);
    };
    draw_flagged(0);
    const auto has = [&](uint32_t flag) {
        return std::ranges::any_of(table.parameters, [=](const auto& info) { return (info.flags & flag) != 0; });
    };
    if (has(parameter_advanced) && ImGui::TreeNode("advanced")) {
        draw_flagged(parameter_advanced);
        ImGui::TreePop();
    }
    for (const ParameterInfo& info : table.parameters)
        if (info.flags & parameter_debug)
            draw_parameter(slot, info);
}

void Ui::draw_parameter(EffectSlot& slot, const ParameterInfo& info) {
    const std::string id = fmt::format("{}.{}", slot.link.effect->name, info.name);
    ImGui::PushID(info.name);
    draw_value(slot, info, id);
    const std::string standard = [&] {
        ParameterSet base(*slot.link.effect->parameters);
        info.set(base.data(), model_.preset_value(slot, info));
        return parameter_text(info, base.data());
    }();
    const std::string help = fmt::format("{}\n{}\n{} {}; --set {}={}", info.doc, range_text(info),
                                         slot.link.preset.empty() ? "Default" : "Preset", standard, id,
                                         parameter_text(info, slot.link.parameters.data()));
    tooltip(help);
    ImGui::SameLine();
    const bool changed = model_.is_changed(slot, info);
    ImGui::BeginDisabled(!changed);
    if (ImGui::SmallButton("x"))
        model_.reset_value(slot, info);
    log_.mark(id + " reset");
    tooltip("Back to " + standard);
    ImGui::EndDisabled();
    ImGui::SameLine();
    if (changed)
        ImGui::TextColored({1.0f, 0.85f, 0.5f, 1.0f}, "%s", info.name);
    else
        ImGui::TextUnformatted(info.name);
    tooltip(help);
    if (*info.unit) {
        ImGui::SameLine();
        ImGui::TextDisabled("%s", info.unit);
    }
    ImGui::PopID();
}

bool Ui::draw_value(EffectSlot& slot, const ParameterInfo& info, const std::string& id) {
    double value = info.get(slot.link.parameters.data());
    bool edited = false;
    ImGui::SetNextItemWidth(ImGui::GetFontSize() * 9.0f);
    ImGuiSliderFlags flags = ImGuiSliderFlags_AlwaysClamp | ImGuiSliderFlags_NoRoundToFormat;
    if (info.flags & parameter_logarithmic)
        flags |= ImGuiSliderFlags_Logarithmic;
    switch (info.kind) {
    case ParameterKind::boolean: {
        bool on = value != 0.0;
        edited = ImGui::Checkbox("##value", &on);
        value = on ? 1.0 : 0.0;
        break;
    }
    case ParameterKind::choice: {
        int index = static_cast<int>(value);
        edited = ImGui::Combo("##value", &index, info.choices.data(), static_cast<int>(info.choices.size()));
        value = index;
        break;
    }
    case ParameterKind::integer: {
        int whole = static_cast<int>(value);
        // ImGui's sliders end at half of the integers; and what a slider of a million steps hits is luck.
        if (info.maximum - info.minimum > 1e6)
            edited = ImGui::InputInt("##value", &whole);
        else
            edited = ImGui::SliderInt("##value", &whole, static_cast<int>(info.minimum), static_cast<int>(info.maximum),
                                      "%d", flags);
        value = whole;
        break;
    }
    case ParameterKind::real:
        edited = ImGui::SliderScalar("##value", ImGuiDataType_Double, &value, &info.minimum, &info.maximum,
                                     number_format(value), flags);
        break;
    }
    log_.mark(id);
    if (edited)
        model_.set_value(slot, info, value);
    return edited;
}

} // namespace sfumato::viewer
