// What the depth and motion channels of a file mean: detected once for a sequence, proven by warping where neighbouring
// frames are at hand, never guessed in silence.
#pragma once

#include "media/channels.h"
#include "media/depth_convention.h"
#include "media/exr_file.h"
#include "media/motion_convention.h"
#include "media/motion_warp.h"
#include "media/normal_convention.h"
#include "sfumato/result.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace sfumato::cli {

struct ConventionOptions {
    std::string layer;
    std::string motion; // the user's word; "" to detect
    std::string depth;
    std::string normals; // space and modifiers; "" or "auto" to detect
};

// The result of the warp check, or why there is none.
struct WarpOutcome {
    std::optional<media::WarpReport> report;
    std::string why_not;
};

// Reads the neighbours' colour and depth and checks `convention` of the motion channels of `image`.
WarpOutcome check_with_neighbours(const media::ExrImage& image, const media::ChannelSelection& channels,
                                  const media::MotionConvention& convention, const std::string& layer,
                                  const std::optional<std::filesystem::path>& previous,
                                  const std::optional<std::filesystem::path>& next);

struct Findings {
    std::vector<std::string> notes;    // for -v
    std::vector<std::string> warnings; // for everybody
};

// Errors (invalid_argument): the file does not tell the convention, and the warp check does not confirm the guess.
Result<media::MotionConvention> settle_motion(const media::ExrImage& image, const media::ChannelSelection& channels,
                                              const ConventionOptions& options,
                                              const std::optional<std::filesystem::path>& previous,
                                              const std::optional<std::filesystem::path>& next, Findings& findings);

Result<media::DepthConvention> settle_depth(const media::ExrImage& image, const media::ChannelSelection& channels,
                                            const ConventionOptions& options, Findings& findings);

// `depth`: linear view depth over part `part`, the evidence together with the camera; either may be missing.
Result<media::NormalConvention> settle_normals(const media::ExrImage& image, const media::ChannelSelection& channels,
                                               size_t part, const ConventionOptions& options,
                                               const std::vector<float>& depth, const Camera* camera,
                                               Findings& findings);

// Channels by role. Errors (invalid_argument): a layer that does not exist, with the nearest that does.
Result<media::ChannelSelection> choose_channels(const media::ExrImage& image, const std::string& layer);

// Errors (invalid_argument): words that no convention has, with the nearest known name.
Result<void> check_convention_words(const ConventionOptions& options);

// The values of a group laid over the data window of part `part`; `outside` fills what the group's part does not cover.
media::Planes planes_in_window(const media::ExrImage& image, const media::ChannelGroup& group, size_t part,
                               float outside);

} // namespace sfumato::cli
