// Every plan of every effect, under every preset and choice and at odd sizes, is free of defects and a pure function.
#include "core/formats.h"
#include "sfumato/sfumato.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

namespace sfumato {
namespace {

constexpr Extent sizes[] = {{1, 1},     {1, 97},      {97, 1},      {7, 3},    {97, 61},
                            {255, 257}, {1920, 1080}, {3840, 2160}, {32768, 3}};

Camera perspective() {
    Camera camera;
    camera.projection = {1.5f, 0, 0, 0, 0, -2.0f, 0, 0, 0, 0, 0, -1, 0, 0, 0.1f, 0};
    return camera;
}

// A struct of images, all present unless `optional` is false; formats as the roles want them.
std::vector<std::byte> make_images(const EffectInfo& effect, Extent extent, bool optional) {
    std::vector<std::byte> storage(effect.images_size);
    for (const ImageRole& role : effect.images) {
        Image& image = *new (&role.get(storage.data())) Image{};
        if (role.is_optional() && !optional)
            continue;
        const VkFormat formats[] = {VK_FORMAT_R16_SFLOAT, VK_FORMAT_R16G16_SFLOAT, VK_FORMAT_R16G16B16A16_SFLOAT,
                                    VK_FORMAT_R16G16B16A16_SFLOAT};
        image.format = formats[role.components - 1];
        image.extent = extent;
    }
    return storage;
}

Frame make_frame(bool cameras) {
    Frame frame;
    frame.index = 3;
    if (cameras)
        frame.camera = frame.previous_camera = frame.next_camera = perspective();
    return frame;
}

void expect_sound(const EffectInfo& effect, const ParameterSet& parameters, const std::string& what) {
    for (const Extent extent : sizes)
        for (const bool optional : {false, true})
            for (const bool reset : {false, true}) {
                Frame frame = make_frame(optional || effect.needs_camera);
                frame.reset = reset;
                const auto images = make_images(effect, extent, optional);
                const auto plan = plan_effect(effect, frame, parameters.data(), images.data());
                // A choice may need an optional image, if it says which.
                if (!plan && !optional && plan.error().message.find("' is missing") != std::string::npos)
                    continue;
                ASSERT_TRUE(plan) << what << ": " << plan.error().message;
                EXPECT_EQ(check_plan(*plan), "") << what << " at " << extent_text(extent);
                EXPECT_EQ(plan->effect, effect.name);
                ASSERT_FALSE(plan->passes.empty());
                EXPECT_EQ(plan->passes.front().barrier, Barrier::none);
            }
}

TEST(EffectPlans, are_sound_under_every_preset) {
    for (const EffectInfo* effect : effects()) {
        expect_sound(*effect, ParameterSet(*effect->parameters), "defaults");
        for (const Preset& preset : effect->parameters->presets) {
            ParameterSet parameters(*effect->parameters);
            ASSERT_TRUE(apply_preset(*effect->parameters, parameters.data(), preset.name));
            expect_sound(*effect, parameters, preset.name);
        }
    }
}

TEST(EffectPlans, are_sound_at_the_limits_and_under_every_choice) {
    for (const EffectInfo* effect : effects())
        for (const ParameterInfo& info : effect->parameters->parameters) {
            std::vector<double> values = {info.minimum, info.maximum};
            for (size_t i = 1; i + 1 < info.choices.size(); ++i)
                values.push_back(static_cast<double>(i));
            for (const double value : values) {
                ParameterSet parameters(*effect->parameters);
                info.set(parameters.data(), value);
                expect_sound(*effect, parameters, info.name + std::string(" = ") + std::to_string(value));
            }
        }
}

bool same(const Plan& a, const Plan& b) {
    if (a.passes.size() != b.passes.size() || a.resources.size() != b.resources.size())
        return false;
    for (size_t i = 0; i < a.passes.size(); ++i) {
        const Pass &x = a.passes[i], &y = b.passes[i];
        if (x.name != y.name || x.constants != y.constants || x.specialization != y.specialization ||
            x.shader.code.data() != y.shader.code.data() || x.barrier != y.barrier)
            return false;
    }
    return true;
}

TEST(EffectPlans, are_a_pure_function) {
    for (const EffectInfo* effect : effects()) {
        const ParameterSet parameters(*effect->parameters);
        const auto images = make_images(*effect, {97, 61}, true);
        const Frame frame = make_frame(true);
        const auto a = plan_effect(*effect, frame, parameters.data(), images.data());
        // Another plan in between, and another place in memory.
        const auto other_images = make_images(*effect, {31, 17}, false);
        ASSERT_TRUE(plan_effect(*effect, make_frame(effect->needs_camera), parameters.data(), other_images.data()));
        const auto images_again = make_images(*effect, {97, 61}, true);
        const auto b = plan_effect(*effect, frame, parameters.data(), images_again.data());
        ASSERT_TRUE(a && b);
        EXPECT_TRUE(same(*a, *b)) << effect->name;
    }
}

// Every image that is handed in is looked at by some pass: a role that no plan takes is a dead input.
TEST(EffectPlans, take_every_image) {
    for (const EffectInfo* effect : effects()) {
        const auto images = make_images(*effect, {97, 61}, true);
        std::set<uint32_t> bound;
        const auto look = [&](const ParameterSet& parameters) {
            const auto plan = plan_effect(*effect, make_frame(true), parameters.data(), images.data());
            ASSERT_TRUE(plan);
            for (const Pass& pass : plan->passes)
                for (const Access& access : pass.accesses)
                    if (access.resource != no_resource && plan->resources[access.resource].kind == ResourceKind::host)
                        bound.insert(plan->resources[access.resource].index);
        };
        // Some are for a choice or a switch that is off by default.
        look(ParameterSet(*effect->parameters));
        for (const ParameterInfo& info : effect->parameters->parameters)
            for (size_t value = 0; value < std::max<size_t>(info.choices.size(), 2); ++value) {
                ParameterSet parameters(*effect->parameters);
                if (info.kind == ParameterKind::choice || info.kind == ParameterKind::boolean)
                    info.set(parameters.data(), static_cast<double>(value));
                look(parameters);
            }
        for (uint32_t i = 0; i < effect->images.size(); ++i)
            EXPECT_TRUE(bound.contains(i)) << effect->name << " does not look at " << effect->images[i].name;
    }
}

// ------------------------------------------------------------------------------------------ refusals

std::string refusal(const EffectInfo& effect, const Frame& frame, const std::vector<std::byte>& images) {
    const ParameterSet parameters(*effect.parameters);
    const auto plan = plan_effect(effect, frame, parameters.data(), images.data());
    return plan ? "" : plan.error().message;
}

TEST(EffectPlans, refuse_broken_frames) {
    const float not_a_number = std::numeric_limits<float>::quiet_NaN();
    for (const EffectInfo* effect : effects()) {
        const auto images = make_images(*effect, {9, 9}, true);
        const auto expect = [&](const Frame& frame, const char* what) {
            const std::string message = refusal(*effect, frame, images);
            EXPECT_NE(message.find(what), std::string::npos) << "'" << message << "' does not name " << what;
            EXPECT_EQ(message.rfind(effect->name, 0), 0u) << message;
        };
        for (const float step : {0.0f, -1.0f, not_a_number, std::numeric_limits<float>::infinity()}) {
            Frame frame = make_frame(true);
            frame.time_step = step;
            expect(frame, "frame.time_step");
        }
        const std::pair<const char*, std::optional<Camera> Frame::*> cameras[] = {
            {"frame.camera", &Frame::camera},
            {"frame.previous_camera", &Frame::previous_camera},
            {"frame.next_camera", &Frame::next_camera}};
        for (const auto& [name, member] : cameras) {
            Frame frame = make_frame(true);
            (frame.*member)->projection[5] = not_a_number;
            expect(frame, name);
            frame = make_frame(true);
            (frame.*member)->world_to_view[12] = std::numeric_limits<float>::infinity();
            expect(frame, name);
            frame = make_frame(true);
            (frame.*member)->jitter[1] = not_a_number;
            expect(frame, name);
        }
        Frame frame = make_frame(false);
        frame.depth_kind = DepthKind::device;
        expect(frame, "frame.camera");
    }
}

TEST(EffectPlans, refuse_broken_images) {
    for (const EffectInfo* effect : effects())
        for (const ImageRole& role : effect->images) {
            const auto expect = [&](auto&& break_image, const std::string& what) {
                auto images = make_images(*effect, {9, 9}, true);
                break_image(role.get(images.data()));
                const std::string message = refusal(*effect, make_frame(true), images);
                EXPECT_NE(message.find(std::string("'") + role.name + "'"), std::string::npos)
                    << "'" << message << "' does not name " << role.name << " (" << what << ")";
                EXPECT_NE(message.find(what), std::string::npos) << message;
            };
            if (!role.is_optional())
                expect([](Image& image) { image = {}; }, "missing");
            expect([](Image& image) { image.extent = {9, 0}; }, "9×0");
            expect([](Image& image) { image.extent = {70000, 9}; }, "70000×9");
            expect([](Image& image) { image.format = VK_FORMAT_UNDEFINED; }, "VkFormat 0");
            expect([](Image& image) { image.format = VK_FORMAT_R64G64_SFLOAT; }, "which no effect takes");
            if (role.components > 1)
                expect([](Image& image) { image.format = VK_FORMAT_R16_SFLOAT; }, "R16_SFLOAT");
            if (role.is_signed)
                expect([](Image& image) { image.format = VK_FORMAT_R16G16B16A16_UNORM; }, "negative");
            if (role.is_output()) {
                expect([](Image& image) { image.extent = {8, 9}; }, "8×9");
                expect([](Image& image) { image.extent = {9, 10}; }, "9×10");
            }
        }
}

} // namespace
} // namespace sfumato
