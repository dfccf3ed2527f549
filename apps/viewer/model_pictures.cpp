// Which pictures there are to look at, and what has to be rendered for them.
#include "apps/viewer/model.h"

#include "sfumato/effect.h"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sfumato::viewer {

namespace {

constexpr std::string_view colour_role = "output";

bool has_parameters(const EffectInfo& effect, std::initializer_list<std::string_view> names) {
    return std::ranges::all_of(names, [&](auto name) { return effect.parameters->find(name) != nullptr; });
}

bool is_plane(const ImageRole& role) {
    return role.components == 1 && !role.is_signed;
}

// The output that a truth of one plane is compared with.
const ImageRole* plane_output(const EffectInfo& effect) {
    const auto found =
        std::ranges::find_if(effect.images, [](const auto& role) { return role.is_output() && is_plane(role); });
    return found == effect.images.end() ? nullptr : &*found;
}

PictureKind kind_of(const ImageRole& role) {
    if (is_plane(role))
        return PictureKind::grey;
    if (role.components == 2)
        return PictureKind::velocity;
    return role.is_signed ? PictureKind::normal : PictureKind::colour;
}

std::string picture_id(const EffectInfo& effect, const ImageRole& role) {
    return fmt::format("{}.{}", effect.name, role.name);
}

void add_unique(std::vector<std::string>& list, const std::string& name) {
    if (std::ranges::find(list, name) == list.end())
        list.push_back(name);
}

// What the images of a scene are on the device, for planning without one.
Image planned_image(uint32_t components, Extent extent) {
    const VkFormat format = components == 1   ? VK_FORMAT_R32_SFLOAT
                            : components == 2 ? VK_FORMAT_R32G32_SFLOAT
                                              : VK_FORMAT_R32G32B32A32_SFLOAT;
    return {VK_NULL_HANDLE, VK_NULL_HANDLE, format, extent, VK_IMAGE_LAYOUT_GENERAL};
}

} // namespace

std::span<const PictureChoice> scene_pictures() {
    static const PictureChoice pictures[] = {
        {"depth", "depth", PictureKind::depth, "View depth; near is bright."},
        {"normal", "normals", PictureKind::normal, "View space: red to the right, green up, blue towards the camera."},
        {"velocity", "velocity", PictureKind::velocity,
         "Pixels a frame, current minus previous: red to the right, green down, grey where nothing moves."},
        {"next_velocity", "next velocity", PictureKind::velocity, "The same, next minus current."},
        {"direct", "direct light", PictureKind::colour, "Sunlight with shadows, emission and sky."},
        {"ambient", "ambient light", PictureKind::colour, "As if nothing hid the sky."},
        {"shadow", "shadow", PictureKind::grey, "White where sunlight arrives."},
    };
    return pictures;
}

std::vector<TruthKind> Model::truths() const {
    std::vector<TruthKind> kinds = {TruthKind::none};
    for (const EffectSlot& slot : effects_) {
        if (slot.enabled && has_parameters(*slot.link.effect, {"shutter", "shutter_position"}))
            kinds.push_back(TruthKind::motion_blur);
        if (slot.enabled && has_parameters(*slot.link.effect, {"radius", "falloff"}) && plane_output(*slot.link.effect))
            kinds.push_back(TruthKind::occlusion);
    }
    return kinds;
}

const EffectSlot* Model::truth_effect() const {
    for (const EffectSlot& slot : effects_) {
        if (!slot.enabled)
            continue;
        if (truth.kind == TruthKind::motion_blur && has_parameters(*slot.link.effect, {"shutter", "shutter_position"}))
            return &slot;
        if (truth.kind == TruthKind::occlusion && has_parameters(*slot.link.effect, {"radius", "falloff"}) &&
            plane_output(*slot.link.effect))
            return &slot;
    }
    return nullptr;
}

std::string Model::compared_picture() const {
    const EffectSlot* slot = truth_effect();
    if (truth.kind != TruthKind::occlusion || !slot)
        return "result";
    return picture_id(*slot->link.effect, *plane_output(*slot->link.effect));
}

std::vector<PictureChoice> Model::pictures() const {
    std::vector<PictureChoice> all = {
        {"result", "result", PictureKind::colour, "After all effects that are on."},
        {"before", "before effects", PictureKind::colour, "The scene as it was rendered."},
    };
    if (const EffectSlot* compared = truth_effect()) {
        const bool plane = truth.kind == TruthKind::occlusion;
        all.push_back(
            {"truth", "ground truth", plane ? PictureKind::grey : PictureKind::colour,
             fmt::format("What {} approximates, gathered while nothing changes.", compared->link.effect->name)});
        all.push_back({"difference", "difference to truth",
                       plane ? PictureKind::grey_difference : PictureKind::difference,
                       "Absolute difference, times the gain."});
    }
    if (frozen)
        all.push_back({"frozen", "frozen", PictureKind::colour, "The result at the moment it was frozen."});
    for (const PictureChoice& choice : scene_pictures())
        all.push_back(choice);
    for (const EffectSlot& slot : effects_)
        for (const ImageRole& role : slot.link.effect->images)
            if (slot.enabled && role.is_output())
                all.push_back({picture_id(*slot.link.effect, role), picture_id(*slot.link.effect, role), kind_of(role),
                               role.doc});
    return all;
}

PictureChoice Model::picture(const std::string& id) const {
    const auto all = pictures();
    const auto found = std::ranges::find(all, id, &PictureChoice::id);
    return found == all.end() ? all.front() : *found;
}

cli::EffectChain Model::enabled_chain(std::string* told) const {
    cli::EffectChain chain;
    bool any_colour = false;
    std::vector<std::string> wanted;
    const EffectSlot* compared = truth.kind == TruthKind::occlusion ? truth_effect() : nullptr;
    for (const EffectSlot& slot : effects_) {
        if (!slot.enabled)
            continue;
        chain.push_back(slot.link);
        for (const ImageRole& role : slot.link.effect->images) {
            const std::string id = picture_id(*slot.link.effect, role);
            const bool shown = (split && left == id) || right == id;
            if (role.is_output() && role.name == colour_role)
                any_colour = true;
            else if (role.is_output() && (shown || (compared == &slot && &role == plane_output(*slot.link.effect))))
                add_unique(wanted, role.name);
        }
    }
    if (any_colour)
        wanted.insert(wanted.begin(), "colour");
    const auto choose = [&] {
        static_cast<void>(static_cast<bool>(cli::choose_outputs(chain, fmt::format("{}", fmt::join(wanted, ",")))));
    };
    choose();
    // An effect that leaves the picture alone still has to make something.
    for (const cli::ChainLink& link : chain)
        if (link.outputs.empty())
            for (const ImageRole& role : link.effect->images)
                if (role.is_output() && role.name != colour_role) {
                    add_unique(wanted, role.name);
                    break;
                }
    choose();
    if (told)
        *told = fmt::format("{}", fmt::join(wanted, ","));
    return chain;
}

PictureRequest Model::request(Extent extent) const {
    PictureRequest request;
    request.extent = extent;
    request.frame = frame_;
    request.samples = samples;
    request.viewpoint = viewpoint();
    request.viewpoint_text = viewpoint_text();
    request.chain = enabled_chain();
    if (std::ranges::any_of(request.chain, keeps_history))
        request.preroll = preroll;
    for (const char* pass : {"direct", "ambient", "shadow"})
        if ((split && left == pass) || right == pass || cli::chain_uses(request.chain, pass))
            request.passes.insert(pass);
    return request;
}

std::string PictureRequest::structure() const {
    std::string text = fmt::format("{} {} passes {}", extent_text(extent), samples, fmt::join(passes, ","));
    for (const cli::ChainLink& link : chain)
        text += fmt::format("; {} {}", link.effect->name, fmt::join(link.outputs, ","));
    return text;
}

std::string PictureRequest::key() const {
    std::string text = fmt::format("{} frame {} preroll {} {}", structure(), frame, preroll, viewpoint_text);
    for (const cli::ChainLink& link : chain)
        text += "; " + cli::parameters_text(link);
    return text;
}

bool keeps_history(const cli::ChainLink& link) {
    const Extent extent = {64, 64};
    Frame frame;
    frame.camera = frame.previous_camera = frame.next_camera = scene::camera_of({}, {}, extent);
    std::vector<std::max_align_t> images(link.effect->images_size / sizeof(std::max_align_t) + 1);
    for (const ImageRole& role : link.effect->images) {
        const auto is_made = [&] { return std::ranges::find(link.outputs, role.name) != link.outputs.end(); };
        const bool is_there = role.is_output() ? is_made() : cli::uses_input(link, role);
        role.get(images.data()) = is_there ? planned_image(role.components, extent) : Image{};
    }
    const auto plan = plan_effect(*link.effect, frame, link.parameters.data(), images.data());
    return plan && std::ranges::any_of(plan->resources,
                                       [](const auto& resource) { return resource.kind == ResourceKind::previous; });
}

} // namespace sfumato::viewer
