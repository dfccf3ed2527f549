// What is measured: an effect with a preset and overrides.
#pragma once

#include "sfumato/effect.h"

#include <string>
#include <utility>
#include <vector>

namespace sfumato::bench {

struct Variant {
    const EffectInfo* effect;
    std::string label; // "high", "high taps=8"
    ParameterSet parameters;
};

struct VariantRequest {
    std::string effect;               // "" for all
    std::vector<std::string> presets; // none: all of the effect
    std::vector<std::string> sets;    // "effect.parameter=value", or without the effect where it is clear
    std::vector<std::string> varied;  // "effect.parameter=value,value": each combination makes variants
};

// Errors (invalid_argument): an unknown effect, preset or parameter, a value that is not allowed.
Result<std::vector<Variant>> make_variants(const VariantRequest& request);

struct Assignment {
    std::string effect; // "" where it is not named
    std::string parameter;
    std::string value;
};
Result<Assignment> parse_assignment(const std::string& text);

} // namespace sfumato::bench
