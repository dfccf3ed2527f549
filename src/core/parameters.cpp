// Setting, checking and printing parameters through their table.
#include "sfumato/parameters.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <numeric>

namespace sfumato {

namespace {

std::string number_text(double value, ParameterKind kind) {
    char buffer[64];
    if (kind == ParameterKind::integer) {
        std::snprintf(buffer, sizeof buffer, "%lld", static_cast<long long>(value));
        return buffer;
    }
    // The shortest text that gives the same float back.
    const auto result = std::to_chars(buffer, buffer + sizeof buffer, static_cast<float>(value));
    return std::string(buffer, result.ptr);
}

std::string choices_text(const ParameterInfo& info) {
    std::string text;
    for (const char* choice : info.choices)
        text += (text.empty() ? "" : ", ") + std::string(choice);
    return text;
}

std::string full_name(const ParameterTable& table, const char* name) {
    return std::string(table.effect) + "." + name;
}

Error bad_value(const ParameterTable& table, const ParameterInfo& info, std::string_view value) {
    std::string allowed;
    switch (info.kind) {
    case ParameterKind::boolean:
        allowed = "true or false";
        break;
    case ParameterKind::choice:
        allowed = "one of " + choices_text(info);
        break;
    default:
        allowed = std::string(info.kind == ParameterKind::integer ? "a whole number" : "a number") + " from " +
                  number_text(info.minimum, info.kind) + " to " + number_text(info.maximum, info.kind) +
                  (*info.unit ? std::string(" ") + info.unit : "");
    }
    return {ErrorCode::invalid_argument,
            full_name(table, info.name) + " is " + std::string(value) + "; allowed is " + allowed};
}

// NaN where the text is not a value of the parameter's kind.
double parse_value(const ParameterInfo& info, std::string_view text) {
    const double none = std::nan("");
    if (info.kind == ParameterKind::boolean) {
        if (text == "true" || text == "on" || text == "1" || text == "yes")
            return 1.0;
        if (text == "false" || text == "off" || text == "0" || text == "no")
            return 0.0;
        return none;
    }
    if (info.kind == ParameterKind::choice) {
        const auto found = std::find(info.choices.begin(), info.choices.end(), text);
        return found == info.choices.end() ? none : static_cast<double>(found - info.choices.begin());
    }
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size())
        return none;
    if (info.kind == ParameterKind::integer && value != std::floor(value))
        return none;
    return value;
}

// Floats widen the double limits by rounding: 0.1f is above 0.1.
bool in_range(const ParameterInfo& info, double value) {
    const double slack = info.kind == ParameterKind::real ? 1e-6 * std::max(1.0, std::abs(value)) : 0.0;
    return std::isfinite(value) && value >= info.minimum - slack && value <= info.maximum + slack;
}

} // namespace

const ParameterInfo* ParameterTable::find(std::string_view name) const {
    const auto found =
        std::find_if(parameters.begin(), parameters.end(), [&](const auto& p) { return p.name == name; });
    return found == parameters.end() ? nullptr : &*found;
}

const Preset* ParameterTable::find_preset(std::string_view name) const {
    const auto found = std::find_if(presets.begin(), presets.end(), [&](const auto& p) { return p.name == name; });
    return found == presets.end() ? nullptr : &*found;
}

std::string nearest_name(std::string_view name, std::span<const std::string> candidates) {
    std::string best;
    size_t best_distance = std::max<size_t>(2, name.size() / 3) + 1;
    for (const std::string& candidate : candidates) {
        // Levenshtein distance, one row at a time.
        std::vector<size_t> row(candidate.size() + 1);
        std::iota(row.begin(), row.end(), size_t{0});
        for (size_t i = 0; i < name.size(); ++i) {
            size_t diagonal = row[0];
            row[0] = i + 1;
            for (size_t j = 0; j < candidate.size(); ++j) {
                const size_t substituted = diagonal + (name[i] == candidate[j] ? 0 : 1);
                diagonal = row[j + 1];
                row[j + 1] = std::min({substituted, row[j] + 1, row[j + 1] + 1});
            }
        }
        if (row.back() < best_distance) {
            best_distance = row.back();
            best = candidate;
        }
    }
    return best;
}

Result<void> set_parameter(const ParameterTable& table, void* parameters, std::string_view name,
                           std::string_view text) {
    const ParameterInfo* info = table.find(name);
    if (!info) {
        std::vector<std::string> names;
        for (const auto& known : table.parameters)
            names.emplace_back(known.name);
        const std::string near = nearest_name(name, names);
        return Error{ErrorCode::invalid_argument, std::string(table.effect) + " has no parameter '" +
                                                      std::string(name) + "'" +
                                                      (near.empty() ? "" : "; did you mean '" + near + "'?")};
    }
    const double value = parse_value(*info, text);
    if (!in_range(*info, value))
        return bad_value(table, *info, "'" + std::string(text) + "'");
    info->set(parameters, value);
    return {};
}

std::string parameter_text(const ParameterInfo& info, const void* parameters) {
    const double value = info.get(parameters);
    if (info.kind == ParameterKind::boolean)
        return value != 0.0 ? "true" : "false";
    if (info.kind == ParameterKind::choice)
        return info.choices[static_cast<size_t>(value)];
    return number_text(value, info.kind);
}

Result<void> validate_parameters(const ParameterTable& table, const void* parameters) {
    for (const ParameterInfo& info : table.parameters) {
        const double value = info.get(parameters);
        if (!in_range(info, value))
            return bad_value(table, info, number_text(value, info.kind));
    }
    return {};
}

Result<void> apply_preset(const ParameterTable& table, void* parameters, std::string_view preset) {
    table.construct(parameters);
    if (preset.empty() || preset == "default")
        return {};
    const Preset* found = table.find_preset(preset);
    if (!found) {
        std::vector<std::string> names = {"default"};
        for (const auto& known : table.presets)
            names.emplace_back(known.name);
        std::string all;
        for (const auto& known : names)
            all += (all.empty() ? "" : ", ") + known;
        const std::string near = nearest_name(preset, names);
        return Error{ErrorCode::invalid_argument, std::string(table.effect) + " has no preset '" + std::string(preset) +
                                                      "'; " + (near.empty() ? "" : "did you mean '" + near + "'? ") +
                                                      "there are " + all};
    }
    for (const auto& [name, value] : found->overrides)
        if (auto set = set_parameter(table, parameters, name, value); !set)
            return Error{ErrorCode::internal, "preset " + std::string(preset) + ": " + set.error().message};
    return {};
}

ParameterSet::ParameterSet(const ParameterTable& table)
    : table_(&table), storage_((table.size + sizeof(std::max_align_t) - 1) / sizeof(std::max_align_t)) {
    table.construct(data());
}

} // namespace sfumato
