// The glTF loader on hostile files: a model that keeps all its promises or an error of one line, nothing else. What
// loads is posed as well.
#include "scene/gltf/model.h"

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <unistd.h>

namespace {

using namespace sfumato::scene;

struct Scratch {
    std::filesystem::path folder;
    Scratch() {
        const std::filesystem::path root =
            std::filesystem::exists("/dev/shm") ? "/dev/shm" : std::filesystem::temp_directory_path();
        folder = root / ("sfumato_fuzz_gltf_" + std::to_string(getpid()));
        std::filesystem::create_directory(folder);
    }
    ~Scratch() {
        std::error_code ignored;
        std::filesystem::remove_all(folder, ignored);
    }
};

void require(bool holds, const char* what) {
    if (!holds) {
        std::fprintf(stderr, "gltf: %s\n", what);
        std::abort();
    }
}

template <class T>
bool all_finite(const T& values) {
    for (const auto value : values)
        if (!std::isfinite(value))
            return false;
    return true;
}

void check_part(const Model& model, const MeshPart& part) {
    require(part.material < model.materials.size(), "a part with an unknown material");
    require(part.indices.size() % 3 == 0 && !part.indices.empty(), "a part without triangles");
    for (const uint32_t index : part.indices)
        require(index < part.vertices.size(), "an index beyond the vertices");
    for (const Vertex& vertex : part.vertices)
        require(all_finite(vertex.position) && all_finite(vertex.normal) && all_finite(vertex.tangent) &&
                    all_finite(vertex.texcoord) && all_finite(vertex.colour) && all_finite(vertex.weights),
                "a vertex that is not finite");
    for (const MorphTarget& target : part.targets)
        for (const auto* offsets : {&target.positions, &target.normals})
            require(offsets->empty() || offsets->size() == part.vertices.size(), "a morph target of another size");
}

void check_node(const Model& model, size_t index) {
    const Node& node = model.nodes[index];
    const auto within = [](uint32_t value, size_t size) { return value == none || value < size; };
    require(node.parent == none || node.parent < index, "a child before its parent");
    require(within(node.mesh, model.meshes.size()) && within(node.skin, model.skins.size()) &&
                within(node.camera, model.cameras.size()) && within(node.light, model.lights.size()),
            "a node with an unknown thing");
    if (node.skin == none)
        return;
    require(node.mesh != none, "a skin without mesh");
    for (const MeshPart& part : model.meshes[node.mesh].parts)
        for (const Vertex& vertex : part.vertices)
            for (const uint16_t joint : vertex.joints)
                require(joint < model.skins[node.skin].joints.size(), "a joint beyond the skin");
}

void check_model(const Model& model) {
    require(!model.materials.empty(), "no material");
    for (const Texture& texture : model.textures)
        require(texture.rgba.size() == size_t{texture.width} * texture.height * 4, "a texture of another size");
    for (const ModelMaterial& material : model.materials)
        for (const uint32_t texture : {material.base_colour_texture, material.metallic_roughness_texture,
                                       material.normal_texture, material.emission_texture})
            require(texture == none || texture < model.textures.size(), "an unknown texture");
    for (const ModelMesh& mesh : model.meshes)
        for (const MeshPart& part : mesh.parts)
            check_part(model, part);
    for (size_t i = 0; i < model.nodes.size(); ++i)
        check_node(model, i);
    for (const Skin& skin : model.skins) {
        require(skin.joints.size() == skin.inverse_bind.size(), "a skin with other matrices than joints");
        for (const uint32_t joint : skin.joints)
            require(joint < model.nodes.size(), "an unknown joint");
    }
    for (const Animation& animation : model.animations)
        for (const Channel& channel : animation.channels) {
            require(channel.node < model.nodes.size(), "a channel of an unknown node");
            require(channel.values.size() == channel.times.size() * channel.components *
                                                 (channel.interpolation == Interpolation::cubic ? 3 : 1),
                    "a channel with too few values");
        }
}

void pose(const Model& model) {
    for (uint32_t animation = 0; animation <= model.animations.size(); ++animation)
        for (const double seconds : {0.0, 0.37, -12.0}) {
            const uint32_t index = animation < model.animations.size() ? animation : none;
            const TriangleMesh mesh = pose_triangles(model, pose_model(model, index, seconds));
            require(mesh.indices.size() == mesh.sources.size() * 3, "triangles without source");
            require(mesh.normals.size() == mesh.positions.size(), "vertices without normal");
            for (const uint32_t vertex : mesh.indices)
                require(vertex < mesh.positions.size(), "a posed index beyond the vertices");
        }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    static const Scratch scratch;
    const std::filesystem::path path = scratch.folder / "model.glb";
    FILE* file = std::fopen(path.c_str(), "wb");
    require(file && std::fwrite(data, 1, size, file) == size, "the scratch file cannot be written");
    std::fclose(file);
    LoadLimits limits;
    limits.file_bytes = 1 << 20;
    limits.json_values = 1 << 14;
    limits.image_side = 256;
    limits.image_pixels = 1 << 16;
    limits.vertices = limits.indices = limits.key_values = 1 << 12;
    const auto model = load_model(path, limits);
    if (!model) {
        require(!model.error().message.empty() && model.error().message.find('\n') == std::string::npos,
                "an error must be one line");
        return 0;
    }
    check_model(*model);
    pose(*model);
    return 0;
}
