// Slices of ground truth, their mean, and the effect's distance from it.
#include "apps/viewer/truth.h"

#include "apps/cli/exit_code.h"
#include "apps/cli/viewpoint.h"
#include "media/metrics.h"

#include <algorithm>
#include <fmt/format.h>

namespace sfumato::viewer {

namespace {

double value_of(const EffectSlot& slot, const char* name) {
    return slot.link.effect->parameters->find(name)->get(slot.link.parameters.data());
}

media::Planes planes_of(const std::vector<float>& values, Extent extent, size_t stride, size_t channels) {
    media::Planes planes{static_cast<int>(extent.width), static_cast<int>(extent.height), {}};
    for (size_t c = 0; c < channels; ++c) {
        std::vector<float>& plane = planes.channels.emplace_back(values.size() / stride);
        for (size_t i = 0; i < plane.size(); ++i)
            plane[i] = values[i * stride + c];
    }
    return planes;
}

// 0, 1/2, 1/4, 3/4, 1/8, …: the bits of the counter behind the point.
double spread(size_t counter) {
    double value = 0.0;
    for (double digit = 0.5; counter > 0; counter >>= 1, digit /= 2.0)
        value += counter & 1 ? digit : 0.0;
    return value;
}

// Whatever else the effect does, its truth stays.
std::string truth_key(const Model& model, const PictureRequest& request) {
    const EffectSlot* slot = model.truth_effect();
    if (!slot)
        return "";
    std::string key = fmt::format("{} {} {} {} {} {} {}", extent_text(request.extent), request.frame, request.samples,
                                  request.viewpoint_text, static_cast<int>(model.truth.kind), model.truth.sub_frames,
                                  model.truth.rays);
    for (const char* name : {"shutter", "shutter_position", "radius", "falloff"})
        if (slot->link.effect->parameters->find(name))
            key += fmt::format(" {}", value_of(*slot, name));
    return key;
}

} // namespace

std::vector<TruthSlice> shutter_slices(int frame, const scene::Shutter& shutter, int slices) {
    const double opens = shutter.position == scene::ShutterPosition::start    ? 0.0
                         : shutter.position == scene::ShutterPosition::centre ? -0.5
                                                                              : -1.0;
    std::vector<std::pair<double, int>> order;
    for (int i = 0; i < slices; ++i)
        order.emplace_back(spread(static_cast<size_t>(i)), i);
    std::vector<int> ranks(order.size()); // the place in time of the i-th slice to be rendered
    std::ranges::sort(order);
    for (size_t place = 0; place < order.size(); ++place)
        ranks[static_cast<size_t>(order[place].second)] = static_cast<int>(place);
    std::vector<TruthSlice> result;
    for (const int place : ranks) {
        TruthSlice slice;
        slice.options.shutter = shutter;
        slice.options.shutter.open = shutter.open / slices;
        slice.options.shutter.position = scene::ShutterPosition::start;
        slice.options.shutter.sub_frames = std::max(shutter.sub_frames / slices, 1);
        slice.share = slice.options.shutter.sub_frames;
        slice.frame = frame + shutter.open * (opens + static_cast<double>(place) / slices);
        result.push_back(slice);
    }
    return result;
}

std::vector<TruthSlice> ray_slices(int frame, const scene::OcclusionTruth& occlusion, int slices) {
    std::vector<TruthSlice> result;
    for (int i = 0; i < slices; ++i) {
        TruthSlice slice;
        slice.frame = frame;
        slice.options.occlusion = occlusion;
        slice.options.occlusion.rays = std::max(occlusion.rays / slices, 1);
        slice.options.occlusion.seed = occlusion.seed + static_cast<uint32_t>(i);
        slice.share = slice.options.occlusion.rays;
        result.push_back(slice);
    }
    return result;
}

Image Truth::mean(const Model& model, const PictureRequest& request) const {
    return done_ > 0 && key_ == truth_key(model, request) ? mean_.image() : Image{};
}

Result<void> Truth::begin(const Model& model, const PictureRequest& request) {
    const EffectSlot& slot = *model.truth_effect();
    kind_ = model.truth.kind;
    if (kind_ == TruthKind::motion_blur) {
        scene::Shutter shutter;
        shutter.open = value_of(slot, "shutter");
        shutter.position = static_cast<scene::ShutterPosition>(static_cast<int>(value_of(slot, "shutter_position")));
        shutter.sub_frames = model.truth.sub_frames;
        slices_ = shutter_slices(request.frame, shutter, std::max(model.truth.sub_frames / sub_frames_a_slice, 1));
    } else {
        scene::OcclusionTruth occlusion;
        occlusion.radius = value_of(slot, "radius");
        occlusion.falloff = static_cast<scene::Falloff>(static_cast<uint32_t>(value_of(slot, "falloff")));
        occlusion.rays = model.truth.rays;
        slices_ = ray_slices(request.frame, occlusion, std::max(model.truth.rays / rays_a_slice, 1));
    }
    next_ = 0;
    done_ = total_ = 0;
    error_.reset();
    for (const TruthSlice& slice : slices_)
        total_ += slice.share;
    const uint32_t components = kind_ == TruthKind::motion_blur ? 4 : 1;
    sum_.assign(size_t{request.extent.width} * request.extent.height * components, 0.0);
    for (apps::HostImage* image : {&slice_, &mean_}) {
        if (image->extent() == request.extent && image->format() == cli::float_format(components))
            continue;
        auto made = renderer_.device().create_image(cli::float_format(components), request.extent);
        if (!made)
            return cli::as_device(made.error());
        *image = std::move(*made);
    }
    return {};
}

Result<void> Truth::add(const TruthSlice& slice, const PictureRequest& request) {
    scene::SceneSource& source = renderer_.source();
    apps::Device& device = renderer_.device();
    source.set_camera(request.viewpoint ? cli::standing_at(*request.viewpoint) : scene::CameraPath{});
    scene::RenderOptions options = slice.options;
    options.samples = request.samples;
    scene::SceneImages images;
    (kind_ == TruthKind::motion_blur ? images.truth : images.true_visibility) = slice_.image();
    auto commands = device.begin();
    if (!commands)
        return cli::as_device(commands.error());
    if (auto recorded = source.record(*commands, slice.frame, options, images, count_++); !recorded)
        return recorded.error();
    if (auto done = device.submit_and_wait(); !done)
        return cli::as_device(done.error());
    const auto values = device.readback(slice_);
    if (!values)
        return cli::as_device(values.error());
    done_ += slice.share;
    std::vector<float> mean(sum_.size());
    for (size_t i = 0; i < sum_.size(); ++i) {
        sum_[i] += static_cast<double>((*values)[i]) * slice.share;
        mean[i] = static_cast<float>(sum_[i] / done_);
    }
    const uint32_t components = kind_ == TruthKind::motion_blur ? 4 : 1;
    if (auto uploaded = device.upload(mean_, mean, components); !uploaded)
        return cli::as_device(uploaded.error());
    return {};
}

Result<void> Truth::measure(const Model& model) {
    auto values = renderer_.read(model.compared_picture());
    if (!values)
        return values.error();
    const Extent extent = mean_.extent();
    const size_t pixels = size_t{extent.width} * extent.height;
    const bool colour = kind_ == TruthKind::motion_blur;
    error_.reset();
    if (values->size() != pixels * (colour ? 4 : 1)) // another picture has taken its place
        return {};
    std::vector<float> mean(sum_.size());
    for (size_t i = 0; i < sum_.size(); ++i)
        mean[i] = static_cast<float>(sum_[i] / done_);
    media::Planes picture = planes_of(*values, extent, colour ? 4 : 1, colour ? 3 : 1);
    media::Planes truth = planes_of(mean, extent, colour ? 4 : 1, colour ? 3 : 1);
    if (colour) {
        picture = media::encode_for_display(picture);
        truth = media::encode_for_display(truth);
    }
    media::MetricOptions options;
    options.ssim = false;
    const auto metrics = media::measure(picture, truth, options);
    if (!metrics)
        return metrics.error();
    error_ = TruthError{metrics->rmse, metrics->psnr};
    return {};
}

Result<bool> Truth::gather(const Model& model, const PictureRequest& request) {
    if (!model.truth_effect()) {
        key_.clear();
        done_ = total_ = 0;
        error_.reset();
        return false;
    }
    const std::string key = truth_key(model, request);
    if (key != key_) {
        key_ = key;
        if (auto begun = begin(model, request); !begun)
            return begun.error();
    }
    const bool was_measured = measured_ == request.key();
    if (next_ == slices_.size() && (was_measured || done_ == 0))
        return false;
    if (next_ < slices_.size())
        if (auto added = add(slices_[next_++], request); !added) {
            next_ = slices_.size(); // what the scene cannot make is not tried again until something changes
            done_ = 0;
            return added.error();
        }
    measured_ = request.key();
    if (auto measured = measure(model); !measured)
        return measured.error();
    return true;
}

} // namespace sfumato::viewer
