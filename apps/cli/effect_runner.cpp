// Instances, outputs and recording of a chain of effects.
#include "apps/cli/effect_runner.h"

#include "apps/cli/exit_code.h"

#include <algorithm>
#include <cstddef>
#include <fmt/format.h>
#include <utility>

namespace sfumato::cli {

VkFormat float_format(uint32_t components) {
    if (components <= 1)
        return VK_FORMAT_R32_SFLOAT;
    return components == 2 ? VK_FORMAT_R32G32_SFLOAT : VK_FORMAT_R32G32B32A32_SFLOAT;
}

// Visibility has a name that other programs know; the others that a scene's truth has as well are called as there.
std::string channel_name(const EffectInfo& effect, const ImageRole& role) {
    const std::string_view name = role.name;
    if (name == "visibility")
        return "AO";
    return name == "bent_normal" || name == "soft_shadow" ? std::string(name) : fmt::format("{}.{}", effect.name, name);
}

Result<std::unique_ptr<EffectRunner>> EffectRunner::create(apps::Device& device, const EffectChain& chain,
                                                           uint32_t frames_in_flight) {
    ContextInfo info = device.context_info();
    info.frames_in_flight = frames_in_flight;
    auto context = Context::create(info);
    if (!context)
        return as_device(context.error());
    auto runner = create(device, **context, chain);
    if (runner)
        (*runner)->own_context_ = std::move(*context);
    return runner;
}

Result<std::unique_ptr<EffectRunner>> EffectRunner::create(apps::Device& device, Context& context,
                                                           const EffectChain& chain) {
    std::unique_ptr<EffectRunner> runner(new EffectRunner(device, context));
    for (const ChainLink& link : chain) {
        Stage stage{&link, nullptr, {}};
        for (const ImageRole& role : link.effect->images) {
            if (!role.is_output())
                continue;
            const bool is_colour = std::string_view(role.name) == "output";
            if (contains(link.outputs, role.name))
                stage.outputs.push_back({&role, is_colour, contains(link.written, role.name), {}});
        }
        runner->stages_.push_back(std::move(stage));
    }
    if (auto started = runner->restart(); !started)
        return started.error();
    return runner;
}

Result<void> EffectRunner::restart() {
    for (Stage& stage : stages_) {
        stage.effect.reset();
        auto effect = AnyEffect::create(*context_, *stage.link->effect);
        if (!effect)
            return as_device(effect.error());
        stage.effect = std::move(*effect);
        stage.warms_up = stage.link->effect->parameters->find("warm_up") != nullptr;
    }
    return {};
}

Result<void> EffectRunner::prepare(Extent extent) {
    if (extent == extent_)
        return {};
    for (Stage& stage : stages_) {
        for (Output& output : stage.outputs) {
            auto image = device_->create_image(float_format(output.role->components), extent);
            if (!image)
                return as_device(image.error());
            output.image = std::move(*image);
        }
    }
    extent_ = extent;
    context_->trim();
    return {};
}

Result<FrameReport> EffectRunner::create_report() const {
    FrameReport report;
    for (size_t stage = 0; stage < stages_.size(); ++stage)
        for (const BufferRole& role : stages_[stage].link->effect->buffers) {
            if (!role.shortfalls)
                continue;
            auto buffer = device_->create_buffer(role.element_bytes);
            if (!buffer)
                return as_device(buffer.error());
            report.entries.push_back({stage, &role, std::move(*buffer)});
        }
    return report;
}

Result<void> EffectRunner::record(VkCommandBuffer commands, const Frame& frame, const RoleImages& inputs,
                                  const FrameReport& report) {
    RoleImages current = inputs;
    for (size_t place = 0; place < stages_.size(); ++place) {
        Stage& stage = stages_[place];
        const EffectInfo& effect = *stage.link->effect;
        std::vector<std::max_align_t> images(effect.images_size / sizeof(std::max_align_t) + 1);
        for (const ImageRole& role : effect.images) {
            const auto found = current.find(role.name);
            role.get(images.data()) =
                !role.is_output() && found != current.end() && uses_input(*stage.link, role) ? found->second : Image{};
        }
        for (const BufferRole& role : effect.buffers)
            role.get(images.data()) = {};
        for (const FrameReport::Entry& entry : report.entries)
            if (entry.stage == place)
                entry.role->get(images.data()) = entry.buffer.buffer();
        for (const Output& output : stage.outputs)
            output.role->get(images.data()) = output.image.image();
        Frame own = frame;
        own.reset = frame.reset || std::exchange(stage.warms_up, false);
        if (auto recorded = stage.effect->record(commands, own, stage.link->parameters.data(), images.data());
            !recorded)
            return recorded.error();
        for (const Output& output : stage.outputs)
            if (output.is_colour)
                current["colour"] = output.image.image();
    }
    if (!report.entries.empty()) {
        VkMemoryBarrier barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER};
        barrier.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT;
        barrier.dstAccessMask = VK_ACCESS_HOST_READ_BIT;
        device_->functions().CmdPipelineBarrier(commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                                                VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &barrier, 0, nullptr, 0, nullptr);
    }
    return {};
}

std::vector<EffectShortfall> EffectRunner::shortfalls(const FrameReport& report) const {
    std::vector<EffectShortfall> result;
    for (const FrameReport::Entry& entry : report.entries) {
        const ChainLink& link = *stages_[entry.stage].link;
        for (Shortfall& one : entry.role->shortfalls(entry.buffer.bytes().data(), link.parameters.data()))
            result.push_back({link.effect, std::move(one)});
    }
    return result;
}

const apps::HostImage* EffectRunner::colour() const {
    for (auto stage = stages_.rbegin(); stage != stages_.rend(); ++stage)
        for (const Output& output : stage->outputs)
            if (output.is_colour && output.is_written)
                return &output.image;
    return nullptr;
}

const apps::HostImage* EffectRunner::output(std::string_view effect, std::string_view role) const {
    for (const Stage& stage : stages_)
        for (const Output& output : stage.outputs)
            if (effect == stage.link->effect->name && role == output.role->name)
                return &output.image;
    return nullptr;
}

std::vector<std::pair<const EffectInfo*, PassTime>> EffectRunner::times() {
    std::vector<std::pair<const EffectInfo*, PassTime>> result;
    for (Stage& stage : stages_)
        for (PassTime& time : stage.effect->times())
            result.emplace_back(stage.link->effect, std::move(time));
    return result;
}

std::map<std::string, ExtraOutput> EffectRunner::extras() const {
    std::map<std::string, ExtraOutput> result;
    for (const Stage& stage : stages_)
        for (const Output& output : stage.outputs)
            if (!output.is_colour && output.is_written)
                result[channel_name(*stage.link->effect, *output.role)] = {&output.image, output.role};
    return result;
}

} // namespace sfumato::cli
