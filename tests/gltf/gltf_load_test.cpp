// What the glTF loader reads, feature by feature, on files that the tests write themselves.
#include "tests/gltf/gltf_builder.h"

#include <cmath>
#include <numbers>

namespace sfumato::scene {
namespace {

using test::base64;
using test::Bytes;
using test::GltfBuilder;
using test::Json;

class GltfLoad : public test::GltfTest {
  protected:
    Model load_glb(const GltfBuilder& builder) { return load(write("model.glb", builder.glb())); }
};

bool warns_of(const Model& model, const std::string& word) {
    for (const std::string& warning : model.warnings)
        if (warning.find(word) != std::string::npos)
            return true;
    return false;
}

TEST_F(GltfLoad, every_container_gives_the_same_model) {
    GltfBuilder builder;
    builder.add_square();
    write("a folder/data 1.bin", builder.binary);
    for (const auto& path : {write("model.glb", builder.glb()), write("embedded.gltf", builder.embedded()),
                             write("model.gltf", builder.gltf("a%20folder/data%201.bin"))}) {
        const Model model = load(path);
        ASSERT_EQ(model.meshes.size(), 1u);
        ASSERT_EQ(model.meshes[0].parts.size(), 1u);
        const MeshPart& part = model.meshes[0].parts[0];
        EXPECT_EQ(part.indices.size(), 6u);
        EXPECT_EQ(part.vertices[2].position, (std::array<float, 3>{1, 1, 0}));
        EXPECT_EQ(part.vertices[2].normal, (std::array<float, 3>{0, 0, 1})); // made
        EXPECT_EQ(part.material, 0u);
        EXPECT_EQ(model.materials.size(), 1u);
        EXPECT_TRUE(model.warnings.empty());
    }
    EXPECT_EQ(load(folder_ / "embedded.gltf").name, "embedded");
}

TEST_F(GltfLoad, missing_normals_are_flat_and_zero_ones_are_mended) {
    GltfBuilder builder;
    Json& square = builder.add_square();
    EXPECT_EQ(load_glb(builder).meshes[0].parts[0].vertices.size(), 6u); // no vertex is shared
    square["attributes"]["NORMAL"] = builder.accessor<float>({0, 0, 2, 0, 0, 0, 0.6f, 0, 0.8f, 0, 0, 0}, "VEC3");
    const Model model = load_glb(builder);
    const auto& vertices = model.meshes[0].parts[0].vertices;
    ASSERT_EQ(vertices.size(), 4u);
    EXPECT_EQ(vertices[0].normal, (std::array<float, 3>{0, 0, 1}));
    EXPECT_EQ(vertices[1].normal, (std::array<float, 3>{0, 0, 1}));
    EXPECT_FLOAT_EQ(vertices[2].normal[0], 0.6f);
}

TEST_F(GltfLoad, integers_are_normalised_as_the_format_says) {
    GltfBuilder builder;
    Json& square = builder.add_square();
    square["attributes"]["COLOR_0"] =
        builder.accessor<uint8_t>({255, 0, 51, 255, 0, 0, 0, 0, 1, 1, 1, 1, 255, 255, 255, 128}, "VEC4", true);
    square["attributes"]["TEXCOORD_0"] = builder.accessor<uint16_t>({0, 65535, 13107, 0, 0, 0, 0, 0}, "VEC2", true);
    square["attributes"]["NORMAL"] =
        builder.accessor<int8_t>({0, 0, 127, -128, 0, 0, 0, -127, 0, 127, 0, 0}, "VEC3", true);
    const Model model = load_glb(builder);
    const auto& vertices = model.meshes[0].parts[0].vertices;
    EXPECT_FLOAT_EQ(vertices[0].colour[2], 0.2f);
    EXPECT_FLOAT_EQ(vertices[3].colour[3], 128.0f / 255.0f);
    EXPECT_EQ(vertices[0].texcoord, (std::array<float, 2>{0, 1}));
    EXPECT_FLOAT_EQ(vertices[1].texcoord[0], 0.2f);
    EXPECT_EQ(vertices[1].normal, (std::array<float, 3>{-1, 0, 0}));
}

TEST_F(GltfLoad, strides_offsets_and_sparse_accessors) {
    GltfBuilder builder;
    Json& square = builder.add_square();
    // Positions interleaved with rubbish, 8 bytes in.
    std::vector<float> mixed = {-9, -9};
    for (const float x : {0.0f, 1.0f, 2.0f, 3.0f})
        mixed.insert(mixed.end(), {x, 10 * x, 100 * x, -9});
    const size_t view = builder.view(mixed);
    builder.root["bufferViews"][view]["byteStride"] = 16;
    const size_t values = builder.view(std::vector<float>{7, 8, 9});
    const size_t indices = builder.view(std::vector<uint8_t>{2});
    const Json sparse = {{"count", 1},
                         {"indices", {{"bufferView", indices}, {"componentType", 5121}}},
                         {"values", {{"bufferView", values}}}};
    builder.root["accessors"].push_back({{"bufferView", view},
                                         {"byteOffset", 8},
                                         {"componentType", 5126},
                                         {"count", 4},
                                         {"type", "VEC3"},
                                         {"sparse", sparse}});
    square["attributes"]["POSITION"] = builder.root["accessors"].size() - 1;
    square.erase("indices");
    const Model model = load_glb(builder); // 4 vertices without indices: one triangle
    const auto& vertices = model.meshes[0].parts[0].vertices;
    ASSERT_EQ(vertices.size(), 3u);
    EXPECT_EQ(vertices[1].position, (std::array<float, 3>{1, 10, 100}));
    EXPECT_EQ(vertices[2].position, (std::array<float, 3>{7, 8, 9}));
    // Without a view the rest is zero.
    builder.root["accessors"].back().erase("bufferView");
    const Model zeros = load_glb(builder);
    EXPECT_EQ(zeros.meshes[0].parts[0].vertices[1].position, (std::array<float, 3>{}));
    EXPECT_EQ(zeros.meshes[0].parts[0].vertices[2].position, (std::array<float, 3>{7, 8, 9}));
}

TEST_F(GltfLoad, strips_fans_points_and_lines) {
    GltfBuilder builder;
    Json& square = builder.add_square();
    square["attributes"]["NORMAL"] = builder.accessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
    square["indices"] = builder.accessor<uint32_t>({0, 1, 3, 2}, "SCALAR");
    square["mode"] = 5;
    EXPECT_EQ(load_glb(builder).meshes[0].parts[0].indices, (std::vector<uint32_t>{0, 1, 3, 3, 1, 2}));
    square["mode"] = 6;
    EXPECT_EQ(load_glb(builder).meshes[0].parts[0].indices, (std::vector<uint32_t>{0, 1, 3, 0, 3, 2}));
    builder.add_square()["mode"] = 1;
    const Model model = load_glb(builder);
    EXPECT_TRUE(model.meshes[1].parts.empty());
    EXPECT_TRUE(warns_of(model, "lines"));
}

TEST_F(GltfLoad, materials_and_textures) {
    GltfBuilder builder;
    Json& square = builder.add_square();
    square["material"] = 0;
    square["attributes"]["TEXCOORD_1"] = builder.accessor<float>({0, 0, 1, 0, 1, 1, 0, 1}, "VEC2");
    const Json mapping = {
        {"KHR_texture_transform", {{"offset", {0.5, 0.25}}, {"scale", {2, 3}}, {"rotation", std::numbers::pi / 2}}}};
    const Json slot = {{"index", 0}, {"texCoord", 1}, {"extensions", mapping}};
    builder.root["materials"] = {
        {{"name", "glass"},
         {"pbrMetallicRoughness",
          {{"baseColorFactor", {0.5, 0.25, 1, 0.75}}, {"roughnessFactor", 0.3}, {"baseColorTexture", slot}}},
         {"emissiveFactor", {1, 0.5, 0}},
         {"emissiveTexture", {{"index", 1}}},
         {"normalTexture", slot},
         {"alphaMode", "MASK"},
         {"alphaCutoff", 0.7},
         {"doubleSided", true},
         {"extensions",
          {{"KHR_materials_emissive_strength", {{"emissiveStrength", 4}}}, {"KHR_materials_unlit", Json::object()}}}}};
    builder.root["materials"][0]["normalTexture"]["scale"] = 0.5;
    builder.root["textures"] = {{{"source", 0}, {"sampler", 0}}, {{"source", 1}}};
    builder.root["samplers"] = {{{"magFilter", 9728}, {"wrapS", 33071}}};
    builder.root["images"] = {{{"bufferView", builder.view(test::png())}, {"mimeType", "image/png"}},
                              {{"uri", "picture.png"}}};
    write("picture.png", test::png());
    const Model model = load_glb(builder);
    ASSERT_EQ(model.materials.size(), 1u);
    const ModelMaterial& material = model.materials[0];
    EXPECT_EQ(material.name, "glass");
    EXPECT_EQ(material.base_colour, (std::array<float, 4>{0.5f, 0.25f, 1, 0.75f}));
    EXPECT_EQ(material.emission, (std::array<float, 3>{4, 2, 0}));
    EXPECT_FLOAT_EQ(material.roughness, 0.3f);
    EXPECT_FLOAT_EQ(material.alpha_cutoff, 0.7f);
    EXPECT_FLOAT_EQ(material.normal_scale, 0.5f);
    EXPECT_EQ(material.alpha_mode, AlphaMode::mask);
    EXPECT_TRUE(material.double_sided && material.unlit);
    // The emission is mapped unlike the others.
    EXPECT_EQ(material.emission_texture, none);
    EXPECT_TRUE(warns_of(model, "mapped"));
    ASSERT_EQ(model.textures.size(), 2u); // one image as colour and as data
    const Texture& colour = model.textures[material.base_colour_texture];
    EXPECT_TRUE(colour.is_srgb && colour.is_nearest && !colour.repeats_u && colour.repeats_v);
    EXPECT_FALSE(model.textures[material.normal_texture].is_srgb);
    EXPECT_EQ(colour.rgba, (std::vector<uint8_t>{255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 128}));
    // offset + rotation · scale · (1, 0): counter-clockwise with v downwards.
    const Vertex& vertex = model.meshes[0].parts[0].vertices[1];
    EXPECT_NEAR(vertex.texcoord[0], 0.5, 1e-6);
    EXPECT_NEAR(vertex.texcoord[1], 0.25 - 2.0, 1e-6);
}

TEST_F(GltfLoad, tangents_are_made_where_a_normal_texture_needs_them) {
    GltfBuilder builder;
    Json& square = builder.add_square();
    square["attributes"]["NORMAL"] = builder.accessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
    square["attributes"]["TEXCOORD_0"] = builder.accessor<float>({0, 1, 1, 1, 1, 0, 0, 0}, "VEC2");
    EXPECT_EQ(load_glb(builder).meshes[0].parts[0].vertices[0].tangent, (std::array<float, 4>{}));
    square["material"] = 0;
    builder.root["materials"] = {{{"normalTexture", {{"index", 0}}}}};
    builder.root["textures"] = {{{"source", 0}}};
    builder.root["images"] = {{{"bufferView", builder.view(test::png())}}};
    // u to the right, v down: the bitangent cross(n, t) · w is upwards.
    EXPECT_EQ(load_glb(builder).meshes[0].parts[0].vertices[0].tangent, (std::array<float, 4>{1, 0, 0, 1}));
    square["attributes"]["TEXCOORD_0"] = builder.accessor<float>({1, 1, 0, 1, 0, 0, 1, 0}, "VEC2"); // mirrored
    EXPECT_EQ(load_glb(builder).meshes[0].parts[0].vertices[0].tangent, (std::array<float, 4>{-1, 0, 0, -1}));
}

TEST_F(GltfLoad, the_tree_has_parents_first_and_shows_one_scene) {
    GltfBuilder builder;
    builder.add_square();
    builder.root["nodes"] = {{{"name", "leaf"}, {"mesh", 0}},
                             {{"name", "branch"}, {"children", {0}}, {"scale", {2, 2, 2}}},
                             {{"name", "root"}, {"children", {1}}},
                             {{"name", "hidden"}, {"mesh", 0}}};
    builder.root["scenes"] = {{{"nodes", {3}}}, {{"nodes", {2}}}};
    builder.root["scene"] = 1;
    const Model model = load_glb(builder);
    ASSERT_EQ(model.nodes.size(), 4u);
    for (size_t i = 0; i < 4; ++i)
        EXPECT_TRUE(model.nodes[i].parent == none || model.nodes[i].parent < i);
    size_t shown = 0;
    for (const Node& node : model.nodes)
        if (node.mesh != none) {
            ++shown;
            EXPECT_EQ(node.name, "leaf");
            EXPECT_EQ(model.nodes[node.parent].name, "branch");
        }
    EXPECT_EQ(shown, 1u);
    EXPECT_TRUE(warns_of(model, "default"));
}

TEST_F(GltfLoad, cameras_and_lights) {
    GltfBuilder builder;
    builder.add_square();
    builder.root["cameras"] = {
        {{"name", "eye"}, {"type", "perspective"}, {"perspective", {{"yfov", std::numbers::pi / 3}, {"znear", 0.1}}}},
        {{"type", "orthographic"}, {"orthographic", {{"xmag", 2}, {"ymag", 1.5}, {"znear", 0}, {"zfar", 50}}}}};
    builder.root["extensionsUsed"] = {"KHR_lights_punctual"};
    builder.root["extensions"]["KHR_lights_punctual"]["lights"] = {
        {{"type", "directional"}, {"intensity", 3}},
        {{"type", "spot"}, {"color", {1, 0.5, 0}}, {"range", 8}, {"spot", {{"innerConeAngle", 0.2}}}}};
    builder.root["nodes"].push_back({{"camera", 1}, {"extensions", {{"KHR_lights_punctual", {{"light", 1}}}}}});
    const Model model = load_glb(builder);
    ASSERT_EQ(model.cameras.size(), 2u);
    EXPECT_EQ(model.cameras[0].name, "eye");
    EXPECT_NEAR(model.cameras[0].view_angle, 60.0, 1e-9);
    EXPECT_EQ(model.cameras[0].orthographic_height, 0.0);
    EXPECT_GT(model.cameras[0].far_plane, 10.0);
    EXPECT_EQ(model.cameras[1].orthographic_height, 3.0);
    ASSERT_EQ(model.lights.size(), 2u);
    EXPECT_EQ(model.lights[0].kind, LightKind::directional);
    EXPECT_EQ(model.lights[0].intensity, 3.0f);
    EXPECT_EQ(model.lights[1].kind, LightKind::spot);
    EXPECT_EQ(model.lights[1].colour, (std::array<float, 3>{1, 0.5f, 0}));
    EXPECT_FLOAT_EQ(model.lights[1].inner_cone, 0.2f);
    EXPECT_FLOAT_EQ(model.lights[1].outer_cone, 0.785398f);
    EXPECT_EQ(model.nodes[1].camera, 1u);
    EXPECT_EQ(model.nodes[1].light, 1u);
    EXPECT_TRUE(model.warnings.empty());
}

TEST_F(GltfLoad, weights_of_joints_sum_to_one) {
    GltfBuilder builder;
    Json& square = builder.add_square();
    square["attributes"]["JOINTS_0"] =
        builder.accessor<uint8_t>({0, 1, 9, 9, 1, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0}, "VEC4");
    square["attributes"]["WEIGHTS_0"] =
        builder.accessor<float>({0.5f, 1.5f, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 2, -1, 0, 0}, "VEC4");
    square["attributes"]["NORMAL"] = builder.accessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
    builder.root["nodes"][0]["skin"] = 0;
    builder.root["nodes"].push_back(Json::object());
    builder.root["skins"] = {{{"joints", {0, 1}}}};
    const Model model = load_glb(builder);
    const auto& vertices = model.meshes[0].parts[0].vertices;
    EXPECT_EQ(vertices[0].weights, (std::array<float, 4>{0.25f, 0.75f, 0, 0}));
    EXPECT_EQ(vertices[0].joints, (std::array<uint16_t, 4>{0, 1, 0, 0})); // 9 without weight does not matter
    EXPECT_EQ(vertices[2].weights, (std::array<float, 4>{1, 0, 0, 0}));   // no weight at all
    EXPECT_EQ(vertices[3].weights, (std::array<float, 4>{1, 0, 0, 0}));
    EXPECT_EQ(model.skins[0].inverse_bind.size(), 2u); // made
    square["attributes"].erase("JOINTS_0");
    const Model plain = load_glb(builder);
    EXPECT_EQ(plain.nodes[0].skin, none);
    EXPECT_TRUE(warns_of(plain, "skin"));
}

TEST_F(GltfLoad, optional_extensions_are_warned_of_and_required_ones_refused) {
    GltfBuilder builder;
    builder.add_square();
    builder.root["extensionsUsed"] = {"KHR_materials_clearcoat", "KHR_mesh_quantization"};
    builder.root["extensionsRequired"] = {"KHR_mesh_quantization"};
    const Model model = load_glb(builder);
    EXPECT_TRUE(warns_of(model, "KHR_materials_clearcoat"));
    EXPECT_FALSE(warns_of(model, "KHR_mesh_quantization"));
    for (const char* name :
         {"KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_texture_basisu", "ABC_new"}) {
        builder.root["extensionsRequired"] = {name};
        const std::string message = refusal(write("model.glb", builder.glb()));
        EXPECT_NE(message.find(name), std::string::npos) << message;
        EXPECT_NE(message.find("; "), std::string::npos) << message; // what to do
    }
}

TEST_F(GltfLoad, the_flight_helmet) {
    const auto path = test::sample_model("FlightHelmet/FlightHelmet.gltf");
    if (path.empty())
        GTEST_SKIP() << "there is no ../shared/data/gltf/FlightHelmet beside this checkout";
    const Model model = load(path);
    EXPECT_EQ(model.meshes.size(), 6u);
    EXPECT_EQ(model.materials.size(), 6u);
    EXPECT_EQ(model.textures.size(), 15u);
    size_t triangles = 0;
    for (const ModelMesh& mesh : model.meshes)
        for (const MeshPart& part : mesh.parts)
            triangles += part.indices.size() / 3;
    EXPECT_EQ(triangles, 94722u);
}

TEST_F(GltfLoad, the_fox) {
    const auto path = test::sample_model("Fox.glb");
    if (path.empty())
        GTEST_SKIP() << "there is no ../shared/data/gltf/Fox.glb beside this checkout";
    const Model model = load(path);
    ASSERT_EQ(model.skins.size(), 1u);
    EXPECT_EQ(model.skins[0].joints.size(), 24u);
    ASSERT_EQ(model.animations.size(), 3u);
    EXPECT_EQ(model.animations[2].name, "Run");
    EXPECT_NEAR(model.animations[2].duration, 1.158, 0.001);
    EXPECT_TRUE(model.warnings.empty());
}

} // namespace
} // namespace sfumato::scene
