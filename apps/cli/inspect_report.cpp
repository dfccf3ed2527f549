// Text and JSON of an inspected file.
#include "apps/cli/inspect_report.h"

#include "apps/cli/camera_source.h"
#include "apps/cli/console.h"
#include "apps/cli/exit_code.h"
#include "apps/cli/frame_list.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sfumato::cli {

namespace {

using Json = nlohmann::ordered_json;

const char* type_name(media::PixelType type) {
    switch (type) {
    case media::PixelType::uint32:
        return "uint";
    case media::PixelType::half:
        return "half";
    case media::PixelType::float32:
        return "float";
    }
    return "";
}

std::string window_text(const media::Window& window) {
    return fmt::format("{},{} to {},{}", window.min_x, window.min_y, window.max_x, window.max_y);
}

template <class T>
std::string numbers_text(const std::vector<char>& bytes) {
    std::vector<T> numbers(bytes.size() / sizeof(T));
    std::memcpy(numbers.data(), bytes.data(), numbers.size() * sizeof(T));
    return fmt::format("{}", fmt::join(numbers, " "));
}

std::string rational_text(const std::vector<char>& bytes) {
    int32_t numerator = 0;
    uint32_t denominator = 0;
    std::memcpy(&numerator, bytes.data(), 4);
    std::memcpy(&denominator, bytes.data() + 4, 4);
    return fmt::format("{}/{}", numerator, denominator);
}

// Short, and safe to print whatever the file says.
std::string attribute_text(const media::ExrAttribute& attribute) {
    constexpr size_t longest = 70;
    std::string text;
    if (attribute.type == "string")
        text = one_line(std::string_view(attribute.bytes.data(), attribute.bytes.size()));
    else if (attribute.type == "int" || attribute.type == "v2i" || attribute.type == "v3i" ||
             attribute.type == "box2i" || attribute.type == "timecode")
        text = numbers_text<int32_t>(attribute.bytes);
    else if (attribute.type == "rational" && attribute.bytes.size() == 8)
        text = rational_text(attribute.bytes);
    else if (attribute.type == "float" || attribute.type == "v2f" || attribute.type == "v3f" ||
             attribute.type == "m44f" || attribute.type == "m33f" || attribute.type == "box2f" ||
             attribute.type == "chromaticities")
        text = numbers_text<float>(attribute.bytes);
    else if (attribute.type == "double" || attribute.type == "m44d")
        text = numbers_text<double>(attribute.bytes);
    else
        text = fmt::format("{} bytes", attribute.bytes.size());
    return text.size() > longest ? text.substr(0, longest) + "…" : text;
}

const char* confidence_name(media::Confidence confidence) {
    static const char* const names[] = {"told", "by name", "by attribute", "by values", "guess"};
    return names[static_cast<int>(confidence)];
}

const char* verdict_name(media::WarpVerdict verdict) {
    static const char* const names[] = {"confirmed", "wrong", "inconclusive"};
    return names[static_cast<int>(verdict)];
}

void add_lines(std::string& text, const char* prefix, const std::vector<std::string>& lines) {
    for (const std::string& line : lines)
        text += fmt::format("  {}{}\n", prefix, one_line(line));
}

std::string part_text(const media::ExrPart& part, size_t index) {
    std::string text = fmt::format("part {}{}: {}x{}, {}, {} compression\n", index,
                                   part.name.empty() ? "" : " '" + one_line(part.name) + "'", part.width(),
                                   part.height(), part.type, part.compression);
    text += fmt::format("  data window {}; display window {}; pixel aspect {:g}\n", window_text(part.data_window),
                        window_text(part.display_window), part.pixel_aspect);
    text += fmt::format("  {} channels:", part.channels.size());
    for (const media::ExrChannel& channel : part.channels)
        text += fmt::format(" {} ({})", one_line(channel.name), type_name(channel.type));
    text += "\n";
    for (const media::ExrAttribute& attribute : part.attributes)
        text += fmt::format("  {} ({}) = {}\n", one_line(attribute.name), one_line(attribute.type),
                            attribute_text(attribute));
    return text;
}

std::string choice_text(const char* role, const media::ChannelChoice& choice) {
    std::string text = fmt::format("{}: {}\n", role, choice.chosen ? one_line(choice.chosen->text()) : "none");
    add_lines(text, "", choice.reasons);
    return text;
}

std::string warp_text(const FileReport& report) {
    if (!report.warp.report)
        return fmt::format("  warp check: none, {}\n", one_line(report.warp.why_not));
    std::string text = fmt::format("  warp check: {}\n", one_line(report.warp.report->text()));
    if (report.warp.report->verdict == media::WarpVerdict::wrong)
        text += fmt::format("  convention {} is wrong; better: --motion-convention {}\n",
                            report.motion->convention.text(), report.warp.report->best_other.convention.text());
    return text;
}

std::string camera_text(const FileReport& report) {
    if (!report.camera)
        return fmt::format("camera: {}\n",
                           report.camera_problem.empty() ? "none in the header" : one_line(report.camera_problem));
    const auto row = [](const Matrix4& m, size_t r) {
        return fmt::format("{:g} {:g} {:g} {:g}", m[r], m[4 + r], m[8 + r], m[12 + r]);
    };
    std::string text = fmt::format("camera: from {}\n", one_line(report.camera_source));
    for (size_t r = 0; r < 3; ++r)
        text += fmt::format("  world to view row {}: {}\n", r, row(report.camera->world_to_view, r));
    return text;
}

} // namespace

std::string report_text(const FileReport& report) {
    std::string text = one_line(report.image.path.string()) + "\n";
    for (size_t i = 0; i < report.image.parts.size(); ++i)
        text += part_text(report.image.parts[i], i);
    text += choice_text("colour", report.channels.colour);
    text += choice_text("depth", report.channels.depth);
    if (report.depth) {
        text += fmt::format("  convention {} ({}): {}\n", report.depth->convention.text(),
                            confidence_name(report.depth->confidence), report.depth->convention.description());
        add_lines(text, "", report.depth->reasons);
        add_lines(text, "warning: ", report.depth->warnings);
    }
    text += choice_text("normals", report.channels.normal);
    if (report.normals) {
        text += fmt::format("  space {} ({}): {}\n", report.normals->convention.text(),
                            confidence_name(report.normals->confidence), report.normals->convention.description());
        add_lines(text, "", report.normals->reasons);
        add_lines(text, "warning: ", report.normals->warnings);
    }
    text += choice_text("motion", report.channels.motion);
    if (report.motion) {
        text += fmt::format("  convention {} ({}): {}\n", report.motion->convention.text(),
                            confidence_name(report.motion->confidence), report.motion->convention.description());
        add_lines(text, "", report.motion->reasons);
        add_lines(text, "warning: ", report.motion->warnings);
        text += warp_text(report);
    }
    text += camera_text(report);
    text += "values:\n";
    for (const ChannelValues& v : report.values)
        text += fmt::format("  {:<8} {:<28} {:>12.6g} to {:<12.6g} {} NaN, {} infinite\n", v.role, one_line(v.name),
                            v.minimum, v.maximum, v.not_a_number, v.infinite);
    text.pop_back();
    return text;
}

namespace {

Json window_json(const media::Window& window) {
    return {window.min_x, window.min_y, window.max_x, window.max_y};
}

Json part_json(const media::ExrPart& part) {
    Json json = {{"name", part.name},
                 {"type", part.type},
                 {"compression", part.compression},
                 {"data_window", window_json(part.data_window)},
                 {"display_window", window_json(part.display_window)},
                 {"pixel_aspect", part.pixel_aspect}};
    for (const media::ExrChannel& channel : part.channels)
        json["channels"].push_back({{"name", channel.name}, {"type", type_name(channel.type)}});
    json["attributes"] = Json::object();
    for (const media::ExrAttribute& attribute : part.attributes)
        json["attributes"][attribute.name] = {{"type", attribute.type}, {"value", attribute_text(attribute)}};
    return json;
}

Json choice_json(const media::ChannelChoice& choice) {
    Json json = {{"channels", nullptr}, {"reasons", choice.reasons}};
    if (choice.chosen) {
        json["channels"] = choice.chosen->text();
        json["part"] = choice.chosen->part;
    }
    return json;
}

Json warp_json(const WarpOutcome& warp) {
    if (!warp.report)
        return {{"verdict", "none"}, {"why", warp.why_not}};
    const media::WarpReport& report = *warp.report;
    Json json = {{"verdict", verdict_name(report.verdict)},
                 {"error_still", report.error_still},
                 {"error_as_read", report.error_chosen},
                 {"moving_pixels", report.moving},
                 {"samples", report.used},
                 {"reasons", report.reasons},
                 {"best_other", report.best_other.change},
                 {"best_other_error", report.best_other.error},
                 {"best_other_convention", report.best_other.convention.text()}};
    return json;
}

template <class Detection>
void add_detection(Json& json, const Detection& detection) {
    json["convention"] = detection.convention.text();
    json["meaning"] = detection.convention.description();
    json["confidence"] = confidence_name(detection.confidence);
    for (const std::string& reason : detection.reasons)
        json["reasons"].push_back(reason);
    json["warnings"] = detection.warnings;
}

} // namespace

Json report_json(const FileReport& report) {
    Json json = {{"file", report.image.path.string()}};
    for (const media::ExrPart& part : report.image.parts)
        json["parts"].push_back(part_json(part));
    json["colour"] = choice_json(report.channels.colour);
    json["depth"] = choice_json(report.channels.depth);
    if (report.depth)
        add_detection(json["depth"], *report.depth);
    json["normals"] = choice_json(report.channels.normal);
    if (report.normals) {
        add_detection(json["normals"], *report.normals);
        for (const media::NormalReading& reading : report.normals->readings)
            json["normals"]["agreement"][reading.convention.text()] = reading.agreement;
    }
    json["motion"] = choice_json(report.channels.motion);
    if (report.motion) {
        add_detection(json["motion"], *report.motion);
        json["motion"]["warp_check"] = warp_json(report.warp);
    }
    json["camera"] = nullptr;
    if (report.camera)
        json["camera"] = {{"world_to_view", report.camera->world_to_view}, {"projection", report.camera->projection}};
    for (const ChannelValues& v : report.values)
        json["values"].push_back({{"role", v.role},
                                  {"channel", v.name},
                                  {"type", v.type},
                                  {"minimum", v.minimum},
                                  {"maximum", v.maximum},
                                  {"nan", v.not_a_number},
                                  {"infinite", v.infinite}});
    return json;
}

namespace {

ChannelValues values_of(const media::ExrChannel& channel, const char* role) {
    ChannelValues result{channel.name, type_name(channel.type), role, 0.0, 0.0, 0, 0};
    bool any = false;
    const auto add = [&](double value) {
        result.minimum = any ? std::min(result.minimum, value) : value;
        result.maximum = any ? std::max(result.maximum, value) : value;
        any = true;
    };
    for (const float value : channel.values) {
        result.not_a_number += std::isnan(value) ? 1 : 0;
        result.infinite += std::isinf(value) ? 1 : 0;
        if (std::isfinite(value))
            add(double{value});
    }
    for (const uint32_t value : channel.integers)
        add(double{static_cast<double>(value)});
    return result;
}

void add_values(FileReport& report, const std::optional<media::ChannelGroup>& group, const char* role) {
    if (group)
        for (const size_t channel : group->channels)
            report.values.push_back(values_of(report.image.parts[group->part].channels[channel], role));
}

} // namespace

namespace {

void add_camera(FileReport& report, const std::filesystem::path& path, const CameraSource& cameras) {
    FrameJob job;
    job.input = path;
    job.frame = neighbours_of(path).frame;
    Frame facts;
    if (auto filled = cameras.fill(facts, job, report.image.parts.front()); !filled)
        report.camera_problem = filled.error().message;
    report.camera = facts.camera;
    report.camera_source = cameras.track() ? cameras.path() : "worldToCamera and worldToNDC";
}

// The evidence is depth as the effects would take it; without it the space is what names and header say.
Result<void> add_normals(FileReport& report, const ConventionOptions& options) {
    const media::ChannelGroup& group = *report.channels.normal.chosen;
    const Camera* camera = report.camera ? &*report.camera : nullptr;
    std::vector<float> depth;
    if (report.depth && camera) {
        const media::Planes planes =
            planes_in_window(report.image, *report.channels.depth.chosen, group.part, media::no_hit_depth);
        if (auto decoded = media::decode_depth(planes.channels.front(), planes.width, planes.height,
                                               report.depth->convention, &camera->projection);
            decoded)
            depth = std::move(*decoded);
    }
    auto normals = media::detect_normals(report.image, group, options.normals, media::planes_of(report.image, group),
                                         depth, camera);
    if (!normals)
        return normals.error();
    report.normals = std::move(*normals);
    return {};
}

} // namespace

Result<FileReport> inspect_file(const std::filesystem::path& path, const ConventionOptions& options,
                                const CameraSource& cameras, int threads) {
    media::ExrReadOptions read_options;
    read_options.threads = threads;
    auto image = media::read_exr(path, read_options);
    if (!image)
        return as_input(image.error());
    FileReport report;
    report.image = std::move(*image);
    auto channels = choose_channels(report.image, options.layer);
    if (!channels)
        return channels.error();
    report.channels = std::move(*channels);
    add_values(report, report.channels.colour.chosen, "colour");
    add_values(report, report.channels.depth.chosen, "depth");
    add_values(report, report.channels.normal.chosen, "normals");
    add_values(report, report.channels.motion.chosen, "motion");
    add_values(report, report.channels.motion.companion, "motion");
    if (report.channels.depth.chosen) {
        auto depth = media::detect_depth(report.image, *report.channels.depth.chosen, options.depth);
        if (!depth)
            return depth.error();
        report.depth = std::move(*depth);
    }
    if (report.channels.motion.chosen) {
        auto motion = media::detect_motion(report.image, *report.channels.motion.chosen, options.motion);
        if (!motion)
            return motion.error();
        report.motion = std::move(*motion);
        const Neighbours beside = neighbours_of(path);
        report.warp = check_with_neighbours(report.image, report.channels, report.motion->convention, options.layer,
                                            beside.previous, beside.next);
    }
    add_camera(report, path, cameras);
    if (report.channels.normal.chosen)
        if (auto added = add_normals(report, options); !added)
            return added.error();
    return report;
}

} // namespace sfumato::cli
