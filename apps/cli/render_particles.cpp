#include "apps/cli/render_particles.h"

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

int particles_preroll(const EffectChain& chain) {
    constexpr int burst_frames = 12;
    for (const ChainLink& link : chain)
        if (const ParameterInfo* warm_up = link.effect->parameters->find("warm_up"))
            return warm_up->get(link.parameters.data()) > 0.0 ? 0 : burst_frames;
    return 0;
}

} // namespace sfumato::cli
