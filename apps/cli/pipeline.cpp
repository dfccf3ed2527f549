// The threads and what passes between them.
#include "apps/cli/pipeline.h"

#include "apps/cli/bounded_queue.h"
#include "apps/cli/exit_code.h"
#include "apps/cli/guarded.h"

#include <csignal>
#include <fmt/format.h>
#include <thread>

namespace sfumato::cli {

std::atomic<bool> interrupted = false;

void catch_interrupts() {
    const auto handler = [](int) { interrupted = true; };
    std::signal(SIGINT, handler);
    std::signal(SIGTERM, handler);
}

namespace {

// Frames that wait between two stages; a 4K frame with its passes takes half a gigabyte.
constexpr size_t queue_length = 2;

class Pipeline {
  public:
    Pipeline(const std::vector<FrameJob>& jobs, FrameLoader& loader, DeviceStage& device, const EffectChain& chain,
             const PipelineOptions& options, Console& console)
        : jobs_(jobs), loader_(loader), device_(device), chain_(chain), options_(options), console_(console) {}

    Result<PipelineReport> run(std::optional<LoadedFrame> first) {
        size_t wanted = 0;
        for (const FrameJob& job : jobs_)
            wanted += job.output.empty() ? 0 : 1;
        console_.start_progress(wanted);
        std::thread reader([&] { read(std::move(first)); });
        std::thread writer([&] { write(); });
        Result<void> processed = guarded([&] { return process(); });
        // Frames that the device has finished are written, whatever came after them.
        if (!processed)
            static_cast<void>(static_cast<bool>(guarded([&] { return drain(); })));
        loaded_.abandon();
        processed_.finish();
        reader.join();
        writer.join();
        console_.end_progress();
        for (const std::string& line : device_.shortfalls().lines(jobs_.size() == 1 ? jobs_[0].input.string() : ""))
            console_.warn(line);
        // The writer's frame came before any that another stage can have failed on.
        if (!written_)
            return written_.error();
        if (!processed)
            return processed.error();
        return report_;
    }

  private:
    void read(std::optional<LoadedFrame> first) {
        for (const FrameJob& job : jobs_) {
            if (interrupted)
                break;
            Result<LoadedFrame> frame =
                first ? Result<LoadedFrame>(std::move(*first)) : guarded([&] { return loader_.load(job); });
            first.reset();
            if (!loaded_.push(std::move(frame)))
                return;
        }
        loaded_.finish();
    }

    Result<void> process() {
        bool restarts = false; // a skipped frame tears the sequence
        while (auto next = loaded_.pop()) {
            Result<void> done = *next ? submit(std::move(**next), restarts) : Result<void>(next->error());
            if (done) {
                restarts = false;
                continue;
            }
            if (!options_.skip_bad_frames || done.error().code != ErrorCode::input)
                return done;
            console_.warn("skipped: " + done.error().message);
            ++report_.skipped;
            restarts = true;
        }
        report_.interrupted = interrupted;
        return drain();
    }

    Result<void> submit(LoadedFrame frame, bool restarts) {
        if (device_.is_full())
            if (auto collected = collect(); !collected)
                return collected;
        frame.job.restarts = frame.job.restarts || restarts;
        return device_.submit(std::move(frame));
    }

    Result<void> drain() {
        while (!device_.is_empty())
            if (auto collected = collect(); !collected)
                return collected;
        return {};
    }

    Result<void> collect() {
        auto frame = device_.collect();
        if (!frame)
            return frame.error();
        // If the writer has gone, it says why.
        if (*frame && !processed_.push(std::move(**frame)))
            return Error{ErrorCode::internal, "the writer stopped"};
        return {};
    }

    void write() {
        while (auto frame = processed_.pop()) {
            const std::filesystem::path output = frame->frame.job.output;
            written_ = guarded([&] { return write_frame(*frame, chain_, options_.writer); });
            if (!written_)
                return processed_.abandon();
            ++report_.written;
            report_.outputs.push_back(output);
            console_.advance(fmt::format("{} -> {}", frame->frame.job.input.string(), output.string()));
        }
    }

    const std::vector<FrameJob>& jobs_;
    FrameLoader& loader_;
    DeviceStage& device_;
    const EffectChain& chain_;
    const PipelineOptions& options_;
    Console& console_;
    BoundedQueue<Result<LoadedFrame>> loaded_{queue_length};
    BoundedQueue<ProcessedFrame> processed_{queue_length};
    Result<void> written_;
    PipelineReport report_; // `written` and `outputs` are the writer's, the rest is the device's
};

} // namespace

Result<PipelineReport> run_pipeline(const std::vector<FrameJob>& jobs, std::optional<LoadedFrame> first,
                                    FrameLoader& loader, DeviceStage& device, const EffectChain& chain,
                                    const PipelineOptions& options, Console& console) {
    return Pipeline(jobs, loader, device, chain, options, console).run(std::move(first));
}

} // namespace sfumato::cli
