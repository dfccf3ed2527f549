// Scores an effect's output against a source's ground truth.
#include "apps/bench/commands.h"
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

scene::RenderOptions truth_options(const Variant& variant, float time_step) {
    scene::RenderOptions options;
    if (const auto ask = adapter_of(*variant.effect).truth_options)
        ask(variant.parameters.table(), variant.parameters.data(), time_step, options);
    return options;
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

std::string Judge::key(const Variant& variant) {
    const auto ask = adapter_of(*variant.effect).truth_options;
    scene::RenderOptions ignored;
    return ask ? ask(variant.parameters.table(), variant.parameters.data(), 1.0f / 24.0f, ignored) : std::string();
}

Result<std::unique_ptr<Judge>> Judge::create(Rig& rig, const Options& options, const Variant& variant,
                                             const Source& source) {
    const EffectInfo& effect = *variant.effect;
    const Adapter& adapter = adapter_of(effect);
    if (adapter.truth == nullptr)
        return Error{ErrorCode::invalid_argument, std::string("there is no ground truth for ") + effect.name};
    if (!source.has(adapter.truth))
        return Error{ErrorCode::input, source.name() + " has no image '" + adapter.truth + "' to score against"};
    std::unique_ptr<Judge> judge(new Judge);
    judge->is_encoded_ = adapter.display_encoded;
    LoadRequest request{
        source.native_extent().value_or(quality_size(options, rig)), 0, wanted_planes(effect, options.opted_in), {}};
    request.planes.emplace_back(adapter.truth);
    if (std::ranges::find(request.planes, adapter.do_nothing) == request.planes.end())
        request.planes.emplace_back(adapter.do_nothing);
    request.options = truth_options(variant, 1.0f / 24.0f);
    request.options.samples = options.samples;
    request.options.shutter.sub_frames = truth_sub_frames(options, rig);
    request.options.occlusion.rays = truth_rays(options, rig);
    auto inputs = source.load(rig, request);
    if (!inputs)
        return inputs.error();
    judge->inputs_ = std::move(*inputs);
    auto images = BoundImages::create(rig, effect, judge->inputs_, options.opted_in);
    if (!images)
        return images.error();
    judge->images_.emplace(std::move(*images));
    auto truth = judge->read(rig, *judge->inputs_.find(adapter.truth));
    auto nothing = judge->read(rig, *judge->inputs_.find(adapter.do_nothing));
    if (!truth || !nothing)
        return truth ? nothing.error() : truth.error();
    judge->truth_ = std::move(*truth);
    judge->do_nothing_ = std::move(*nothing);
    judge->moving_ = media::moving_region(judge->do_nothing_, judge->truth_);
    judge->still_ = media::inverse(judge->moving_);
    judge->moving_share_ = static_cast<double>(inside(judge->moving_)) / static_cast<double>(judge->moving_.size());
    if (!source.is_analytic())
        return judge;
    request.planes = {adapter.truth};
    request.options.shutter.sub_frames = std::max(1, request.options.shutter.sub_frames / 2);
    ++request.options.occlusion.seed;
    auto half = source.load(rig, request);
    if (!half)
        return half.error();
    auto ceiling = judge->read(rig, *half->find(adapter.truth));
    if (!ceiling)
        return ceiling.error();
    judge->ceiling_ = std::move(*ceiling);
    return judge;
}

Result<media::Planes> Judge::read(Rig& rig, const apps::HostImage& image) const {
    const auto bytes = rig.device().readback_bytes(image);
    if (!bytes)
        return bytes.error();
    if (is_encoded_ && image.format() == VK_FORMAT_R16G16B16A16_SFLOAT)
        return encoded_planes_of_halves(*bytes, image.extent());
    const apps::PixelFormat& format = *apps::find_pixel_format(image.format());
    media::Planes planes = planes_of(apps::decode_pixels(format, *bytes), format.components, image.extent());
    return is_encoded_ ? media::encode_for_display(planes) : planes;
}

Result<media::Planes> Judge::run(Rig& rig, Context& context, const Variant& variant) const {
    if (auto run = run_once(rig, context, *variant.effect, variant.parameters.data(), inputs_.frame, *images_); !run)
        return run.error();
    return read(rig, images_->output());
}

Score Judge::score(const media::Planes& picture, bool ssim) const {
    // Pictures of equal extent and channels by construction: measure cannot fail.
    const auto psnr = [&](const media::Mask& mask) {
        const auto metrics = media::measure(picture, truth_, {&mask, false});
        return metrics ? metrics->psnr : std::numeric_limits<double>::quiet_NaN();
    };
    Score score;
    if (const auto all = media::measure(picture, truth_, {nullptr, ssim}); all)
        score.all = *all;
    score.moving_psnr = psnr(moving_);
    score.still_psnr = psnr(still_);
    return score;
}

Json score_json(const Score& score) {
    return {{"psnr", score.all.psnr},           {"psnr_moving", score.moving_psnr},
            {"psnr_still", score.still_psnr},   {"ssim", score.all.ssim},
            {"rmse", score.all.rmse},           {"bias", score.all.bias},
            {"max_error", score.all.max_error}, {"non_finite_pixels", score.all.non_finite}};
}

} // namespace sfumato::bench
