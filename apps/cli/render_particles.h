// What `sfumato render --particles PRESET` stands for.
#pragma once

#include "apps/cli/effect_chain.h"

namespace sfumato::cli {

// Puts the effect before the others, with its preset; "" leaves everything as it is.
void add_particles(ChainOptions& chain, const std::string& preset);

// Frames to run before the first: none where the particles warm up, some where a burst has just begun.
int particles_preroll(const EffectChain& chain);

} // namespace sfumato::cli
