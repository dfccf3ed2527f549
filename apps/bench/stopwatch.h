// GPU time of an effect's whole chain and of each of its passes.
#pragma once

#include "apps/bench/effect_run.h"
#include "apps/bench/rig.h"
#include "sfumato/context.h"

#include <functional>
#include <span>
#include <string>
#include <vector>

namespace sfumato::bench {

// Milliseconds.
struct Statistics {
    double median = 0.0;
    double minimum = 0.0;
    double p95 = 0.0;
    size_t samples = 0;
};

Statistics statistics(std::vector<double> samples);

struct TimingOptions {
    int frames = 100;
    double warm_up = 0.3; // seconds of work before the first sample: clocks settle
    uint32_t batch = 8;   // frames in a command buffer, 1 to 8
};

// The frames that a measurement goes round through, so that a cache does not keep the inputs of the frame before.
struct InputSet {
    Frame frame;
    BoundImages images;
};

struct ChainTime {
    Statistics chain;
    MemoryUsage memory;
};

// Stamps around the whole chain; no stamps between passes.
Result<ChainTime> time_chain(Rig& rig, const EffectInfo& effect, const void* parameters,
                             std::span<const InputSet> inputs, const TimingOptions& options);

struct PassStatistics {
    std::string pass;
    Statistics time;
};

// Records one frame of what is timed, the next with every call.
using RecordFrame = std::function<Result<void>(VkCommandBuffer commands)>;

// The same of anything that a context with 2 * options.batch frames in flight records.
Result<Statistics> time_frames(Rig& rig, const RecordFrame& record, const TimingOptions& options);

// By the library's own stamps, in the order of execution.
Result<std::vector<PassStatistics>> time_passes(Rig& rig, const EffectInfo& effect, const void* parameters,
                                                std::span<const InputSet> inputs, const TimingOptions& options);

// The same of anything that a context with options.batch frames in flight and timestamps records; `times` tells those
// of the newest frame, as Executor::times does.
Result<std::vector<PassStatistics>> time_passes(Rig& rig, const RecordFrame& record,
                                                const std::function<std::vector<PassTime>()>& times,
                                                const TimingOptions& options);

} // namespace sfumato::bench
