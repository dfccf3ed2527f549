// A model at a moment: animated properties, the matrices of nodes and skins. All in double.
#include "scene/gltf/model.h"

#include <algorithm>
#include <cmath>

namespace sfumato::scene {
namespace {

Transform product(const Transform& a, const Transform& b) {
    Transform result{};
    for (size_t column = 0; column < 4; ++column)
        for (size_t row = 0; row < 4; ++row)
            for (size_t k = 0; k < 4; ++k)
                result[column * 4 + row] += a[k * 4 + row] * b[column * 4 + k];
    return result;
}

using Quaternion = std::array<double, 4>;

Quaternion normalised(const Quaternion& q) {
    const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(length > 1e-12))
        return {0, 0, 0, 1};
    return {q[0] / length, q[1] / length, q[2] / length, q[3] / length};
}

// The shorter way round.
Quaternion slerp(const Quaternion& a, const Quaternion& b, double share) {
    double cosine = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
    const double sign = cosine < 0.0 ? -1.0 : 1.0;
    cosine *= sign;
    double of_a = 1.0 - share, of_b = share;
    if (cosine < 1.0 - 1e-9) { // else the arc is as straight as a line
        const double angle = std::acos(cosine), sine = std::sin(angle);
        of_a = std::sin((1.0 - share) * angle) / sine;
        of_b = std::sin(share * angle) / sine;
    }
    Quaternion result;
    for (size_t k = 0; k < 4; ++k)
        result[k] = of_a * a[k] + of_b * sign * b[k];
    return normalised(result);
}

// Of translation, rotation and scale.
Transform composed(const std::array<double, 3>& t, const Quaternion& rotation, const std::array<double, 3>& s) {
    const auto [x, y, z, w] = normalised(rotation);
    return {(1 - 2 * (y * y + z * z)) * s[0],
            2 * (x * y + z * w) * s[0],
            2 * (x * z - y * w) * s[0],
            0,
            2 * (x * y - z * w) * s[1],
            (1 - 2 * (x * x + z * z)) * s[1],
            2 * (y * z + x * w) * s[1],
            0,
            2 * (x * z + y * w) * s[2],
            2 * (y * z - x * w) * s[2],
            (1 - 2 * (x * x + y * y)) * s[2],
            0,
            t[0],
            t[1],
            t[2],
            1};
}

Quaternion quaternion_at(const float* values) {
    Quaternion result;
    std::copy_n(values, 4, result.begin());
    return normalised(result);
}

// The channel's values at a time: before its first key those of the first, after its last those of the last.
std::vector<double> sampled(const Channel& channel, double seconds) {
    const auto upper = std::ranges::upper_bound(channel.times, seconds, {}, [](float t) { return double(t); });
    const size_t after = static_cast<size_t>(upper - channel.times.begin());
    const size_t first = after == 0 ? 0 : after - 1, second = std::min(after, channel.times.size() - 1);
    const double start = static_cast<double>(channel.times[first]);
    const double length = static_cast<double>(channel.times[second]) - start;
    const double share = length > 0.0 ? std::clamp((seconds - start) / length, 0.0, 1.0) : 0.0;
    const size_t n = channel.components;
    const bool is_cubic = channel.interpolation == Interpolation::cubic;
    // Of a cubic key: 0 the tangent that leads to it, 1 its value, 2 the tangent that leads away.
    const auto key = [&](size_t index, size_t which) {
        return channel.values.data() + (is_cubic ? index * 3 + which : index) * n;
    };
    const float *a = key(first, 1), *b = key(second, 1);
    std::vector<double> result(a, a + n);
    if (channel.interpolation == Interpolation::step || share == 0.0)
        return result;
    if (is_cubic) {
        const float *away = key(first, 2), *to = key(second, 0);
        const double s = share, s2 = s * s, s3 = s2 * s;
        for (size_t k = 0; k < n; ++k)
            result[k] = (2 * s3 - 3 * s2 + 1) * double(a[k]) + (s3 - 2 * s2 + s) * length * double(away[k]) +
                        (3 * s2 - 2 * s3) * double(b[k]) + (s3 - s2) * length * double(to[k]);
    } else if (channel.property == AnimatedProperty::rotation) {
        std::ranges::copy(slerp(quaternion_at(a), quaternion_at(b), share), result.begin());
    } else {
        for (size_t k = 0; k < n; ++k)
            result[k] += (double(b[k]) - double(a[k])) * share;
    }
    return result;
}

// What of a node an animation changes.
struct NodeState {
    std::array<double, 3> translation, scale;
    Quaternion rotation;
    std::vector<float> weights;
};

NodeState rest_state(const Model& model, const Node& node) {
    NodeState state{node.translation, node.scale, node.rotation, {}};
    if (node.mesh != none)
        state.weights = node.weights.empty() ? model.meshes[node.mesh].weights : node.weights;
    return state;
}

void apply(const Channel& channel, double seconds, NodeState& state) {
    const std::vector<double> values = sampled(channel, seconds);
    switch (channel.property) {
    case AnimatedProperty::translation:
        std::copy_n(values.begin(), 3, state.translation.begin());
        break;
    case AnimatedProperty::scale:
        std::copy_n(values.begin(), 3, state.scale.begin());
        break;
    case AnimatedProperty::rotation:
        std::copy_n(values.begin(), 4, state.rotation.begin());
        break;
    case AnimatedProperty::weights:
        state.weights.assign(values.size(), 0.0f);
        std::ranges::transform(values, state.weights.begin(), [](double w) { return static_cast<float>(w); });
        break;
    }
}

double wrapped(double seconds, double duration) {
    if (!(duration > 0.0) || !std::isfinite(seconds))
        return 0.0;
    const double rest = std::fmod(seconds, duration);
    return rest < 0.0 ? rest + duration : rest;
}

} // namespace

ModelPose pose_model(const Model& model, uint32_t animation, double seconds) {
    std::vector<NodeState> states;
    states.reserve(model.nodes.size());
    for (const Node& node : model.nodes)
        states.push_back(rest_state(model, node));
    if (animation < model.animations.size()) {
        const Animation& played = model.animations[animation];
        const double time = wrapped(seconds, played.duration);
        for (const Channel& channel : played.channels)
            apply(channel, time, states[channel.node]);
    }
    ModelPose pose;
    for (size_t i = 0; i < model.nodes.size(); ++i) {
        const Node& node = model.nodes[i];
        NodeState& state = states[i];
        const Transform local = node.matrix ? *node.matrix : composed(state.translation, state.rotation, state.scale);
        pose.nodes.push_back(node.parent == none ? local : product(pose.nodes[node.parent], local));
        pose.weights.push_back(std::move(state.weights));
    }
    for (const Skin& skin : model.skins) {
        auto& matrices = pose.skins.emplace_back();
        for (size_t i = 0; i < skin.joints.size(); ++i)
            matrices.push_back(product(pose.nodes[skin.joints[i]], skin.inverse_bind[i]));
    }
    return pose;
}

} // namespace sfumato::scene
