// A finished frame to its file: EXR with everything that the input had, or a PNG to look at.
#pragma once

#include "apps/cli/device_stage.h"

#include <string>

namespace sfumato::cli {

struct WriterOptions {
    bool png = false;
    bool full_float = false; // colour as 32-bit floats
    bool no_clobber = false;
    std::string command_line;
    int threads = 1; // for encoding
};

Result<void> write_frame(ProcessedFrame& frame, const EffectChain& chain, const WriterOptions& options);

// The channel of one component: "AO", "bent_normal.X".
std::string extra_channel(const std::string& name, const ImageRole& role, uint32_t component);

// Attributes that tell how an image was made. The same for the same command, whenever and wherever it runs.
void add_provenance(media::ExrPart& part, const EffectChain& chain, const std::string& command_line);

} // namespace sfumato::cli
