// Effects × presets × varied parameters.
#include "apps/bench/variants.h"

#include <algorithm>

namespace sfumato::bench {
namespace {

Error unknown_effect(const std::string& name) {
    std::vector<std::string> names;
    std::string list;
    for (const EffectInfo* effect : effects()) {
        names.emplace_back(effect->name);
        list += (list.empty() ? "" : ", ") + names.back();
    }
    const std::string near = nearest_name(name, names);
    return {ErrorCode::invalid_argument, "there is no effect '" + name + "'" +
                                             (near.empty() ? "; there are " + list : "; did you mean '" + near + "'?")};
}

Result<std::vector<Assignment>> parse_all(const std::vector<std::string>& texts, const VariantRequest& request) {
    std::vector<Assignment> assignments;
    for (const std::string& text : texts) {
        auto assignment = parse_assignment(text);
        if (!assignment)
            return assignment.error();
        if (!assignment->effect.empty() && find_effect(assignment->effect) == nullptr)
            return unknown_effect(assignment->effect);
        if (assignment->effect.empty() && request.effect.empty() && effects().size() > 1)
            return Error{ErrorCode::invalid_argument,
                         "'" + text + "' does not say which effect it is for: write EFFECT.PARAMETER=VALUE"};
        assignments.push_back(std::move(*assignment));
    }
    return assignments;
}

std::vector<std::string> split(const std::string& text) {
    std::vector<std::string> parts;
    size_t begin = 0;
    while (begin <= text.size()) {
        const size_t end = std::min(text.find(',', begin), text.size());
        parts.push_back(text.substr(begin, end - begin));
        begin = end + 1;
    }
    return parts;
}

bool concerns(const Assignment& assignment, const EffectInfo& effect) {
    return assignment.effect.empty() || assignment.effect == effect.name;
}

Result<std::vector<Variant>> of_preset(const EffectInfo& effect, const std::string& preset,
                                       const std::vector<Assignment>& sets, const std::vector<Assignment>& varied) {
    std::vector<Variant> variants{{&effect, preset, ParameterSet(*effect.parameters)}};
    if (auto applied = apply_preset(*effect.parameters, variants[0].parameters.data(), preset); !applied)
        return applied.error();
    for (const Assignment& set : sets)
        if (concerns(set, effect))
            if (auto done = set_parameter(*effect.parameters, variants[0].parameters.data(), set.parameter, set.value);
                !done)
                return done.error();
    for (const Assignment& vary : varied) {
        if (!concerns(vary, effect))
            continue;
        std::vector<Variant> more;
        for (const Variant& variant : variants)
            for (const std::string& value : split(vary.value)) {
                more.push_back(variant);
                more.back().label += " " + vary.parameter + "=" + value;
                if (auto done = set_parameter(*effect.parameters, more.back().parameters.data(), vary.parameter, value);
                    !done)
                    return done.error();
            }
        variants = std::move(more);
    }
    return variants;
}

} // namespace

Result<Assignment> parse_assignment(const std::string& text) {
    const size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0)
        return Error{ErrorCode::invalid_argument, "'" + text + "' is not EFFECT.PARAMETER=VALUE"};
    const size_t dot = text.find('.');
    const bool names_effect = dot != std::string::npos && dot < equals;
    return Assignment{names_effect ? text.substr(0, dot) : "",
                      names_effect ? text.substr(dot + 1, equals - dot - 1) : text.substr(0, equals),
                      text.substr(equals + 1)};
}

Result<std::vector<Variant>> make_variants(const VariantRequest& request) {
    std::vector<const EffectInfo*> chosen(effects().begin(), effects().end());
    if (!request.effect.empty()) {
        const EffectInfo* effect = find_effect(request.effect);
        if (effect == nullptr)
            return unknown_effect(request.effect);
        chosen = {effect};
    }
    const auto sets = parse_all(request.sets, request);
    if (!sets)
        return sets.error();
    const auto varied = parse_all(request.varied, request);
    if (!varied)
        return varied.error();
    std::vector<Variant> variants;
    for (const EffectInfo* effect : chosen) {
        std::vector<std::string> presets = request.presets;
        if (presets == std::vector<std::string>{"all"})
            presets.clear();
        if (presets.empty())
            for (const Preset& preset : effect->parameters->presets)
                presets.emplace_back(preset.name);
        if (presets.empty())
            presets.emplace_back("default");
        for (const std::string& preset : presets) {
            auto made = of_preset(*effect, preset, *sets, *varied);
            if (!made)
                return made.error();
            variants.insert(variants.end(), made->begin(), made->end());
        }
    }
    return variants;
}

} // namespace sfumato::bench
