// Scores an effect's output against a source's ground truth.
#include "apps/bench/commands.h"
#include "apps/bench/effect_run.h"
#include "apps/common/pixels.h"

#include "media/colour.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sfumato::bench {
namespace {

size_t inside(const media::Mask& mask) {
    return static_cast<size_t>(std::ranges::count(mask, uint8_t{1}));
}

// What media::encode_for_display makes of every half float: most pictures are halves.
const std::vector<float>& encoded_halves() {
    static const std::vector<float> table = [] {
        std::vector<float> values(65536);
        for (size_t i = 0; i < values.size(); ++i) {
            const float value = apps::float_from_half(static_cast<uint16_t>(i));
            values[i] = std::isnan(value) ? value : std::clamp(media::srgb_encode(value), 0.0f, 1.0f);
        }
        return values;
    }();
    return table;
}

media::Planes planes_of(std::span<const float> values, size_t components, Extent extent) {
    media::Planes planes{static_cast<int>(extent.width), static_cast<int>(extent.height), {}};
    planes.channels.resize(std::min<size_t>(components, 3)); // alpha is not scored
    for (size_t c = 0; c < planes.channels.size(); ++c) {
        planes.channels[c].resize(planes.pixel_count());
        for (size_t i = 0; i < planes.pixel_count(); ++i)
            planes.channels[c][i] = values[i * components + c];
    }
    return planes;
}

media::Planes encoded_planes_of_halves(std::span<const std::byte> bytes, Extent extent) {
    const std::vector<float>& table = encoded_halves();
    media::Planes planes{static_cast<int>(extent.width), static_cast<int>(extent.height), {}};
    planes.channels.resize(3);
    for (size_t c = 0; c < 3; ++c) {
        planes.channels[c].resize(planes.pixel_count());
        for (size_t i = 0; i < planes.pixel_count(); ++i) {
            const size_t at = (i * 4 + c) * 2;
            const size_t half = static_cast<size_t>(bytes[at]) | static_cast<size_t>(bytes[at + 1]) << 8;
            planes.channels[c][i] = table[half];
        }
    }
    return planes;
}

// Fills in what the variant asks of the truth; the text tells apart what differs.
std::string ask_truth(const Options& options, const Variant& variant, scene::RenderOptions& asked) {
    const auto ask = adapter_of(*variant.effect).truth_options;
    const TruthRequest request{1.0f / 24.0f, options.truth_falloff};
    return ask ? ask(variant.parameters.table(), variant.parameters.data(), request, asked) : std::string();
}

} // namespace

Extent quality_size(const Options& options, const Rig& rig) {
    return options.quality_size.value_or(rig.is_cpu() ? Extent{256, 144} : Extent{960, 540});
}

int truth_sub_frames(const Options& options, const Rig& rig) {
    if (options.sub_frames > 0)
        return options.sub_frames;
    return rig.is_cpu() ? 32 : 128;
}

int truth_rays(const Options& options, const Rig& rig) {
    if (options.rays > 0)
        return options.rays;
    return rig.is_cpu() ? 128 : 1024;
}

std::string Judge::key(const Options& options, const Variant& variant) {
    scene::RenderOptions ignored;
    return ask_truth(options, variant, ignored);
}

std::string Judge::why_not(const Options& options, const Variant& variant, const Source& source) {
    scene::RenderOptions asked;
    ask_truth(options, variant, asked);
    return source.why_no_truth(adapter_of(*variant.effect).truth, asked);
}

Result<std::unique_ptr<Judge>> Judge::create(Rig& rig, const Options& options, const Variant& variant,
                                             const Source& source) {
    const EffectInfo& effect = *variant.effect;
    const Adapter& adapter = adapter_of(effect);
    if (adapter.truth == nullptr)
        return Error{ErrorCode::invalid_argument, std::string("there is no ground truth for ") + effect.name};
    if (!source.has(adapter.truth))
        return Error{ErrorCode::input, source.name() + " has no image '" + adapter.truth + "' to score against"};
    if (const std::string why = why_not(options, variant, source); !why.empty())
        return Error{ErrorCode::input, why};
    std::unique_ptr<Judge> judge(new Judge(options, effect, source));
    LoadRequest request{
        source.native_extent().value_or(quality_size(options, rig)), 0, wanted_planes(effect, options.opted_in), {}};
    request.planes.emplace_back(adapter.truth);
    if (adapter.do_nothing != nullptr && std::ranges::find(request.planes, adapter.do_nothing) == request.planes.end())
        request.planes.emplace_back(adapter.do_nothing);
    request.holds_still = adapter.history != nullptr;
    ask_truth(options, variant, request.options);
    request.options.samples = options.samples;
    request.options.shutter.sub_frames = truth_sub_frames(options, rig);
    request.options.occlusion.rays = truth_rays(options, rig);
    if (auto loaded = judge->load_frame(rig, request); !loaded)
        return loaded.error();
    if (auto loaded = judge->load_truths(rig, std::move(request)); !loaded)
        return loaded.error();
    return judge;
}

Result<void> Judge::load_frame(Rig& rig, const LoadRequest& request) {
    auto inputs = source_.load(rig, request);
    if (!inputs)
        return inputs.error();
    auto images = BoundImages::create(rig, effect_, *inputs, options_.opted_in);
    if (!images)
        return images.error();
    frames_.push_back({std::move(*inputs), std::move(*images)});
    return {};
}

Result<void> Judge::load_truths(Rig& rig, LoadRequest request) {
    const Inputs& inputs = frames_.back().inputs;
    auto truth = read(rig, *inputs.find(adapter_.truth));
    if (!truth)
        return truth.error();
    truth_ = std::move(*truth);
    do_nothing_ = truth_;
    for (std::vector<float>& plane : do_nothing_.channels)
        std::ranges::fill(plane, 1.0f);
    if (adapter_.do_nothing != nullptr) {
        auto nothing = read(rig, *inputs.find(adapter_.do_nothing));
        if (!nothing)
            return nothing.error();
        do_nothing_ = std::move(*nothing);
    }
    region_ = media::moving_region(do_nothing_, truth_);
    rest_ = media::inverse(region_);
    region_share_ = static_cast<double>(inside(region_)) / static_cast<double>(region_.size());
    if (!source_.is_analytic())
        return {};
    request.planes = {adapter_.truth};
    request.options.shutter.sub_frames = std::max(1, request.options.shutter.sub_frames / 2);
    ++request.options.occlusion.seed;
    auto half = source_.load(rig, request);
    if (!half)
        return half.error();
    auto ceiling = read(rig, *half->find(adapter_.truth));
    if (!ceiling)
        return ceiling.error();
    ceiling_ = std::move(*ceiling);
    return {};
}

// The frames before the one that is scored, which stays the last.
Result<void> Judge::load_preroll(Rig& rig) {
    if (frames_.size() > 1)
        return {};
    LoadedFrame scored = std::move(frames_.back());
    frames_.clear();
    const int count = std::min(options_.preroll, source_.earlier_frames());
    Result<void> done;
    for (int offset = -count; offset < 0 && done; ++offset) {
        LoadRequest request{scored.inputs.extent, offset, wanted_planes(effect_, options_.opted_in), {}};
        request.holds_still = true;
        request.options.samples = options_.samples;
        done = load_frame(rig, request);
    }
    frames_.push_back(std::move(scored));
    return done;
}

Result<media::Planes> Judge::read(Rig& rig, const apps::HostImage& image) const {
    const auto bytes = rig.device().readback_bytes(image);
    if (!bytes)
        return bytes.error();
    const bool is_encoded = adapter_.display_encoded;
    if (is_encoded && image.format() == VK_FORMAT_R16G16B16A16_SFLOAT)
        return encoded_planes_of_halves(*bytes, image.extent());
    const apps::PixelFormat& format = *apps::find_pixel_format(image.format());
    media::Planes planes = planes_of(apps::decode_pixels(format, *bytes), format.components, image.extent());
    return is_encoded ? media::encode_for_display(planes) : planes;
}

Result<media::Planes> Judge::run(Rig& rig, Context& context, const Variant& variant) {
    const ParameterInfo* history = adapter_.history ? variant.parameters.table().find(adapter_.history) : nullptr;
    const bool has_history = history != nullptr && history->get(variant.parameters.data()) != 0.0;
    if (has_history)
        if (auto loaded = load_preroll(rig); !loaded)
            return loaded.error();
    std::vector<SequenceFrame> sequence;
    for (const LoadedFrame& frame : frames_)
        if (has_history || &frame == &frames_.back())
            sequence.push_back({frame.inputs.frame, &frame.images});
    if (auto run = run_sequence(rig, context, effect_, variant.parameters.data(), sequence); !run)
        return run.error();
    return read(rig, frames_.back().images.output());
}

Score Judge::score(const media::Planes& picture, bool ssim) const {
    const auto measured = [&](const media::MetricOptions& metric_options) {
        const double nan = std::numeric_limits<double>::quiet_NaN();
        const auto metrics = media::measure(picture, truth_, metric_options);
        // Pictures of equal extent and channels by construction: measure cannot fail.
        return metrics ? *metrics : media::Metrics{nan, nan, nan, nan, nan, 0, 0};
    };
    return {measured({nullptr, ssim}), measured({&region_, false}), measured({&rest_, false})};
}

double merit(const Adapter& adapter, const Score& score) {
    return adapter.display_encoded ? score.region.psnr : -score.all.rmse;
}

std::string merit_text(const Adapter& adapter, double merit) {
    return adapter.display_encoded ? fixed(merit, 2) + " dB" : "RMSE " + fixed(-merit, 4);
}

Json score_json(const Adapter& adapter, const Score& score) {
    const std::string region = std::string("_") + adapter.region, rest = std::string("_") + adapter.rest;
    return {{"psnr", score.all.psnr},
            {"psnr" + region, score.region.psnr},
            {"psnr" + rest, score.rest.psnr},
            {"ssim", score.all.ssim},
            {"rmse", score.all.rmse},
            {"rmse" + region, score.region.rmse},
            {"rmse" + rest, score.rest.rmse},
            {"bias", score.all.bias},
            {"bias" + region, score.region.bias},
            {"bias" + rest, score.rest.bias},
            {"max_error", score.all.max_error},
            {"non_finite_pixels", score.all.non_finite}};
}

} // namespace sfumato::bench
