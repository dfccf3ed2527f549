// Golden images: one built-in scene through every preset of every effect, against pictures in tests/golden that
// somebody has looked at. They catch what no property names. SFUMATO_UPDATE_GOLDEN=1 writes them anew: look at them
// again then.
#include "media/exr_file.h"
#include "scene/scene.h"
#include "tests/gpu/gpu_test.h"

#include <cstdlib>
#include <filesystem>

namespace sfumato::test {
namespace {

constexpr Extent extent{128, 72};
// Drivers differ in the last bits, and a bit can move a tap by a pixel: a few pixels may differ by more.
constexpr float tolerance = 5.0f / 255.0f;
constexpr double share_beyond = 0.002;

struct SceneInputs {
    FloatImage colour, depth, velocity, next_velocity;
    Frame frame;
};

const SceneInputs& fairground() {
    static const SceneInputs inputs = [] {
        auto context = make_context();
        auto renderer = expect_value(scene::SceneRenderer::create(*context), "renderer");
        const scene::Scene* found = scene::find_scene("fairground");
        const auto image = [](VkFormat format) { return expect_value(device().create_image(format, extent), "image"); };
        const auto colour = image(VK_FORMAT_R16G16B16A16_SFLOAT), depth = image(VK_FORMAT_R32_SFLOAT);
        const auto velocity = image(VK_FORMAT_R32G32_SFLOAT), next = image(VK_FORMAT_R32G32_SFLOAT);
        scene::SceneImages images;
        images.colour = colour.image();
        images.depth = depth.image();
        images.velocity = velocity.image();
        images.next_velocity = next.image();
        const int frame = found->info.key_frame;
        run_commands([&](VkCommandBuffer commands) {
            expect_done(renderer->record(commands, *found, frame, {.samples = 2}, images, 0), "scene");
        });
        return SceneInputs{read_back(colour), read_back(depth), read_back(velocity), read_back(next),
                           scene::frame_facts(*found, frame, extent)};
    }();
    return inputs;
}

media::ExrImage exr_of(const FloatImage& image) {
    media::ExrImage exr;
    media::ExrPart& part = exr.parts.emplace_back();
    part.data_window =
        part.display_window = {0, 0, static_cast<int>(extent.width) - 1, static_cast<int>(extent.height) - 1};
    for (uint32_t c = 0; c < 3; ++c) {
        std::vector<float> plane;
        for (size_t i = c; i < image.values.size(); i += image.components)
            plane.push_back(image.values[i]);
        part.set_channel(std::string(1, "RGB"[c]), std::move(plane));
    }
    return exr;
}

class Golden : public GpuTest {};

TEST_F(Golden, EveryPresetOfMotionBlur) {
    const EffectInfo& effect = MotionBlur::info();
    auto context = make_context();
    for (const Preset& preset : effect.parameters->presets) {
        ParameterSet parameters(*effect.parameters);
        expect_done(apply_preset(*effect.parameters, parameters.data(), preset.name), preset.name);
        EffectRig rig(*context, effect);
        rig.set("colour", fairground().colour);
        rig.set("depth", fairground().depth);
        rig.set("velocity", fairground().velocity);
        rig.set("next_velocity", fairground().next_velocity);
        const FloatImage blurred = rig.run(fairground().frame, parameters.data());
        const std::string path =
            std::string(SFUMATO_SOURCE_DIR "/tests/golden/") + effect.name + "." + preset.name + ".exr";
        if (std::getenv("SFUMATO_UPDATE_GOLDEN")) {
            expect_done(media::write_exr(path, exr_of(blurred), {}), path.c_str());
            continue;
        }
        const auto golden = expect_value(media::read_exr(path, {}), path.c_str());
        size_t beyond = 0;
        for (uint32_t c = 0; c < 3; ++c) {
            const auto* channel = golden.parts.front().find_channel(std::string(1, "RGB"[c]));
            ASSERT_NE(channel, nullptr) << path;
            for (size_t i = 0; i < channel->values.size(); ++i)
                beyond +=
                    std::abs(channel->values[i] - blurred.values[i * blurred.components + c]) <= tolerance ? 0 : 1;
        }
        EXPECT_LE(static_cast<double>(beyond), share_beyond * 3 * extent.width * extent.height) << path;
        // What is compared is a blurred picture.
        EXPECT_NE(first_difference(blurred, fairground().colour), "") << path;
    }
}

} // namespace
} // namespace sfumato::test
