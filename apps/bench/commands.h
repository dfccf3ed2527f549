// The commands of sfumato-bench, and the measurements that they share.
#pragma once

#include "apps/bench/options.h"
#include "apps/bench/report.h"
#include "apps/bench/sources.h"
#include "apps/bench/variants.h"
#include "media/metrics.h"

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace sfumato::bench {

using Variants = std::vector<Variant>;

Result<void> measure_times(Rig& rig, const Options& options, const Variants& variants, const Sources& sources,
                           const Output& output);
Result<void> measure_quality(Rig& rig, const Options& options, const Variants& variants, const Sources& sources,
                             const Output& output);
Result<void> measure_frontier(Rig& rig, const Options& options, const Variants& variants, const Sources& sources,
                              const Output& output);
Result<void> tune(Rig& rig, const Options& options, const Variants& variants, const Sources& sources,
                  const Output& output);
// Sort, prefix sum and compaction, with and without subgroups, each checked against the CPU.
Result<void> measure_sort(Rig& rig, const Options& options, const Output& output);
Result<void> list_all(const Output& output);

// What is timed and scored if the command line does not say; small on a software device.
std::vector<Extent> times_sizes(const Options& options, const Rig& rig, bool only_one);
Extent quality_size(const Options& options, const Rig& rig);
TimingOptions timing_options(const Options& options, const Rig& rig, double warm_up);
int truth_sub_frames(const Options& options, const Rig& rig);
int truth_rays(const Options& options, const Rig& rig);

// Frames of a source with outputs, ready to be timed. The inputs own what the bound images point at.
struct TimedInputs {
    std::vector<std::unique_ptr<Inputs>> inputs;
    std::vector<InputSet> sets;
};
Result<TimedInputs> load_timed_inputs(Rig& rig, const Options& options, const EffectInfo& effect, const Source& source,
                                      Extent extent);

// One picture against the truth: all of it, where doing nothing differs from the truth, and the rest. Figures are NaN
// where the source has no such region.
struct Score {
    media::Metrics all, region, rest;
};

// What presets are ranked by, the higher the better: PSNR where things move, or for what is no picture -RMSE.
double merit(const Adapter& adapter, const Score& score);
std::string merit_text(const Adapter& adapter, double merit); // "31.52 dB", "RMSE 0.0423"

struct ScoredRow {
    std::string label;
    Score score;
};

// Ground truth of one source for one shutter or radius, and the input frame that goes with it.
class Judge {
  public:
    // Errors: no truth in the source, no adapter for the effect.
    static Result<std::unique_ptr<Judge>> create(Rig& rig, const Options& options, const Variant& variant,
                                                 const Source& source);

    // What the truth depends on: judges of equal keys are the same.
    static std::string key(const Options& options, const Variant& variant);
    // Why the source has no truth for the variant, "" if it has.
    static std::string why_not(const Options& options, const Variant& variant, const Source& source);

    Extent extent() const { return frames_.back().inputs.extent; }
    double region_share() const { return region_share_; } // of the pixels
    const media::Planes& truth() const { return truth_; }
    const media::Planes& do_nothing() const { return do_nothing_; }
    const std::optional<media::Planes>& ceiling() const {
        return ceiling_;
    } // a truth with half the sub-frames, other rays

    // Runs the effect and reads its output back, encoded like the truth; with a history on the frames before as well.
    Result<media::Planes> run(Rig& rig, Context& context, const Variant& variant);

    Score score(const media::Planes& picture, bool ssim) const; // may be called from several threads

  private:
    struct LoadedFrame {
        Inputs inputs;
        BoundImages images;
    };

    Judge(const Options& options, const EffectInfo& effect, const Source& source)
        : options_(options), effect_(effect), source_(source), adapter_(adapter_of(effect)) {}
    Result<void> load_frame(Rig& rig, const LoadRequest& request);
    Result<void> load_preroll(Rig& rig);
    Result<void> load_truths(Rig& rig, LoadRequest request);
    Result<media::Planes> read(Rig& rig, const apps::HostImage& image) const;

    const Options& options_;
    const EffectInfo& effect_;
    const Source& source_;
    const Adapter& adapter_;
    std::vector<LoadedFrame> frames_; // the last one is scored; the others are there once they are needed
    media::Planes truth_, do_nothing_;
    std::optional<media::Planes> ceiling_;
    media::Mask region_, rest_;
    double region_share_ = 0.0;
};

Json score_json(const Adapter& adapter, const Score& score);

} // namespace sfumato::bench
