// Which channels of a file are colour, depth, normals and motion: found by name in any part and layer.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "exr_file.h"
#include "planes.h"
#include "sfumato/result.h"

namespace sfumato::media {

enum class ChannelRole { colour, depth, normal, motion };

const char* role_name(ChannelRole role);

// Channels of one layer that together play one role.
struct ChannelGroup {
    size_t part = 0;
    std::string layer; // "View.Combined"; the part's name comes first in a file of several parts; may be empty
    std::vector<size_t> channels; // indices in the part: R G B [A]; Y; Z; X Y Z; X Y [Z W]
    std::string letters;          // what the channels are called, in the same order: "RGBA", "XYZW"
    std::string convention;       // motion and depth: the convention that the name stands for, empty if none
    int score = 0;                // how well the name fits; higher wins

    std::string text() const; // "View.Combined (RGBA)"
};

struct ChannelChoice {
    std::optional<ChannelGroup> chosen;
    std::vector<ChannelGroup> others; // candidates not taken, best first
    // A second motion group that belongs to the chosen one: forward to a backward.
    std::optional<ChannelGroup> companion;
    std::vector<std::string> reasons; // one sentence each: why this one, what else there was, what was rejected
};

struct ChannelSelection {
    ChannelChoice colour, depth, normal, motion;
};

// Looks for all four roles. `layer` (case does not matter) restricts the candidates to layers that it names: the whole
// layer, or some of its components in a row ("View" or "view.combined"). A layer that nothing has is an error that
// lists the layers; a role that the layer lacks is looked for in the whole file, and a reason says so. Among several
// candidates the better known name wins, then the shorter, then the first part, then the alphabet.
Result<ChannelSelection> select_channels(const ExrImage& image, std::string_view layer = {});

// All layers of a file, for messages and lists.
std::vector<std::string> layer_names(const ExrImage& image);

// Copies of the values of a group, in its order. Integer channels are converted.
Planes planes_of(const ExrImage& image, const ChannelGroup& group);
// A grey picture becomes three equal planes, alpha is left off.
Planes colour_planes_of(const ExrImage& image, const ChannelGroup& group);

} // namespace sfumato::media
