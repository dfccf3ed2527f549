// What the numbers in a renderer's motion channels mean, and how they become Sfumato's velocity: pixels per frame, +x
// right, +y down, current minus previous; for a second pair of channels, next minus current.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "channels.h"
#include "exr_file.h"
#include "planes.h"
#include "sfumato/result.h"

namespace sfumato::media {

enum class MotionUnit {
    pixels,
    ndc, // -1...1 over the picture
    uv,  // 0...1 over the picture
};

// Between which positions of a surface the first pair of channels points. A second pair in the same layer tells of the
// other neighbour and runs the same way in time: "previous - current" is followed by "current - next".
enum class MotionTime {
    from_previous, // current - previous
    to_previous,   // previous - current
    to_next,       // next - current
    from_next,     // current - next
};

// Decoding, in this order: encoded: value * 2 - 1; swap: the second channel is x; unit to pixels; flips; the sense of
// time; scale.
struct MotionConvention {
    std::string base = "pixels"; // the named convention that the rest starts from
    MotionUnit unit = MotionUnit::pixels;
    MotionTime time = MotionTime::from_previous;
    bool encoded = false; // 0...1, 0.5 is still
    bool swap = false;
    bool flip_x = false;        // channels count x to the left
    bool flip_y = false;        // channels count y upwards
    bool four_channels = false; // channels 3 and 4 tell of the other neighbour
    double scale = 1.0;

    // "blender", "blender,flip-y": what parse_motion_convention() reads back.
    std::string text() const;
    // One sentence for people.
    std::string description() const;
    // Whether the first pair tells of the next frame.
    bool tells_next() const { return time == MotionTime::to_next || time == MotionTime::from_next; }
    // One pair of channel values in pixels, x right, y down, forward in time.
    std::array<double, 2> decode(double first, double second, int width, int height) const;
};

// NAME[,MODIFIER...]. Names: see motion_convention_names(). Modifiers: flip-x, flip-y, swap (each turns over what the
// name says), scale=NUMBER (multiplies), encoded, raw, pixels, ndc, uv, and one of from-previous, to-previous, to-next,
// from-next. The name may be left off ("flip-y") and means pixels then.
Result<MotionConvention> parse_motion_convention(std::string_view text);
const std::vector<std::string>& motion_convention_names();

struct MotionField {
    int width = 0;
    int height = 0;
    std::vector<float> velocity;   // x, y of each pixel: current minus previous
    std::vector<float> next;       // next minus current; empty if the file does not tell
    bool velocity_is_next = false; // only the next frame is told; velocity is taken to be the same
    size_t non_finite = 0;         // pixels with NaN or infinity, which became 0
    double longest = 0.0;          // pixels
};

// `motion` holds 2 or 4 channels; `companion`, if given, the 2 channels towards the other neighbour with the same
// convention but the opposite sense. `width` and `height` of the picture that ndc and uv refer to.
Result<MotionField> decode_motion(const Planes& motion, const MotionConvention& convention, int width, int height,
                                  const Planes* companion = nullptr);

enum class Confidence { told, named, attribute, values, guess };

struct ValueStatistics {
    double minimum = 0.0;
    double maximum = 0.0;
    double median = 0.0;
    double large = 0.0; // 99 % of the absolute values are below
    size_t non_finite = 0;
    bool all_zero = true;
};

ValueStatistics statistics_of(const std::vector<float>& values);

struct MotionDetection {
    MotionConvention convention;
    Confidence confidence = Confidence::guess;
    bool all_zero = false;
    std::vector<std::string> reasons;  // why, one sentence each
    std::vector<std::string> warnings; // what the user should check
};

// By name, then by header attributes, then by values. `told` is the user's choice (empty: detect) and wins, while the
// values may still warn.
Result<MotionDetection> detect_motion(const ExrImage& image, const ChannelGroup& group, std::string_view told = {});

// The renderer that a part's attributes speak of: "blender", "unreal", "arnold", "vray", "redshift", "renderman" or
// nothing; `attribute` receives the attribute's name.
std::string renderer_of(const ExrPart& part, std::string& attribute);

} // namespace sfumato::media
