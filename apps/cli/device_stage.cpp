// Upload, effects and read-back of frames in flight.
#include "apps/cli/device_stage.h"

#include "apps/cli/exit_code.h"
#include "apps/common/pixels.h"

#include <fmt/format.h>

namespace sfumato::cli {

Result<std::unique_ptr<DeviceStage>> DeviceStage::create(const std::string& device, const EffectChain& chain) {
    apps::DeviceOptions options;
    options.device = device;
    auto made = apps::Device::create(options);
    if (!made)
        return as_device(made.error());
    std::unique_ptr<DeviceStage> stage(new DeviceStage(std::move(*made)));
    auto runner = EffectRunner::create(*stage->device_, chain, frames_in_flight);
    if (!runner)
        return runner.error();
    stage->runner_ = std::move(*runner);
    for (uint32_t i = 0; i < frames_in_flight; ++i) {
        auto commands = stage->device_->create_commands();
        if (!commands)
            return as_device(commands.error());
        auto report = stage->runner_->create_report();
        if (!report)
            return report.error();
        Slot& slot = stage->slots_.emplace_back();
        slot.commands = std::move(*commands);
        slot.report = std::move(*report);
        stage->free_.push_back(&slot);
    }
    return stage;
}

DeviceStage::~DeviceStage() {
    if (device_)
        static_cast<void>(static_cast<bool>(device_->wait_idle()));
}

// Sizes and roles may change from frame to frame; most often they do not.
Result<void> DeviceStage::prepare(const LoadedFrame& frame) {
    bool same = true;
    for (const auto& [role, picture] : frame.roles) {
        const auto found = inputs_.find(role);
        same = same && found != inputs_.end() && found->second.extent() == picture.extent &&
               found->second.format() == float_format(picture.components);
    }
    if (same && !frame.job.restarts)
        return {};
    // Images and effects of frames in flight are about to be replaced.
    if (auto idle = device_->wait_idle(); !idle)
        return as_device(idle.error());
    for (const auto& [role, picture] : frame.roles) {
        apps::HostImage& image = inputs_[role];
        if (image.extent() == picture.extent && image.format() == float_format(picture.components))
            continue;
        auto made = device_->create_image(float_format(picture.components), picture.extent);
        if (!made)
            return as_device(made.error());
        image = std::move(*made);
    }
    if (auto prepared = runner_->prepare(frame.extent); !prepared)
        return prepared;
    return frame.job.restarts ? runner_->restart() : Result<void>{};
}

Result<apps::HostBuffer*> DeviceStage::buffer(std::map<std::string, apps::HostBuffer>& buffers, const std::string& name,
                                              size_t bytes) {
    apps::HostBuffer& existing = buffers[name];
    if (existing.bytes().size() != bytes) {
        auto made = device_->create_buffer(bytes);
        if (!made)
            return as_device(made.error());
        existing = std::move(*made);
    }
    return &existing;
}

namespace {

size_t byte_count(const apps::HostImage& image) {
    return size_t{image.extent().width} * image.extent().height * apps::find_pixel_format(image.format())->bytes();
}

} // namespace

Result<void> DeviceStage::record_uploads(Slot& slot) {
    for (const auto& [role, picture] : slot.frame->roles) {
        const apps::HostImage& image = inputs_.at(role);
        auto staging = buffer(slot.uploads, role, byte_count(image));
        if (!staging)
            return staging.error();
        apps::encode_pixels(*apps::find_pixel_format(image.format()), picture.values, picture.components,
                            (*staging)->bytes());
        device_->record_upload(slot.commands.buffer(), **staging, image);
    }
    return {};
}

Result<void> DeviceStage::record_readbacks(Slot& slot) {
    std::map<std::string, const apps::HostImage*> outputs;
    for (const auto& [name, extra] : runner_->extras())
        outputs[name] = extra.image;
    if (runner_->colour())
        outputs[""] = runner_->colour();
    for (const auto& [name, image] : outputs) {
        auto staging = buffer(slot.readbacks, name, byte_count(*image));
        if (!staging)
            return staging.error();
        device_->record_readback(slot.commands.buffer(), *image, **staging);
    }
    return {};
}

Result<void> DeviceStage::record(Slot& slot) {
    if (auto uploaded = record_uploads(slot); !uploaded)
        return uploaded;
    RoleImages images;
    for (const auto& [role, picture] : slot.frame->roles)
        images[role] = inputs_.at(role).image();
    if (auto recorded = runner_->record(slot.commands.buffer(), slot.frame->facts, images, slot.report); !recorded) {
        // Parameters were checked; what is refused now is the picture's own size or content.
        Error error = as_input(recorded.error());
        error.message = fmt::format("{}: {}", slot.frame->job.input.string(), error.message);
        return error;
    }
    return slot.frame->job.output.empty() ? Result<void>{} : record_readbacks(slot);
}

Result<void> DeviceStage::submit(LoadedFrame frame) {
    if (auto prepared = prepare(frame); !prepared)
        return prepared;
    Slot& slot = *free_.front();
    slot.frame = std::move(frame);
    if (auto begun = device_->begin(slot.commands); !begun)
        return as_device(begun.error());
    if (auto recorded = record(slot); !recorded)
        return recorded;
    if (auto submitted = device_->submit(slot.commands); !submitted)
        return as_device(submitted.error());
    slot.frame->roles.clear(); // uploaded; the memory is better used for the next frame
    free_.pop_front();
    in_flight_.push_back(&slot);
    return {};
}

Result<std::optional<ProcessedFrame>> DeviceStage::collect() {
    Slot& slot = *in_flight_.front();
    if (auto waited = device_->wait(slot.commands); !waited)
        return as_device(waited.error());
    in_flight_.pop_front();
    free_.push_back(&slot);
    ProcessedFrame result{std::move(*slot.frame), {}, {}};
    slot.frame.reset();
    if (result.frame.job.output.empty())
        return std::optional<ProcessedFrame>();
    shortfalls_.add(result.frame.job.frame, runner_->shortfalls(slot.report));
    if (const apps::HostImage* colour = runner_->colour())
        result.colour = apps::decode_pixels(*apps::find_pixel_format(colour->format()), slot.readbacks.at("").bytes());
    const media::ExrPart& part = result.frame.image.parts[result.frame.colour.part];
    const Extent extent = {static_cast<uint32_t>(part.width()), static_cast<uint32_t>(part.height())};
    for (const auto& [name, extra] : runner_->extras()) {
        const apps::PixelFormat& format = *apps::find_pixel_format(extra.image->format());
        result.extras[name] = {
            {extent, format.components, apps::decode_pixels(format, slot.readbacks.at(name).bytes())}, extra.role};
    }
    return std::optional<ProcessedFrame>(std::move(result));
}

} // namespace sfumato::cli
