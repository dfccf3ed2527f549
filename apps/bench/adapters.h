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

// What is asked of a ground truth beside the effect's own parameters.
struct TruthRequest {
    float time_step = 1.0f / 24.0f;
    std::string falloff = "hard"; // of occlusion; "own": that of the parameters
};

struct Adapter {
    const char* effect;
    std::span<const Feed> feeds;            // where names of role and plane differ
    std::span<const char* const> opt_in;    // roles that are bound only where asked for
    std::span<const char* const> not_tuned; // parameters that are a matter of taste or of the content

    // Quality: the plane with the truth, and the one that stands for doing nothing; without it that is 1 everywhere.
    const char* truth = nullptr;
    const char* do_nothing = nullptr;
    // Pictures are compared as sRGB, in dB; everything else as it is, by root mean square error and bias.
    bool display_encoded = true;
    // Where doing nothing differs from the truth, and where it does not.
    const char* region = "moving";
    const char* rest = "still";
    // A boolean parameter with which earlier frames matter: such settings are scored at the end of a sequence.
    const char* history = nullptr;

    // What the parameters ask of the truth. The text tells apart what differs, "" for the effect's defaults.
    std::string (*truth_options)(const ParameterTable& table, const void* parameters, const TruthRequest& request,
                                 scene::RenderOptions& options) = nullptr;

    // Shares of tiles by class, read off a debug view (rgba): parameter, value, reader.
    const char* class_parameter = nullptr;
    const char* class_value = nullptr;
    std::vector<TileClassShare> (*classes)(std::span<const float> rgba) = nullptr;
};

// Never null: an effect without an adapter of its own gets an empty one.
const Adapter& adapter_of(const EffectInfo& effect);

// Whether the role is bound without being asked for.
bool is_bound(const Adapter& adapter, const ImageRole& role, std::span<const std::string> opted_in);

// The plane that feeds the role, "" for none.
std::string plane_of(const Adapter& adapter, const ImageRole& role, std::span<const std::string> opted_in);

} // namespace sfumato::bench
