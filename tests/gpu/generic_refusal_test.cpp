// A host's mistakes, each in turn, for every effect: an Error that names the thing, and nothing recorded.
#include "tests/gpu/effect_fixture.h"

#include <algorithm>
#include <cmath>

namespace sfumato::test {
namespace {

constexpr Extent extent{33, 21};

class Refusal : public EffectTest {
  protected:
    void SetUp() override {
        EffectTest::SetUp();
        context_ = make_context();
        rig_ = std::make_unique<EffectRig>(*context_, effect());
        set_fixture(*rig_, effect(), extent);
        clean_ = first_frame();
    }
    // After every refusal the effect still works as before.
    void TearDown() override {
        EXPECT_EQ(first_difference(clean_, first_frame()), "");
        rig_.reset();
        context_.reset();
        EffectTest::TearDown();
    }

    std::string message(const std::function<void(void* images)>& change, const ParameterSet& parameters,
                        const Frame& frame) {
        std::string text;
        run_commands([&](VkCommandBuffer commands) {
            const auto done = rig_->record(commands, frame, parameters.data(), change);
            text = done ? "" : done.error().message;
            EXPECT_TRUE(done || done.error().code == ErrorCode::invalid_argument) << text;
        });
        return text;
    }

    void expect(const std::string& text, std::initializer_list<std::string> parts) {
        for (const std::string& part : parts)
            EXPECT_NE(text.find(part), std::string::npos) << "'" << text << "' lacks '" << part << "'";
    }

    // Changes one image, expects the parts, and puts it back.
    void expect_image(const ImageRole& role, const std::function<void(Image&)>& change, const std::string& part) {
        Image before;
        const std::string text = message(
            [&](void* images) {
                before = role.get(images);
                change(role.get(images));
            },
            defaults(), fixture_frame(1, extent));
        expect(text, {effect().name, std::string("'") + role.name + "'", part});
        message([&](void* images) { role.get(images) = before; }, defaults(), fixture_frame(1, extent));
    }

  private:
    // Some effects are elsewhere in every frame: all begin anew.
    FloatImage first_frame() {
        Frame frame = fixture_frame(1, extent);
        frame.reset = true;
        return rig_->run(frame, defaults().data());
    }

    std::unique_ptr<Context> context_;
    std::unique_ptr<EffectRig> rig_;
    FloatImage clean_;
};

TEST_P(Refusal, images) {
    for (const ImageRole& role : effect().images) {
        if (!role.is_optional())
            expect_image(
                role, [](Image& image) { image = {}; }, "missing");
        expect_image(
            role, [](Image& image) { image.handle = VK_NULL_HANDLE; }, "null");
        expect_image(
            role, [](Image& image) { image.view = VK_NULL_HANDLE; }, "null");
        expect_image(
            role, [](Image& image) { image.layout = VK_IMAGE_LAYOUT_UNDEFINED; }, "VkImageLayout 0");
        expect_image(
            role, [](Image& image) { image.layout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL; }, "GENERAL");
        expect_image(
            role, [](Image& image) { image.extent.height = 0; }, "33×0");
        expect_image(
            role, [](Image& image) { image.format = VK_FORMAT_R8_UINT; }, "VkFormat");
        if (role.is_signed)
            expect_image(
                role, [](Image& image) { image.format = VK_FORMAT_R8G8B8A8_UNORM; }, "R8G8B8A8_UNORM");
        if (role.components > 1)
            expect_image(
                role, [](Image& image) { image.format = VK_FORMAT_R16_SFLOAT; }, "components");
        if (role.is_output()) {
            expect_image(
                role, [](Image& image) { image.layout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL; }, "GENERAL");
            expect_image(
                role, [](Image& image) { image.extent.width = 32; }, "32×21");
        }
    }
}

TEST_P(Refusal, buffers) {
    const apps::HostBuffer made = expect_value(device().create_buffer(1 << 16), "create_buffer");
    for (const BufferRole& role : effect().buffers) {
        Buffer before;
        const auto refused = [&](const Buffer& buffer, const std::string& part) {
            const auto put = [&](void* images) {
                before = role.get(images);
                role.get(images) = buffer;
            };
            expect(message(put, defaults(), fixture_frame(1, extent)),
                   {effect().name, std::string("'") + role.name + "'", part});
            message([&](void* images) { role.get(images) = before; }, defaults(), fixture_frame(1, extent));
        };
        const uint64_t element = role.element_bytes;
        if (!role.is_optional())
            refused({}, "missing");
        refused({VK_NULL_HANDLE, 0, element}, "null");
        refused({made.handle(), 0, element + 1}, "multiple of " + std::to_string(element));
        refused({made.handle(), 0, role.largest_bytes + element}, "at most");
        refused({made.handle(), 16, element}, "byte 16");
        // One range for two roles, of which one is written.
        for (const BufferRole& other : effect().buffers)
            if (&other != &role && (role.is_output() || other.is_output())) {
                const auto put = [&](void* images) {
                    role.get(images) = {made.handle(), 0, element};
                    other.get(images) = {made.handle(), 0, other.element_bytes};
                };
                expect(message(put, defaults(), fixture_frame(1, extent)), {"overlaps"});
                const auto clear = [&](void* images) { role.get(images) = other.get(images) = {}; };
                message(clear, defaults(), fixture_frame(1, extent));
            }
    }
}

TEST_P(Refusal, working_in_place) {
    for (const ImageRole& output : effect().images)
        for (const ImageRole& input : effect().images)
            if (output.is_output() && !input.is_output()) {
                Image before;
                const std::string text = message(
                    [&](void* images) {
                        before = input.get(images);
                        input.get(images) = output.get(images);
                    },
                    defaults(), fixture_frame(1, extent));
                expect(text, {std::string("'") + output.name + "'", "input"});
                message([&](void* images) { input.get(images) = before; }, defaults(), fixture_frame(1, extent));
            }
}

TEST_P(Refusal, parameters) {
    for (const ParameterInfo& info : effect().parameters->parameters) {
        std::vector<double> values;
        if (info.kind == ParameterKind::real)
            values = {NAN, INFINITY, -INFINITY};
        if (info.kind != ParameterKind::boolean) {
            values.push_back(info.maximum + std::max(1.0, 1e-5 * info.maximum));
            values.push_back(info.minimum - 1.0);
        }
        for (const double value : values) {
            ParameterSet parameters = defaults();
            info.set(parameters.data(), value);
            expect(message({}, parameters, fixture_frame(1, extent)),
                   {std::string(effect().name) + "." + info.name, "allowed is"});
        }
    }
}

TEST_P(Refusal, frames) {
    const auto with = [&](auto&& change) {
        Frame frame = fixture_frame(1, extent);
        change(frame);
        return message({}, defaults(), frame);
    };
    expect(with([](Frame& frame) { frame.time_step = 0.0f; }), {"time_step", "above 0"});
    expect(with([](Frame& frame) { frame.time_step = NAN; }), {"time_step", "finite"});
    expect(with([](Frame& frame) { frame.camera->projection[0] = NAN; }), {"frame.camera", "NaN"});
    expect(with([](Frame& frame) { frame.previous_camera->world_to_view[3] = INFINITY; }), {"frame.previous_camera"});
    expect(with([](Frame& frame) { frame.next_camera->jitter[0] = NAN; }), {"frame.next_camera"});
    std::vector<Light> lights(most_lights + 1);
    std::vector<Collider> colliders(most_colliders + 1);
    expect(with([&](Frame& frame) { frame.lights = lights; }), {"frame.lights", "5", "at most 4"});
    expect(with([&](Frame& frame) { frame.colliders = colliders; }), {"frame.colliders", "33", "at most 32"});
    lights.resize(2);
    lights[1].radiance[0] = NAN;
    expect(with([&](Frame& frame) { frame.lights = lights; }), {"frame.lights[1]", "NaN"});
    lights[1] = {.to_light = {0, 0, 0}};
    expect(with([&](Frame& frame) { frame.lights = lights; }), {"frame.lights[1]", "direction"});
    colliders.resize(3);
    colliders[2].velocity[1] = INFINITY;
    expect(with([&](Frame& frame) { frame.colliders = colliders; }), {"frame.colliders[2]", "infinity"});
    colliders[2] = {.shape = ColliderShape::box, .size = {1, 0, 1}};
    expect(with([&](Frame& frame) { frame.colliders = colliders; }), {"frame.colliders[2]", "size"});
    colliders[2] = {};
    colliders[2].axes[1] = {0, 0.5f, 0};
    expect(with([&](Frame& frame) { frame.colliders = colliders; }), {"frame.colliders[2]", "axes"});
    colliders[2] = {.shape = static_cast<ColliderShape>(7)};
    expect(with([&](Frame& frame) { frame.colliders = colliders; }), {"frame.colliders[2]", "shape 7"});
    expect(with([](Frame& frame) {
               frame.depth_kind = DepthKind::device;
               frame.camera.reset();
           }),
           {"depth_kind", "camera"});
}

INSTANTIATE_TEST_SUITE_P(effects, Refusal, testing::ValuesIn(all_effects()), effect_test_name);

} // namespace
} // namespace sfumato::test
