// Loads a glTF 2.0 file, see the specification of the Khronos Group. The JSON is checked before tinygltf reads it, and
// bytes are looked at only within bounds that were checked: a broken or hostile file is an error, never a crash.
#include "scene/gltf/load_parts.h"

#include <algorithm>
#include <new>

namespace sfumato::scene {
namespace gltf {

void Loader::warn(const std::string& sentence) {
    if (std::ranges::find(model.warnings, sentence) == model.warnings.end())
        model.warnings.push_back(sentence);
}

void take(uint64_t& left, uint64_t count, uint64_t factor, const std::string& what) {
    require(factor == 0 || count <= left / factor, what + " makes the model too large");
    left -= count * factor;
}

namespace {

// One line without control characters, whatever a library or the file put into it.
std::string one_line(std::string text) {
    for (char& c : text)
        if (static_cast<unsigned char>(c) < 32)
            c = ' ';
    while (text.ends_with(' '))
        text.pop_back();
    return text;
}

void read_buffers(Loader& loader, std::span<const uint8_t> binary) {
    for (size_t i = 0; i < loader.document.buffer_sources.size(); ++i) {
        const BufferSource& source = loader.document.buffer_sources[i];
        const std::string what = place("buffers", i);
        Bytes bytes = source.is_embedded ? Bytes(binary.begin(), binary.end()) : loader.files.read(source.uri, what);
        require(bytes.size() >= source.size, what + " has " + std::to_string(bytes.size()) + " bytes; the model says " +
                                                 std::to_string(source.size));
        loader.buffers.push_back(std::move(bytes));
    }
    loader.image_bytes.resize(loader.document.images.size());
}

// Meshes that many nodes show count as often.
void check_instances(const Loader& loader) {
    uint64_t indices = loader.limits.indices, vertices = 4 * loader.limits.vertices, weights = loader.limits.key_values,
             triangles = 0;
    for (size_t i = 0; i < loader.model.nodes.size(); ++i) {
        if (loader.model.nodes[i].mesh == none)
            continue;
        const ModelMesh& mesh = loader.model.meshes[loader.model.nodes[i].mesh];
        take(weights, mesh.weights.size(), 1, "showing morphed meshes at many nodes");
        for (const MeshPart& part : mesh.parts) {
            take(indices, part.indices.size(), 1, "showing meshes at many nodes");
            take(vertices, part.vertices.size(), 1, "showing meshes at many nodes");
            triangles += part.indices.size() / 3;
        }
    }
    require(triangles > 0, "the model's scene shows no triangles");
}

Model load(const std::filesystem::path& path, const LoadLimits& limits) {
    Loader loader{.files = Files(path, limits.file_bytes), .limits = limits, .document = {}, .model = {}};
    loader.pixels_left = limits.image_pixels;
    loader.vertices_left = limits.vertices;
    loader.target_vertices_left = limits.vertices;
    loader.indices_left = limits.indices;
    loader.key_values_left = limits.key_values;
    const Container container = open_container(loader.files.main());
    loader.document = parse_document(container.json, limits);
    loader.model.name = path.stem().string();
    for (const std::string& warning : loader.document.warnings)
        loader.warn(warning);
    read_buffers(loader, container.binary);
    load_materials(loader);
    load_meshes(loader);
    load_cameras_and_lights(loader);
    load_nodes(loader);
    load_skins(loader);
    load_animations(loader);
    check_instances(loader);
    for (std::string& warning : loader.model.warnings)
        warning = one_line(std::move(warning));
    return std::move(loader.model);
}

} // namespace
} // namespace gltf

Result<Model> load_model(const std::filesystem::path& path, const LoadLimits& limits) {
    const auto error = [&](const std::string& message) {
        return Error{ErrorCode::input, gltf::one_line(path.string() + ": " + message)};
    };
    try {
        return gltf::load(path, limits);
    } catch (const std::bad_alloc&) {
        return Error{ErrorCode::out_of_memory, gltf::one_line(path.string() + ": not enough memory for the model")};
    } catch (const std::exception& failure) {
        return error(failure.what());
    } catch (...) {
        return error("cannot be read");
    }
}

} // namespace sfumato::scene
