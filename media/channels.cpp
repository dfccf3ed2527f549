// Tables of the names that renderers and compositors give to their channels, and the choice among what a file holds.
#include "channels.h"

#include <algorithm>
#include <cctype>
#include <iterator>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sfumato::media {

namespace {

std::string lower(std::string_view text) {
    std::string result(text);
    std::transform(result.begin(), result.end(), result.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return result;
}

// Letters and digits only, in lower case: "Motion Vectors" and "motion_vectors" are the same name.
std::string plain(std::string_view text) {
    std::string result;
    for (const char c : text)
        if (std::isalnum(static_cast<unsigned char>(c)))
            result += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return result;
}

std::vector<std::string> split(std::string_view text) {
    std::vector<std::string> components;
    while (true) {
        const size_t dot = text.find('.');
        components.emplace_back(text.substr(0, dot));
        if (dot == std::string_view::npos)
            return components;
        text.remove_prefix(dot + 1);
    }
}

// One layer of one part: where its channels are, by their last component.
struct Layer {
    size_t part = 0;
    std::string name;
    std::string last;                                     // last component, plain
    std::vector<std::pair<std::string, size_t>> channels; // lower-case last component of the name, index

    std::optional<size_t> find(std::string_view letter) const {
        for (const auto& [name_part, index] : channels)
            if (name_part == letter)
                return index;
        return std::nullopt;
    }
};

// "View.Combined.R" is R of layer View.Combined. In a file of several parts the part's name is a layer around the
// channel's, unless the channel repeats it.
std::pair<std::string, std::string> layer_and_letter(const ExrPart& part, const std::string& channel, bool multi_part) {
    std::string name = channel;
    if (multi_part && !part.name.empty() && !lower(name).starts_with(lower(part.name) + "."))
        name = part.name + "." + name;
    const size_t dot = name.rfind('.');
    if (dot == std::string::npos)
        return {"", name};
    return {name.substr(0, dot), name.substr(dot + 1)};
}

std::vector<Layer> layers_of(const ExrImage& image) {
    std::vector<Layer> layers;
    for (size_t p = 0; p < image.parts.size(); ++p) {
        const ExrPart& part = image.parts[p];
        for (size_t c = 0; c < part.channels.size(); ++c) {
            auto [name, letter] = layer_and_letter(part, part.channels[c].name, image.parts.size() > 1);
            auto place = std::find_if(layers.begin(), layers.end(), [&, &n = name](const Layer& layer) {
                return layer.part == p && layer.name == n;
            });
            if (place == layers.end()) {
                layers.push_back({p, name, plain(split(name).back()), {}});
                place = std::prev(layers.end());
            }
            place->channels.emplace_back(lower(letter), c);
        }
    }
    return layers;
}

// Takes the first set of letters that the layer has in full.
std::optional<ChannelGroup> take(const Layer& layer, std::initializer_list<const char*> sets, int score) {
    for (const std::string_view set : sets) {
        ChannelGroup group{layer.part, layer.name, {}, {}, {}, score};
        for (const std::string& letter : split(set)) {
            if (const auto index = layer.find(letter)) {
                group.channels.push_back(*index);
                group.letters += static_cast<char>(std::toupper(static_cast<unsigned char>(letter[0])));
            }
        }
        if (group.letters.size() == split(set).size())
            return group;
    }
    return std::nullopt;
}

struct NameScore {
    std::string_view name; // plain
    int score;
    std::string_view convention = {};
};

template <size_t count>
const NameScore* look_up(const NameScore (&table)[count], std::string_view name) {
    for (const NameScore& row : table)
        if (row.name == name)
            return &row;
    return nullptr;
}

// --------------------------------------------------------------------------------------------------- tables

constexpr NameScore colour_names[] = {
    {"", 100},     {"rgba", 95},   {"rgb", 95},        {"combined", 90}, {"beauty", 85},
    {"color", 80}, {"colour", 80}, {"finalimage", 80}, {"image", 75},    {"main", 70},
    {"ci", 70},    {"c", 65},      {"composite", 60},
};

constexpr NameScore depth_names[] = {
    {"depth", 90, ""},
    {"z", 85, ""},
    {"zdepth", 80, ""},
    {"vrayzdepth", 88, "vray"},
    {"depthz", 80, ""},
    {"worlddepth", 80, "unreal"},
    {"linearz", 78, ""},
    {"lineardepth", 78, ""},
    {"finalimagemovierenderqueueworlddepth", 85, "unreal"},
    {"pz", 70, ""},
    {"viewz", 78, ""},
    {"distance", 40, "distance"},
};

constexpr NameScore normal_names[] = {
    {"normal", 90},     {"normals", 90},     {"n", 80},
    {"nn", 70},         {"vraynormals", 85}, {"worldnormal", 80},
    {"viewnormal", 80}, {"normalspass", 70}, {"finalimagemovierenderqueueworldnormal", 80},
};

constexpr NameScore motion_names[] = {
    {"motionvector", 90, "arnold"},
    {"motionvectors", 88, "redshift"},
    {"motionvec", 86, "ndc"},
    {"velocity", 84, "vray"},
    {"vrayvelocity", 84, "vray"},
    {"motionback", 80, "renderman-back"},
    {"motionfore", 78, "renderman"},
    {"backward", 76, "nuke-backward"},
    {"forward", 74, "nuke-forward"},
    {"vector", 60, ""},
    {"motion", 60, ""},
    {"flow", 50, ""},
    {"motion2d", 60, ""},
    {"mv", 50, ""},
    {"rsmb", 60, "rsmb"},
};

// Layers whose RGB is no picture.
constexpr std::string_view data_names[] = {"ao",       "shadow", "mist", "uv", "indexob", "indexma",    "p",
                                           "position", "emit",   "env",  "st", "albedo",  "cryptomatte"};

std::optional<ChannelGroup> depth_group(const Layer& layer) {
    if (const NameScore* row = look_up(depth_names, layer.last); row && !layer.name.empty()) {
        auto group = take(layer, {"z", "r", "v", "y", "x", "depth"}, row->score);
        if (group)
            group->convention = row->convention;
        // RenderMan's __depth is the distance from the camera.
        if (group && split(layer.name).back().starts_with("__"))
            group->convention = "distance";
        return group;
    }
    // A bare Z is depth unless X and Y stand beside it.
    if (layer.find("z") && !(layer.find("x") && layer.find("y")))
        return take(layer, {"z"}, layer.name.empty() ? 100 : look_up(colour_names, layer.last) ? 95 : 60);
    // A layer without letters: "depth", "View.VRayZDepth".
    for (const auto& [letter, index] : layer.channels) {
        const NameScore* row = look_up(depth_names, plain(letter));
        if (!row || letter == "z")
            continue;
        ChannelGroup group{layer.part, layer.name, {index}, std::string(1, letter[0]), std::string(row->convention),
                           row->score};
        group.letters = letter;
        if (letter.starts_with("__"))
            group.convention = "distance";
        return group;
    }
    return std::nullopt;
}

std::optional<ChannelGroup> normal_group(const Layer& layer) {
    const NameScore* row = look_up(normal_names, layer.last);
    if (!row || layer.name.empty())
        return std::nullopt;
    return take(layer, {"x.y.z", "r.g.b"}, row->score);
}

std::optional<ChannelGroup> motion_group(const Layer& layer) {
    // Four channels called Vector are Blender's and nobody else's.
    if (layer.last == "vector") {
        if (auto group = take(layer, {"x.y.z.w"}, 100)) {
            group->convention = "blender";
            return group;
        }
    }
    // What sfumato render writes.
    if (layer.last == "sfumatovelocity") {
        auto group = take(layer, {"x.y.z.w", "x.y"}, 100);
        if (group)
            group->convention = "sfumato";
        return group;
    }
    // The camera's name may follow.
    if (layer.last.find("movierenderqueuemotionvectors") != std::string::npos) {
        auto group = take(layer, {"r.g", "x.y"}, 95);
        if (group)
            group->convention = "unreal";
        return group;
    }
    const NameScore* row = look_up(motion_names, layer.last);
    if (!row || layer.name.empty())
        return std::nullopt;
    auto group = take(layer, {"u.v", "r.g", "x.y"}, row->score);
    if (group)
        group->convention = row->convention;
    return group;
}

bool is_rejected_motion(const Layer& layer) {
    return layer.last == "dpdtime" || layer.last == "dpcameradtime";
}

std::optional<ChannelGroup> colour_group(const Layer& layer) {
    const NameScore* row = look_up(colour_names, layer.last);
    if (!row &&
        (motion_group(layer) || normal_group(layer) || is_rejected_motion(layer) || look_up(depth_names, layer.last) ||
         std::find(std::begin(data_names), std::end(data_names), layer.last) != std::end(data_names)))
        return std::nullopt;
    const int score = row ? row->score : 10;
    if (auto group = take(layer, {"r.g.b.a", "r.g.b", "red.green.blue.alpha", "red.green.blue"}, score))
        return group;
    // A single Y is a grey picture; with X or Z beside it, it is something else.
    if (row && layer.find("y") && !layer.find("x") && !layer.find("z"))
        return take(layer, {"y"}, score - 50);
    return std::nullopt;
}

// --------------------------------------------------------------------------------------------------- choice

bool names_layer(std::string_view layer, std::string_view wanted) {
    const std::string whole = "." + lower(layer) + ".", part = "." + lower(wanted) + ".";
    return whole.find(part) != std::string::npos;
}

bool better(const ChannelGroup& a, const ChannelGroup& b) {
    const auto depth = [](const ChannelGroup& g) { return g.layer.empty() ? size_t{0} : split(g.layer).size(); };
    if (a.score != b.score)
        return a.score > b.score;
    if (depth(a) != depth(b))
        return depth(a) < depth(b);
    if (a.part != b.part)
        return a.part < b.part;
    return a.layer < b.layer;
}

using Finder = std::optional<ChannelGroup> (*)(const Layer&);

std::vector<ChannelGroup> candidates(const std::vector<Layer>& layers, Finder find) {
    std::vector<ChannelGroup> found;
    for (const Layer& layer : layers)
        if (auto group = find(layer))
            found.push_back(std::move(*group));
    std::sort(found.begin(), found.end(), better);
    return found;
}

ChannelChoice choose(ChannelRole role, const std::vector<Layer>& layers, Finder find, std::string_view wanted) {
    ChannelChoice choice;
    std::vector<ChannelGroup> found = candidates(layers, find);
    const char* name = role_name(role);
    if (found.empty()) {
        choice.reasons.push_back(fmt::format("no channels with a known name for {}", name));
        return choice;
    }
    if (!wanted.empty()) {
        auto inside = std::stable_partition(found.begin(), found.end(),
                                            [&](const ChannelGroup& g) { return names_layer(g.layer, wanted); });
        if (inside == found.begin())
            choice.reasons.push_back(
                fmt::format("layer '{}' has no {}; taken from the rest of the file", wanted, name));
        else
            found.erase(inside, found.end());
    }
    choice.chosen = found.front();
    choice.others.assign(found.begin() + 1, found.end());
    choice.reasons.push_back(fmt::format("{} is {}, by name", name, choice.chosen->text()));
    if (!choice.others.empty()) {
        std::vector<std::string> names;
        for (const ChannelGroup& other : choice.others)
            names.push_back(other.text());
        const bool tied = choice.others.front().score == choice.chosen->score;
        choice.reasons.push_back(
            fmt::format("not taken for {}: {} ({}; --layer chooses)", name, fmt::join(names, ", "),
                        tied ? "the name fits as well; the shorter, earlier, alphabetically first won"
                             : "the name fits less well"));
    }
    return choice;
}

// motionBack with motionFore, backward with forward: two halves of one thing.
void find_companion(ChannelChoice& motion) {
    static constexpr std::string_view pairs[][2] = {{"renderman-back", "renderman"}, {"nuke-backward", "nuke-forward"}};
    if (!motion.chosen)
        return;
    for (const auto& [back, fore] : pairs)
        for (const ChannelGroup& other : motion.others)
            if (!motion.companion && motion.chosen->convention == back && other.convention == fore)
                motion.companion = other;
    if (motion.companion)
        motion.reasons.push_back(fmt::format("motion to the next frame is {}", motion.companion->text()));
}

} // namespace

const char* role_name(ChannelRole role) {
    switch (role) {
    case ChannelRole::colour:
        return "colour";
    case ChannelRole::depth:
        return "depth";
    case ChannelRole::normal:
        return "normals";
    case ChannelRole::motion:
        return "motion";
    }
    return "";
}

std::string ChannelGroup::text() const {
    return layer.empty() ? letters : fmt::format("{} ({})", layer, letters);
}

std::vector<std::string> layer_names(const ExrImage& image) {
    std::vector<std::string> names;
    for (const Layer& layer : layers_of(image))
        if (std::find(names.begin(), names.end(), layer.name) == names.end())
            names.push_back(layer.name);
    return names;
}

Result<ChannelSelection> select_channels(const ExrImage& image, std::string_view layer) {
    const std::vector<Layer> layers = layers_of(image);
    if (!layer.empty() &&
        std::none_of(layers.begin(), layers.end(), [&](const Layer& l) { return names_layer(l.name, layer); }))
        return Error{ErrorCode::invalid_argument, fmt::format("{}: no layer '{}'; the file has {}", image.path.string(),
                                                              layer, fmt::join(layer_names(image), ", "))};
    ChannelSelection selection;
    selection.colour = choose(ChannelRole::colour, layers, colour_group, layer);
    selection.depth = choose(ChannelRole::depth, layers, depth_group, layer);
    selection.normal = choose(ChannelRole::normal, layers, normal_group, layer);
    selection.motion = choose(ChannelRole::motion, layers, motion_group, layer);
    find_companion(selection.motion);
    for (const Layer& rejected : layers)
        if (is_rejected_motion(rejected))
            selection.motion.reasons.push_back(fmt::format(
                "rejected for motion: {}: it holds velocities in three dimensions, which would need projection; render "
                "motionBack or motionFore in place of it",
                rejected.name));
    return selection;
}

Planes planes_of(const ExrImage& image, const ChannelGroup& group) {
    const ExrPart& part = image.parts[group.part];
    Planes planes{static_cast<int>(part.width()), static_cast<int>(part.height()), {}};
    for (const size_t index : group.channels) {
        const ExrChannel& channel = part.channels[index];
        if (channel.type != PixelType::uint32) {
            planes.channels.push_back(channel.values);
            continue;
        }
        std::vector<float> values(channel.integers.size());
        std::transform(channel.integers.begin(), channel.integers.end(), values.begin(),
                       [](uint32_t value) { return static_cast<float>(value); });
        planes.channels.push_back(std::move(values));
    }
    return planes;
}

Planes colour_planes_of(const ExrImage& image, const ChannelGroup& group) {
    Planes planes = planes_of(image, group);
    if (planes.channels.size() == 1)
        planes.channels.resize(3, planes.channels.front());
    planes.channels.resize(std::min<size_t>(3, planes.channels.size()));
    return planes;
}

} // namespace sfumato::media
