// What `sfumato render --particles PRESET` stands for.
#pragma once

#include "apps/cli/frame_loader.h"

namespace sfumato::cli {

// Puts the effect before the others, with its preset; "" leaves everything as it is.
void add_particles(ChainOptions& chain, const std::string& preset);

// What `--particle-texture FILE` gives as the image `profile`: of an EXR the layer or channel of that name, else its
// colour's first channel; nothing where neither file nor chain ask for it. Errors: usage where only one of them does,
// input for files.
Result<RolePicture> particle_texture(const std::string& file, const EffectChain& chain);

// Frames to run before the first: none where the particles warm up, some where a burst has just begun.
int particles_preroll(const EffectChain& chain);

} // namespace sfumato::cli
