// The harness of the GPU tests.
#include "tests/gpu/gpu_test.h"

#include "apps/common/pixels.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <stdexcept>

namespace sfumato::test {

FloatImage make_image(Extent extent, uint32_t components,
                      const std::function<void(uint32_t x, uint32_t y, float* pixel)>& fill) {
    FloatImage image{extent, components, std::vector<float>(size_t{extent.width} * extent.height * components)};
    for (uint32_t y = 0; y < extent.height; ++y)
        for (uint32_t x = 0; x < extent.width; ++x)
            fill(x, y, image.at(x, y));
    return image;
}

std::string first_difference(const FloatImage& a, const FloatImage& b) {
    if (a.extent != b.extent || a.components != b.components)
        return extent_text(a.extent) + " and " + extent_text(b.extent);
    if (std::memcmp(a.values.data(), b.values.data(), a.values.size() * sizeof(float)) == 0)
        return "";
    for (size_t i = 0; i < a.values.size(); ++i)
        if (std::memcmp(&a.values[i], &b.values[i], sizeof(float)) != 0) {
            const size_t pixel = i / a.components;
            return "at (" + std::to_string(pixel % a.extent.width) + ", " + std::to_string(pixel / a.extent.width) +
                   ") channel " + std::to_string(i % a.components) + ": " + std::to_string(a.values[i]) + " and " +
                   std::to_string(b.values[i]);
        }
    return "";
}

bool all_finite(const FloatImage& image) {
    for (const float value : image.values)
        if (!std::isfinite(value))
            return false;
    return true;
}

VkFormat float_format(uint32_t components) {
    constexpr VkFormat formats[] = {VK_FORMAT_R32_SFLOAT, VK_FORMAT_R32G32_SFLOAT, VK_FORMAT_R32G32B32A32_SFLOAT,
                                    VK_FORMAT_R32G32B32A32_SFLOAT};
    return formats[components - 1];
}

apps::Device& device() {
    // Never destroyed: drivers keep threads that must not outlive their library at exit.
    static apps::Device* made = [] {
        auto created = apps::Device::create({.device = "", .validation = true, .labels = true});
        if (!created) {
            std::cerr << "no Vulkan device to test on: " << created.error().message << std::endl;
            std::exit(1);
        }
        return std::move(created).value().release();
    }();
    return *made;
}

void GpuTest::SetUp() {
    device().clear_validation_messages();
}

void GpuTest::TearDown() {
    const auto messages = device().validation_messages();
    for (size_t i = 0; i < messages.size() && i < 5; ++i)
        ADD_FAILURE() << "validation: " << messages[i];
    device().clear_validation_messages();
}

void expect_done(const Result<void>& result, const char* what) {
    if (!result)
        throw std::runtime_error(std::string(what) + ": " + result.error().message);
}

std::unique_ptr<Context> make_context(int poison, const std::function<void(ContextInfo&)>& change) {
    ContextInfo info = device().context_info();
    info.poison = poison;
    if (change)
        change(info);
    return expect_value(Context::create(info), "Context::create");
}

apps::HostImage upload(const FloatImage& image, VkFormat format) {
    apps::HostImage made = expect_value(device().create_image(format, image.extent), "create_image");
    expect_done(device().upload(made, image.values, image.components), "upload");
    return made;
}

apps::HostImage upload(const FloatImage& image) {
    return upload(image, float_format(image.components));
}

FloatImage read_back(const apps::HostImage& image) {
    const auto* format = apps::find_pixel_format(image.format());
    return {image.extent(), format->components, expect_value(device().readback(image), "readback")};
}

void run_commands(const std::function<void(VkCommandBuffer)>& record) {
    const VkCommandBuffer commands = expect_value(device().begin(), "begin");
    record(commands);
    expect_done(device().submit_and_wait(), "submit");
}

void show_host(VkCommandBuffer commands) {
    const VkMemoryBarrier barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER, nullptr, VK_ACCESS_SHADER_WRITE_BIT,
                                  VK_ACCESS_HOST_READ_BIT};
    device().functions().CmdPipelineBarrier(commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_PIPELINE_STAGE_HOST_BIT,
                                            0, 1, &barrier, 0, nullptr, 0, nullptr);
}

EffectRig::EffectRig(Context& context, const EffectInfo& effect)
    : effect_(&effect), instance_(expect_value(AnyEffect::create(context, effect), "AnyEffect::create")),
      storage_(effect.images_size) {
    for (const ImageRole& role : effect.images)
        new (&role.get(storage_.data())) Image{};
    for (const BufferRole& role : effect.buffers)
        new (&role.get(storage_.data())) Buffer{};
}

void EffectRig::set(const std::string& role, const FloatImage& image, std::optional<VkFormat> format) {
    images_[role] = upload(image, format.value_or(float_format(image.components)));
}

void EffectRig::remove(const std::string& role) {
    images_.erase(role);
}

void EffectRig::set_buffer(const std::string& role, const Buffer& buffer) {
    for (const BufferRole& known : effect_->buffers)
        if (role == known.name)
            known.get(storage_.data()) = buffer;
}

void EffectRig::make_outputs() {
    const Extent extent = images_.at(effect_->images.front().name).extent();
    const FloatImage filled =
        make_image(extent, 4, [&](uint32_t, uint32_t, float* pixel) { std::fill(pixel, pixel + 4, sentinel); });
    for (const ImageRole& role : effect_->images) {
        if (!role.is_output() || (role.is_optional() && !optional_outputs)) {
            if (role.is_output())
                images_.erase(role.name);
            continue;
        }
        const bool fits = !role.is_signed || output_format != VK_FORMAT_R8G8B8A8_UNORM;
        images_[role.name] = upload(filled, fits ? output_format : VK_FORMAT_R16G16B16A16_SFLOAT);
    }
    for (const ImageRole& role : effect_->images) {
        const auto found = images_.find(role.name);
        role.get(storage_.data()) = found == images_.end() ? Image{} : found->second.image();
    }
}

Result<void> EffectRig::record(VkCommandBuffer commands, const Frame& frame, const void* parameters,
                               const std::function<void(void* images)>& change) {
    if (change)
        change(storage_.data());
    return instance_->record(commands, frame, parameters, storage_.data());
}

bool EffectRig::has_kind(const Frame& frame, const void* parameters, std::initializer_list<ResourceKind> kinds) {
    make_outputs();
    const Plan plan = expect_value(plan_effect(*effect_, frame, parameters, storage_.data()), "plan");
    return std::any_of(plan.resources.begin(), plan.resources.end(), [&](const Resource& resource) {
        return std::find(kinds.begin(), kinds.end(), resource.kind) != kinds.end();
    });
}

bool EffectRig::keeps_history(const Frame& frame, const void* parameters) {
    return has_kind(frame, parameters, {ResourceKind::previous, ResourceKind::state});
}

bool EffectRig::keeps_state(const Frame& frame, const void* parameters) {
    return has_kind(frame, parameters, {ResourceKind::state});
}

FloatImage EffectRig::run(const Frame& frame, const void* parameters) {
    make_outputs();
    run_commands([&](VkCommandBuffer commands) {
        expect_done(record(commands, frame, parameters), "record");
        show_host(commands);
    });
    // One below the other.
    FloatImage all;
    for (const ImageRole& role : effect_->images)
        if (role.is_output() && images_.contains(role.name)) {
            const FloatImage output = read_back(images_.at(role.name));
            if (all.values.empty()) {
                all = output;
            } else {
                all.values.insert(all.values.end(), output.values.begin(), output.values.end());
                all.extent.height += output.extent.height;
            }
        }
    return all;
}

} // namespace sfumato::test
