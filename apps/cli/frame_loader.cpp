// Reading frames, and filling the roles of the effects from their channels.
#include "apps/cli/frame_loader.h"

#include "apps/cli/exit_code.h"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sfumato::cli {

namespace {

Extent extent_of(const media::Planes& planes) {
    return {static_cast<uint32_t>(planes.width), static_cast<uint32_t>(planes.height)};
}

RolePicture interleave(const media::Planes& planes) {
    const size_t count = planes.channels.size();
    RolePicture picture{extent_of(planes), static_cast<uint32_t>(count), {}};
    picture.values.resize(planes.pixel_count() * count);
    for (size_t c = 0; c < count; ++c)
        for (size_t i = 0; i < planes.pixel_count(); ++i)
            picture.values[i * count + c] = planes.channels[c][i];
    return picture;
}

// Red, green, blue and alpha, whatever the file has of them.
RolePicture colour_picture(const media::ExrImage& image, const media::ChannelGroup& group) {
    media::Planes planes = media::colour_planes_of(image, group);
    if (group.channels.size() == 4) {
        const media::ChannelGroup alpha{group.part, group.layer, {group.channels[3]}, {}, {}, 0};
        planes.channels.push_back(std::move(media::planes_of(image, alpha).channels.front()));
    } else {
        planes.channels.emplace_back(planes.pixel_count(), 1.0f);
    }
    return interleave(planes);
}

std::string last_component(const std::string& name) {
    return name.substr(name.rfind('.') + 1);
}

} // namespace

media::ChannelGroup named_group(const media::ExrImage& image, std::string_view role) {
    static constexpr std::array<std::string_view, 14> order = {"R", "X", "U", "r", "x", "u", "G",
                                                               "Y", "V", "g", "y", "v", "B", "Z"};
    for (size_t p = 0; p < image.parts.size(); ++p) {
        std::vector<std::pair<size_t, size_t>> found; // place in `order`, channel
        for (size_t c = 0; c < image.parts[p].channels.size(); ++c) {
            const std::string& name = image.parts[p].channels[c].name;
            const size_t dot = name.rfind('.');
            const std::string letter = last_component(name);
            const auto place = static_cast<size_t>(std::find(order.begin(), order.end(), letter) - order.begin());
            if (letter == role || (image.parts[p].name == role && dot == std::string::npos))
                found.emplace_back(place, c);
            else if (dot != std::string::npos && last_component(name.substr(0, dot)) == role && place < order.size())
                found.emplace_back(place, c);
        }
        std::sort(found.begin(), found.end());
        media::ChannelGroup group{p, std::string(role), {}, {}, {}, 0};
        for (const auto& [place, channel] : found)
            group.channels.push_back(channel);
        if (!group.channels.empty())
            return group;
    }
    return {};
}

Result<FrameLoader> FrameLoader::create(const EffectChain& chain, const LoaderOptions& options, Console& console) {
    auto cameras = CameraSource::open(options.camera);
    if (!cameras)
        return cameras.error();
    return FrameLoader(chain, options, console, std::move(*cameras));
}

bool FrameLoader::needs(std::string_view role) const {
    return chain_uses(*chain_, role);
}

void FrameLoader::tell(Findings& findings) const {
    for (const std::string& note : findings.notes)
        console_->note(note);
    for (const std::string& warning : findings.warnings)
        console_->warn(warning);
    findings = {};
}

Result<void> FrameLoader::settle(const LoadedFrame& frame, const media::ChannelSelection& channels) {
    const media::ExrImage& image = frame.image;
    Findings findings;
    for (const media::ChannelChoice* choice : {&channels.colour, &channels.depth, &channels.normal, &channels.motion})
        for (const std::string& reason : choice->reasons)
            findings.notes.push_back(reason);
    const bool needs_motion = needs("velocity") || needs("next_velocity");
    if (needs("depth") && channels.depth.chosen) {
        auto depth = settle_depth(image, channels, options_.conventions, findings);
        if (!depth)
            return depth.error();
        depth_ = *depth;
    } else if (needs("depth") && needs_motion && channels.motion.chosen) {
        findings.warnings.push_back(
            fmt::format("{}: no depth channel; everything counts as one distance", frame.job.input.string()));
    }
    tell(findings);
    if (needs_motion && channels.motion.chosen) {
        auto motion =
            settle_motion(image, channels, options_.conventions, frame.job.previous, frame.job.next, findings);
        tell(findings);
        if (!motion)
            return motion.error();
        motion_ = *motion;
    }
    return {};
}

// After depth, which is the evidence.
Result<void> FrameLoader::settle_normals_of(const LoadedFrame& frame, const media::ChannelSelection& channels,
                                            Findings& findings) {
    if (!needs("normal"))
        return {};
    if (!channels.normal.chosen) {
        findings.notes.push_back("normals: none; they are derived from depth");
        return {};
    }
    const auto depth = frame.roles.find("depth");
    auto normals = settle_normals(frame.image, channels, frame.colour.part, options_.conventions,
                                  depth == frame.roles.end() ? std::vector<float>{} : depth->second.values,
                                  frame.facts.camera ? &*frame.facts.camera : nullptr, findings);
    if (!normals)
        return normals.error();
    normals_ = *normals;
    return {};
}

Result<void> FrameLoader::add_depth(LoadedFrame& frame, const media::ChannelSelection& channels) {
    if (!depth_)
        return {};
    if (!channels.depth.chosen)
        return input_error(
            fmt::format("{}: no depth channel, while the frames before have one", frame.job.input.string()));
    const media::Planes planes =
        planes_in_window(frame.image, *channels.depth.chosen, frame.colour.part, media::no_hit_depth);
    const Matrix4* projection = frame.facts.camera ? &frame.facts.camera->projection : nullptr;
    auto decoded = media::decode_depth(planes.channels.front(), planes.width, planes.height, *depth_, projection);
    if (!decoded)
        return usage_error(fmt::format("{}: {}", frame.job.input.string(), decoded.error().message));
    frame.roles["depth"] = {extent_of(planes), 1, std::move(*decoded)};
    return {};
}

Result<void> FrameLoader::add_motion(LoadedFrame& frame, const media::ChannelSelection& channels) {
    if (!motion_)
        return {};
    if (!channels.motion.chosen)
        return input_error(
            fmt::format("{}: no motion channels, while the frames before have them", frame.job.input.string()));
    const media::Planes planes = planes_in_window(frame.image, *channels.motion.chosen, frame.colour.part, 0.0f);
    media::Planes companion;
    if (channels.motion.companion)
        companion = planes_in_window(frame.image, *channels.motion.companion, frame.colour.part, 0.0f);
    const media::Window& display = frame.image.parts[frame.colour.part].display_window;
    auto field =
        media::decode_motion(planes, *motion_, static_cast<int>(display.width()), static_cast<int>(display.height()),
                             channels.motion.companion ? &companion : nullptr);
    if (!field)
        return input_error(fmt::format("{}: {}", frame.job.input.string(), field.error().message));
    if (needs("velocity"))
        frame.roles["velocity"] = {extent_of(planes), 2, std::move(field->velocity)};
    if (needs("next_velocity") && !field->next.empty())
        frame.roles["next_velocity"] = {extent_of(planes), 2, std::move(field->next)};
    return {};
}

// Normals, and anything else that bears a role's name.
void FrameLoader::add_others(LoadedFrame& frame, const media::ChannelSelection& channels) {
    for (const ChainLink& link : *chain_) {
        for (const ImageRole& role : link.effect->images) {
            if (role.is_output() || frame.roles.contains(role.name) || std::string_view(role.name) == "depth" ||
                std::string_view(role.name).ends_with("velocity") || !uses_input(link, role))
                continue;
            const bool is_normal = std::string_view(role.name).starts_with("normal");
            const media::ChannelGroup group = is_normal ? channels.normal.chosen.value_or(media::ChannelGroup{})
                                                        : named_group(frame.image, role.name);
            if (group.channels.size() < role.components || group.channels.empty())
                continue;
            media::Planes planes = planes_in_window(frame.image, group, frame.colour.part, 0.0f);
            if (is_normal && normals_)
                media::decode_normals(planes, *normals_);
            frame.roles[role.name] = interleave(planes);
        }
    }
}

namespace {

// What was asked for cannot be made without it, though the effect can do without.
bool is_asked_for(const ChainLink& link, const ImageRole& role) {
    const std::string_view name = role.name;
    return (name == "shadow" || name == "ambient" || name == "colour" || name == "profile") && role.is_optional() &&
           uses_input(link, role);
}

} // namespace

Result<void> FrameLoader::check_complete(const LoadedFrame& frame) const {
    const std::string file = frame.job.input.string();
    for (const ChainLink& link : *chain_) {
        for (const ImageRole& role : link.effect->images)
            if (!frame.roles.contains(role.name) && (role.use == ImageUse::input || is_asked_for(link, role)))
                return input_error(fmt::format("{}: {} needs '{}' ({}), and no channel has it; the layers are {}", file,
                                               link.effect->name, role.name, role.doc,
                                               fmt::join(media::layer_names(frame.image), ", ")));
        // The only thing that a table of roles cannot say: motion comes from vectors or from cameras.
        const bool blurs_motion = std::string_view(link.effect->name) == "motion-blur";
        const bool cameras = frame.facts.camera && (frame.facts.previous_camera || frame.facts.next_camera);
        if (blurs_motion && !frame.roles.contains("velocity") && !(cameras && frame.roles.contains("depth")))
            return input_error(fmt::format("{}: motion-blur needs motion channels (Vector, motion, velocity, …), or "
                                           "depth and the cameras of this and "
                                           "a neighbouring frame (--camera FILE.toml); the layers are {}",
                                           file, fmt::join(media::layer_names(frame.image), ", ")));
    }
    return {};
}

// The result goes to the part of the colour, or without one to that of the depth.
Result<void> FrameLoader::place_result(LoadedFrame& frame, const media::ChannelSelection& channels) const {
    if (channels.colour.chosen)
        frame.colour = *channels.colour.chosen;
    else if (!needs("colour") && channels.depth.chosen)
        frame.colour = {channels.depth.chosen->part, "", {}, "", "", 0};
    else
        return input_error(fmt::format("{}: no colour channels; the layers are {} (--layer chooses)",
                                       frame.job.input.string(), fmt::join(media::layer_names(frame.image), ", ")));
    const media::ExrPart& part = frame.image.parts[frame.colour.part];
    frame.extent = {static_cast<uint32_t>(part.width()), static_cast<uint32_t>(part.height())};
    return {};
}

Result<void> FrameLoader::check_camera(const LoadedFrame& frame) const {
    for (const ChainLink& link : *chain_)
        if (link.effect->needs_camera && !frame.facts.camera)
            return input_error(fmt::format("{}: {} needs a camera, and the file has none (worldToCamera, worldToNDC); "
                                           "give --camera FILE.toml",
                                           frame.job.input.string(), link.effect->name));
    return {};
}

Result<void> FrameLoader::decode(LoadedFrame& frame, const media::ChannelSelection& channels) {
    if (!settled_)
        if (auto settled = settle(frame, channels); !settled)
            return settled;
    if (needs("colour"))
        frame.roles["colour"] = colour_picture(frame.image, frame.colour);
    if (auto added = add_depth(frame, channels); !added)
        return added;
    if (auto added = add_motion(frame, channels); !added)
        return added;
    if (!settled_) {
        Findings findings;
        auto settled = settle_normals_of(frame, channels, findings);
        tell(findings);
        if (!settled)
            return settled;
        settled_ = true;
    }
    add_others(frame, channels);
    return check_complete(frame);
}

Result<LoadedFrame> FrameLoader::load(const FrameJob& job) {
    media::ExrReadOptions read_options;
    read_options.threads = options_.threads;
    auto image = media::read_exr(job.input, read_options);
    if (!image)
        return as_input(image.error());
    auto channels = choose_channels(*image, options_.conventions.layer);
    if (!channels)
        return channels.error();
    LoadedFrame frame{job, std::move(*image), {}, {}, {}, {}};
    frame.facts.index = static_cast<uint64_t>(static_cast<int64_t>(job.frame));
    if (auto placed = place_result(frame, *channels); !placed)
        return placed.error();
    if (auto filled = cameras_.fill(frame.facts, job, frame.image.parts[frame.colour.part]); !filled)
        return filled.error();
    if (auto checked = check_camera(frame); !checked)
        return checked.error();
    if (auto decoded = decode(frame, *channels); !decoded)
        return decoded.error();
    return frame;
}

} // namespace sfumato::cli
