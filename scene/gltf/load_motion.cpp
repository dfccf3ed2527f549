// Animations, cameras and lights.
#include "scene/gltf/load_parts.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sfumato::scene::gltf {
namespace {

// False where the property is none that is known.
bool set_property(const std::string& path, Channel& channel) {
    if (path == "translation" || path == "scale") {
        channel.property = path == "scale" ? AnimatedProperty::scale : AnimatedProperty::translation;
        channel.components = 3;
    } else if (path == "rotation") {
        channel.property = AnimatedProperty::rotation;
        channel.components = 4;
    } else if (path == "weights") {
        channel.property = AnimatedProperty::weights;
    } else {
        return false;
    }
    return true;
}

Interpolation interpolation_of(const std::string& name, const std::string& where) {
    if (name == "STEP")
        return Interpolation::step;
    if (name == "CUBICSPLINE")
        return Interpolation::cubic;
    require(name.empty() || name == "LINEAR",
            where + " has the interpolation '" + name.substr(0, 40) + "'; STEP, LINEAR and CUBICSPLINE are known");
    return Interpolation::linear;
}

void read_keys(Loader& loader, const tinygltf::AnimationSampler& sampler, const std::string& where, Channel& channel) {
    take(loader.key_values_left, accessor_count(loader, sampler.input), 1, where);
    channel.times = read_floats(loader, sampler.input, {TINYGLTF_TYPE_SCALAR}, loader.limits.key_values).values;
    require(!channel.times.empty(), where + " has no keys");
    require(std::ranges::is_sorted(channel.times) && channel.times[0] >= 0.0f,
            where + " has times that do not ascend from 0 on");
    take(loader.key_values_left, accessor_count(loader, sampler.output), 4, where);
    channel.values = read_floats(loader, sampler.output, {TINYGLTF_TYPE_SCALAR, TINYGLTF_TYPE_VEC3, TINYGLTF_TYPE_VEC4},
                                 loader.limits.key_values)
                         .values;
    const size_t expected =
        channel.times.size() * channel.components * (channel.interpolation == Interpolation::cubic ? 3 : 1);
    require(channel.values.size() == expected, where + " has " + std::to_string(channel.values.size()) +
                                                   " values; its keys need " + std::to_string(expected));
}

// Whether the channel moves anything that is shown.
bool set_target(Loader& loader, const tinygltf::AnimationChannel& source, Channel& channel) {
    if (!set_property(source.target_path, channel)) {
        loader.warn("The animated property '" + source.target_path.substr(0, 40) + "' is not known; it stays.");
        return false;
    }
    if (source.target_node < 0)
        return false;
    channel.node = loader.node_of[static_cast<size_t>(source.target_node)];
    const Node& node = loader.model.nodes[channel.node];
    if (channel.property == AnimatedProperty::weights) {
        if (node.mesh == none || loader.model.meshes[node.mesh].weights.empty())
            return false;
        channel.components = static_cast<uint32_t>(loader.model.meshes[node.mesh].weights.size());
    } else if (node.matrix) {
        loader.warn("Nodes with a matrix are not animated.");
        return false;
    }
    return true;
}

ModelCamera camera_of(const tinygltf::Camera& source, const std::string& where) {
    ModelCamera camera;
    camera.name = source.name;
    const bool perspective = source.type == "perspective";
    if (perspective) {
        camera.view_angle = source.perspective.yfov * 180.0 / std::numbers::pi;
        require(camera.view_angle > 0.0 && camera.view_angle < 180.0, where + " has the view angle " +
                                                                          std::to_string(source.perspective.yfov) +
                                                                          "; angles between 0 and π are allowed");
    } else {
        camera.orthographic_height = 2.0 * std::abs(source.orthographic.ymag);
        require(camera.orthographic_height > 0.0, where + " has the height 0");
    }
    const double near_plane = perspective ? source.perspective.znear : source.orthographic.znear;
    const double far_plane = perspective ? source.perspective.zfar : source.orthographic.zfar;
    require(near_plane >= 0.0 && (near_plane > 0.0 || !perspective),
            where + " has its near plane at " + std::to_string(near_plane));
    camera.near_plane = near_plane;
    // A perspective camera without far plane sees to infinity.
    camera.far_plane = far_plane > 0.0 ? far_plane : std::max(1000.0, 1000.0 * near_plane);
    require(camera.far_plane > camera.near_plane, where + " has its far plane before its near plane");
    return camera;
}

ModelLight light_of(Loader& loader, const tinygltf::Light& source, const std::string& where) {
    ModelLight light;
    if (source.type == "point")
        light.kind = LightKind::point;
    else if (source.type == "spot")
        light.kind = LightKind::spot;
    else if (source.type != "directional") {
        loader.warn("A light of the kind '" + source.type.substr(0, 40) + "' is not known; it is dark.");
        light.intensity = 0.0f;
        return light;
    }
    for (size_t k = 0; k < 3 && k < source.color.size(); ++k)
        light.colour[k] = static_cast<float>(std::max(source.color[k], 0.0));
    require(source.intensity >= 0.0 && source.range >= 0.0, where + " has a negative intensity or range");
    light.intensity = static_cast<float>(source.intensity);
    light.range = static_cast<float>(source.range);
    light.outer_cone = static_cast<float>(std::clamp(source.spot.outerConeAngle, 1e-3, std::numbers::pi / 2.0));
    light.inner_cone = std::clamp(static_cast<float>(source.spot.innerConeAngle), 0.0f, light.outer_cone);
    return light;
}

} // namespace

void load_animations(Loader& loader) {
    for (size_t i = 0; i < loader.file().animations.size(); ++i) {
        const tinygltf::Animation& source = loader.file().animations[i];
        Animation animation;
        animation.name = source.name;
        for (size_t k = 0; k < source.channels.size(); ++k) {
            Channel channel;
            if (!set_target(loader, source.channels[k], channel))
                continue;
            const std::string where = place("animations", i) + "." + place("channels", k);
            const auto& sampler = source.samplers[static_cast<size_t>(source.channels[k].sampler)];
            channel.interpolation = interpolation_of(sampler.interpolation, where);
            read_keys(loader, sampler, where, channel);
            animation.duration = std::max(animation.duration, static_cast<double>(channel.times.back()));
            animation.channels.push_back(std::move(channel));
        }
        loader.model.animations.push_back(std::move(animation));
    }
}

void load_cameras_and_lights(Loader& loader) {
    for (size_t i = 0; i < loader.file().cameras.size(); ++i)
        loader.model.cameras.push_back(camera_of(loader.file().cameras[i], place("cameras", i)));
    for (size_t i = 0; i < loader.file().lights.size(); ++i)
        loader.model.lights.push_back(light_of(loader, loader.file().lights[i], place("lights", i)));
}

} // namespace sfumato::scene::gltf
