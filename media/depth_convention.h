// What the numbers in a renderer's depth channel mean, and how they become Sfumato's linear view depth: distance along
// the viewing axis in scene units, above 0, 1e10 where nothing was hit.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "channels.h"
#include "exr_file.h"
#include "motion_convention.h"
#include "sfumato/frame.h"
#include "sfumato/result.h"

namespace sfumato::media {

inline constexpr float no_hit_depth = 1e10f;

enum class DepthMeaning {
    planar,     // along the viewing axis
    distance,   // from the camera's position
    normalised, // 0 at `near_distance`, 1 at `far_distance`
    inverse,    // 1 / depth, 0 at infinity
};

struct DepthConvention {
    std::string base = "planar";
    DepthMeaning meaning = DepthMeaning::planar;
    bool inverted = false;      // normalised: 1 is near
    bool negative = false;      // counts down from 0, as view space's Z
    bool zero_is_far = false;   // renderers that leave the background at 0
    double scale = 1.0;         // to scene units, 0.01 for centimetres
    double near_distance = 0.0; // normalised only; 0: not known
    double far_distance = 0.0;
    double sentinel = 1e9; // from here on, nothing was hit

    std::string text() const;
    std::string description() const;
};

// NAME[,MODIFIER...]; names: planar, distance, normalised, inverse, blender, unreal, arnold, vray, redshift, renderman,
// karma, nuke. Modifiers: inverted, negative, zero-is-far, scale=N, near=N, far=N, sentinel=N.
Result<DepthConvention> parse_depth_convention(std::string_view text);
const std::vector<std::string>& depth_convention_names();

struct DepthStatistics {
    size_t pixels = 0;
    size_t not_a_number = 0;
    size_t infinite = 0;
    size_t negative = 0;
    size_t zero = 0;
    size_t sentinel = 0; // finite, 1e9 and above: nothing was hit
    // Of what is left: finite, not zero, no sentinel.
    size_t surfaces = 0;
    double minimum = 0.0;
    double median = 0.0;
    double maximum = 0.0;
};

DepthStatistics depth_statistics_of(const std::vector<float>& values);

struct DepthDetection {
    DepthConvention convention;
    Confidence confidence = Confidence::guess;
    DepthStatistics statistics;
    std::vector<std::string> reasons;
    std::vector<std::string> warnings;
};

// By name, header and values, as for motion; `told` wins.
Result<DepthDetection> detect_depth(const ExrImage& image, const ChannelGroup& group, std::string_view told = {});

// Linear view depth of every pixel. `distance` needs the camera's projection, `normalised` near and far
// (`invalid_argument` without). NaN and infinity become no_hit_depth.
Result<std::vector<float>> decode_depth(const std::vector<float>& values, int width, int height,
                                        const DepthConvention& convention, const Matrix4* projection = nullptr);

} // namespace sfumato::media
