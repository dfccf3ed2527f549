// What the effects of a chain make, what of it is written, and which inputs that takes.
#include "apps/cli/effect_chain.h"
#include "apps/cli/exit_code.h"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sstream>

namespace sfumato::cli {

namespace {

constexpr std::string_view colour_output = "output"; // the role of every effect that changes the picture

const ImageRole* find_role(const EffectInfo& effect, std::string_view name) {
    const auto found = std::ranges::find_if(effect.images, [&](const ImageRole& role) { return name == role.name; });
    return found == effect.images.end() ? nullptr : &*found;
}

std::string choice_of(const ChainLink& link, std::string_view name) {
    const ParameterInfo* info = link.effect->parameters->find(name);
    return info ? parameter_text(*info, link.parameters.data()) : "";
}

// An effect whose picture is optional leaves the picture alone, unless it is asked for it: by name, by a parameter, or
// by an effect after it that goes on with the picture.
bool makes_colour(const EffectChain& chain, size_t place, bool is_wanted) {
    const ChainLink& link = chain[place];
    const ImageRole* role = find_role(*link.effect, colour_output);
    if (role == nullptr || choice_of(link, "application") == "none")
        return false;
    const bool goes_on =
        std::any_of(chain.begin() + static_cast<ptrdiff_t>(place) + 1, chain.end(), [](const auto& next) {
            const ImageRole* colour = find_role(*next.effect, "colour");
            return colour != nullptr && colour->use == ImageUse::input;
        });
    return !role->is_optional() || is_wanted || goes_on || contains(link.set_by_hand, "application");
}

Result<std::vector<std::string>> parse_wanted(const EffectChain& chain, const std::string& text) {
    std::vector<std::string> names, known;
    for (const ChainLink& link : chain)
        for (const ImageRole& role : link.effect->images)
            if (role.is_output())
                known.push_back(role.name == colour_output ? "colour" : role.name);
    std::istringstream words(text);
    for (std::string word; std::getline(words, word, ',');) {
        if (!contains(known, word))
            return usage_error(fmt::format("--outputs {}: no effect of this run makes '{}'{}; there are {}", text, word,
                                           did_you_mean(word, known), fmt::join(known, ", ")));
        names.push_back(word == "colour" ? std::string(colour_output) : word);
    }
    if (names.empty())
        return usage_error(fmt::format("--outputs is empty; there are {}", fmt::join(known, ", ")));
    return names;
}

} // namespace

Result<void> choose_outputs(EffectChain& chain, const std::string& text) {
    std::vector<std::string> wanted;
    if (!text.empty()) {
        auto parsed = parse_wanted(chain, text);
        if (!parsed)
            return parsed.error();
        wanted = std::move(*parsed);
    }
    for (size_t place = 0; place < chain.size(); ++place) {
        ChainLink& link = chain[place];
        link.outputs.clear();
        link.written.clear();
        for (const ImageRole& role : link.effect->images) {
            if (!role.is_output())
                continue;
            const bool is_wanted = contains(wanted, role.name);
            const bool is_made =
                role.name == colour_output ? makes_colour(chain, place, is_wanted) : !role.is_optional() || is_wanted;
            if (is_made)
                link.outputs.emplace_back(role.name);
            if (is_made && (is_wanted || wanted.empty()))
                link.written.emplace_back(role.name);
        }
    }
    return {};
}

bool uses_input(const ChainLink& link, const ImageRole& role) {
    const std::string_view name = role.name;
    const ImageRole* picture = find_role(*link.effect, colour_output);
    const bool applies = picture == nullptr || contains(link.outputs, colour_output);
    if (!role.is_optional())
        return true;
    if (name == "velocity" && choice_of(link, "temporal") == "false")
        return false;
    if (name == "normal" && choice_of(link, "normals") == "derived")
        return false;
    if (name == "profile")
        return choice_of(link, "profile") == "texture" && choice_of(link, "profile_strength") != "0";
    if (name == "shadow")
        return find_role(*link.effect, "soft_shadow") == nullptr || contains(link.outputs, "soft_shadow");
    if (name == "ambient")
        return applies && choice_of(link, "application") == "ambient";
    return name == "colour" ? applies : true;
}

bool chain_uses(const EffectChain& chain, std::string_view input) {
    return std::ranges::any_of(chain, [&](const ChainLink& link) {
        const ImageRole* role = find_role(*link.effect, input);
        return role != nullptr && !role->is_output() && uses_input(link, *role);
    });
}

bool writes_colour(const EffectChain& chain) {
    return std::ranges::any_of(chain, [](const ChainLink& link) { return contains(link.written, colour_output); });
}

bool writes_plane(const EffectChain& chain) {
    return std::ranges::any_of(chain, [](const ChainLink& link) {
        return std::ranges::any_of(link.effect->images, [&](const ImageRole& role) {
            return role.components == 1 && !role.is_signed && contains(link.written, role.name);
        });
    });
}

} // namespace sfumato::cli
