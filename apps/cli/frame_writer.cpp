// Putting results back into the images that they came from, and writing them.
#include "apps/cli/frame_writer.h"

#include "apps/cli/frame_list.h"
#include "media/png_file.h"

#include <algorithm>
#include <fmt/format.h>

namespace sfumato::cli {

void add_provenance(media::ExrPart& part, const EffectChain& chain, const std::string& command_line) {
    part.set_string_attribute("sfumato/command", command_line);
    for (const ChainLink& link : chain)
        part.set_string_attribute(fmt::format("sfumato/{}", link.effect->name), parameters_text(link));
}

std::string extra_channel(const std::string& name, const ImageRole& role, uint32_t component) {
    if (role.components == 1)
        return name;
    return fmt::format("{}.{}", name, (role.is_signed ? "XYZW" : "RGBA")[component]);
}

namespace {

std::vector<float> plane_of(const std::vector<float>& values, size_t components, size_t component) {
    std::vector<float> plane(values.size() / components);
    for (size_t i = 0; i < plane.size(); ++i)
        plane[i] = values[i * components + component];
    return plane;
}

void replace_colour(ProcessedFrame& frame, bool full_float) {
    media::ExrPart& part = frame.frame.image.parts[frame.frame.colour.part];
    for (size_t c = 0; c < frame.frame.colour.channels.size() && !frame.colour.empty(); ++c) {
        media::ExrChannel& channel = part.channels[frame.frame.colour.channels[c]];
        channel.values = plane_of(frame.colour, 4, c);
        channel.integers.clear();
        channel.type = full_float ? media::PixelType::float32 : media::PixelType::half;
    }
}

void add_extras(ProcessedFrame& frame) {
    media::ExrPart& part = frame.frame.image.parts[frame.frame.colour.part];
    for (const auto& [name, extra] : frame.extras)
        for (uint32_t c = 0; c < extra.role->components; ++c)
            part.set_channel(extra_channel(name, *extra.role, c),
                             plane_of(extra.picture.values, extra.picture.components, c));
}

bool is_shown(const ImageRole& role) {
    return role.components == 1 && !role.is_signed;
}

Result<void> write_picture(const ProcessedFrame& frame, const WriterOptions& options) {
    const media::ExrPart& part = frame.frame.image.parts[frame.frame.colour.part];
    // Without a picture, what was made in its place is shown as the brightness of a white surface.
    if (frame.colour.empty()) {
        const auto shown =
            std::ranges::find_if(frame.extras, [](const auto& extra) { return is_shown(*extra.second.role); });
        if (shown != frame.extras.end()) {
            const float* values = shown->second.picture.values.data();
            const auto picture = media::make_picture(static_cast<int>(part.width()), static_cast<int>(part.height()),
                                                     values, values, values);
            return media::write_png(frame.frame.job.output, picture, {options.no_clobber, true});
        }
    }
    const auto plane = [&](size_t c) -> const float* {
        return c < frame.frame.colour.channels.size() ? part.channels[frame.frame.colour.channels[c]].values.data()
                                                      : nullptr;
    };
    const bool grey = frame.frame.colour.channels.size() < 3;
    const auto picture = media::make_picture(static_cast<int>(part.width()), static_cast<int>(part.height()), plane(0),
                                             plane(grey ? 0 : 1), plane(grey ? 0 : 2), grey ? nullptr : plane(3));
    return media::write_png(frame.frame.job.output, picture, {options.no_clobber, true});
}

} // namespace

Result<void> write_frame(ProcessedFrame& frame, const EffectChain& chain, const WriterOptions& options) {
    replace_colour(frame, options.full_float || options.png);
    if (options.png)
        return write_picture(frame, options);
    add_extras(frame);
    add_provenance(frame.frame.image.parts[frame.frame.colour.part], chain, options.command_line);
    media::ExrWriteOptions write_options;
    write_options.no_clobber = options.no_clobber;
    write_options.threads = options.threads;
    return media::write_exr(frame.frame.job.output, frame.frame.image, write_options);
}

} // namespace sfumato::cli
