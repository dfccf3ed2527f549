// Effects by name, presets and single settings.
#include "apps/cli/effect_chain.h"

#include "apps/cli/exit_code.h"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sfumato::cli {

bool contains(const std::vector<std::string>& list, std::string_view name) {
    return std::ranges::find(list, name) != list.end();
}

std::string did_you_mean(std::string_view name, const std::vector<std::string>& candidates) {
    const std::string near = nearest_name(name, candidates);
    return near.empty() ? "" : fmt::format("; did you mean '{}'?", near);
}

std::vector<std::string> effect_names() {
    std::vector<std::string> names;
    for (const EffectInfo* effect : effects())
        names.emplace_back(effect->name);
    return names;
}

Error unknown_effect(std::string_view name) {
    const std::string hint = did_you_mean(name, effect_names());
    return usage_error(
        fmt::format("no effect is called '{}'{}", name,
                    hint.empty() ? fmt::format("; there are {}", fmt::join(effect_names(), ", ")) : hint));
}

namespace {

std::vector<std::string> split(std::string_view text, char separator) {
    std::vector<std::string> parts;
    while (true) {
        const size_t end = text.find(separator);
        parts.emplace_back(text.substr(0, end));
        if (end == std::string_view::npos)
            return parts;
        text.remove_prefix(end + 1);
    }
}

ChainLink* find_link(EffectChain& chain, std::string_view name) {
    const auto found =
        std::find_if(chain.begin(), chain.end(), [&](const auto& link) { return link.effect->name == name; });
    return found == chain.end() ? nullptr : &*found;
}

std::vector<std::string> names_of(const EffectChain& chain) {
    std::vector<std::string> names;
    for (const ChainLink& link : chain)
        names.emplace_back(link.effect->name);
    return names;
}

// For a name that is an effect, but not one of this run, or no effect at all.
Error not_in_chain(const EffectChain& chain, std::string_view name, std::string_view where) {
    if (find_effect(name))
        return usage_error(fmt::format("{}: '{}' is not one of the effects of this run, {}", where, name,
                                       fmt::join(names_of(chain), ", ")));
    return usage_error(fmt::format("{}: {}", where, unknown_effect(name).message));
}

Result<EffectChain> parse_effects(const std::string& text) {
    EffectChain chain;
    for (const std::string& name : split(text, ',')) {
        const EffectInfo* effect = find_effect(name);
        if (!effect)
            return unknown_effect(name);
        // Settings name an effect, not its place.
        if (find_link(chain, name))
            return usage_error(fmt::format("effect '{}' is named twice", name));
        chain.push_back({effect, "", ParameterSet(*effect->parameters)});
    }
    return chain;
}

// A preset replaces what the configuration said: it stands for a whole look.
Result<void> apply_presets(EffectChain& chain, const std::string& text) {
    if (text.empty())
        return {};
    for (const std::string& item : split(text, ',')) {
        const size_t equals = item.find('=');
        if (equals == std::string::npos && text != item)
            return usage_error(fmt::format("--preset {}: several presets are written EFFECT=NAME,EFFECT=NAME", text));
        const std::string preset = equals == std::string::npos ? item : item.substr(equals + 1);
        ChainLink* one = equals == std::string::npos ? nullptr : find_link(chain, item.substr(0, equals));
        if (equals != std::string::npos && !one)
            return not_in_chain(chain, item.substr(0, equals), fmt::format("--preset {}", item));
        for (ChainLink& link : chain) {
            if (one && one != &link)
                continue;
            if (auto applied = apply_preset(*link.effect->parameters, link.parameters.data(), preset); !applied)
                return usage_error(fmt::format("--preset {}: {}", item, applied.error().message));
            link.preset = preset;
        }
    }
    return {};
}

Result<void> apply_setting(EffectChain& chain, const std::string& setting) {
    const auto wrong = [&](const std::string& why) { return usage_error(fmt::format("--set {}: {}", setting, why)); };
    const size_t equals = setting.find('=');
    if (equals == std::string::npos)
        return wrong("write effect.parameter=value, as in motion-blur.taps=20");
    const std::string name = setting.substr(0, equals);
    const size_t dot = name.find('.');
    ChainLink* link = &chain.front();
    if (dot != std::string::npos)
        link = find_link(chain, name.substr(0, dot));
    else if (chain.size() > 1)
        return wrong(fmt::format("say which effect it is for, as in {}.{}", chain.front().effect->name, setting));
    if (!link)
        return not_in_chain(chain, name.substr(0, dot), "--set " + setting);
    const std::string parameter = dot == std::string::npos ? name : name.substr(dot + 1);
    auto set = set_parameter(*link->effect->parameters, link->parameters.data(), parameter, setting.substr(equals + 1));
    link->set_by_hand.push_back(parameter);
    return set ? Result<void>{} : wrong(set.error().message);
}

} // namespace

Result<EffectChain> make_chain(const ChainOptions& options) {
    auto chain = parse_effects(options.effects);
    if (!chain)
        return chain.error();
    if (!options.config.empty())
        if (auto loaded = load_config(*chain, options.config); !loaded)
            return loaded.error();
    if (auto applied = apply_presets(*chain, options.preset); !applied)
        return applied.error();
    for (const std::string& setting : options.settings)
        if (auto set = apply_setting(*chain, setting); !set)
            return set.error();
    return chain;
}

std::string parameters_text(const ChainLink& link) {
    std::string text;
    for (const ParameterInfo& info : link.effect->parameters->parameters)
        text +=
            fmt::format("{}{}={}", text.empty() ? "" : " ", info.name, parameter_text(info, link.parameters.data()));
    return text;
}

} // namespace sfumato::cli
