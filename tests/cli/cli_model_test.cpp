// render with glTF models: what is chosen, what is refused.
#include "tests/cli/program.h"

#include <algorithm>
#include <gtest/gtest.h>

namespace sfumato::cli_tests {

class CliModel : public ProgramTest {
  protected:
    // A blue wall, two metres wide, that slides two metres to the right in a second; with a camera before it.
    CliModel() { write("wall.gltf", model(true)); }

    static std::string model(bool has_camera) {
        return R"({"asset": {"version": "2.0"},
"scenes": [{"nodes": [0)" +
               std::string(has_camera ? ", 1" : "") +
               R"(]}], "scene": 0,
"nodes": [{"mesh": 0}, {"name": "front", "camera": 0, "translation": [0, 1, 5]}],
"cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}],
"materials": [{"doubleSided": true, "pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.1, 0.8, 1], "metallicFactor": 0}}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
"animations": [{"name": "Slide", "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
  "samplers": [{"input": 2, "output": 3}]}],
"accessors": [
  {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-1, 0, 0], "max": [1, 2, 0]},
  {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"},
  {"bufferView": 2, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1]},
  {"bufferView": 3, "componentType": 5126, "count": 2, "type": "VEC3"}],
"bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12},
  {"buffer": 0, "byteOffset": 60, "byteLength": 8}, {"buffer": 0, "byteOffset": 68, "byteLength": 24}],
"buffers": [{"byteLength": 92, "uri": "data:application/octet-stream;base64,)"
               R"(AACAvwAAAAAAAAAAAACAPwAAAAAAAAAAAACAPwAAAEAAAAAAAACAvwAAAEAAAAAAAAABAAIAAAACAAMAAAAAAAAAgD8AAAAAAAAAAAAA)"
               R"(AAAAAABAAAAAAAAAAAA="}]})";
    }

    ProgramResult render(std::vector<std::string> arguments) const {
        arguments.insert(arguments.begin(), {"render"});
        arguments.insert(arguments.end(), {"--size", "64x36", "--samples", "1"});
        return run(arguments);
    }

    // One value of a channel.
    float value(const std::string& file, const std::string& channel, int x, int y) const {
        const auto image = media::read_exr(path(file));
        EXPECT_TRUE(image) << (image ? "" : image.error().message);
        if (!image)
            return -1.0f;
        const media::ExrPart& part = image->parts.front();
        const auto* found = part.find_channel(channel);
        EXPECT_NE(found, nullptr) << channel;
        return found ? found->values[static_cast<size_t>(y) * 64 + static_cast<size_t>(x)] : -1.0f;
    }
};

TEST_F(CliModel, passes_effects_and_truth_of_a_model) {
    const ProgramResult done =
        render({"wall.gltf", "-o", "w.####.exr", "--frames", "3-4", "--apply", "ambient-occlusion,motion-blur",
                "--passes", "--truth", "2,ambient-occlusion", "--truth-rays", "4", "--outputs", "colour,visibility"});
    ASSERT_EQ(done.code, 0) << done.error;
    EXPECT_TRUE(exists("w.0003.exr"));
    EXPECT_NEAR(value("w.0004.exr", "Z", 32, 18), 5.0f, 1e-3f);
    // Two metres in 24 frames, at a scale of 36 pixels over 2 · 5 · tan(0.4) metres.
    EXPECT_NEAR(value("w.0004.exr", "sfumato_velocity.X", 32, 18), 2.0f / 24.0f * 36.0f / (10.0f * 0.42279f), 1e-3f);
    EXPECT_NEAR(value("w.0004.exr", "sfumato_velocity.Y", 32, 18), 0.0f, 1e-4f);
    EXPECT_GT(value("w.0004.exr", "B", 32, 18), 3.0f * value("w.0004.exr", "R", 32, 18));
    EXPECT_GT(value("w.0004.exr", "truth.B", 32, 18), 0.1f);
    EXPECT_EQ(value("w.0004.exr", "truth.AO", 32, 18), 1.0f);
    EXPECT_EQ(value("w.0004.exr", "N.Z", 32, 18), 1.0f);
}

TEST_F(CliModel, animation_camera_and_ground_are_chosen) {
    ASSERT_EQ(render({"wall.gltf", "-o", "rest.exr", "--animation", "none", "--frames", "6"}).code, 0);
    EXPECT_EQ(value("rest.exr", "sfumato_velocity.X", 32, 18), 0.0f);
    ASSERT_EQ(render({"wall.gltf", "-o", "slide.exr", "--animation", "Slide", "--frames", "6"}).code, 0);
    EXPECT_GT(value("slide.exr", "sfumato_velocity.X", 32, 18), 0.1f);
    ASSERT_EQ(render({"wall.gltf", "-o", "named.exr", "--camera-name", "front", "--frames", "6"}).code, 0);
    EXPECT_EQ(value("named.exr", "Z", 32, 18), value("slide.exr", "Z", 32, 18));
    // Its own camera sees no floor; a view of the whole does, unless told otherwise.
    const float sky = 1e10f;
    EXPECT_EQ(value("slide.exr", "Z", 2, 35), sky);
    write("bare.gltf", model(false));
    ASSERT_EQ(render({"bare.gltf", "-o", "floor.exr"}).code, 0);
    EXPECT_LT(value("floor.exr", "Z", 2, 35), 100.0f);
    ASSERT_EQ(render({"bare.gltf", "-o", "none.exr", "--no-ground"}).code, 0);
    EXPECT_EQ(value("none.exr", "Z", 2, 35), sky);
}

TEST_F(CliModel, a_turntable_turns_once) {
    for (const char* scene : {"wall.gltf", "contact"}) {
        ASSERT_EQ(render({scene, "-o", "t.####.exr", "--turntable", "--turntable-frames", "4", "--animation", "none",
                          "--frames", "1-5x4"})
                      .code,
                  scene == std::string("contact") ? 2 : 0);
    }
    EXPECT_EQ(read("t.0001.exr").size(), read("t.0005.exr").size());
    EXPECT_NEAR(value("t.0001.exr", "Z", 2, 35), value("t.0005.exr", "Z", 2, 35), 1e-3f);
    // Without --frames, all of one turn; dry.
    const ProgramResult dry = render({"contact", "-o", "c.####.png", "--turntable", "--turntable-frames", "7", "-n"});
    ASSERT_EQ(dry.code, 0);
    EXPECT_EQ(std::ranges::count(dry.out, '\n'), 7);
    ASSERT_EQ(render({"contact", "-o", "c.png", "--turntable", "--frames", "2"}).code, 0);
}

// A picture of a chain has its ambient light occluded, not its sunlight.
TEST_F(CliModel, occlusion_in_a_chain_darkens_the_ambient_light) {
    const std::vector<std::string> chain = {"wall.gltf",     "-o",    "x.exr",   "--turntable",
                                            "--frames",      "3",     "--apply", "ambient-occlusion,motion-blur",
                                            "--save-config", "x.toml"};
    ASSERT_EQ(render(chain).code, 0);
    EXPECT_NE(read("x.toml").find("application = \"ambient\""), std::string::npos) << read("x.toml");
    // The radius is the model's: half of the bounds' radius over the whole slide.
    EXPECT_EQ(read("x.toml").find("radius = 1.5\n"), std::string::npos) << read("x.toml");
    std::vector<std::string> by_hand = chain;
    by_hand.insert(by_hand.end(),
                   {"--set", "ambient-occlusion.application=everything", "--set", "ambient-occlusion.radius=1.5"});
    ASSERT_EQ(render(by_hand).code, 0);
    EXPECT_NE(read("x.toml").find("application = \"everything\""), std::string::npos);
    EXPECT_NE(read("x.toml").find("radius = 1.5"), std::string::npos);
}

TEST_F(CliModel, mistakes_are_told_in_a_line) {
    expect_error({"render", "wal.gltf", "-o", "x.exr"}, 3, {"wal.gltf", "no such file", "did you mean 'wall.gltf'?"});
    expect_error({"render", "nowhere/wall.glb", "-o", "x.exr"}, 3, {"nowhere/wall.glb", "no such file"});
    write("broken.glb", "glTF but not really");
    expect_error({"render", "broken.glb", "-o", "x.exr"}, 3, {"broken.glb"});
    write("notes.txt", "no model");
    expect_error({"render", "notes.txt", "-o", "x.exr"}, 3, {"notes.txt", ".glb"});
    expect_error({"render", "wall.gltf", "-o", "x.exr", "--animation", "Slyde"}, 2, {"did you mean 'Slide'?"});
    expect_error({"render", "wall.gltf", "-o", "x.exr", "--animation", "1"}, 2,
                 {"no animation is called '1'", "'Slide'"});
    expect_error({"render", "wall.gltf", "-o", "x.exr", "--camera-name", "frond"}, 2, {"did you mean 'front'?"});
    expect_error({"render", "wall.gltf", "-o", "x.exr", "--camera-name", "front", "--turntable"}, 2, {"two cameras"});
    expect_error({"render", "still", "-o", "x.exr", "--animation", "Run"}, 2, {"--animation", "built-in"});
    expect_error({"render", "stil", "-o", "x.exr"}, 2, {"did you mean 'still'?"});
    EXPECT_FALSE(exists("x.exr"));
}

} // namespace sfumato::cli_tests
