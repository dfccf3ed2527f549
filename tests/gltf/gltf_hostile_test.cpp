// Broken and hostile glTF files: an error of one line that names what is wrong, never a crash.
#include "tests/gltf/gltf_builder.h"

#include <functional>
#include <random>

namespace sfumato::scene {
namespace {

using test::Bytes;
using test::GltfBuilder;
using test::Json;

class GltfHostile : public test::GltfTest {
  protected:
    std::string refusal_of(const GltfBuilder& builder, const LoadLimits& limits = {}) {
        return refusal(write("model.glb", builder.glb()), limits);
    }
    void expect_refusal(const GltfBuilder& builder, const std::string& word) {
        const std::string message = refusal_of(builder);
        EXPECT_NE(message.find(word), std::string::npos) << "'" << message << "' does not say " << word;
    }
};

// With all that has indices and sizes in it.
GltfBuilder rich_model() {
    GltfBuilder builder;
    Json square = builder.add_square();
    square["attributes"]["NORMAL"] = builder.accessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
    square["attributes"]["TEXCOORD_0"] = builder.accessor<float>({0, 1, 1, 1, 1, 0, 0, 0}, "VEC2");
    square["attributes"]["JOINTS_0"] =
        builder.accessor<uint8_t>({0, 1, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0}, "VEC4");
    square["attributes"]["WEIGHTS_0"] =
        builder.accessor<float>({0.5f, 0.5f, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4");
    square["targets"] = {{{"POSITION", builder.accessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3")}}};
    square["material"] = 0;
    builder.root["meshes"][0]["primitives"][0] = square;
    builder.root["meshes"][0]["weights"] = {0.5};
    builder.root["nodes"] = {{{"mesh", 0}, {"skin", 0}},
                             {{"children", {2}}, {"rotation", {0, 0, 0, 1}}},
                             {{"translation", {0, 1, 0}}, {"camera", 0}}};
    builder.root["scenes"] = {{{"nodes", {0, 1}}}};
    builder.root["scene"] = 0;
    const std::vector<float> one = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    std::vector<float> two = one;
    two.insert(two.end(), one.begin(), one.end());
    builder.root["skins"] = {{{"joints", {1, 2}}, {"inverseBindMatrices", builder.accessor<float>(two, "MAT4")}}};
    const size_t times = builder.accessor<float>({0, 1}, "SCALAR");
    builder.root["animations"] = {
        {{"samplers",
          {{{"input", times}, {"output", builder.accessor<float>({0, 0, 0, 1, 1, 1}, "VEC3")}},
           {{"input", times}, {"output", builder.accessor<float>({0, 1}, "SCALAR")}, {"interpolation", "STEP"}}}},
         {"channels",
          {{{"sampler", 0}, {"target", {{"node", 2}, {"path", "translation"}}}},
           {{"sampler", 1}, {"target", {{"node", 0}, {"path", "weights"}}}}}}}};
    builder.root["materials"] = {{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}};
    builder.root["textures"] = {{{"source", 0}, {"sampler", 0}}};
    builder.root["samplers"] = {{{"wrapS", 33071}}};
    builder.root["images"] = {{{"bufferView", builder.view(test::png())}}};
    builder.root["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.8}, {"znear", 0.1}}}}};
    return builder;
}

TEST_F(GltfHostile, what_is_no_gltf_at_all) {
    EXPECT_NE(refusal(folder_ / "absent.glb").find("does not exist"), std::string::npos);
    EXPECT_NE(refusal(folder_).find("regular file"), std::string::npos);
    EXPECT_NE(refusal(write("empty.glb", Bytes{})).find("empty"), std::string::npos);
    for (const std::string text :
         {"{}", "[]", "1", "{", "hello\nworld", "glTF", "glTF\1\2\3", "{\"asset\":{}}", "\xff\xfe",
          "{\"asset\":{\"version\":\"1.0\"}}", "{\"asset\":{\"version\":\"2.0\"}}"})
        EXPECT_NE(refusal(write("model.gltf", text)), "") << text;
    EXPECT_NE(refusal(write("model.gltf", std::string("{\"asset\":{\"version\":\"1.0\"}}"))).find("1.0"),
              std::string::npos);
    EXPECT_NE(refusal(write("deep.gltf", std::string(1 << 20, '['))).find("nests"), std::string::npos);
    EXPECT_NE(refusal(write("wide.gltf", "[" + std::string(5 << 20, ','))).find("values"), std::string::npos);
}

TEST_F(GltfHostile, every_index_is_checked) {
    const GltfBuilder good = rich_model();
    ASSERT_EQ(refusal_of(good), "");
    for (const char* pointer : {"/bufferViews/0/buffer",
                                "/accessors/0/bufferView",
                                "/images/0/bufferView",
                                "/textures/0/source",
                                "/textures/0/sampler",
                                "/materials/0/pbrMetallicRoughness/baseColorTexture/index",
                                "/meshes/0/primitives/0/material",
                                "/meshes/0/primitives/0/indices",
                                "/meshes/0/primitives/0/attributes/NORMAL",
                                "/meshes/0/primitives/0/targets/0/POSITION",
                                "/nodes/0/mesh",
                                "/nodes/0/skin",
                                "/nodes/1/children/0",
                                "/nodes/2/camera",
                                "/scenes/0/nodes/0",
                                "/scene",
                                "/skins/0/joints/0",
                                "/skins/0/inverseBindMatrices",
                                "/animations/0/channels/0/sampler",
                                "/animations/0/channels/0/target/node",
                                "/animations/0/samplers/0/input",
                                "/animations/0/samplers/0/output"})
        for (const Json& value : {Json(1000), Json(-1), Json(0.5), Json(4294967296), Json(1e300), Json("0"), Json(),
                                  Json::array(), Json::object()}) {
            GltfBuilder builder = good;
            ASSERT_TRUE(builder.root.contains(Json::json_pointer(pointer))) << pointer;
            builder.root[Json::json_pointer(pointer)] = value;
            EXPECT_NE(refusal_of(builder), "") << pointer << " " << value.dump();
        }
}

TEST_F(GltfHostile, every_size_is_checked) {
    const GltfBuilder good = rich_model();
    for (const char* pointer : {"/bufferViews/0/byteLength", "/bufferViews/0/byteOffset", "/accessors/0/count",
                                "/accessors/0/byteOffset", "/bufferViews/0/byteStride"})
        for (const Json& value : {Json(2147483647), Json(4294967295), Json(18446744073709551615u), Json(-4), Json(1e99),
                                  Json("12"), Json(1.5)}) {
            GltfBuilder builder = good;
            builder.root[Json::json_pointer(pointer)] = value;
            EXPECT_NE(refusal_of(builder), "") << pointer << " " << value.dump();
        }
    GltfBuilder builder = good; // a stride smaller than the elements
    builder.root["bufferViews"][0]["byteStride"] = 4;
    EXPECT_NE(refusal_of(builder), "");
    builder = good;
    builder.binary.resize(40);
    expect_refusal(builder, "bufferViews[0]");
}

TEST_F(GltfHostile, wrong_contents_are_named) {
    const GltfBuilder good = rich_model();
    const auto changed = [&](const std::function<void(GltfBuilder&)>& change, const char* word) {
        GltfBuilder builder = good;
        change(builder);
        expect_refusal(builder, word);
    };
    const auto attribute = [](GltfBuilder& b, const char* name) -> Json& {
        return b.root["meshes"][0]["primitives"][0]["attributes"][name];
    };
    changed(
        [&](auto& b) {
            b.root["meshes"][0]["primitives"][0]["indices"] = b.template accessor<uint16_t>({0, 1, 4}, "SCALAR");
        },
        "the index 4");
    changed(
        [&](auto& b) { attribute(b, "JOINTS_0") = b.template accessor<uint8_t>(std::vector<uint8_t>(16, 2), "VEC4"); },
        "joint 2");
    changed(
        [&](auto& b) {
            attribute(b, "NORMAL") = b.template accessor<float>({0, 0, 1}, "VEC3");
        },
        "positions have 4");
    for (const float bad : {std::nanf(""), INFINITY, 1e30f})
        for (const char* name : {"POSITION", "NORMAL"})
            changed(
                [&](auto& b) {
                    attribute(b, name) = b.template accessor<float>({0, 0, 1, 0, bad, 0, 1, 0, 0, 0, 1, 0}, "VEC3");
                },
                "element 1");
    changed([&](auto& b) { attribute(b, "POSITION") = attribute(b, "TEXCOORD_0"); }, "wrong type");
    changed([&](auto& b) { b.root["nodes"][2]["children"] = {1}; }, "ancestor");
    changed([&](auto& b) { b.root["nodes"][0]["children"] = {2}; }, "two parents");
    changed([&](auto& b) { b.root["nodes"][1]["children"] = {2, 2}; }, "two parents");
    changed([&](auto& b) { b.root["nodes"][1]["children"] = {1}; }, "ancestor");
    changed([&](auto& b) { b.root["nodes"][1]["rotation"] = {0, 0, 1}; }, "4 numbers");
    changed([&](auto& b) { b.root["nodes"][1]["translation"] = {0, 0, 1e200}; }, "3 numbers");
    changed([&](auto& b) { b.root["skins"][0]["joints"] = {1, 2, 0}; }, "2 matrices for 3");
    changed(
        [&](auto& b) {
            b.root["animations"][0]["samplers"][0]["input"] = b.template accessor<float>({1, 0}, "SCALAR");
        },
        "ascend");
    changed(
        [&](auto& b) {
            b.root["animations"][0]["samplers"][0]["output"] = b.template accessor<float>({0, 0, 0}, "VEC3");
        },
        "need 6");
    changed([&](auto& b) { b.root["animations"][0]["samplers"][0]["interpolation"] = "WIGGLY"; }, "WIGGLY");
    changed([&](auto& b) { b.root["meshes"][0]["weights"] = {1, 2}; }, "2 weights");
    changed([&](auto& b) { b.root["cameras"][0]["perspective"]["yfov"] = 4; }, "view angle");
    changed([&](auto& b) { b.root["materials"][0]["alphaMode"] = "GHOST"; }, "GHOST");
    changed([&](auto& b) { b.root["images"][0]["bufferView"] = 0; }, "neither PNG nor JPEG");
    changed([&](auto& b) { b.root["scenes"][0]["nodes"] = {1}; }, "no triangles");
    changed([&](auto& b) { b.root["nodes"] = "none\nat all"; }, "nodes");
}

TEST_F(GltfHostile, only_files_in_the_folder_are_read) {
    GltfBuilder builder;
    builder.add_square();
    write("outside.bin", builder.binary);
    write("inside/data.bin", builder.binary);
    std::filesystem::create_symlink(folder_ / "outside.bin", folder_ / "inside/link.bin");
    const auto message = [&](const std::string& uri) { return refusal(write("inside/model.gltf", builder.gltf(uri))); };
    EXPECT_EQ(message("data.bin"), "");
    EXPECT_EQ(message("./deeper/../data.bin"), "");
    for (const std::string& uri :
         {std::string("../outside.bin"), std::string("%2e%2e/outside.bin"), std::string("x/../../outside.bin"),
          (folder_ / "outside.bin").string(), std::string("link.bin"), std::string("..")})
        EXPECT_NE(message(uri).find("outside of the model's folder"), std::string::npos) << uri << ": " << message(uri);
    EXPECT_NE(message("https://example.com/data.bin").find("elsewhere"), std::string::npos);
    EXPECT_NE(message("file:///etc/hostname").find("elsewhere"), std::string::npos);
    EXPECT_NE(message("missing.bin").find("missing.bin"), std::string::npos);
    EXPECT_NE(message("data.bin%00"), "");
    EXPECT_NE(message(""), "");
    EXPECT_NE(message("."), "");
    EXPECT_NE(message("data:application/octet-stream;base64,!!!!").find("base64"), std::string::npos);
    EXPECT_NE(message("data:application/octet-stream,abc").find("base64"), std::string::npos);
    EXPECT_NE(message("data:application/octet-stream;base64,AAAA"), ""); // too short
}

TEST_F(GltfHostile, limits_hold_before_anything_is_allocated) {
    GltfBuilder builder = rich_model();
    const auto limited = [&](auto set) {
        LoadLimits limits;
        set(limits);
        return refusal_of(builder, limits);
    };
    EXPECT_NE(limited([](LoadLimits& l) { l.file_bytes = 100; }).find("bytes"), std::string::npos);
    EXPECT_NE(limited([](LoadLimits& l) { l.json_values = 20; }).find("values"), std::string::npos);
    EXPECT_NE(limited([](LoadLimits& l) { l.image_side = 1; }).find("pixels"), std::string::npos);
    EXPECT_NE(limited([](LoadLimits& l) { l.image_pixels = 3; }).find("too large"), std::string::npos);
    EXPECT_NE(limited([](LoadLimits& l) { l.vertices = 3; }).find("too large"), std::string::npos);
    EXPECT_NE(limited([](LoadLimits& l) { l.indices = 5; }).find("too large"), std::string::npos);
    EXPECT_NE(limited([](LoadLimits& l) { l.key_values = 3; }).find("too large"), std::string::npos);
    // Two billion zeros that no byte stands for.
    builder.root["accessors"].push_back({{"componentType", 5126}, {"count", 2147483647}, {"type", "VEC3"}});
    builder.root["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = builder.root["accessors"].size() - 1;
    expect_refusal(builder, "too large");
    // One mesh at ever so many nodes.
    GltfBuilder many;
    many.add_square();
    for (int i = 0; i < 1000; ++i)
        many.root["nodes"].push_back({{"mesh", 0}});
    LoadLimits limits;
    limits.indices = 6000;
    EXPECT_NE(refusal_of(many, limits).find("many nodes"), std::string::npos);
}

// A PNG whose header promises much more than there is.
TEST_F(GltfHostile, images_that_lie_about_their_size) {
    GltfBuilder builder;
    builder.add_square()["material"] = 0;
    builder.root["materials"] = {{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}};
    builder.root["textures"] = {{{"source", 0}}};
    Bytes image = test::png();
    image[18] = 0xff; // the width becomes 65282
    builder.root["images"] = {{{"bufferView", builder.view(image)}}};
    expect_refusal(builder, "images[0]");
    image[18] = 0;
    image.resize(image.size() - 30);
    builder.root["images"] = {{{"bufferView", builder.view(image)}}};
    const std::string message = refusal_of(builder);
    EXPECT_TRUE(message.empty() || message.find("images[0]") != std::string::npos) << message;
}

void mutate(Bytes& bytes, std::mt19937& random, size_t from, size_t to) {
    for (uint32_t i = 0, count = 1 + random() % 4; i < count; ++i) {
        uint8_t& byte = bytes[from + random() % (to - from)];
        byte = random() % 3 == 0 ? static_cast<uint8_t>(random()) : static_cast<uint8_t>(byte ^ (1u << random() % 8));
    }
}

TEST_F(GltfHostile, truncated_and_flipped_small_files) {
    const Bytes good = rich_model().glb();
    for (size_t size = 0; size < good.size(); size += size < 100 ? 1 : 37)
        EXPECT_NE(refusal(write("model.glb", Bytes(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size)))),
                  "")
            << size;
    std::mt19937 random(7);
    size_t loaded = 0;
    for (int i = 0; i < 1500; ++i) {
        Bytes bytes = good;
        mutate(bytes, random, 0, bytes.size());
        const auto model = load_model(write("model.glb", bytes));
        loaded += static_cast<bool>(model);
        if (model)
            pose_triangles(*model, pose_model(*model, 0, 0.4));
        else
            EXPECT_EQ(model.error().message.find('\n'), std::string::npos);
    }
    EXPECT_GT(loaded, 100u); // many changes do no harm
    EXPECT_LT(loaded, 1400u);
}

TEST_F(GltfHostile, truncated_and_flipped_fox) {
    const auto path = test::sample_model("Fox.glb");
    if (path.empty())
        GTEST_SKIP() << "there is no ../shared/data/gltf/Fox.glb beside this checkout";
    const Bytes good = test::read_file(path);
    for (size_t i = 0; i < 40; ++i)
        EXPECT_NE(refusal(write("fox.glb",
                                Bytes(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(i * good.size() / 40)))),
                  "");
    std::mt19937 random(11);
    const size_t json_end = 20 + (good[12] | size_t{good[13]} << 8 | size_t{good[14]} << 16);
    for (int i = 0; i < 120; ++i) {
        Bytes bytes = good;
        if (i % 2 == 0) // half of them in the JSON
            mutate(bytes, random, 0, json_end);
        else
            mutate(bytes, random, json_end, bytes.size());
        const auto model = load_model(write("fox.glb", bytes));
        if (model)
            pose_triangles(*model, pose_model(*model, 2, 0.4));
        else
            EXPECT_EQ(model.error().message.find('\n'), std::string::npos);
    }
}

} // namespace
} // namespace sfumato::scene
