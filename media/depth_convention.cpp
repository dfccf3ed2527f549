// Names, detection and decoding of depth conventions.
#include "depth_convention.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sfumato::media {

namespace {

struct Row {
    const char* name;
    DepthMeaning meaning;
    bool inverted;
    bool zero_is_far;
    double scale;
};

constexpr Row rows[] = {
    {"planar", DepthMeaning::planar, false, false, 1.0},
    {"distance", DepthMeaning::distance, false, false, 1.0},
    {"normalised", DepthMeaning::normalised, false, false, 1.0},
    {"inverse", DepthMeaning::inverse, false, true, 1.0},
    {"blender", DepthMeaning::planar, false, false, 1.0},
    {"unreal", DepthMeaning::planar, false, false, 0.01},
    {"arnold", DepthMeaning::planar, false, true, 1.0},
    {"vray", DepthMeaning::normalised, true, false, 1.0},
    {"redshift", DepthMeaning::planar, false, true, 1.0},
    {"renderman", DepthMeaning::planar, false, false, 1.0},
    {"karma", DepthMeaning::planar, false, true, 1.0},
    {"nuke", DepthMeaning::inverse, false, true, 1.0},
};

struct Setting {
    std::string_view name;
    double DepthConvention::*value;
};

constexpr Setting settings[] = {
    {"near=", &DepthConvention::near_distance},
    {"far=", &DepthConvention::far_distance},
    {"sentinel=", &DepthConvention::sentinel},
};

DepthConvention from_row(const Row& row) {
    DepthConvention convention;
    convention.base = row.name;
    convention.meaning = row.meaning;
    convention.inverted = row.inverted;
    convention.zero_is_far = row.zero_is_far;
    convention.scale = row.scale;
    return convention;
}

const Row* find_row(std::string_view name) {
    for (const Row& row : rows)
        if (row.name == name)
            return &row;
    return nullptr;
}

bool read_positive(std::string_view text, double& value) {
    double read = 0.0;
    const auto [stop, code] = std::from_chars(text.data(), text.data() + text.size(), read);
    if (code != std::errc() || stop != text.data() + text.size() || !(read > 0.0 && read < 1e30))
        return false;
    value = read;
    return true;
}

bool apply_modifier(DepthConvention& convention, std::string_view modifier) {
    if (modifier == "inverted")
        convention.inverted = !convention.inverted;
    else if (modifier == "negative")
        convention.negative = !convention.negative;
    else if (modifier == "zero-is-far")
        convention.zero_is_far = true;
    else if (modifier.starts_with("scale=")) {
        double factor = 1.0;
        if (!read_positive(modifier.substr(6), factor))
            return false;
        convention.scale *= factor;
    } else {
        for (const Setting& setting : settings)
            if (modifier.starts_with(setting.name))
                return read_positive(modifier.substr(setting.name.size()), convention.*setting.value);
        return false;
    }
    return true;
}

} // namespace

const std::vector<std::string>& depth_convention_names() {
    static const std::vector<std::string> names = [] {
        std::vector<std::string> list;
        for (const Row& row : rows)
            list.emplace_back(row.name);
        return list;
    }();
    return names;
}

Result<DepthConvention> parse_depth_convention(std::string_view text) {
    DepthConvention convention;
    std::string_view rest = text;
    for (bool first = true;; first = false) {
        const size_t comma = rest.find(',');
        const std::string_view item = rest.substr(0, comma);
        const Row* row = first ? find_row(item) : nullptr;
        if (row)
            convention = from_row(*row);
        else if (!apply_modifier(convention, item))
            return Error{
                ErrorCode::invalid_argument,
                fmt::format("depth convention '{}': '{}' is unknown; names are {}; modifiers are inverted, negative, "
                            "zero-is-far, scale=N, near=N, far=N, sentinel=N with N above 0",
                            text, item, fmt::join(depth_convention_names(), ", "))};
        if (comma == std::string_view::npos)
            break;
        rest.remove_prefix(comma + 1);
    }
    if (convention.near_distance > 0.0 && convention.far_distance > 0.0 &&
        convention.far_distance <= convention.near_distance)
        return Error{ErrorCode::invalid_argument, fmt::format("depth convention '{}': far must be above near", text)};
    return convention;
}

std::string DepthConvention::text() const {
    const Row* row = find_row(base);
    const DepthConvention named = row ? from_row(*row) : DepthConvention{};
    std::string result = named.base;
    if (inverted != named.inverted)
        result += ",inverted";
    if (negative != named.negative)
        result += ",negative";
    if (zero_is_far && !named.zero_is_far)
        result += ",zero-is-far";
    if (scale != named.scale)
        result += fmt::format(",scale={:.9g}", scale / named.scale);
    for (const Setting& setting : settings)
        if (this->*setting.value != named.*setting.value)
            result += fmt::format(",{}{:.9g}", setting.name, this->*setting.value);
    return result;
}

std::string DepthConvention::description() const {
    static constexpr const char* meanings[] = {"planar view depth", "distance from the camera",
                                               "normalised between near and far", "one over planar view depth"};
    std::string result = meanings[static_cast<int>(meaning)];
    if (inverted)
        result += ", inverted";
    if (negative)
        result += ", negative";
    if (scale != 1.0)
        result += fmt::format(", times {:g}", scale);
    if (meaning == DepthMeaning::normalised)
        result += near_distance > 0.0 && far_distance > 0.0 ? fmt::format(" {:g} and {:g}", near_distance, far_distance)
                                                            : ", which are not known";
    return result + fmt::format(", nothing hit from {:g}{}", sentinel, zero_is_far ? " or at 0" : "");
}

// ------------------------------------------------------------------------------------------------ detection

DepthStatistics depth_statistics_of(const std::vector<float>& values) {
    DepthStatistics statistics;
    statistics.pixels = values.size();
    std::vector<float> sample;
    // Every pixel counts in the sums; at most a million make the median.
    const size_t stride = std::max<size_t>(1, values.size() / 1'000'000);
    for (size_t i = 0; i < values.size(); ++i) {
        const float value = values[i];
        statistics.not_a_number += std::isnan(value) ? 1 : 0;
        statistics.infinite += std::isinf(value) ? 1 : 0;
        if (!std::isfinite(value))
            continue;
        statistics.negative += value < 0.0f ? 1 : 0;
        statistics.zero += value == 0.0f ? 1 : 0;
        statistics.sentinel += std::abs(value) >= 1e9f ? 1 : 0;
        if (value == 0.0f || std::abs(value) >= 1e9f)
            continue;
        const double wide = value;
        statistics.minimum = statistics.surfaces > 0 ? std::min(statistics.minimum, wide) : wide;
        statistics.maximum = statistics.surfaces > 0 ? std::max(statistics.maximum, wide) : wide;
        ++statistics.surfaces;
        if (i % stride == 0)
            sample.push_back(value);
    }
    if (!sample.empty()) {
        const auto middle = sample.begin() + static_cast<ptrdiff_t>(sample.size() / 2);
        std::nth_element(sample.begin(), middle, sample.end());
        statistics.median = double{*middle};
    }
    return statistics;
}

namespace {

void detect_by_name_and_header(const ExrImage& image, const ChannelGroup& group, DepthDetection& found) {
    auto take = [&found](std::string_view name) {
        if (const Row* row = find_row(name))
            found.convention = from_row(*row);
    };
    std::string attribute;
    std::string renderer = renderer_of(image.parts[group.part], attribute);
    if (renderer.empty() && group.part != 0)
        renderer = renderer_of(image.parts[0], attribute);
    if (!group.convention.empty()) {
        take(group.convention);
        found.confidence = Confidence::named;
        found.reasons.push_back(
            fmt::format("channel {} has the name of convention {}", group.text(), group.convention));
    } else if (!renderer.empty()) {
        take(renderer);
        // A Z that V-Ray did not name VRayZDepth is ordinary depth.
        if (renderer == "vray")
            take("planar");
        found.confidence = Confidence::attribute;
        found.reasons.push_back(fmt::format("attribute '{}' is {}'s", attribute, renderer));
    } else {
        found.reasons.push_back("nothing in name or header says more than depth; planar is assumed");
    }
}

void detect_by_values(DepthDetection& found) {
    const DepthStatistics& s = found.statistics;
    DepthConvention& convention = found.convention;
    if (s.surfaces == 0) {
        found.warnings.push_back("no pixel holds a depth");
        return;
    }
    if (s.negative * 2 > s.surfaces && !convention.negative) {
        convention.negative = true;
        found.reasons.push_back(fmt::format("{} of {} depths are below 0: negative", s.negative, s.surfaces));
    }
    const bool within_one = s.minimum >= 0.0 && s.maximum <= 1.0;
    if (within_one && convention.meaning == DepthMeaning::planar) {
        convention.base = "normalised";
        convention.meaning = DepthMeaning::normalised;
        found.confidence = Confidence::values;
        found.reasons.push_back(
            fmt::format("all depths lie between {:.4g} and {:.4g}: normalised", s.minimum, s.maximum));
        found.warnings.push_back("a scene smaller than one unit would look the same; check, or choose with "
                                 "--depth-convention planar");
    } else if (!within_one && convention.meaning == DepthMeaning::normalised) {
        convention = from_row(rows[0]);
        found.reasons.push_back(fmt::format("depths up to {:.4g} are not normalised: planar", s.maximum));
    }
    if (s.zero * 50 > s.pixels && !convention.zero_is_far && convention.meaning == DepthMeaning::planar) {
        convention.zero_is_far = true;
        found.reasons.push_back(fmt::format("{} pixels are exactly 0: taken as nothing hit", s.zero));
    }
}

void report_values(DepthDetection& found) {
    const DepthStatistics& s = found.statistics;
    if (s.surfaces > 0)
        found.reasons.push_back(
            fmt::format("depths from {:.4g} to {:.4g}, median {:.4g}", s.minimum, s.maximum, s.median));
    if (s.sentinel > 0)
        found.reasons.push_back(fmt::format("{} pixels of 1e9 and above: nothing hit", s.sentinel));
    if (s.not_a_number + s.infinite > 0)
        found.warnings.push_back(
            fmt::format("{} pixels are NaN and {} infinite; they count as nothing hit", s.not_a_number, s.infinite));
    const DepthConvention& convention = found.convention;
    if (convention.meaning == DepthMeaning::normalised &&
        (convention.near_distance <= 0.0 || convention.far_distance <= 0.0))
        found.warnings.push_back(
            fmt::format("near and far are not in the file; say {},near=N,far=N", convention.text()));
    if (convention.meaning == DepthMeaning::distance)
        found.warnings.push_back("distance from the camera needs the camera to become depth");
}

} // namespace

Result<DepthDetection> detect_depth(const ExrImage& image, const ChannelGroup& group, std::string_view told) {
    DepthDetection found;
    if (group.channels.empty())
        return Error{ErrorCode::invalid_argument, fmt::format("{}: no depth channel", image.path.string())};
    found.statistics = depth_statistics_of(image.parts[group.part].channels[group.channels[0]].values);
    if (!told.empty()) {
        auto convention = parse_depth_convention(told);
        if (!convention)
            return convention.error();
        found.convention = *convention;
        found.confidence = Confidence::told;
        found.reasons.push_back(fmt::format("convention {} was told", convention->text()));
    } else {
        detect_by_name_and_header(image, group, found);
        detect_by_values(found);
    }
    report_values(found);
    return found;
}

// ------------------------------------------------------------------------------------------------- decoding

namespace {

// Depth along the axis over distance from the camera, for the middle of a pixel.
double axis_share(size_t x, size_t y, int width, int height, const Matrix4& projection) {
    if (projection[11] == 0.0f)
        return 1.0; // orthographic rays run along the axis
    const double ndc_x = 2.0 * (static_cast<double>(x) + 0.5) / width - 1.0;
    const double ndc_y = 2.0 * (static_cast<double>(y) + 0.5) / height - 1.0;
    // clip = P * (X, Y, -1, 1) with w = 1, off-centre terms in the third column.
    const double slope_x = (ndc_x + double{projection[8]}) / double{projection[0]};
    const double slope_y = (ndc_y + double{projection[9]}) / double{projection[5]};
    return 1.0 / std::sqrt(1.0 + slope_x * slope_x + slope_y * slope_y);
}

double decode_value(double value, const DepthConvention& convention) {
    if (!std::isfinite(value))
        return double{no_hit_depth};
    if (convention.negative)
        value = -value;
    if (value >= convention.sentinel || (convention.zero_is_far && value == 0.0))
        return double{no_hit_depth};
    if (convention.meaning == DepthMeaning::inverse)
        return value > 0.0 ? convention.scale / value : double{no_hit_depth};
    if (convention.meaning == DepthMeaning::normalised) {
        value = convention.inverted ? 1.0 - value : value;
        // The farthest value is where the background was cut off.
        if (value >= 1.0)
            return double{no_hit_depth};
        return (convention.near_distance + value * (convention.far_distance - convention.near_distance)) *
               convention.scale;
    }
    return value * convention.scale;
}

} // namespace

Result<std::vector<float>> decode_depth(const std::vector<float>& values, int width, int height,
                                        const DepthConvention& convention, const Matrix4* projection) {
    if (width < 1 || height < 1 || values.size() != static_cast<size_t>(width) * static_cast<size_t>(height))
        return Error{ErrorCode::invalid_argument,
                     fmt::format("{} depths do not fit {}x{} pixels", values.size(), width, height)};
    if (convention.meaning == DepthMeaning::distance && !projection)
        return Error{ErrorCode::invalid_argument, "depth that is the distance from the camera needs a camera"};
    if (convention.meaning == DepthMeaning::normalised &&
        !(convention.near_distance > 0.0 && convention.far_distance > convention.near_distance))
        return Error{ErrorCode::invalid_argument,
                     fmt::format("normalised depth needs near and far; say --depth-convention {},near=N,far=N",
                                 convention.text())};
    std::vector<float> result(values.size());
    const auto stride = static_cast<size_t>(width);
    for (size_t i = 0; i < values.size(); ++i) {
        double depth = decode_value(double{values[i]}, convention);
        if (convention.meaning == DepthMeaning::distance && depth < double{no_hit_depth})
            depth *= axis_share(i % stride, i / stride, width, height, *projection);
        // Nothing lies at the camera or behind it.
        result[i] = depth > 0.0 ? static_cast<float>(std::min(depth, double{no_hit_depth})) : no_hit_depth;
    }
    return result;
}

} // namespace sfumato::media
