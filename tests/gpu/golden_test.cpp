// Golden images: a built-in scene through presets of every effect, against pictures in tests/golden that somebody has
// looked at. They catch what no property names. SFUMATO_UPDATE_GOLDEN=1 writes them anew: look at them
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
    FloatImage colour, depth, normal, velocity, next_velocity;
    Frame frame;
};

SceneInputs render(const char* name, int back = 0) {
    auto context = make_context();
    auto renderer = expect_value(scene::SceneRenderer::create(*context), "renderer");
    const scene::Scene* found = scene::find_scene(name);
    const auto image = [](VkFormat format) { return expect_value(device().create_image(format, extent), "image"); };
    const auto colour = image(VK_FORMAT_R16G16B16A16_SFLOAT), depth = image(VK_FORMAT_R32_SFLOAT);
    const auto velocity = image(VK_FORMAT_R32G32_SFLOAT), next = image(VK_FORMAT_R32G32_SFLOAT);
    const auto normal = image(VK_FORMAT_R32G32B32A32_SFLOAT);
    scene::SceneImages images;
    images.colour = colour.image();
    images.depth = depth.image();
    images.velocity = velocity.image();
    images.next_velocity = next.image();
    images.normal = normal.image();
    const int frame = found->info.key_frame - back;
    run_commands([&](VkCommandBuffer commands) {
        expect_done(renderer->record(commands, *found, frame, {.samples = 2}, images, 0), "scene");
    });
    return SceneInputs{read_back(colour),   read_back(depth), read_back(normal),
                       read_back(velocity), read_back(next),  scene::frame_facts(*found, frame, extent)};
}

const SceneInputs& fairground() {
    static const SceneInputs inputs = render("fairground");
    return inputs;
}

std::string channel_name(uint32_t channel, uint32_t channels) {
    return std::string(1, channels == 1 ? 'Y' : "RGB"[channel]);
}

// The first `channels` channels.
media::ExrImage exr_of(const FloatImage& image, uint32_t channels) {
    media::ExrImage exr;
    media::ExrPart& part = exr.parts.emplace_back();
    part.data_window =
        part.display_window = {0, 0, static_cast<int>(extent.width) - 1, static_cast<int>(extent.height) - 1};
    for (uint32_t c = 0; c < channels; ++c) {
        std::vector<float> plane;
        for (size_t i = c; i < image.values.size(); i += image.components)
            plane.push_back(image.values[i]);
        part.set_channel(channel_name(c, channels), std::move(plane));
    }
    return exr;
}

class Golden : public GpuTest {
  protected:
    // Against the picture in tests/golden, or writes it.
    void compare(const FloatImage& image, uint32_t channels, const EffectInfo& effect, const std::string& preset) {
        const std::string path = std::string(SFUMATO_SOURCE_DIR "/tests/golden/") + effect.name + "." + preset + ".exr";
        if (std::getenv("SFUMATO_UPDATE_GOLDEN")) {
            expect_done(media::write_exr(path, exr_of(image, channels), {}), path.c_str());
            return;
        }
        const auto golden = expect_value(media::read_exr(path, {}), path.c_str());
        size_t beyond = 0;
        for (uint32_t c = 0; c < channels; ++c) {
            const auto* channel = golden.parts.front().find_channel(channel_name(c, channels));
            ASSERT_NE(channel, nullptr) << path;
            for (size_t i = 0; i < channel->values.size(); ++i)
                beyond += std::abs(channel->values[i] - image.values[i * image.components + c]) <= tolerance ? 0 : 1;
        }
        EXPECT_LE(static_cast<double>(beyond), share_beyond * channels * extent.width * extent.height) << path;
    }
};

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
        compare(blurred, 3, effect, preset.name);
        // What is compared is a blurred picture.
        EXPECT_NE(first_difference(blurred, fairground().colour), "") << preset.name;
    }
}

// The documents' presets; those found by search change with every search. Three frames, for the sake of histories.
TEST_F(Golden, DocumentsPresetsOfAmbientOcclusion) {
    const EffectInfo& effect = AmbientOcclusion::info();
    auto context = make_context();
    for (const char* preset : {"current-gen", "dx11", "sao", "hbao-crease", "hbao", "soma", "soma-spatial"}) {
        ParameterSet parameters(*effect.parameters);
        expect_done(apply_preset(*effect.parameters, parameters.data(), preset), preset);
        EffectRig rig(*context, effect);
        rig.optional_outputs = false;
        FloatImage visibility;
        for (int back = 2; back >= 0; --back) {
            const SceneInputs inputs = render("columns", back);
            rig.set("depth", inputs.depth);
            rig.set("normal", inputs.normal);
            rig.set("velocity", inputs.velocity);
            visibility = rig.run(inputs.frame, parameters.data());
        }
        compare(visibility, 1, effect, preset);
    }
}

} // namespace
} // namespace sfumato::test
