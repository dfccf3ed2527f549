// Axes, lights and constants of drawing particles.
#include "effects/particles/particles_draw_setup.h"

#include "core/matrix.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sfumato {

namespace {

using gpu::ParticleDrawConstants;

float dot(const Direction& a, const Direction& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Direction normalised(const Direction& a) {
    const float scale = 1.0f / std::max(std::sqrt(dot(a, a)), 1e-30f);
    return {a[0] * scale, a[1] * scale, a[2] * scale};
}
Direction cross(const Direction& a, const Direction& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// The unit vector towards the eye: the view space's +z in world space.
Direction to_eye(const Camera& camera) {
    const Matrix4& m = camera.world_to_view;
    return normalised({m[2], m[6], m[10]});
}

gpu::vec4 vec4_of(const Direction& a, float w) {
    return {a[0], a[1], a[2], w};
}

gpu::mat4 light_matrix(const Light& light) {
    const LightAxes axes = light_axes(light.to_light);
    const auto& [r, u, l, c] = std::tie(axes.right, axes.up, light.to_light, light.radiance);
    return {{r[0], r[1], r[2], 0, u[0], u[1], u[2], 0, l[0], l[1], l[2], 0, c[0], c[1], c[2], 0}};
}

void set_lights(ParticleDrawConstants& c, const std::vector<Light>& lights) {
    gpu::mat4* const slots[] = {&c.light_0, &c.light_1, &c.light_2, &c.light_3};
    for (size_t i = 0; i < std::min(lights.size(), most_lights); ++i)
        *slots[i] = light_matrix(lights[i]);
    c.shadow_map_from_world.columns = lights[0].world_to_shadow;
}

void set_camera(ParticleDrawConstants& c, const Frame& frame, Extent extent) {
    const Camera& camera = *frame.camera;
    const Camera& previous = frame.previous_camera ? *frame.previous_camera : camera;
    const Matrix4& p = camera.projection;
    const auto width = static_cast<float>(extent.width), height = static_cast<float>(extent.height);
    const bool perspective = p[11] != 0.0f;
    c.view_from_world.columns = camera.world_to_view;
    c.world_from_view.columns = inverse(camera.world_to_view);
    c.projection.columns = p;
    c.previous_clip_from_world.columns = multiply(previous.projection, previous.world_to_view);
    c.size = {width, height};
    // clip.x = p0 x + p8 z + p12, with z = -depth and clip.w = depth or 1.
    c.pixel_to_view = {2.0f / (width * p[0]), 2.0f / (height * p[5]),
                       (perspective ? p[8] - 1.0f : -1.0f - p[12]) / p[0],
                       (perspective ? p[9] - 1.0f : -1.0f - p[13]) / p[5]};
    c.pixels = 0.5f * height * std::abs(p[5]) * c.scale;
    c.near_start = near_depth(p);
}

// Depth of view, or the distance from the light's end along the half angle, as seen from the eye so that numbers stay
// small far from the origin.
gpu::vec4 sort_axis(const Frame& frame, const ParticleVolumeParameters& parameters, const Direction& to_light) {
    const Camera& camera = *frame.camera;
    const Matrix4& m = camera.world_to_view;
    if (parameters.mode == ParticleMode::light_volume)
        return {-m[2], -m[6], -m[10], -m[14]};
    const Direction axis = half_angle(to_eye(camera), to_light).axis;
    const Matrix4 world = inverse(m);
    return vec4_of({-axis[0], -axis[1], -axis[2]}, dot(axis, {world[12], world[13], world[14]}));
}

void set_profile(ParticleDrawConstants& c, const ParticleVolumeParameters& p) {
    const bool is_noise = p.profile == ParticleProfile::noise;
    c.profile_strength = p.profile_strength;
    c.profile_reach = is_noise ? p.profile_scale / 16.0f : 0.5f;
    // Wisps of less than a pixel cannot be seen.
    c.profile_least = is_noise ? std::max(2.0f, p.profile_scale) : 2.0f;
}

} // namespace

HalfAngle half_angle(const Direction& eye, const Direction& light) {
    const bool front_to_back = dot(eye, light) > 0.0f;
    const float sign = front_to_back ? 1.0f : -1.0f;
    return {normalised({sign * eye[0] + light[0], sign * eye[1] + light[1], sign * eye[2] + light[2]}), front_to_back};
}

LightAxes light_axes(const Direction& to_light) {
    // The world's up would be along an overhead light: there the view is turned about another axis.
    const Direction up = std::abs(to_light[1]) < 0.99f ? Direction{0, 1, 0} : Direction{0, 0, 1};
    const Direction right = normalised(cross(up, to_light));
    return {right, cross(to_light, right)};
}

std::vector<Light> particle_lights(const Frame& frame, const ParticleVolumeParameters& parameters) {
    std::vector<Light> lights(frame.lights.begin(), frame.lights.end());
    if (lights.empty()) {
        constexpr float degrees = std::numbers::pi_v<float> / 180.0f;
        const float azimuth = parameters.light_azimuth * degrees, elevation = parameters.light_elevation * degrees;
        const float s = parameters.light_strength;
        lights.push_back({.to_light = {std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                                       std::cos(azimuth) * std::cos(elevation)},
                          .radiance = {s, s, s}});
    }
    for (Light& light : lights)
        light.to_light = normalised(light.to_light);
    return lights;
}

float near_depth(const Matrix4& p) {
    // Depth d lies at clip.z = d clip.w, with z = -depth: one of d = 0 and d = 1 is the near plane, the other lies
    // farther away or at infinity.
    float nearest = 0.0f;
    for (const float d : {0.0f, 1.0f}) {
        const float slope = p[10] - d * p[11];
        if (slope == 0.0f)
            continue;
        const float depth = -(d * p[15] - p[14]) / slope;
        if (std::isfinite(depth) && depth > 0.0f && (nearest == 0.0f || depth < nearest))
            nearest = depth;
    }
    return nearest;
}

uint32_t resolution_factor(ParticleResolution resolution) {
    return 1u << static_cast<uint32_t>(resolution);
}

uint32_t layer_count(const ParticleVolumeParameters& parameters) {
    return static_cast<uint32_t>(parameters.mode == ParticleMode::half_angle ? parameters.slices : parameters.layers);
}

uint32_t key_bits(const ParticleVolumeParameters& parameters) {
    return 16u + 8u * static_cast<uint32_t>(parameters.sort_bits);
}

ParticleProfile drawn_profile(const ParticleVolumeParameters& parameters) {
    return parameters.profile_strength > 0.0f ? parameters.profile : ParticleProfile::sphere;
}

Extent working_extent(Extent extent, ParticleResolution resolution) {
    const uint32_t factor = resolution_factor(resolution);
    return {(extent.width + factor - 1) / factor, (extent.height + factor - 1) / factor};
}

bool draws_backward(const Frame& frame, const ParticleVolumeParameters& parameters) {
    return parameters.mode == ParticleMode::half_angle &&
           !half_angle(to_eye(*frame.camera), particle_lights(frame, parameters)[0].to_light).front_to_back;
}

ParticleDrawConstants particle_draw_constants(const Frame& frame, const ParticleVolumeParameters& p, Extent extent) {
    ParticleDrawConstants c{};
    const std::vector<Light> lights = particle_lights(frame, p);
    const Extent working = working_extent(extent, p.resolution);
    c.scale = 1.0f / static_cast<float>(resolution_factor(p.resolution));
    set_camera(c, frame, extent);
    set_lights(c, lights);
    c.sort_axis = sort_axis(frame, p, lights[0].to_light);
    c.shadow_colour = {p.shadow_colour_r, p.shadow_colour_g, p.shadow_colour_b, p.scene_shadow};
    c.ambient = {p.ambient, p.ambient, p.ambient, 0.0f};
    c.octaves = {static_cast<float>(p.scattering_octaves), 0.5f, 0.5f, 0.5f};
    c.working_size = {static_cast<float>(working.width), static_cast<float>(working.height)};
    c.near_range = p.near_fade;
    c.phase = p.phase;
    c.soft_distance = p.soft_distance;
    c.key_range = key_bits(p) >= 24 ? 16777215.0f : 65535.0f;
    c.layer_spread = p.scattering_blur;
    // Light that spreads from texel to texel goes on from the same depth.
    c.row_shift = p.scattering_blur > 0.0f ? 0.0f : 0.5f;
    c.simplification = p.resolution == ParticleResolution::full ? 0.0f : 0.12f * p.simplification;
    c.shadow_map_bias = 1e-3f;
    c.depth_tolerance = 0.05f;
    c.time_step = frame.time_step;
    set_profile(c, p);
    return c;
}

} // namespace sfumato
