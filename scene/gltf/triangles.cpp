// A posed model as triangles in world space: morphed, then skinned or moved by its node, in double until the end.
#include "scene/gltf/model.h"
#include "scene/vec3.h"

#include <cmath>

namespace sfumato::scene {
namespace {

Vec3 vec3_of(const std::array<float, 3>& v) {
    return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
}

std::array<float, 3> floats_of(Vec3 v) {
    return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

Vec3 column(const Transform& m, size_t index) {
    return {m[index * 4], m[index * 4 + 1], m[index * 4 + 2]};
}

Vec3 moved(const Transform& m, Vec3 p) {
    return column(m, 0) * p.x + column(m, 1) * p.y + column(m, 2) * p.z + column(m, 3);
}

double determinant(const Transform& m) {
    return dot(column(m, 0), cross(column(m, 1), column(m, 2)));
}

// By the inverse transpose, up to a positive factor: its columns are the cross products of the matrix's columns, and
// mirrors turn the sign. Flattened things have no inverse, but still these. Zero if nothing is left.
Vec3 moved_normal(const Transform& m, Vec3 n) {
    const Vec3 a = column(m, 0), b = column(m, 1), c = column(m, 2);
    const Vec3 sum = cross(b, c) * n.x + cross(c, a) * n.y + cross(a, b) * n.z;
    const double length = std::sqrt(dot(sum, sum)) * (determinant(m) < 0.0 ? -1.0 : 1.0);
    return length != 0.0 && std::isfinite(length) ? sum * (1.0 / length) : Vec3{};
}

Transform blended(const std::vector<Transform>& matrices, const Vertex& vertex) {
    Transform result{};
    for (size_t k = 0; k < 4; ++k)
        if (vertex.weights[k] != 0.0f)
            for (size_t i = 0; i < 16; ++i)
                result[i] += static_cast<double>(vertex.weights[k]) * matrices[vertex.joints[k]][i];
    return result;
}

void morph(const MeshPart& part, const std::vector<float>& weights, size_t index, Vec3& position, Vec3& normal) {
    for (size_t k = 0; k < part.targets.size() && k < weights.size(); ++k) {
        const double weight = static_cast<double>(weights[k]);
        if (weight == 0.0)
            continue;
        if (!part.targets[k].positions.empty())
            position = position + vec3_of(part.targets[k].positions[index]) * weight;
        if (!part.targets[k].normals.empty())
            normal = normal + vec3_of(part.targets[k].normals[index]) * weight;
    }
}

} // namespace

TriangleMesh pose_triangles(const Model& model, const ModelPose& pose) {
    TriangleMesh mesh;
    for (uint32_t n = 0; n < model.nodes.size(); ++n) {
        const Node& node = model.nodes[n];
        if (node.mesh == none)
            continue;
        const bool is_skinned = node.skin != none;
        const auto& parts = model.meshes[node.mesh].parts;
        for (uint32_t p = 0; p < parts.size(); ++p) {
            const MeshPart& part = parts[p];
            const auto first = static_cast<uint32_t>(mesh.positions.size());
            for (size_t i = 0; i < part.vertices.size(); ++i) {
                const Vertex& vertex = part.vertices[i];
                Vec3 position = vec3_of(vertex.position), normal = vec3_of(vertex.normal);
                morph(part, pose.weights[n], i, position, normal);
                const Transform matrix = is_skinned ? blended(pose.skins[node.skin], vertex) : pose.nodes[n];
                mesh.positions.push_back(floats_of(moved(matrix, position)));
                mesh.normals.push_back(floats_of(moved_normal(matrix, normal)));
                mesh.texcoords.push_back(vertex.texcoord);
                mesh.opacities.push_back(model.materials[part.material].base_colour[3] * vertex.colour[3]);
            }
            // In a mirror the other side would be in front.
            const bool is_mirrored = !is_skinned && determinant(pose.nodes[n]) < 0.0;
            for (uint32_t i = 0; i + 2 < part.indices.size(); i += 3) {
                const uint32_t second = is_mirrored ? 2 : 1, third = is_mirrored ? 1 : 2;
                for (const uint32_t corner : {0u, second, third})
                    mesh.indices.push_back(first + part.indices[i + corner]);
                mesh.sources.push_back({n, p, i / 3});
            }
        }
    }
    return mesh;
}

} // namespace sfumato::scene
