// Inputs for the generic tests of effects.
#include "tests/gpu/effect_fixture.h"

#include <cmath>
#include <cstring>
#include <sstream>

namespace sfumato::test {
namespace {

constexpr const char* motion_looks[] = {
    "frame_rate_mode=fixed reference_frame_rate=30",
    "dilation=selective test_edge_neighbours=true",
    "weighting=talk weight_centre=1 weight_foreground=1 weight_background=1 weight_mutual=1",
};

// Everything that is on only now and then, under a radius that the fixture's bar and post lie within.
constexpr const char* occlusion_looks[] = {
    "radius=5 temporal=true animate_noise=true",
    "radius=5 temporal=true animate_noise=true resolution=half upsample=soma",
    "radius=5 resolution=half measure=cosine falloff=quadratic",
    "radius=5 estimator=obscurance falloff=linear application=ambient",
    "radius=5 filter_comparison=radius filter_weight=tent mip_rate=1",
};

// In front of the fixture's camera, where its wall and bar are in the way.
constexpr const char* particle_looks[] = {
    "attractor_strength=5 attractor_y=1 attractor_z=-3 wind_x=1 wind_y=0.5 wind_z=-2",
    "direction_elevation=10 direction_azimuth=170 speed=6 collision=depth bounce=0.5 friction=0.5 lifetime=1 burst=800",
    "emission=20 emission_time=0.3 phase=0.5 burst=1000 time_scale=0.3 dilution=1",
    "mode=half-angle scattering_blur=0.1 scattering_octaves=3 slices=16",
    "profile=texture radius_start=0.3 radius_end=1",
    "emitter=box emitter_size=1 radius_end=1 count=1000 burst=1000 soft_distance=1 near_fade=4 pairs_per_particle=1",
};
constexpr const char* particle_parameter_looks[] = {
    "profile=noise profile_strength=0.9 profile_scale=2 radius_start=0.3 radius_end=1",
    "resolution=half simplification=1 radius_start=0.04 radius_end=0.04 extinction=1 burst=1500",
    // Most of them near, some a long way off: 16 bits do not tell the near ones apart.
    "sort_bits=24 layers=8 rate=4000 burst=0 count=2000 wind_x=-200 wind_z=-200 drag=0.5 lifetime=1",
};

constexpr EffectFacts facts[] = {
    // Two tiles of 32 and the jitter of the tile lookup.
    {"motion-blur", 80, motion_looks},
    {"ambient-occlusion", 128, occlusion_looks},
    {"particles", 128, particle_looks, "position_y=-1 position_z=-4 count=1500 rate=600 burst=200 warm_up=0.5",
     "count=2000 burst=2000 rate=4000 warm_up=1 shadow_resolution=128", particle_parameter_looks},
};

float hash(uint32_t x, uint32_t y, uint32_t seed) {
    uint32_t h = x * 0x9e3779b1u ^ y * 0x85ebca77u ^ seed * 0xc2b2ae3du;
    h = (h ^ h >> 15) * 0x2c1b3c6du;
    h = (h ^ h >> 12) * 0x297a2d39u;
    return static_cast<float>((h ^ h >> 15) >> 8) / 16777216.0f;
}

bool contains(const char* name, const char* part) {
    return std::strstr(name, part) != nullptr;
}

// Four surfaces: a far wall, a post half a metre before it, a near bar that leans, sky above. In relative units, so
// that every size has them.
enum class Surface { wall, post, bar, sky };
Surface surface_at(uint32_t x, uint32_t y, Extent extent) {
    const float u = (static_cast<float>(x) + 0.5f) / static_cast<float>(extent.width);
    const float v = (static_cast<float>(y) + 0.5f) / static_cast<float>(extent.height);
    const float middle = 0.48f + 0.1f * (v - 0.5f);
    if (std::abs(u - middle) < 0.07f)
        return Surface::bar;
    if (u > 0.16f && u < 0.22f && v > 0.25f)
        return Surface::post;
    return v < 0.12f && u > 0.35f && u < 0.6f ? Surface::sky : Surface::wall;
}

void depth_pixel(uint32_t x, uint32_t y, Extent extent, float* pixel) {
    const float v = static_cast<float>(y) / static_cast<float>(extent.height);
    const Surface surface = surface_at(x, y, extent);
    const float wall = 8.0f - 2.0f * v;
    switch (surface) {
    case Surface::sky:
        *pixel = 1e10f;
        break;
    case Surface::bar:
        *pixel = 3.0f + 0.1f * v;
        break;
    case Surface::post:
        *pixel = wall - 0.5f;
        break;
    case Surface::wall:
        *pixel = wall;
        break;
    }
}

// The left third moves nearly alike, the bar across, the right part straight down and the faster the farther right, the
// rest in a swirl: even tiles, mixed tiles, edges, and tiles whose blur stays in its column, whatever the tile's size.
void vector_pixel(uint32_t x, uint32_t y, Extent extent, uint32_t seed, float* pixel) {
    const auto height = static_cast<float>(extent.height);
    const float u = static_cast<float>(x) / static_cast<float>(extent.width);
    const float v = static_cast<float>(y) / height;
    const auto turn = static_cast<float>(seed % 7) * 0.4f;
    const Surface surface = surface_at(x, y, extent);
    if (u >= 0.62f) {
        pixel[0] = 0.0f;
        pixel[1] = (0.05f + 0.5f * (u - 0.62f)) * height;
        return;
    }
    float length = 0.1f * height, angle = 0.3f + turn;
    if (surface == Surface::bar) {
        length = 0.13f * height;
        angle = 1.9f + turn;
    } else if (u < 0.35f) {
        length *= 1.0f + 0.08f * std::sin(40.0f * u) * std::sin(25.0f * v);
    } else {
        angle += 4.0f * (u - 0.5f) + 3.0f * v;
        length *= 0.2f + v;
    }
    pixel[0] = length * std::cos(angle);
    pixel[1] = length * std::sin(angle);
}

void normal_pixel(uint32_t x, uint32_t y, Extent extent, float* pixel) {
    const Surface surface = surface_at(x, y, extent);
    const float tilt = surface == Surface::bar ? 0.4f : 0.1f * std::sin(static_cast<float>(x) * 0.3f);
    pixel[0] = std::sin(tilt);
    pixel[1] = 0.0f;
    pixel[2] = surface == Surface::sky ? 0.0f : std::cos(tilt);
}

void colour_pixel(uint32_t x, uint32_t y, uint32_t seed, float* pixel) {
    for (uint32_t c = 0; c < 4; ++c) {
        const float wave =
            0.5f + 0.5f * std::sin(static_cast<float>(x * (c + 2)) * 0.23f + static_cast<float>(y) * 0.31f);
        pixel[c] = 0.6f * wave + 0.4f * hash(x, y, seed + c);
    }
    // A few small bright lights.
    if (hash(x / 2, y / 2, seed + 77) > 0.985f)
        for (uint32_t c = 0; c < 3; ++c)
            pixel[c] *= 20.0f;
    pixel[3] = 0.5f + 0.5f * pixel[3];
}

} // namespace

FloatImage fixture_image(const ImageRole& role, Extent extent, uint32_t seed) {
    const char* name = role.name;
    uint32_t salt = seed;
    for (const char* c = name; *c; ++c)
        salt = salt * 31 + static_cast<uint32_t>(*c);
    if (contains(name, "mask"))
        return make_image(extent, 1, [&](uint32_t x, uint32_t y, float* pixel) {
            const auto third = (3 * x + y + salt % 5) / (1 + extent.width / 2);
            *pixel = third % 2 == 0 ? 0.0f : 0.6f;
        });
    if (contains(name, "velocity") || contains(name, "layer"))
        return make_image(extent, 2, [&](uint32_t x, uint32_t y, float* pixel) {
            vector_pixel(x, y, extent, contains(name, "layer") ? salt : seed + contains(name, "next"), pixel);
            const float strength = contains(name, "layer") ? 0.25f : 1.0f;
            pixel[0] *= strength;
            pixel[1] *= strength;
        });
    if (contains(name, "depth"))
        return make_image(extent, 1, [&](uint32_t x, uint32_t y, float* pixel) { depth_pixel(x, y, extent, pixel); });
    if (contains(name, "normal"))
        return make_image(extent, 3, [&](uint32_t x, uint32_t y, float* pixel) { normal_pixel(x, y, extent, pixel); });
    return make_image(extent, 4, [&](uint32_t x, uint32_t y, float* pixel) { colour_pixel(x, y, salt, pixel); });
}

Frame fixture_frame(uint64_t index, Extent extent) {
    const auto camera = [&](double time) {
        Camera made;
        const auto aspect = static_cast<float>(extent.width) / static_cast<float>(extent.height);
        const auto angle = static_cast<float>(0.01 * time);
        made.projection = {1.8f / aspect, 0, 0, 0, 0, -1.8f, 0, 0, 0, 0, 0, -1, 0, 0, 0.1f, 0};
        made.world_to_view = {std::cos(angle),
                              0,
                              std::sin(angle),
                              0,
                              0,
                              1,
                              0,
                              0,
                              -std::sin(angle),
                              0,
                              std::cos(angle),
                              0,
                              static_cast<float>(0.02 * time),
                              0,
                              0,
                              1};
        return made;
    };
    Frame frame;
    frame.index = index;
    frame.time_step = 1.0f / 24.0f;
    frame.camera = camera(static_cast<double>(index));
    frame.previous_camera = camera(static_cast<double>(index) - 1.0);
    frame.next_camera = camera(static_cast<double>(index) + 1.3);
    return frame;
}

void set_fixture(EffectRig& rig, const EffectInfo& effect, Extent extent, bool optional, uint32_t seed) {
    rig.optional_outputs = optional;
    for (const ImageRole& role : effect.images) {
        if (role.is_output())
            continue;
        if (role.use == ImageUse::input || optional)
            rig.set(role.name, fixture_image(role, extent, seed));
        else
            rig.remove(role.name);
    }
}

EffectFacts effect_facts(const EffectInfo& effect) {
    for (const EffectFacts& known : facts)
        if (std::strcmp(known.effect, effect.name) == 0)
            return known;
    return {effect.name, 128, {}};
}

std::vector<const EffectInfo*> all_effects() {
    return {effects().begin(), effects().end()};
}

std::string effect_test_name(const testing::TestParamInfo<const EffectInfo*>& info) {
    std::string name = info.param->name;
    for (char& c : name)
        c = c == '-' ? '_' : c;
    return name;
}

void apply_settings(ParameterSet& parameters, const char* settings) {
    std::istringstream words(settings);
    for (std::string word; words >> word;) {
        const size_t equals = word.find('=');
        expect_done(
            set_parameter(parameters.table(), parameters.data(), word.substr(0, equals), word.substr(equals + 1)),
            settings);
    }
}

ParameterSet EffectTest::defaults() const {
    ParameterSet parameters(*effect().parameters);
    apply_settings(parameters, effect_facts(effect()).settings);
    return parameters;
}

double EffectTest::maximum_of(const ParameterInfo& info) const {
    std::istringstream words(effect_facts(effect()).maxima);
    for (std::string word; words >> word;)
        if (word.substr(0, word.find('=')) == info.name)
            return std::stod(word.substr(word.find('=') + 1));
    return info.maximum;
}

std::vector<EffectTest::Look> EffectTest::looks_of(std::span<const char* const> all) const {
    std::vector<Look> result;
    for (const char* settings : all) {
        result.emplace_back(settings, defaults());
        apply_settings(result.back().second, effect_facts(effect()).settings);
        apply_settings(result.back().second, settings);
    }
    return result;
}

std::vector<EffectTest::Look> EffectTest::special_looks() const {
    return looks_of(effect_facts(effect()).looks);
}

std::vector<EffectTest::Look> EffectTest::parameter_looks() const {
    return looks_of(effect_facts(effect()).parameter_looks);
}

std::vector<EffectTest::Look> EffectTest::looks() const {
    std::vector<Look> result;
    result.emplace_back("default", defaults());
    for (const Preset& preset : effect().parameters->presets) {
        result.emplace_back(preset.name, defaults());
        expect_done(apply_preset(*effect().parameters, result.back().second.data(), preset.name), "apply_preset");
        apply_settings(result.back().second, effect_facts(effect()).settings);
    }
    return result;
}

} // namespace sfumato::test
