// What the bench knows of each effect beyond its description. An effect without an adapter is timed with inputs found
// by the names of its image roles; with one it is scored against ground truth as well.
#pragma once

#include "scene/scene.h"
#include "sfumato/effect.h"

#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sfumato::bench {

struct Feed {
    const char* role;
    const char* plane; // "" leaves the role absent
};

struct TileClassShare {
    std::string name;
    double share = 0.0;
};

struct Adapter {
    const char* effect;
    std::span<const Feed> feeds;            // where names of role and plane differ
    std::span<const char* const> opt_in;    // roles that are bound only where asked for
    std::span<const char* const> not_tuned; // parameters that are a matter of taste or of the content

    // Quality: the plane with the truth, and the one that stands for doing nothing.
    const char* truth = nullptr;
    const char* do_nothing = nullptr;
    bool display_encoded = true; // compared as sRGB, and apart where things move

    // What the parameters ask of the truth. The text tells apart what differs, "" for the effect's defaults.
    std::string (*truth_options)(const ParameterTable& table, const void* parameters, float time_step,
                                 scene::RenderOptions& options) = nullptr;

    // Shares of tiles by class, read off a debug view (rgba): parameter, value, reader.
    const char* class_parameter = nullptr;
    const char* class_value = nullptr;
    std::vector<TileClassShare> (*classes)(std::span<const float> rgba) = nullptr;
};

// Never null: an effect without an adapter of its own gets an empty one.
const Adapter& adapter_of(const EffectInfo& effect);

// The plane that feeds the role, "" for none.
std::string plane_of(const Adapter& adapter, const ImageRole& role, std::span<const std::string> opted_in);

} // namespace sfumato::bench
