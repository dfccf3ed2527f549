#include "tests/gpu/particle_draw_support.h"

#include "scene/vec3.h"

#include <cmath>
#include <cstring>

namespace sfumato::test {

namespace {

apps::HostBuffer buffer_of(const void* data, size_t bytes) {
    auto buffer = expect_value(device().create_buffer(bytes), "create_buffer");
    std::memcpy(buffer.bytes().data(), data, bytes);
    return buffer;
}

FloatImage rows_of(const FloatImage& all, uint32_t first, Extent extent) {
    const size_t row = size_t{extent.width} * all.components;
    FloatImage part{extent, all.components, {}};
    const auto begin = all.values.begin() + static_cast<ptrdiff_t>(row * first);
    part.values.assign(begin, begin + static_cast<ptrdiff_t>(row * extent.height));
    return part;
}

// By poison.
std::map<int, std::unique_ptr<Context>> contexts;

Context& shared_context(int poison) {
    auto& context = contexts[poison];
    if (!context)
        context = make_context(poison);
    return *context;
}

} // namespace

void ParticleDrawTest::TearDownTestSuite() {
    contexts.clear();
}

ParticleShot::ParticleShot() {
    parameters.phase = 0.0f;
    parameters.ambient = 0.0f;
    parameters.soft_distance = 0.0f;
    parameters.near_fade = 0.0f;
    parameters.scene_shadow = 0.0f;
    parameters.pairs_per_particle = 64;
}

Frame ParticleShot::frame() const {
    Frame frame;
    frame.camera = camera;
    frame.previous_camera = previous_camera;
    frame.lights = lights;
    return frame;
}

scene::ParticleTruth ParticleShot::truth() const {
    return scene::particle_truth(sprites, frame(), parameters, extent, depth.values, 2,
                                 {profile.extent, profile.values});
}

ParticleImages ParticleShot::draw(int poison) const {
    EffectRig rig(shared_context(poison), ParticleVolume::info());
    const auto constant = [&](uint32_t components, float value) {
        return make_image(extent, components, [&](uint32_t, uint32_t, float* p) { std::fill_n(p, components, value); });
    };
    rig.set("colour", colour.values.empty() ? constant(4, 0.0f) : colour);
    rig.set("depth", depth.values.empty() ? constant(1, 1e10f) : depth);
    for (const auto& [name, image] :
         {std::pair{"direct", &direct}, {"shadow_map", &shadow_map}, {"velocity", &velocity}, {"profile", &profile}})
        if (!image->values.empty())
            rig.set(name, *image);
    rig.optional_outputs = optional_outputs;
    const auto particles = buffer_of(sprites.data(), sprites.size() * sizeof(ParticleSprite));
    const ParticleStatistics none{77, 77, 77, 77, 77, 77, 77, 77};
    const auto statistics = buffer_of(&none, sizeof(none));
    rig.set_buffer("sprites", particles.buffer());
    rig.set_buffer("statistics", statistics.buffer());
    const FloatImage all = rig.run(frame(), &parameters);
    ParticleImages images{rows_of(all, 0, extent), {}, {}, {}};
    if (optional_outputs) {
        images.velocity = rows_of(all, extent.height, extent);
        images.transmittance = rows_of(all, 2 * extent.height, extent);
    }
    std::memcpy(&images.statistics, statistics.bytes().data(), sizeof(ParticleStatistics));
    return images;
}

Light white_light(std::array<float, 3> to_light) {
    Light light;
    light.to_light = to_light;
    light.radiance = {12.5663706f, 12.5663706f, 12.5663706f};
    return light;
}

ParticleShot cloud_shot(double angle, uint32_t count) {
    ParticleShot shot;
    shot.sprites = scene::particle_cloud({.count = count, .radius = 0.13f, .extinction = 0.7f});
    shot.camera = shot.previous_camera = look_at({0, 0, 4}, {0, 0, 0}, 1.5, shot.extent);
    // Tilted a little, so that nothing lines up with an axis.
    const double a = scene::radians(angle), tilt = scene::radians(25.0);
    shot.lights = {white_light({static_cast<float>(std::sin(a) * std::cos(tilt)),
                                static_cast<float>(std::sin(a) * std::sin(tilt)), static_cast<float>(std::cos(a))})};
    return shot;
}

ParticleSprite sprite(std::array<float, 3> position, float radius, float extinction, std::array<float, 3> albedo) {
    ParticleSprite s{};
    s.position = position;
    s.radius = radius;
    s.extinction = extinction;
    s.albedo = albedo;
    return s;
}

double rms_difference(const FloatImage& a, const FloatImage& b) {
    double sum = 0.0;
    size_t count = 0;
    for (size_t i = 0; i < a.values.size(); ++i)
        if (i % a.components < 3) {
            const double d = double{a.values[i]} - double{b.values[i]};
            sum += d * d;
            ++count;
        }
    return std::sqrt(sum / static_cast<double>(count));
}

double optical_mass(const FloatImage& transmittance) {
    double sum = 0.0;
    for (size_t i = 0; i < transmittance.values.size(); i += transmittance.components)
        sum -= std::log(std::max(double{transmittance.values[i]}, 1e-6));
    return sum;
}

} // namespace sfumato::test
