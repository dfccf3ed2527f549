// Settling the conventions of a sequence on its first frame.
#include "apps/cli/conventions.h"

#include "apps/cli/effect_chain.h"
#include "apps/cli/exit_code.h"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sstream>

namespace sfumato::cli {

namespace fs = std::filesystem;

media::Planes planes_in_window(const media::ExrImage& image, const media::ChannelGroup& group, size_t part,
                               float outside) {
    const media::Window& target = image.parts[part].data_window;
    const media::Window& source = image.parts[group.part].data_window;
    media::Planes planes = media::planes_of(image, group);
    if (source == target)
        return planes;
    const auto width = static_cast<size_t>(target.width()), source_width = static_cast<size_t>(source.width());
    const int64_t left = std::max(source.min_x, target.min_x), right = std::min(source.max_x, target.max_x);
    for (std::vector<float>& plane : planes.channels) {
        std::vector<float> moved(image.parts[part].pixel_count(), outside);
        for (int64_t y = std::max(source.min_y, target.min_y); y <= std::min(source.max_y, target.max_y); ++y) {
            if (left > right)
                break;
            const auto from =
                static_cast<size_t>(y - source.min_y) * source_width + static_cast<size_t>(left - source.min_x);
            const auto to = static_cast<size_t>(y - target.min_y) * width + static_cast<size_t>(left - target.min_x);
            std::copy_n(plane.begin() + static_cast<ptrdiff_t>(from), right - left + 1,
                        moved.begin() + static_cast<ptrdiff_t>(to));
        }
        plane = std::move(moved);
    }
    planes.width = static_cast<int>(target.width());
    planes.height = static_cast<int>(target.height());
    return planes;
}

Result<media::ChannelSelection> choose_channels(const media::ExrImage& image, const std::string& layer) {
    auto channels = media::select_channels(image, layer);
    if (channels)
        return channels;
    // A layer may be named by its path or by any component of it.
    std::vector<std::string> names = media::layer_names(image);
    for (const std::string& name : media::layer_names(image)) {
        std::istringstream components(name);
        for (std::string component; std::getline(components, component, '.');)
            names.push_back(component);
    }
    return usage_error(channels.error().message + did_you_mean(layer, names));
}

Result<void> check_convention_words(const ConventionOptions& options) {
    const auto base = [](const std::string& text) { return text.substr(0, text.find(',')); };
    if (!options.motion.empty())
        if (auto parsed = media::parse_motion_convention(options.motion); !parsed)
            return usage_error(parsed.error().message +
                               did_you_mean(base(options.motion), media::motion_convention_names()));
    if (!options.depth.empty())
        if (auto parsed = media::parse_depth_convention(options.depth); !parsed)
            return usage_error(parsed.error().message +
                               did_you_mean(base(options.depth), media::depth_convention_names()));
    if (!options.normals.empty() && options.normals != "auto")
        if (auto parsed = media::parse_normal_convention(options.normals); !parsed)
            return usage_error("--normal-space: " + parsed.error().message);
    return {};
}

namespace {

// Colour and, in raw values, depth of a neighbouring frame.
struct NeighbourPictures {
    media::Planes colour;
    std::vector<float> depth;
};

std::optional<NeighbourPictures> read_neighbour(const std::optional<fs::path>& path, const std::string& layer,
                                                const media::Window& window) {
    if (!path)
        return std::nullopt;
    const auto image = media::read_exr(*path);
    if (!image)
        return std::nullopt;
    const auto channels = media::select_channels(*image, layer);
    if (!channels || !channels->colour.chosen)
        return std::nullopt;
    const media::ChannelGroup& colour = *channels->colour.chosen;
    if (image->parts[colour.part].data_window != window)
        return std::nullopt;
    NeighbourPictures pictures{media::colour_planes_of(*image, colour), {}};
    if (channels->depth.chosen && image->parts[channels->depth.chosen->part].data_window == window)
        pictures.depth = media::planes_of(*image, *channels->depth.chosen).channels.front();
    return pictures;
}

} // namespace

WarpOutcome check_with_neighbours(const media::ExrImage& image, const media::ChannelSelection& channels,
                                  const media::MotionConvention& convention, const std::string& layer,
                                  const std::optional<fs::path>& previous, const std::optional<fs::path>& next) {
    if (!channels.colour.chosen || !channels.motion.chosen)
        return {std::nullopt, "colour or motion is missing"};
    const media::ExrPart& part = image.parts[channels.colour.chosen->part];
    const auto before = read_neighbour(previous, layer, part.data_window);
    const auto after = read_neighbour(next, layer, part.data_window);
    if (!before && !after)
        return {std::nullopt, "no neighbouring frame of the same size beside it"};
    const size_t index = channels.colour.chosen->part;
    const media::Planes colour = media::colour_planes_of(image, *channels.colour.chosen);
    const media::Planes motion = planes_in_window(image, *channels.motion.chosen, index, 0.0f);
    media::Planes companion, depth;
    media::WarpInput input;
    input.colour = &colour;
    input.motion = &motion;
    if (channels.motion.companion) {
        companion = planes_in_window(image, *channels.motion.companion, index, 0.0f);
        input.companion = &companion;
    }
    if (channels.depth.chosen) {
        depth = planes_in_window(image, *channels.depth.chosen, index, media::no_hit_depth);
        input.depth = &depth.channels.front();
    }
    input.screen_width = static_cast<int>(part.display_window.width());
    input.screen_height = static_cast<int>(part.display_window.height());
    if (before) {
        input.previous_colour = &before->colour;
        input.previous_depth = before->depth.empty() ? nullptr : &before->depth;
    }
    if (after) {
        input.next_colour = &after->colour;
        input.next_depth = after->depth.empty() ? nullptr : &after->depth;
    }
    auto report = media::check_by_warping(input, convention);
    if (!report)
        return {std::nullopt, report.error().message};
    return {std::move(*report), ""};
}

namespace {

bool is_told_by_file(media::Confidence confidence) {
    return confidence == media::Confidence::named || confidence == media::Confidence::attribute;
}

} // namespace

Result<media::MotionConvention> settle_motion(const media::ExrImage& image, const media::ChannelSelection& channels,
                                              const ConventionOptions& options, const std::optional<fs::path>& previous,
                                              const std::optional<fs::path>& next, Findings& findings) {
    const media::ChannelGroup& group = *channels.motion.chosen;
    auto found = media::detect_motion(image, group, options.motion);
    if (!found)
        return as_input(found.error());
    const std::string file = image.path.string();
    const std::string name = found->convention.text();
    for (const std::string& reason : found->reasons)
        findings.notes.push_back("motion: " + reason);
    for (const std::string& warning : found->warnings)
        (found->all_zero ? findings.warnings : findings.notes).push_back(fmt::format("{}: motion: {}", file, warning));
    const WarpOutcome warp = check_with_neighbours(image, channels, found->convention, options.layer, previous, next);
    findings.notes.push_back("motion: warp check: " + (warp.report ? warp.report->text() : "none, " + warp.why_not));
    const auto verdict = warp.report ? warp.report->verdict : media::WarpVerdict::inconclusive;
    if (verdict == media::WarpVerdict::wrong)
        findings.warnings.push_back(
            fmt::format("{}: motion convention {} looks wrong: the neighbouring frame is better explained by {}; say "
                        "--motion-convention {} if it is",
                        file, name, warp.report->best_other.change, warp.report->best_other.convention.text()));
    const bool settled = found->confidence == media::Confidence::told || is_told_by_file(found->confidence) ||
                         verdict == media::WarpVerdict::confirmed || found->all_zero;
    if (!settled)
        return usage_error(
            fmt::format("{}: nothing tells what the motion channels {} mean ({} is a guess); say --motion-convention "
                        "{} or another of {}",
                        file, group.text(), name,
                        verdict == media::WarpVerdict::wrong ? warp.report->best_other.convention.text() : name,
                        fmt::join(media::motion_convention_names(), ", ")));
    return found->convention;
}

Result<media::DepthConvention> settle_depth(const media::ExrImage& image, const media::ChannelSelection& channels,
                                            const ConventionOptions& options, Findings& findings) {
    const media::ChannelGroup& group = *channels.depth.chosen;
    auto found = media::detect_depth(image, group, options.depth);
    if (!found)
        return as_input(found.error());
    for (const std::string& reason : found->reasons)
        findings.notes.push_back("depth: " + reason);
    for (const std::string& warning : found->warnings)
        findings.notes.push_back(fmt::format("{}: depth: {}", image.path.string(), warning));
    return found->convention;
}

Result<media::NormalConvention> settle_normals(const media::ExrImage& image, const media::ChannelSelection& channels,
                                               size_t part, const ConventionOptions& options,
                                               const std::vector<float>& depth, const Camera* camera,
                                               Findings& findings) {
    const media::ChannelGroup& group = *channels.normal.chosen;
    const auto found =
        media::detect_normals(image, group, options.normals, planes_in_window(image, group, part, 0.0f), depth, camera);
    if (!found)
        return found.error();
    for (const std::string& reason : found->reasons)
        findings.notes.push_back("normals: " + reason);
    for (const std::string& warning : found->warnings)
        findings.warnings.push_back(fmt::format("{}: {}", image.path.string(), warning));
    if (found->confidence == media::Confidence::guess)
        findings.warnings.push_back(fmt::format("{}: nothing tells the space of the normals {}: {} is assumed; say "
                                                "--normal-space view or world",
                                                image.path.string(), group.text(), found->convention.text()));
    return found->convention;
}

} // namespace sfumato::cli
