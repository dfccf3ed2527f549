// Which effects run, in which order, with which parameters: from --config, --preset and --set, later ones winning.
#pragma once

#include "sfumato/effect.h"
#include "sfumato/result.h"

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace sfumato::cli {

struct ChainLink {
    const EffectInfo* effect = nullptr;
    std::string preset; // the last one that was applied; "" for the defaults
    ParameterSet parameters;
    std::vector<std::string> set_by_hand = {}; // parameters that --set named
    std::vector<std::string> outputs = {};     // roles that the effect makes
    std::vector<std::string> written = {};     // those of them that go to the file
};

using EffectChain = std::vector<ChainLink>;

// As the user typed them.
struct ChainOptions {
    std::string effects;               // "motion-blur,…"
    std::string preset;                // NAME for all effects, or EFFECT=NAME[,EFFECT=NAME…]
    std::vector<std::string> settings; // "motion-blur.taps=20"; the effect may be left off if there is only one
    std::string config;                // path or ""
};

// Errors (invalid_argument, with the nearest known name; input for a broken configuration file).
Result<EffectChain> make_chain(const ChainOptions& options);

// Decides what effects make and what is written. `wanted` is a list of roles, "colour" for the picture; empty: what
// each effect is for. Errors (invalid_argument): a name that no effect of the chain makes.
Result<void> choose_outputs(EffectChain& chain, const std::string& wanted);

// Whether an input has any influence with these parameters and outputs.
bool uses_input(const ChainLink& link, const ImageRole& role);
bool chain_uses(const EffectChain& chain, std::string_view input);

// Whether the chain changes the picture, or puts something beside it only; and whether that is a plane that can be
// shown as a grey picture.
bool writes_colour(const EffectChain& chain);
bool writes_plane(const EffectChain& chain);

// The effective values, as a file that --config reads back to the same.
Result<void> save_config(const EffectChain& chain, const std::filesystem::path& path, bool no_clobber);

// "shutter=0.5 taps=15 …": what an image remembers of how it was made.
std::string parameters_text(const ChainLink& link);

// Reads [effect] tables into the links that they name.
Result<void> load_config(EffectChain& chain, const std::filesystem::path& path);

bool contains(const std::vector<std::string>& list, std::string_view name);

// "; did you mean 'x'?" or "".
std::string did_you_mean(std::string_view name, const std::vector<std::string>& candidates);
std::vector<std::string> effect_names();

// The error for an effect that does not exist.
Error unknown_effect(std::string_view name);

} // namespace sfumato::cli
