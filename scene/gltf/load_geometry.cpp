// Normals and tangents where a file has none. Tangents are the directions in which u grows, summed over the triangles
// about a vertex; not MikkTSpace, so that normal maps baked for that can differ a little at seams.
#include "scene/gltf/load_parts.h"
#include "scene/vec3.h"

#include <cmath>

namespace sfumato::scene::gltf {
namespace {

Vec3 vec3_of(const std::array<float, 3>& v) {
    return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
}

std::array<float, 3> floats_of(Vec3 v) {
    return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

// Unit, or `otherwise` where there is no direction.
Vec3 direction(Vec3 v, Vec3 otherwise) {
    const double length = std::sqrt(dot(v, v));
    return length > 1e-30 ? v * (1.0 / length) : otherwise;
}

// Twice the area long.
Vec3 face_normal(const MeshPart& part, size_t triangle) {
    const auto corner = [&](size_t k) { return vec3_of(part.vertices[part.indices[triangle * 3 + k]].position); };
    return cross(corner(1) - corner(0), corner(2) - corner(0));
}

template <class T>
void gather(std::vector<T>& values, const std::vector<uint32_t>& indices) {
    if (values.empty())
        return;
    std::vector<T> result;
    result.reserve(indices.size());
    for (const uint32_t index : indices)
        result.push_back(values[index]);
    values = std::move(result);
}

} // namespace

// As glTF asks for: every triangle gets vertices of its own.
void make_flat_normals(MeshPart& part, uint64_t& vertices_left, uint64_t& target_vertices_left) {
    take(vertices_left, part.indices.size(), 1, "a mesh without normals");
    take(target_vertices_left, part.indices.size(), part.targets.size(), "a mesh without normals");
    gather(part.vertices, part.indices);
    for (MorphTarget& target : part.targets) {
        gather(target.positions, part.indices);
        target.normals.clear();
    }
    for (size_t i = 0; i < part.indices.size(); ++i)
        part.indices[i] = static_cast<uint32_t>(i);
    for (size_t i = 0; i < part.indices.size() / 3; ++i) {
        const auto normal = floats_of(direction(face_normal(part, i), {0, 1, 0}));
        for (size_t k = 0; k < 3; ++k)
            part.vertices[i * 3 + k].normal = normal;
    }
}

void mend_normals(MeshPart& part) {
    bool all_good = true;
    for (Vertex& vertex : part.vertices) {
        const Vec3 normal = vec3_of(vertex.normal);
        const bool is_good = dot(normal, normal) > 1e-12;
        vertex.normal = is_good ? floats_of(normalised(normal)) : std::array<float, 3>{};
        all_good = all_good && is_good;
    }
    if (all_good)
        return;
    std::vector<Vec3> sums(part.vertices.size());
    for (size_t i = 0; i < part.indices.size(); ++i)
        sums[part.indices[i]] = sums[part.indices[i]] + face_normal(part, i / 3);
    for (size_t i = 0; i < part.vertices.size(); ++i)
        if (part.vertices[i].normal == std::array<float, 3>{})
            part.vertices[i].normal = floats_of(direction(sums[i], {0, 1, 0}));
}

void make_tangents(MeshPart& part) {
    std::vector<Vec3> along_u(part.vertices.size()), along_v(part.vertices.size());
    for (size_t i = 0; i < part.indices.size() / 3; ++i) {
        const Vertex* corners[3];
        for (size_t k = 0; k < 3; ++k)
            corners[k] = &part.vertices[part.indices[i * 3 + k]];
        const auto uv = [&](size_t k, size_t axis) {
            return static_cast<double>(corners[k]->texcoord[axis]) - static_cast<double>(corners[0]->texcoord[axis]);
        };
        const double area = uv(1, 0) * uv(2, 1) - uv(2, 0) * uv(1, 1);
        if (area == 0.0)
            continue;
        const Vec3 a = vec3_of(corners[1]->position) - vec3_of(corners[0]->position);
        const Vec3 b = vec3_of(corners[2]->position) - vec3_of(corners[0]->position);
        // The sign alone: larger triangles count more, however much texture they bear.
        const double sign = area > 0.0 ? 1.0 : -1.0;
        const Vec3 u = (a * uv(2, 1) - b * uv(1, 1)) * sign, v = (b * uv(1, 0) - a * uv(2, 0)) * sign;
        for (size_t k = 0; k < 3; ++k) {
            const uint32_t vertex = part.indices[i * 3 + k];
            along_u[vertex] = along_u[vertex] + u;
            along_v[vertex] = along_v[vertex] + v;
        }
    }
    for (size_t i = 0; i < part.vertices.size(); ++i) {
        const Vec3 normal = vec3_of(part.vertices[i].normal);
        const Vec3 tangent = direction(along_u[i] - normal * dot(normal, along_u[i]), {0, 0, 0});
        const auto xyz = floats_of(tangent);
        const bool is_none = dot(tangent, tangent) == 0.0;
        // Normal maps have their y upwards, texture coordinates of glTF their v downwards: the bitangent, which is
        // cross(normal, tangent) · w, points to where v falls.
        const float w = dot(cross(normal, tangent), along_v[i]) > 0.0 ? -1.0f : 1.0f;
        part.vertices[i].tangent = {xyz[0], xyz[1], xyz[2], is_none ? 0.0f : w};
    }
}

} // namespace sfumato::scene::gltf
