// Meshes: vertices with all that belongs to them, triangles, morph targets.
#include "scene/gltf/load_parts.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace sfumato::scene::gltf {
namespace {

using Attributes = std::map<std::string, int>;

int find_attribute(const Attributes& attributes, const std::string& name) {
    const auto found = attributes.find(name);
    return found == attributes.end() ? -1 : found->second;
}

// All attributes of a primitive have as many elements as it has vertices.
Floats read_attribute(const Loader& loader, int accessor, std::initializer_list<int> types, size_t vertices) {
    require(accessor_count(loader, accessor) == vertices, place("accessors", static_cast<size_t>(accessor)) + " has " +
                                                              std::to_string(accessor_count(loader, accessor)) +
                                                              " elements; the positions have " +
                                                              std::to_string(vertices));
    return read_floats(loader, accessor, types, vertices);
}

void read_joints(const Loader& loader, const Attributes& attributes, MeshPart& part) {
    const int joints = find_attribute(attributes, "JOINTS_0"), weights = find_attribute(attributes, "WEIGHTS_0");
    if (joints < 0 || weights < 0)
        return;
    require(accessor_count(loader, joints) == part.vertices.size(),
            place("accessors", static_cast<size_t>(joints)) + " has another size than the positions");
    const auto indices = read_integers(loader, joints, TINYGLTF_TYPE_VEC4, part.vertices.size());
    const Floats shares = read_attribute(loader, weights, {TINYGLTF_TYPE_VEC4}, part.vertices.size());
    for (size_t i = 0; i < part.vertices.size(); ++i) {
        Vertex& vertex = part.vertices[i];
        double sum = 0.0;
        for (size_t k = 0; k < 4; ++k)
            sum += std::max(static_cast<double>(shares.at(i)[k]), 0.0);
        for (size_t k = 0; k < 4; ++k) {
            const double weight = std::max(static_cast<double>(shares.at(i)[k]), 0.0);
            vertex.weights[k] = sum > 0.0 ? static_cast<float>(weight / sum) : k == 0 ? 1.0f : 0.0f;
            if (vertex.weights[k] == 0.0f)
                continue; // its joint does not matter
            if (indices[i * 4 + k] > 0xffff)
                fail("a vertex names the joint " + std::to_string(indices[i * 4 + k]));
            vertex.joints[k] = static_cast<uint16_t>(indices[i * 4 + k]);
        }
    }
}

void read_texcoords(const Loader& loader, const Attributes& attributes, const TextureMapping& mapping, MeshPart& part) {
    const int accessor = find_attribute(attributes, "TEXCOORD_" + std::to_string(mapping.set));
    if (accessor < 0)
        return;
    const Floats values = read_attribute(loader, accessor, {TINYGLTF_TYPE_VEC2}, part.vertices.size());
    const auto& m = mapping.transform;
    for (size_t i = 0; i < part.vertices.size(); ++i) {
        const double u = static_cast<double>(values.at(i)[0]), v = static_cast<double>(values.at(i)[1]);
        part.vertices[i].texcoord = {static_cast<float>(m[0] * u + m[1] * v + m[2]),
                                     static_cast<float>(m[3] * u + m[4] * v + m[5])};
    }
}

void read_colours(const Loader& loader, const Attributes& attributes, MeshPart& part) {
    const int accessor = find_attribute(attributes, "COLOR_0");
    if (accessor < 0)
        return;
    const Floats values =
        read_attribute(loader, accessor, {TINYGLTF_TYPE_VEC3, TINYGLTF_TYPE_VEC4}, part.vertices.size());
    for (size_t i = 0; i < part.vertices.size(); ++i)
        for (size_t k = 0; k < values.components; ++k)
            part.vertices[i].colour[k] = std::clamp(values.at(i)[k], 0.0f, 1.0f);
}

// Whether the file has tangents.
bool read_tangents(const Loader& loader, const Attributes& attributes, MeshPart& part) {
    const int accessor = find_attribute(attributes, "TANGENT");
    if (accessor < 0)
        return false;
    const Floats values = read_attribute(loader, accessor, {TINYGLTF_TYPE_VEC4}, part.vertices.size());
    for (size_t i = 0; i < part.vertices.size(); ++i) {
        const float* v = values.at(i);
        const float length = std::hypot(v[0], v[1], v[2]);
        if (length > 1e-6f)
            part.vertices[i].tangent = {v[0] / length, v[1] / length, v[2] / length, v[3] < 0.0f ? -1.0f : 1.0f};
    }
    return true;
}

std::array<float, 3> three(const float* values) {
    return {values[0], values[1], values[2]};
}

std::vector<std::array<float, 3>> read_offsets(const Loader& loader, int accessor, size_t vertices) {
    std::vector<std::array<float, 3>> result;
    if (accessor < 0)
        return result;
    const Floats values = read_attribute(loader, accessor, {TINYGLTF_TYPE_VEC3}, vertices);
    for (size_t i = 0; i < vertices; ++i)
        result.push_back(three(values.at(i)));
    return result;
}

void read_targets(Loader& loader, const tinygltf::Primitive& primitive, const std::string& where, MeshPart& part) {
    for (const Attributes& attributes : primitive.targets) {
        take(loader.target_vertices_left, part.vertices.size(), 1, where + "'s morph targets");
        part.targets.push_back({read_offsets(loader, find_attribute(attributes, "POSITION"), part.vertices.size()),
                                read_offsets(loader, find_attribute(attributes, "NORMAL"), part.vertices.size())});
        for (const auto& [name, accessor] : attributes)
            if (name.starts_with("TEXCOORD_") || name.starts_with("COLOR_"))
                loader.warn("Morph targets move positions and normals; texture coordinates and colours stay.");
    }
}

// Strips and fans as triangles. Errors: an index that is no vertex.
std::vector<uint32_t> read_triangles(Loader& loader, const tinygltf::Primitive& primitive, size_t vertices,
                                     const std::string& where) {
    std::vector<uint32_t> order;
    const uint64_t count = primitive.indices < 0 ? vertices : accessor_count(loader, primitive.indices);
    const bool is_list = primitive.mode == TINYGLTF_MODE_TRIANGLES;
    take(loader.indices_left, count, is_list ? 1 : 3, where);
    if (primitive.indices >= 0) {
        order = read_integers(loader, primitive.indices, TINYGLTF_TYPE_SCALAR, count);
    } else {
        order.resize(count);
        std::iota(order.begin(), order.end(), 0u);
    }
    for (const uint32_t index : order)
        if (index >= vertices)
            fail(where + " has the index " + std::to_string(index) + "; it has " + std::to_string(vertices) +
                 " vertices");
    if (is_list) {
        order.resize(order.size() / 3 * 3);
        return order;
    }
    std::vector<uint32_t> result;
    for (size_t i = 2; i < order.size(); ++i) {
        const bool is_fan = primitive.mode == TINYGLTF_MODE_TRIANGLE_FAN, is_odd = i % 2 == 1;
        const uint32_t first = is_fan ? order[0] : order[i - 2];
        const uint32_t second = order[i - 1];
        // Every other triangle of a strip is turned round.
        if (!is_fan && is_odd)
            result.insert(result.end(), {second, first, order[i]});
        else
            result.insert(result.end(), {first, second, order[i]});
    }
    return result;
}

void read_normals(Loader& loader, const Attributes& attributes, MeshPart& part) {
    const int normals = find_attribute(attributes, "NORMAL");
    if (normals < 0)
        return make_flat_normals(part, loader.vertices_left, loader.target_vertices_left);
    const Floats values = read_attribute(loader, normals, {TINYGLTF_TYPE_VEC3}, part.vertices.size());
    for (size_t i = 0; i < part.vertices.size(); ++i)
        part.vertices[i].normal = three(values.at(i));
    mend_normals(part);
}

void warn_of_attributes(Loader& loader, const Attributes& attributes) {
    for (const auto& [name, accessor] : attributes)
        if (name == "JOINTS_1")
            loader.warn("Vertices with more than four joints follow the first four.");
        else if (name == "COLOR_1")
            loader.warn("Of several vertex colours the first is shown.");
}

// An empty part is not shown.
MeshPart read_part(Loader& loader, const tinygltf::Primitive& primitive, const std::string& where) {
    MeshPart part;
    const int mode = primitive.mode;
    if (mode >= TINYGLTF_MODE_POINTS && mode <= TINYGLTF_MODE_LINE_STRIP) {
        loader.warn("Points and lines are not shown.");
        return part;
    }
    require(mode >= TINYGLTF_MODE_TRIANGLES && mode <= TINYGLTF_MODE_TRIANGLE_FAN,
            where + " has the mode " + std::to_string(mode) + "; 0 to 6 are known");
    const int positions = find_attribute(primitive.attributes, "POSITION");
    if (positions < 0) {
        loader.warn("Meshes without positions are not shown.");
        return part;
    }
    take(loader.vertices_left, accessor_count(loader, positions), 1, where);
    const Floats places = read_floats(loader, positions, {TINYGLTF_TYPE_VEC3}, loader.limits.vertices);
    part.vertices.resize(places.count);
    for (size_t i = 0; i < places.count; ++i)
        part.vertices[i].position = three(places.at(i));
    part.material = primitive.material < 0 ? default_material(loader) : static_cast<uint32_t>(primitive.material);
    part.indices = read_triangles(loader, primitive, places.count, where);
    read_targets(loader, primitive, where, part);
    read_texcoords(loader, primitive.attributes, loader.mappings[part.material], part);
    read_colours(loader, primitive.attributes, part);
    read_joints(loader, primitive.attributes, part);
    const bool has_tangents = read_tangents(loader, primitive.attributes, part);
    read_normals(loader, primitive.attributes, part);
    if (!has_tangents && loader.model.materials[part.material].normal_texture != none)
        make_tangents(part);
    warn_of_attributes(loader, primitive.attributes);
    return part;
}

} // namespace

void load_meshes(Loader& loader) {
    for (size_t i = 0; i < loader.file().meshes.size(); ++i) {
        const tinygltf::Mesh& source = loader.file().meshes[i];
        ModelMesh mesh;
        mesh.name = source.name;
        const size_t targets = source.primitives.empty() ? 0 : source.primitives[0].targets.size();
        for (size_t k = 0; k < source.primitives.size(); ++k) {
            const std::string where = place("meshes", i) + "." + place("primitives", k);
            require(source.primitives[k].targets.size() == targets,
                    where + " has " + std::to_string(source.primitives[k].targets.size()) +
                        " morph targets; the mesh's first one has " + std::to_string(targets));
            MeshPart part = read_part(loader, source.primitives[k], where);
            if (!part.indices.empty())
                mesh.parts.push_back(std::move(part));
        }
        require(source.weights.empty() || source.weights.size() == targets,
                place("meshes", i) + " has " + std::to_string(source.weights.size()) + " weights for " +
                    std::to_string(targets) + " morph targets");
        mesh.weights.resize(targets);
        std::ranges::transform(source.weights, mesh.weights.begin(), [](double w) { return static_cast<float>(w); });
        loader.model.meshes.push_back(std::move(mesh));
    }
}

} // namespace sfumato::scene::gltf
