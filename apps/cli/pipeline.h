// Frames through three stages that overlap: a thread that reads, the device, a thread that writes. Results do not
// depend on which stage is faster: every stage keeps the order.
#pragma once

#include "apps/cli/device_stage.h"
#include "apps/cli/frame_writer.h"

#include <atomic>
#include <vector>

namespace sfumato::cli {

struct PipelineOptions {
    WriterOptions writer;
    bool skip_bad_frames = false;
};

struct PipelineReport {
    size_t written = 0;
    size_t skipped = 0;
    bool interrupted = false;
    std::vector<std::filesystem::path> outputs; // written, in order
};

// `first`: jobs.front() already loaded, if it is. An error leaves all frames before the bad one written and no partial
// file anywhere.
Result<PipelineReport> run_pipeline(const std::vector<FrameJob>& jobs, std::optional<LoadedFrame> first,
                                    FrameLoader& loader, DeviceStage& device, const EffectChain& chain,
                                    const PipelineOptions& options, Console& console);

// Set by Ctrl-C and by the shell's polite request to end; the pipeline then finishes what is in flight.
extern std::atomic<bool> interrupted;
void catch_interrupts();

} // namespace sfumato::cli
