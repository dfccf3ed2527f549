// Records frames back to back, several to a command buffer and two command buffers in flight, so that the device never
// waits for the host and neither launches nor idle clocks are measured.
#include "apps/bench/stopwatch.h"

#include "apps/bench/gpu_clock.h"

#include <algorithm>
#include <array>
#include <chrono>

namespace sfumato::bench {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

// Records and submits frames of one effect with rising index.
class Stream {
  public:
    Stream(Rig& rig, const void* parameters, std::span<const InputSet> inputs)
        : rig_(rig), parameters_(parameters), inputs_(inputs) {}

    Result<void> open(const EffectInfo& effect, uint32_t frames_in_flight, bool timestamps) {
        auto context = rig_.create_context(frames_in_flight, timestamps);
        if (!context)
            return context.error();
        context_ = std::move(*context);
        auto made = AnyEffect::create(*context_, effect);
        if (!made)
            return made.error();
        effect_ = std::move(*made);
        return {};
    }

    Result<void> record(VkCommandBuffer commands) {
        const InputSet& input = inputs_[index_ % inputs_.size()];
        Frame frame = input.frame;
        frame.index = index_++;
        return effect_->record(commands, frame, parameters_, input.images.data());
    }

    AnyEffect& effect() { return *effect_; }
    Context& context() { return *context_; }

  private:
    Rig& rig_;
    const void* parameters_;
    std::span<const InputSet> inputs_;
    std::unique_ptr<Context> context_;
    std::unique_ptr<AnyEffect> effect_; // goes before its context
    uint64_t index_ = 0;
};

struct Batch {
    apps::Commands commands;
    std::unique_ptr<GpuClock> clock;
};

Result<void> submit_batch(Rig& rig, const RecordFrame& record, Batch& batch, uint32_t frames) {
    if (auto begun = rig.device().begin(batch.commands); !begun)
        return begun;
    const VkCommandBuffer commands = batch.commands.buffer();
    batch.clock->reset(commands);
    batch.clock->stamp(commands);
    for (uint32_t i = 0; i < frames; ++i) {
        if (auto recorded = record(commands); !recorded)
            return recorded;
        batch.clock->stamp(commands);
    }
    return rig.device().submit(batch.commands);
}

// Waits for the batch; its samples are appended if there is a place for them.
Result<void> collect(Rig& rig, Batch& batch, std::vector<double>* samples) {
    if (!batch.commands.pending())
        return {};
    if (auto waited = rig.device().wait(batch.commands); !waited)
        return waited;
    const auto times = batch.clock->intervals();
    if (!times)
        return times.error();
    if (samples != nullptr)
        samples->insert(samples->end(), times->begin(), times->end());
    return {};
}

} // namespace

Statistics statistics(std::vector<double> samples) {
    Statistics result;
    result.samples = samples.size();
    if (samples.empty())
        return result;
    std::ranges::sort(samples);
    const auto at = [&](double share) {
        return samples[static_cast<size_t>(share * static_cast<double>(samples.size() - 1) + 0.5)];
    };
    const size_t half = samples.size() / 2;
    result.median = samples.size() % 2 ? samples[half] : 0.5 * (samples[half - 1] + samples[half]);
    result.minimum = samples.front();
    result.p95 = at(0.95);
    return result;
}

Result<Statistics> time_frames(Rig& rig, const RecordFrame& record, const TimingOptions& options) {
    const uint32_t frames = options.batch;
    std::array<Batch, 2> batches;
    for (Batch& batch : batches) {
        auto commands = rig.device().create_commands();
        if (!commands)
            return commands.error();
        batch.commands = std::move(*commands);
        auto clock = GpuClock::create(rig.device(), frames + 1);
        if (!clock)
            return clock.error();
        batch.clock = std::move(*clock);
    }
    std::vector<double> samples;
    const auto wanted = static_cast<size_t>(options.frames);
    const auto start = Clock::now();
    // The first two batches hold the pipelines' and the pool's making and never count.
    for (size_t i = 0; samples.size() < wanted; ++i) {
        Batch& batch = batches[i % 2];
        const bool is_warm = i >= 4 && seconds_since(start) >= options.warm_up;
        if (auto collected = collect(rig, batch, is_warm ? &samples : nullptr); !collected)
            return collected.error();
        if (auto submitted = submit_batch(rig, record, batch, frames); !submitted)
            return submitted.error();
    }
    for (Batch& batch : batches)
        if (auto collected = collect(rig, batch, nullptr); !collected)
            return collected.error();
    return statistics(std::move(samples));
}

Result<ChainTime> time_chain(Rig& rig, const EffectInfo& effect, const void* parameters,
                             std::span<const InputSet> inputs, const TimingOptions& options) {
    Stream stream(rig, parameters, inputs);
    // Two batches are a context's 16 frames in flight at most.
    if (auto opened = stream.open(effect, 2 * options.batch, false); !opened)
        return opened.error();
    auto chain = time_frames(
        rig, [&](VkCommandBuffer commands) { return stream.record(commands); }, options);
    if (!chain)
        return chain.error();
    return ChainTime{*chain, stream.context().memory_usage()};
}

Result<std::vector<PassStatistics>> time_passes(Rig& rig, const RecordFrame& record,
                                                const std::function<std::vector<PassTime>()>& newest,
                                                const TimingOptions& options) {
    // Only the newest frame's times are to be had: the frames before it in the batch keep the device busy.
    const uint32_t frames = options.batch;
    std::vector<PassStatistics> passes;
    std::vector<std::vector<double>> samples;
    const auto start = Clock::now();
    for (size_t taken = 0, i = 0; taken < static_cast<size_t>(options.frames); ++i) {
        auto commands = rig.device().begin();
        if (!commands)
            return commands.error();
        for (uint32_t frame = 0; frame < frames; ++frame)
            if (auto recorded = record(*commands); !recorded)
                return recorded.error();
        if (auto done = rig.device().submit_and_wait(); !done)
            return done.error();
        if (i < 2 || seconds_since(start) < options.warm_up)
            continue;
        const std::vector<PassTime> times = newest();
        if (times.empty())
            return Error{ErrorCode::unsupported, "the device gives no times of passes"};
        samples.resize(times.size());
        for (size_t pass = 0; pass < times.size(); ++pass)
            samples[pass].push_back(times[pass].milliseconds);
        if (passes.empty())
            for (const PassTime& time : times)
                passes.push_back({time.pass.substr(time.pass.find('/') + 1), {}});
        ++taken;
    }
    for (size_t pass = 0; pass < passes.size(); ++pass)
        passes[pass].time = statistics(std::move(samples[pass]));
    return passes;
}

Result<std::vector<PassStatistics>> time_passes(Rig& rig, const EffectInfo& effect, const void* parameters,
                                                std::span<const InputSet> inputs, const TimingOptions& options) {
    Stream stream(rig, parameters, inputs);
    if (auto opened = stream.open(effect, options.batch, true); !opened)
        return opened.error();
    return time_passes(
        rig, [&](VkCommandBuffer commands) { return stream.record(commands); }, [&] { return stream.effect().times(); },
        options);
}

} // namespace sfumato::bench
