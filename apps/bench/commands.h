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

// One picture against the truth. Moving and still are NaN where the source has no such region.
struct Score {
    media::Metrics all;
    double moving_psnr = 0.0;
    double still_psnr = 0.0;
};

struct ScoredRow {
    std::string label;
    Score score;
};

// Ground truth of one source for one shutter, and the input frame that goes with it.
class Judge {
  public:
    // Errors: no truth in the source, no adapter for the effect.
    static Result<std::unique_ptr<Judge>> create(Rig& rig, const Options& options, const Variant& variant,
                                                 const Source& source);

    // What the truth depends on: judges of equal keys are the same.
    static std::string key(const Variant& variant);

    Extent extent() const { return inputs_.extent; }
    double moving_share() const { return moving_share_; } // of the pixels
    const media::Planes& truth() const { return truth_; }
    const media::Planes& do_nothing() const { return do_nothing_; }
    const std::optional<media::Planes>& ceiling() const {
        return ceiling_;
    } // a truth with half the sub-frames, other rays

    // Runs the effect and reads its output back, encoded like the truth.
    Result<media::Planes> run(Rig& rig, Context& context, const Variant& variant) const;

    Score score(const media::Planes& picture, bool ssim) const; // may be called from several threads

  private:
    Judge() = default;
    Result<media::Planes> read(Rig& rig, const apps::HostImage& image) const;

    Inputs inputs_;
    std::optional<BoundImages> images_;
    bool is_encoded_ = true;
    media::Planes truth_, do_nothing_;
    std::optional<media::Planes> ceiling_;
    media::Mask moving_, still_;
    double moving_share_ = 0.0;
};

Json score_json(const Score& score);

} // namespace sfumato::bench
