// The tree of nodes, in an order that has parents first, and skins.
#include "scene/gltf/load_parts.h"

#include <algorithm>
#include <cmath>

namespace sfumato::scene::gltf {
namespace {

// Parents of the file's nodes. Errors: two parents, or cycles.
std::vector<uint32_t> parents_of(const tinygltf::Model& file) {
    std::vector<uint32_t> parents(file.nodes.size(), none);
    for (size_t i = 0; i < file.nodes.size(); ++i)
        for (const int child : file.nodes[i].children) {
            uint32_t& parent = parents[static_cast<size_t>(child)];
            require(parent == none, place("nodes", static_cast<size_t>(child)) + " has two parents");
            parent = static_cast<uint32_t>(i);
        }
    return parents;
}

// The file's nodes, parents before children.
std::vector<uint32_t> tree_order(const tinygltf::Model& file, const std::vector<uint32_t>& parents) {
    std::vector<uint32_t> order;
    for (size_t i = 0; i < parents.size(); ++i)
        if (parents[i] == none)
            order.push_back(static_cast<uint32_t>(i));
    for (size_t next = 0; next < order.size(); ++next)
        for (const int child : file.nodes[order[next]].children)
            order.push_back(static_cast<uint32_t>(child));
    if (order.size() < parents.size()) { // what no root leads to hangs on itself
        std::vector<bool> is_reached(parents.size());
        for (const uint32_t node : order)
            is_reached[node] = true;
        fail(place("nodes", static_cast<size_t>(std::ranges::find(is_reached, false) - is_reached.begin())) +
             " is its own ancestor, or hangs on one that is");
    }
    return order;
}

// Which of the file's nodes the scene shows. Of the others poses are needed at most.
std::vector<bool> shown_nodes(Loader& loader, const std::vector<uint32_t>& order,
                              const std::vector<uint32_t>& parents) {
    const tinygltf::Model& file = loader.file();
    if (file.scenes.empty())
        return std::vector<bool>(file.nodes.size(), true);
    if (file.scenes.size() > 1)
        loader.warn("Of several scenes only the default one is shown.");
    std::vector<bool> shown(file.nodes.size());
    const size_t scene = file.defaultScene < 0 ? 0 : static_cast<size_t>(file.defaultScene);
    for (const int root : file.scenes[scene].nodes)
        shown[static_cast<size_t>(root)] = true;
    for (const uint32_t node : order)
        if (parents[node] != none && shown[parents[node]])
            shown[node] = true;
    return shown;
}

// Rows four of projective matrices are dropped: glTF does not allow them.
Transform affine(const double* values) {
    Transform result;
    std::copy(values, values + 16, result.begin());
    result[3] = result[7] = result[11] = 0.0;
    result[15] = 1.0;
    return result;
}

void set_pose(const tinygltf::Node& source, Node& node) {
    if (source.matrix.size() == 16) {
        node.matrix = affine(source.matrix.data());
        return;
    }
    if (source.translation.size() == 3)
        std::ranges::copy(source.translation, node.translation.begin());
    if (source.scale.size() == 3)
        std::ranges::copy(source.scale, node.scale.begin());
    if (source.rotation.size() == 4) {
        double length = 0.0;
        for (const double value : source.rotation)
            length += value * value;
        length = std::sqrt(length);
        if (length > 1e-12)
            for (size_t k = 0; k < 4; ++k)
                node.rotation[k] = source.rotation[k] / length;
    }
}

uint32_t index_of(int index) {
    return index < 0 ? none : static_cast<uint32_t>(index);
}

void set_weights(Loader& loader, const tinygltf::Node& source, const std::string& where, Node& node) {
    if (source.weights.empty() || node.mesh == none)
        return;
    const size_t targets = loader.model.meshes[node.mesh].weights.size();
    require(source.weights.size() == targets, where + " has " + std::to_string(source.weights.size()) +
                                                  " weights; its mesh has " + std::to_string(targets) +
                                                  " morph targets");
    for (const double weight : source.weights)
        node.weights.push_back(static_cast<float>(weight));
}

void check_joints(Loader& loader, Node& node, const std::string& where) {
    if (node.skin == none)
        return;
    if (node.mesh == none) {
        node.skin = none;
        return;
    }
    const size_t joints = loader.model.skins[node.skin].joints.size();
    for (const MeshPart& part : loader.model.meshes[node.mesh].parts)
        for (const Vertex& vertex : part.vertices) {
            if (vertex.weights == std::array<float, 4>{}) {
                loader.warn("The mesh of " + where + " has vertices without joints; its skin is left out.");
                node.skin = none;
                return;
            }
            for (const uint16_t joint : vertex.joints)
                if (joint >= joints)
                    fail(where + "'s mesh has a vertex at joint " + std::to_string(joint) + "; its skin has " +
                         std::to_string(joints));
        }
}

} // namespace

void load_nodes(Loader& loader) {
    const tinygltf::Model& file = loader.file();
    const auto parents = parents_of(file);
    const auto order = tree_order(file, parents);
    const auto shown = shown_nodes(loader, order, parents);
    loader.node_of.resize(order.size());
    for (const uint32_t index : order) {
        const tinygltf::Node& source = file.nodes[index];
        loader.node_of[index] = static_cast<uint32_t>(loader.model.nodes.size());
        Node node;
        node.name = source.name;
        if (parents[index] != none)
            node.parent = loader.node_of[parents[index]];
        set_pose(source, node);
        if (shown[index]) {
            node.mesh = index_of(source.mesh);
            node.skin = index_of(source.skin);
            node.camera = index_of(source.camera);
            if (const auto found = source.extensions.find("KHR_lights_punctual"); found != source.extensions.end())
                node.light = static_cast<uint32_t>(found->second.Get("light").GetNumberAsInt());
            set_weights(loader, source, place("nodes", index), node);
        }
        loader.model.nodes.push_back(std::move(node));
    }
}

void load_skins(Loader& loader) {
    for (size_t i = 0; i < loader.file().skins.size(); ++i) {
        const tinygltf::Skin& source = loader.file().skins[i];
        Skin skin;
        for (const int joint : source.joints)
            skin.joints.push_back(loader.node_of[static_cast<size_t>(joint)]);
        require(!skin.joints.empty(), place("skins", i) + " has no joints");
        if (source.inverseBindMatrices >= 0) {
            take(loader.key_values_left, accessor_count(loader, source.inverseBindMatrices), 16, place("skins", i));
            const Floats matrices =
                read_floats(loader, source.inverseBindMatrices, {TINYGLTF_TYPE_MAT4}, loader.limits.key_values);
            require(matrices.count >= skin.joints.size(), place("skins", i) + " has " + std::to_string(matrices.count) +
                                                              " matrices for " + std::to_string(skin.joints.size()) +
                                                              " joints");
            for (size_t k = 0; k < skin.joints.size(); ++k) {
                Transform matrix;
                std::copy_n(matrices.at(k), 16, matrix.begin());
                skin.inverse_bind.push_back(affine(matrix.data()));
            }
        } else {
            skin.inverse_bind.assign(skin.joints.size(), {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1});
        }
        loader.model.skins.push_back(std::move(skin));
    }
    for (size_t i = 0; i < loader.model.nodes.size(); ++i)
        check_joints(loader, loader.model.nodes[i], "the node '" + loader.model.nodes[i].name.substr(0, 60) + "'");
}

} // namespace sfumato::scene::gltf
