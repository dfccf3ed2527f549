// The list of effects, and the validation of everything that a host passes to one.
#include "sfumato/effect.h"

#include "core/formats.h"
#include "sfumato/effects/ambient_occlusion.h"
#include "sfumato/effects/motion_blur.h"
#include "sfumato/effects/particles.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace sfumato {

std::span<const EffectInfo* const> effects() {
    static const EffectInfo* const list[] = {
        &MotionBlur::info(),
        &AmbientOcclusion::info(),
        &ParticleVolume::info(),
    };
    return list;
}

const EffectInfo* find_effect(std::string_view name) {
    for (const EffectInfo* effect : effects())
        if (effect->name == name)
            return effect;
    return nullptr;
}

namespace {

// Larger images are more than any device's maxImageDimension2D, and keep pixel arithmetic far from overflow.
constexpr uint32_t largest_side = 32768;

Error invalid(const EffectInfo& effect, const std::string& message) {
    return {ErrorCode::invalid_argument, std::string(effect.name) + ": " + message};
}

Result<void> validate_layout(const EffectInfo& effect, const ImageRole& role, const Image& image) {
    const std::string name = std::string("image '") + role.name + "' ";
    if (image.view == VK_NULL_HANDLE || image.handle == VK_NULL_HANDLE)
        return invalid(effect, name + "has an extent but a null handle or view");
    const bool readable =
        image.layout == VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL || image.layout == VK_IMAGE_LAYOUT_GENERAL ||
        image.layout == VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL ||
        image.layout == VK_IMAGE_LAYOUT_DEPTH_READ_ONLY_STENCIL_ATTACHMENT_OPTIMAL ||
        image.layout == VK_IMAGE_LAYOUT_DEPTH_READ_ONLY_OPTIMAL || image.layout == VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL;
    const bool fits = role.is_output() ? image.layout == VK_IMAGE_LAYOUT_GENERAL : readable;
    if (!fits)
        return invalid(effect,
                       name + "is in VkImageLayout " + std::to_string(image.layout) +
                           (role.is_output() ? "; an output must be in GENERAL"
                                             : "; an input must be in SHADER_READ_ONLY_OPTIMAL, GENERAL or a depth "
                                               "read-only layout"));
    return {};
}

Result<void> validate_image(const EffectInfo& effect, const ImageRole& role, const Image& image, bool need_handles) {
    const std::string name = std::string("image '") + role.name + "' ";
    if (!image) {
        if (image.extent.width != 0 || image.extent.height != 0)
            return invalid(effect, name + "is " + extent_text(image.extent) + "; both sides must be at least 1");
        if (role.is_optional())
            return {};
        return invalid(effect, name + "is missing: " + role.doc);
    }
    if (image.extent.width > largest_side || image.extent.height > largest_side)
        return invalid(effect, name + "is " + extent_text(image.extent) + "; each side may be at most " +
                                   std::to_string(largest_side));
    const FormatInfo* format = find_format(image.format);
    if (!format)
        return invalid(effect, name + "has VkFormat " + std::to_string(image.format) + ", which no effect takes");
    if (format->components < role.components)
        return invalid(effect, name + "has format " + format->name + "; it needs at least " +
                                   std::to_string(role.components) + " components");
    if (role.is_signed && !format->is_signed)
        return invalid(effect, name + "has format " + format->name + ", which cannot hold negative values");
    if (role.is_output() && format->is_depth)
        return invalid(effect, name + "has depth format " + format->name + ", which cannot be written");
    return need_handles ? validate_layout(effect, role, image) : Result<void>{};
}

Result<void> validate_buffer(const EffectInfo& effect, const BufferRole& role, const Buffer& buffer,
                             bool need_handles) {
    const std::string name = std::string("buffer '") + role.name + "' ";
    if (!buffer)
        return role.is_optional() ? Result<void>{} : invalid(effect, name + "is missing: " + role.doc);
    if (buffer.bytes % role.element_bytes != 0 || buffer.bytes > role.largest_bytes)
        return invalid(effect, name + "is " + std::to_string(buffer.bytes) + " bytes long; it must be a multiple of " +
                                   std::to_string(role.element_bytes) + " and at most " +
                                   std::to_string(role.largest_bytes));
    if (buffer.offset % buffer_alignment != 0)
        return invalid(effect, name + "starts at byte " + std::to_string(buffer.offset) +
                                   "; it must be a multiple of " + std::to_string(buffer_alignment));
    if (need_handles && buffer.handle == VK_NULL_HANDLE)
        return invalid(effect, name + "has a size but a null handle");
    return {};
}

// Hazards are tracked by role: an output that shares bytes with another role would hide one.
Result<void> validate_buffers(const EffectInfo& effect, const void* images, bool need_handles) {
    for (const BufferRole& role : effect.buffers) {
        const Buffer& buffer = role.get(const_cast<void*>(images));
        if (auto valid = validate_buffer(effect, role, buffer, need_handles); !valid)
            return valid.error();
        for (const BufferRole& other : effect.buffers) {
            const Buffer& second = other.get(const_cast<void*>(images));
            const bool shared = &other != &role && buffer && second && buffer.handle == second.handle &&
                                buffer.offset < second.offset + second.bytes &&
                                second.offset < buffer.offset + buffer.bytes;
            if (need_handles && role.is_output() && shared)
                return invalid(effect, std::string("buffer '") + role.name + "' overlaps '" + other.name + "'");
        }
    }
    return {};
}

bool all_finite(std::span<const float> values) {
    return std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); });
}

bool finite(const Camera& camera) {
    const auto all = [](const auto& values) { return all_finite(values); };
    return all(camera.world_to_view) && all(camera.projection) && all(camera.jitter);
}

float length_squared(const std::array<float, 3>& v) {
    return v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
}

std::string wrong_light(const Light& light) {
    if (!all_finite(light.to_light) || !all_finite(light.radiance) || !all_finite(light.world_to_shadow))
        return "holds NaN or infinity";
    const float squared = length_squared(light.to_light);
    return std::isfinite(squared) && squared > 0.0f ? "" : "has a to_light without a direction";
}

std::string wrong_collider(const Collider& collider) {
    bool is_finite = all_finite(collider.centre) && all_finite(collider.size) && all_finite(collider.velocity);
    bool has_units = true;
    for (const auto& axis : collider.axes) {
        is_finite = is_finite && all_finite(axis);
        has_units = has_units && std::abs(length_squared(axis) - 1.0f) < 0.01f;
    }
    if (!is_finite)
        return "holds NaN or infinity";
    if (collider.shape > ColliderShape::box)
        return "has shape " + std::to_string(static_cast<uint32_t>(collider.shape)) + "; there are plane, sphere, box";
    const bool has_size = collider.size[0] > 0.0f && collider.size[1] > 0.0f && collider.size[2] > 0.0f;
    if (collider.shape != ColliderShape::plane && !has_size)
        return "has a size that is not above 0";
    return has_units ? "" : "has axes that are not of length 1";
}

Result<void> validate_surroundings(const EffectInfo& effect, const Frame& frame) {
    if (frame.lights.size() > most_lights)
        return invalid(effect, "frame.lights holds " + std::to_string(frame.lights.size()) + "; at most " +
                                   std::to_string(most_lights) + " are allowed");
    if (frame.colliders.size() > most_colliders)
        return invalid(effect, "frame.colliders holds " + std::to_string(frame.colliders.size()) + "; at most " +
                                   std::to_string(most_colliders) + " are allowed");
    for (size_t i = 0; i < frame.lights.size(); ++i)
        if (const std::string wrong = wrong_light(frame.lights[i]); !wrong.empty())
            return invalid(effect, "frame.lights[" + std::to_string(i) + "] " + wrong);
    for (size_t i = 0; i < frame.colliders.size(); ++i)
        if (const std::string wrong = wrong_collider(frame.colliders[i]); !wrong.empty())
            return invalid(effect, "frame.colliders[" + std::to_string(i) + "] " + wrong);
    return {};
}

Result<void> validate_frame(const EffectInfo& effect, const Frame& frame) {
    if (!(std::isfinite(frame.time_step) && frame.time_step > 0.0f))
        return invalid(effect,
                       "frame.time_step is " + std::to_string(frame.time_step) + " s; it must be finite and above 0");
    const std::pair<const char*, const std::optional<Camera>*> cameras[] = {
        {"camera", &frame.camera}, {"previous_camera", &frame.previous_camera}, {"next_camera", &frame.next_camera}};
    for (const auto& [name, camera] : cameras)
        if (*camera && !finite(**camera))
            return invalid(effect, std::string("frame.") + name + " holds NaN or infinity");
    if (frame.depth_kind == DepthKind::device && !frame.camera)
        return invalid(effect, "frame.depth_kind is device, but frame.camera is missing: depth is read off its "
                               "projection");
    if (effect.needs_camera && !frame.camera)
        return invalid(effect, "frame.camera is missing: positions are read off its projection");
    return validate_surroundings(effect, frame);
}

} // namespace

Result<void> validate_effect(const EffectInfo& effect, const Frame& frame, const void* parameters, const void* images,
                             bool need_handles) {
    if (auto valid = validate_parameters(*effect.parameters, parameters); !valid)
        return valid.error();
    if (auto valid = validate_frame(effect, frame); !valid)
        return valid.error();
    const Image* inputs[64];
    size_t input_count = 0;
    for (const ImageRole& role : effect.images) {
        // Roles hand out mutable references for tools that fill the struct; here it is only read.
        const Image& image = role.get(const_cast<void*>(images));
        if (auto valid = validate_image(effect, role, image, need_handles); !valid)
            return valid.error();
        if (!role.is_output() && image && need_handles && input_count < 64)
            inputs[input_count++] = &image;
    }
    // Every pixel of an output is written: it has the size of what the effect works on, its first image.
    const Image& first = effect.images.front().get(const_cast<void*>(images));
    for (const ImageRole& role : effect.images)
        if (const Image& image = role.get(const_cast<void*>(images));
            role.is_output() && image && image.extent != first.extent)
            return invalid(effect, std::string("image '") + role.name + "' is " + extent_text(image.extent) +
                                       "; it must have the size of '" + effect.images.front().name + "', " +
                                       extent_text(first.extent));
    for (const ImageRole& role : effect.images)
        for (size_t i = 0; i < input_count && role.is_output() && need_handles; ++i)
            if (const Image& image = role.get(const_cast<void*>(images)); image && image.view == inputs[i]->view)
                return invalid(effect, std::string("image '") + role.name +
                                           "' is also an input; an effect cannot work in place");
    if (auto valid = validate_buffers(effect, images, need_handles); !valid)
        return valid.error();
    if (effect.check)
        if (const std::string wrong = effect.check(frame, parameters, images); !wrong.empty())
            return invalid(effect, wrong);
    return {};
}

Result<Plan> plan_effect(const EffectInfo& effect, const Frame& frame, const void* parameters, const void* images) {
    if (auto valid = validate_effect(effect, frame, parameters, images, false); !valid)
        return valid.error();
    return effect.plan(frame, parameters, images);
}

} // namespace sfumato
