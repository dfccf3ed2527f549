// A glTF file in memory: what the renderer and the ray tracer need of it, without the file format. Lengths in metres,
// right-handed, y up; colours linear unless said otherwise. Everything is checked when it is loaded: indices are in
// range, numbers finite, nodes form trees.
#pragma once

#include "scene/scene.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace sfumato::scene {

inline constexpr uint32_t none = ~0u;

struct Texture {
    uint32_t width = 0, height = 0;
    std::vector<uint8_t> rgba; // width * height * 4, row by row from the top
    bool is_srgb = false;      // colour; alpha is linear always
    bool repeats_u = true, repeats_v = true;
    bool is_nearest = false;
};

enum class AlphaMode : uint32_t { opaque, mask, blend };

struct ModelMaterial {
    std::string name;
    std::array<float, 4> base_colour = {1, 1, 1, 1};
    std::array<float, 3> emission = {0, 0, 0};
    float metallic = 1.0f, roughness = 1.0f;
    float alpha_cutoff = 0.5f;
    float normal_scale = 1.0f;
    AlphaMode alpha_mode = AlphaMode::opaque;
    bool double_sided = false;
    bool unlit = false;
    uint32_t base_colour_texture = none; // index into Model::textures
    uint32_t metallic_roughness_texture = none;
    uint32_t normal_texture = none;
    uint32_t emission_texture = none;
};

struct Vertex {
    std::array<float, 3> position = {};
    std::array<float, 3> normal = {};  // made from the triangles where the file has none
    std::array<float, 4> tangent = {}; // w: handedness; zero where there is none
    std::array<float, 2> texcoord = {};
    std::array<float, 4> colour = {1, 1, 1, 1};
    std::array<uint16_t, 4> joints = {}; // index into Skin::joints
    std::array<float, 4> weights = {};   // sum is 1, or all 0 without a skin
};

// Offsets to vertices, one a vertex.
struct MorphTarget {
    std::vector<std::array<float, 3>> positions, normals; // either may be empty
};

struct MeshPart {
    std::vector<Vertex> vertices;
    std::vector<uint32_t> indices; // triangles, counter-clockwise in front
    std::vector<MorphTarget> targets;
    uint32_t material = 0;
};

struct ModelMesh {
    std::string name;
    std::vector<MeshPart> parts;
    std::vector<float> weights; // of the morph targets at rest
};

// Column-major, as in glTF.
using Transform = std::array<double, 16>;

struct Node {
    std::string name;
    uint32_t parent = none;
    std::array<double, 3> translation = {0, 0, 0};
    std::array<double, 4> rotation = {0, 0, 0, 1}; // quaternion x y z w
    std::array<double, 3> scale = {1, 1, 1};
    std::optional<Transform> matrix; // in place of the three; never animated
    uint32_t mesh = none, skin = none, camera = none, light = none;
    std::vector<float> weights; // of the mesh's morph targets, in place of the mesh's own
};

struct Skin {
    std::vector<uint32_t> joints; // nodes
    std::vector<Transform> inverse_bind;
};

enum class AnimatedProperty { translation, rotation, scale, weights };
enum class Interpolation { step, linear, cubic };

struct Channel {
    uint32_t node = 0;
    AnimatedProperty property = AnimatedProperty::translation;
    Interpolation interpolation = Interpolation::linear;
    std::vector<float> times;  // seconds, ascending
    std::vector<float> values; // times.size() × components, three times that for cubic (in-tangent, value, out-tangent)
    uint32_t components = 3;
};

struct Animation {
    std::string name;
    double duration = 0.0; // seconds
    std::vector<Channel> channels;
};

struct ModelCamera {
    std::string name;
    double view_angle = 40.0;         // vertical, degrees
    double orthographic_height = 0.0; // metres; above 0: orthographic
    double near_plane = 0.05, far_plane = 1000.0;
};

enum class LightKind { directional, point, spot };

struct ModelLight {
    LightKind kind = LightKind::directional;
    std::array<float, 3> colour = {1, 1, 1};
    float intensity = 1.0f;                          // lux, or candela
    float range = 0.0f;                              // metres; 0: endless
    float inner_cone = 0.0f, outer_cone = 0.785398f; // radians
};

struct Model {
    std::string name;
    std::vector<Texture> textures;
    std::vector<ModelMaterial> materials; // one at least
    std::vector<ModelMesh> meshes;
    std::vector<Node> nodes; // parents before children
    std::vector<Skin> skins;
    std::vector<Animation> animations;
    std::vector<ModelCamera> cameras;
    std::vector<ModelLight> lights;
    std::vector<std::string> warnings; // what is in the file and not shown, one sentence each
};

// What a file may ask for; checked before anything of that size is allocated.
struct LoadLimits {
    uint64_t file_bytes = uint64_t{1} << 30;   // of all files together
    uint64_t json_values = uint64_t{1} << 22;  // and a nesting of at most 64
    uint32_t image_side = 16384;               // pixels
    uint64_t image_pixels = uint64_t{1} << 27; // of all textures together
    uint64_t vertices = uint64_t{1} << 24;     // of all parts together, and as many of morph targets
    uint64_t indices = uint64_t{1} << 26;      // of all parts together, and of all parts at all nodes
    uint64_t key_values = uint64_t{1} << 24;   // of all animations together
};

// Reads .gltf or .glb, with the files beside it that it names. Errors (input): not readable, not glTF 2.0, a required
// extension that is not known, no triangles, sizes beyond the limits, anything out of range; the message names the
// file and the thing in it.
Result<Model> load_model(const std::filesystem::path& path, const LoadLimits& limits = {});

// The model at a moment of one of its animations.
struct ModelPose {
    std::vector<Transform> nodes;              // local to world, one a node
    std::vector<std::vector<Transform>> skins; // of each skin, joint · inverse bind, to world
    std::vector<std::vector<float>> weights;   // of each node's mesh's morph targets; empty where there are none
};

// `animation`: an index, or `none` for the pose at rest. Seconds wrap round the animation's duration.
ModelPose pose_model(const Model& model, uint32_t animation, double seconds);

// Triangles in world space.
struct TriangleMesh {
    std::vector<std::array<float, 3>> positions;
    std::vector<std::array<float, 3>> normals;   // one a vertex, unit; zero where there is none
    std::vector<std::array<float, 2>> texcoords; // one a vertex
    std::vector<float> opacities;                // one a vertex: the material's alpha times the vertex's
    std::vector<uint32_t> indices;               // three a triangle, counter-clockwise in front
    struct Source {
        uint32_t node, part, triangle; // of Node::mesh
    };
    std::vector<Source> sources; // one a triangle
};

// Skinned and morphed on the CPU, in double. The order of vertices is the same at every moment.
TriangleMesh pose_triangles(const Model& model, const ModelPose& pose);

} // namespace sfumato::scene
