// GPU time of an effect's whole chain and of each of its passes.
#pragma once

#include "apps/bench/effect_run.h"
#include "apps/bench/rig.h"
#include "sfumato/context.h"

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

// By the library's own stamps, in the order of execution.
Result<std::vector<PassStatistics>> time_passes(Rig& rig, const EffectInfo& effect, const void* parameters,
                                                std::span<const InputSet> inputs, const TimingOptions& options);

} // namespace sfumato::bench
