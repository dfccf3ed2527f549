#include "apps/cli/render_particles.h"

#include "apps/cli/exit_code.h"
#include "media/channels.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sstream>

namespace sfumato::cli {

void add_particles(ChainOptions& chain, const std::string& preset) {
    if (preset.empty())
        return;
    // A preset without a name before it is for the effects that are named.
    if (!chain.preset.empty() && chain.preset.find('=') == std::string::npos) {
        std::string each;
        std::istringstream names(chain.effects);
        for (std::string name; std::getline(names, name, ',');)
            each += (each.empty() ? "" : ",") + name + "=" + chain.preset;
        chain.preset = each;
    }
    chain.effects = chain.effects.empty() ? "particles" : "particles," + chain.effects;
    chain.preset = "particles=" + preset + (chain.preset.empty() ? "" : "," + chain.preset);
}

Result<RolePicture> particle_texture(const std::string& file, const EffectChain& chain) {
    const bool is_needed = chain_uses(chain, "profile");
    if (file.empty() && !is_needed)
        return RolePicture{};
    if (file.empty())
        return usage_error("particles.profile=texture needs --particle-texture FILE");
    if (!is_needed)
        return usage_error("--particle-texture is for particles with --set particles.profile=texture");
    auto image = media::read_exr(file);
    if (!image)
        return image.error();
    media::ChannelGroup group = named_group(*image, "profile");
    if (group.channels.empty()) {
        const auto channels = media::select_channels(*image);
        if (!channels)
            return channels.error();
        if (!channels->colour.chosen)
            return input_error(fmt::format("{}: no channel 'profile' and no colour; the layers are {}", file,
                                           fmt::join(media::layer_names(*image), ", ")));
        group = *channels->colour.chosen;
    }
    media::Planes planes = media::planes_of(*image, group);
    return RolePicture{{static_cast<uint32_t>(planes.width), static_cast<uint32_t>(planes.height)},
                       1,
                       std::move(planes.channels.front())};
}

int particles_preroll(const EffectChain& chain) {
    constexpr int burst_frames = 12;
    for (const ChainLink& link : chain)
        if (const ParameterInfo* warm_up = link.effect->parameters->find("warm_up"))
            return warm_up->get(link.parameters.data()) > 0.0 ? 0 : burst_frames;
    return 0;
}

} // namespace sfumato::cli
