// Binds an effect's image roles to inputs and to outputs of its own.
#include "apps/bench/effect_run.h"

#include <algorithm>

namespace sfumato::bench {
namespace {

VkFormat output_format(const apps::Device& device, const ImageRole& role, bool is_compact) {
    // Renderers keep a visibility in a byte.
    if (is_compact && role.components == 1 && !role.is_signed && device.can_store(VK_FORMAT_R8_UNORM))
        return VK_FORMAT_R8_UNORM;
    if (role.components >= 3)
        return VK_FORMAT_R16G16B16A16_SFLOAT;
    return role.components == 2 ? VK_FORMAT_R16G16_SFLOAT : VK_FORMAT_R16_SFLOAT;
}

} // namespace

std::vector<std::string> wanted_planes(const EffectInfo& effect, const std::vector<std::string>& opted_in) {
    std::vector<std::string> wanted;
    for (const ImageRole& role : effect.images) {
        if (role.is_output())
            continue;
        const std::string plane = plane_of(adapter_of(effect), role, opted_in);
        if (!plane.empty() && std::ranges::find(wanted, plane) == wanted.end())
            wanted.push_back(plane);
    }
    return wanted;
}

Result<BoundImages> BoundImages::create(Rig& rig, const EffectInfo& effect, const Inputs& inputs,
                                        const std::vector<std::string>& opted_in) {
    if (effect.needs_camera && !inputs.frame.camera)
        return Error{ErrorCode::input, std::string(effect.name) +
                                           " needs a camera, which the source does not give (a file gets one by "
                                           "exr_to_raw.py --camera)"};
    BoundImages bound;
    // All zero is every image absent.
    bound.storage_.resize((effect.images_size + sizeof(Unit) - 1) / sizeof(Unit));
    for (const BufferRole& role : effect.buffers)
        role.get(bound.storage_.data()) = {};
    for (const ImageRole& role : effect.images) {
        Image& target = role.get(bound.storage_.data());
        if (role.is_output()) {
            if (!is_bound(adapter_of(effect), role, opted_in))
                continue;
            auto made = rig.device().create_image(output_format(rig.device(), role, inputs.is_compact), inputs.extent);
            if (!made)
                return made.error();
            target = made->image();
            bound.outputs_.push_back(std::move(*made));
            continue;
        }
        const apps::HostImage* input = inputs.find(plane_of(adapter_of(effect), role, opted_in));
        if (input != nullptr)
            target = input->image();
        else if (role.use == ImageUse::input)
            return Error{ErrorCode::input, std::string(effect.name) + " needs the image '" + role.name +
                                               "', which the source does not give"};
    }
    if (bound.outputs_.empty())
        return Error{ErrorCode::internal, std::string(effect.name) + " has no output image"};
    return bound;
}

Result<void> run_sequence(Rig& rig, Context& context, const EffectInfo& effect, const void* parameters,
                          std::span<const SequenceFrame> frames) {
    auto instance = AnyEffect::create(context, effect);
    if (!instance)
        return instance.error();
    for (const SequenceFrame& frame : frames) {
        auto commands = rig.device().begin();
        if (!commands)
            return commands.error();
        if (auto recorded = (*instance)->record(*commands, frame.facts, parameters, frame.images->data()); !recorded)
            return recorded;
        if (auto done = rig.device().submit_and_wait(); !done)
            return done;
    }
    return {};
}

} // namespace sfumato::bench
