// Which motion convention a file follows: by the names of its channels, its header and its values, with reasons.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "motion_convention.h"

namespace sfumato::media {

ValueStatistics statistics_of(const std::vector<float>& values) {
    ValueStatistics result;
    // A million values tell median and percentile well enough.
    const size_t stride = std::max<size_t>(1, values.size() / 1'000'000);
    std::vector<float> sample;
    bool any = false;
    for (size_t i = 0; i < values.size(); ++i) {
        const float value = values[i];
        if (!std::isfinite(value)) {
            ++result.non_finite;
            continue;
        }
        const double wide = value;
        result.minimum = any ? std::min(result.minimum, wide) : wide;
        result.maximum = any ? std::max(result.maximum, wide) : wide;
        any = true;
        if (i % stride == 0)
            sample.push_back(value);
    }
    result.all_zero = any && result.minimum == 0.0 && result.maximum == 0.0;
    if (sample.empty())
        return result;
    auto at = [&sample](double share) {
        const auto place = sample.begin() + static_cast<ptrdiff_t>(share * static_cast<double>(sample.size() - 1));
        std::nth_element(sample.begin(), place, sample.end());
        return double{*place};
    };
    result.median = at(0.5);
    for (float& value : sample)
        value = std::abs(value);
    result.large = at(0.99);
    return result;
}

std::string renderer_of(const ExrPart& part, std::string& attribute) {
    static constexpr std::pair<std::string_view, const char*> prefixes[] = {
        {"blendermultichannel", "blender"},
        {"cycles.", "blender"},
        {"exr/unreal/", "unreal"},
        {"unreal/", "unreal"},
        {"arnold/", "arnold"},
        {"vray", "vray"},
        {"rs/", "redshift"},
        {"redshift", "redshift"},
        {"rman", "renderman"},
        {"renderman", "renderman"},
    };
    for (const ExrAttribute& candidate : part.attributes) {
        std::string name = candidate.name;
        std::transform(name.begin(), name.end(), name.begin(),
                       [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
        for (const auto& [prefix, renderer] : prefixes)
            if (name.starts_with(prefix)) {
                attribute = candidate.name;
                return renderer;
            }
    }
    return {};
}

namespace {

struct PairStatistics {
    ValueStatistics x, y;

    bool all_zero() const { return x.all_zero && y.all_zero; }
    double large() const { return std::max(x.large, y.large); }
    bool look_encoded() const {
        auto encoded = [](const ValueStatistics& s) {
            return std::abs(s.median - 0.5) < 0.02 && s.minimum >= -0.01 && s.maximum <= 1.01;
        };
        return encoded(x) && encoded(y);
    }
};

// Names that several programs use; the header may say which it was.
bool is_shared_name(const std::string& convention) {
    return convention == "arnold" || convention == "redshift" || convention == "vray" || convention == "ndc" ||
           convention.empty();
}

MotionConvention named(const char* name) {
    auto parsed = parse_motion_convention(name);
    return parsed ? *parsed : MotionConvention{};
}

// With neither a name nor a header to go by.
void guess_by_values(const PairStatistics& values, int width, MotionDetection& found) {
    found.confidence = Confidence::values;
    if (values.look_encoded()) {
        found.convention = named("ndc,encoded");
        found.reasons.push_back(fmt::format("median {:.3f} and range {:.3f} to {:.3f}: encoded, 0.5 is still",
                                            values.x.median, values.x.minimum, values.x.maximum));
        found.warnings.push_back("the scale of encoded vectors cannot be seen; ndc is assumed");
    } else if (values.large() < 2.0 && width >= 256) {
        found.convention = named(values.large() <= 1.0 ? "uv" : "ndc");
        found.reasons.push_back(
            fmt::format("99 % of the values are below {:.3g} on a picture {} pixels wide: {} rather than "
                        "pixels",
                        values.large(), width, found.convention.base));
        found.warnings.push_back(
            "slow motion in pixels would look the same; check, or choose with --motion-convention");
    } else {
        found.convention = named("pixels");
        found.reasons.push_back(
            fmt::format("median {:.3g}, 99 % of the values below {:.3g}: raw pixels", values.x.median, values.large()));
    }
    found.warnings.push_back("signs and direction of time are assumed, as nothing in the file tells them");
}

void detect_by_name_and_header(const ExrImage& image, const ChannelGroup& group, const PairStatistics& values,
                               MotionDetection& found) {
    const ExrPart& part = image.parts[group.part];
    std::string attribute;
    std::string renderer = renderer_of(part, attribute);
    if (renderer.empty() && group.part != 0)
        renderer = renderer_of(image.parts[0], attribute);
    // Blender's pass has four channels; its header alone does not make two channels such a pass.
    if (renderer == "blender" && group.channels.size() < 4)
        renderer.clear();
    if (!renderer.empty() && is_shared_name(group.convention) && renderer != group.convention) {
        found.convention = named(renderer.c_str());
        found.confidence = Confidence::attribute;
        found.reasons.push_back(fmt::format("attribute '{}' is {}'s: convention {}", attribute, renderer, renderer));
        return;
    }
    if (group.convention.empty()) {
        guess_by_values(values, static_cast<int>(part.width()), found);
        return;
    }
    found.convention = named(group.convention.c_str());
    found.confidence = Confidence::named;
    found.reasons.push_back(fmt::format("channels {} have the name of convention {}", group.text(), group.convention));
    if (!renderer.empty() && group.convention.starts_with(renderer))
        found.reasons.push_back(fmt::format("attribute '{}' agrees", attribute));
    else if (!renderer.empty())
        found.warnings.push_back(fmt::format("attribute '{}' speaks of {}", attribute, renderer));
}

void compare_with_values(const PairStatistics& values, bool told, MotionDetection& found) {
    if (found.all_zero)
        return;
    MotionConvention& convention = found.convention;
    const bool encoded = values.look_encoded();
    if (convention.encoded == encoded || (!encoded && values.x.minimum >= 0.0 && values.y.minimum >= 0.0 &&
                                          values.x.maximum <= 1.01 && values.y.maximum <= 1.01))
        return;
    const std::string what =
        fmt::format("values from {:.3g} to {:.3g} with median {:.3g} look {}",
                    std::min(values.x.minimum, values.y.minimum), std::max(values.x.maximum, values.y.maximum),
                    values.x.median, encoded ? "encoded (0.5 is still)" : "raw (0 is still)");
    if (told) {
        found.warnings.push_back(fmt::format("{}, which {} does not expect", what, convention.text()));
        return;
    }
    convention.encoded = encoded;
    found.reasons.push_back(fmt::format("{}, so {}", what, convention.text()));
}

void warn_of_open_questions(MotionDetection& found) {
    const MotionConvention& convention = found.convention;
    if (convention.base == "unreal")
        found.warnings.push_back(
            "scale and signs of Unreal's pass differ between versions and recipes; check by warping");
    if (convention.encoded && convention.unit == MotionUnit::pixels && convention.scale == 1.0)
        found.warnings.push_back(
            fmt::format("the length of encoded vectors is not in the file; say {},scale=MAXIMUM", convention.text()));
    if (convention.base == "arnold")
        found.warnings.push_back("Arnold's vectors span the shutter; half a frame is assumed (scale 2)");
    if (convention.base == "redshift" || convention.base.starts_with("renderman") || convention.base == "vray")
        found.warnings.push_back(
            fmt::format("signs of {} are not documented for certain; check by warping", convention.base));
}

} // namespace

Result<MotionDetection> detect_motion(const ExrImage& image, const ChannelGroup& group, std::string_view told) {
    const ExrPart& part = image.parts[group.part];
    if (group.channels.size() < 2)
        return Error{ErrorCode::invalid_argument, fmt::format("{}: motion needs two channels", image.path.string())};
    const PairStatistics values{statistics_of(part.channels[group.channels[0]].values),
                                statistics_of(part.channels[group.channels[1]].values)};
    MotionDetection found;
    found.all_zero = values.all_zero();
    if (!told.empty()) {
        auto convention = parse_motion_convention(told);
        if (!convention)
            return convention.error();
        found.convention = *convention;
        found.confidence = Confidence::told;
        found.reasons.push_back(fmt::format("convention {} was told", convention->text()));
    } else {
        detect_by_name_and_header(image, group, values, found);
    }
    if (found.convention.four_channels && group.channels.size() < 4) {
        found.convention.four_channels = false;
        found.warnings.push_back("only two channels: nothing is known of motion to the next frame");
    }
    compare_with_values(values, !told.empty(), found);
    if (told.empty())
        warn_of_open_questions(found);
    if (found.all_zero)
        found.warnings.push_back(
            found.convention.base == "blender"
                ? "all vectors are zero: Blender writes zeros when its own motion blur is on; render with "
                  "motion blur off"
                : "all vectors are zero: most renderers need motion blur settings of their own for this "
                  "pass");
    const size_t broken = std::max(values.x.non_finite, values.y.non_finite);
    if (broken > 0)
        found.warnings.push_back(fmt::format("{} vectors are NaN or infinite and count as still", broken));
    return found;
}

} // namespace sfumato::media
