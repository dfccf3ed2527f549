// Lights as the shaders take them, after KHR_lights_punctual.
#include "scene/gltf/mesh_renderer_lights.h"

#include "scene/vec3.h"

#include <algorithm>

namespace sfumato::scene {
namespace {

using shared::MeshLight;
using shared::MeshLights;

shared::vec4 vec4_of(Vec3 v, double w = 0.0) {
    return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z), static_cast<float>(w)};
}

Vec3 position_of(const Transform& t) {
    return {t[12], t[13], t[14]};
}

// Lights shine along their node's -Z.
Vec3 against_beam(const Transform& t) {
    const Vec3 z = {t[8], t[9], t[10]};
    return dot(z, z) > 1e-20 ? normalised(z) : Vec3{0, 1, 0};
}

double brightest(const ModelLight& light) {
    return std::ranges::max(light.colour) * static_cast<double>(light.intensity);
}

MeshLight light_constants(const ModelLight& light, const Transform& place, double exposure) {
    MeshLight result{};
    const double scale = exposure * static_cast<double>(light.intensity);
    result.colour = vec4_of(Vec3{light.colour[0], light.colour[1], light.colour[2]} * scale,
                            light.kind == LightKind::directional ? MESH_DIRECTIONAL
                            : light.kind == LightKind::point     ? MESH_POINT
                                                                 : MESH_SPOT);
    result.position = vec4_of(position_of(place), light.range > 0.0f ? 1.0 / static_cast<double>(light.range) : 0.0);
    result.direction = vec4_of(against_beam(place));
    const double inner = std::cos(static_cast<double>(light.inner_cone));
    const double outer = std::cos(static_cast<double>(light.outer_cone));
    const double slope = 1.0 / std::max(inner - outer, 1e-3);
    result.cone = {static_cast<float>(slope), static_cast<float>(-outer * slope), 0.0f, 0.0f};
    return result;
}

// Orthographic, from the light's side of the sphere; 0 is nearest to the light. The sphere's middle is put on a whole
// texel, so that shadows do not crawl when it moves.
shared::mat4 shadow_view(Vec3 to_light, const Bounds& casters, uint32_t side, double& texel) {
    const double radius = casters.radius * 1.01;
    texel = 2.0 * radius / side;
    const Vec3 aside = std::abs(to_light.y) < 0.99 ? Vec3{0, 1, 0} : Vec3{1, 0, 0};
    const Vec3 right = normalised(cross(aside, to_light));
    const Vec3 up = cross(to_light, right);
    shared::mat4 view{};
    const auto set_row = [&](size_t row, Vec3 axis, double scale, double offset) {
        view.elements[row] = static_cast<float>(axis.x * scale);
        view.elements[4 + row] = static_cast<float>(axis.y * scale);
        view.elements[8 + row] = static_cast<float>(axis.z * scale);
        view.elements[12 + row] = static_cast<float>(offset);
    };
    const auto snapped = [&](double place) { return std::floor(place / texel) * texel; };
    set_row(0, right, 1.0 / radius, -snapped(dot(right, casters.centre)) / radius);
    set_row(1, up, 1.0 / radius, -snapped(dot(up, casters.centre)) / radius);
    set_row(2, to_light, -0.5 / radius, 0.5 + 0.5 * dot(to_light, casters.centre) / radius);
    set_row(3, {}, 0.0, 1.0);
    return view;
}

} // namespace

MeshLightRig::MeshLightRig(const Model& model, const ModelPose& pose, const Bounds& casters, const Light& otherwise)
    : model_(&model), casters_(casters), otherwise_(otherwise) {
    for (uint32_t i = 0; i < model.nodes.size(); ++i)
        if (model.nodes[i].light != none && brightest(model.lights[model.nodes[i].light]) > 0.0)
            nodes_.push_back(i);
    const auto light = [&](uint32_t node) -> const ModelLight& { return model.lights[model.nodes[node].light]; };
    std::stable_partition(nodes_.begin(), nodes_.end(),
                          [&](uint32_t i) { return light(i).kind == LightKind::directional; });
    if (nodes_.size() > MESH_MOST_LIGHTS)
        nodes_.resize(MESH_MOST_LIGHTS);
    double most = 0.0;
    for (const uint32_t node : nodes_) {
        const Vec3 away = position_of(pose.nodes[node]) - casters.centre;
        // A light within the model is not the measure of all others.
        const double square = std::max(dot(away, away), casters.radius * casters.radius);
        const bool is_far = light(node).kind == LightKind::directional;
        most = std::max(most, brightest(light(node)) / (is_far ? 1.0 : square));
    }
    exposure_ = most > 0.0 ? otherwise.sun.x / most : 1.0;
}

MeshLights MeshLightRig::at(const ModelPose& pose, uint32_t side) const {
    MeshLights result{};
    result.ambient_up = vec4_of(otherwise_.ambient_up);
    result.ambient_down = vec4_of(otherwise_.ambient_down);
    size_t count = 0;
    for (const uint32_t node : nodes_)
        result.lights[count++] =
            light_constants(model_->lights[model_->nodes[node].light], pose.nodes[node], exposure_);
    if (nodes_.empty()) {
        result.lights[count].colour = vec4_of(otherwise_.sun, MESH_DIRECTIONAL);
        result.lights[count++].direction = vec4_of(normalised(otherwise_.to_sun));
    }
    const bool casts = result.lights[0].colour.w == static_cast<float>(MESH_DIRECTIONAL);
    double texel = 0.0;
    if (casts)
        result.shadow_from_world = shadow_view(to_sun(pose), casters_, side, texel);
    result.shadow = {static_cast<float>(texel), static_cast<float>(side), casts ? 1.0f : 0.0f,
                     static_cast<float>(count)};
    return result;
}

Vec3 MeshLightRig::to_sun(const ModelPose& pose) const {
    if (nodes_.empty())
        return normalised(otherwise_.to_sun);
    const uint32_t node = nodes_.front();
    if (model_->lights[model_->nodes[node].light].kind == LightKind::directional)
        return against_beam(pose.nodes[node]);
    const Vec3 away = position_of(pose.nodes[node]) - casters_.centre;
    return dot(away, away) > 1e-20 ? normalised(away) : Vec3{0, 1, 0};
}

} // namespace sfumato::scene
