// Errors of particles against the brute-force truth, and what must not change: with the side that the light comes from,
// the number of slices, the resolution, or from one run to the next.
#include "apps/bench/particles.h"

#include "apps/bench/pictures.h"
#include "scene/particle_truth.h"
#include "scene/vec3.h"
#include "sfumato/effects/particles.h"

#include <cmath>
#include <cstring>

namespace sfumato::bench {
namespace {

struct Setting {
    const char* name;
    ParticleMode mode;
    int layers;
};

constexpr Setting settings[] = {
    {"light-volume 8", ParticleMode::light_volume, 8},   {"light-volume 16", ParticleMode::light_volume, 16},
    {"light-volume 32", ParticleMode::light_volume, 32}, {"light-volume 64", ParticleMode::light_volume, 64},
    {"half-angle 16", ParticleMode::half_angle, 16},     {"half-angle 64", ParticleMode::half_angle, 64},
    {"half-angle 256", ParticleMode::half_angle, 256},
};

ParticleVolumeParameters parameters_of(const Setting& setting) {
    ParticleVolumeParameters p;
    p.mode = setting.mode;
    (p.mode == ParticleMode::half_angle ? p.slices : p.layers) = setting.layers;
    p.phase = p.ambient = p.near_fade = p.soft_distance = p.scene_shadow = 0.0f;
    p.pairs_per_particle = 64;
    return p;
}

// The standard cloud before black, lit from one side.
class Studio {
  public:
    static Result<std::unique_ptr<Studio>> create(Rig& rig, Extent extent, uint32_t count) {
        std::unique_ptr<Studio> studio(new Studio(rig, extent));
        // As dense as makes the middle opaque, whatever the number.
        const double radius = 0.09 * std::cbrt(20000.0 / count);
        studio->sprites_ = scene::particle_cloud(
            {.count = count, .radius = static_cast<float>(radius), .extinction = static_cast<float>(0.0486 / radius)});
        if (auto made = studio->make(); !made)
            return made.error();
        return studio;
    }

    // `eye` and `light`: degrees about the upright axis.
    Frame frame(double eye, double light) {
        Frame frame;
        const double e = scene::radians(eye), l = scene::radians(light), tilt = scene::radians(25.0);
        frame.camera = scene::look_at({4.0 * std::sin(e), 0, 4.0 * std::cos(e)}, {0, 0, 0}, 1.5, extent_);
        light_.to_light = {static_cast<float>(std::sin(l) * std::cos(tilt)), static_cast<float>(std::sin(tilt)),
                           static_cast<float>(std::cos(l) * std::cos(tilt))};
        light_.radiance = {12.5663706f, 12.5663706f, 12.5663706f};
        frame.lights = {&light_, 1};
        return frame;
    }

    scene::ParticleTruth truth(const Frame& frame) const {
        return scene::particle_truth(sprites_, frame, parameters_of(settings[0]), extent_);
    }

    Result<std::vector<float>> draw(const Frame& frame, const ParticleVolumeParameters& parameters) {
        auto effect = ParticleVolume::create(*context_);
        if (!effect)
            return effect.error();
        ParticleVolumeImages images{};
        images.colour = colour_.image();
        images.depth = depth_.image();
        images.output = output_.image();
        images.sprites = buffer_.buffer();
        auto commands = rig_.device().begin();
        if (!commands)
            return commands.error();
        if (auto done = (*effect)->record(*commands, frame, parameters, images); !done)
            return done.error();
        if (auto done = rig_.device().submit_and_wait(); !done)
            return done.error();
        return rig_.device().readback(output_);
    }

    size_t count() const { return sprites_.size(); }

  private:
    Studio(Rig& rig, Extent extent) : rig_(rig), extent_(extent) {}

    Result<void> make() {
        auto context = rig_.create_context(1, false);
        if (!context)
            return context.error();
        context_ = std::move(*context);
        auto buffer = rig_.device().create_buffer(sprites_.size() * sizeof(ParticleSprite));
        if (!buffer)
            return buffer.error();
        buffer_ = std::move(*buffer);
        std::memcpy(buffer_.bytes().data(), sprites_.data(), buffer_.bytes().size());
        for (auto [image, format] : {std::pair{&colour_, VK_FORMAT_R16G16B16A16_SFLOAT},
                                     {&depth_, VK_FORMAT_R32_SFLOAT},
                                     {&output_, VK_FORMAT_R32G32B32A32_SFLOAT}}) {
            auto made = rig_.device().create_image(format, extent_);
            if (!made)
                return made.error();
            *image = std::move(*made);
        }
        return rig_.device().upload(depth_, std::vector<float>(size_t{extent_.width} * extent_.height, 1e10f), 1);
    }

    Rig& rig_;
    Extent extent_;
    Light light_;
    std::vector<ParticleSprite> sprites_;
    std::unique_ptr<Context> context_;
    apps::HostBuffer buffer_;
    apps::HostImage colour_, depth_, output_;
};

double rms(const std::vector<float>& a, const std::vector<float>& b) {
    double sum = 0.0;
    for (size_t i = 0; i < a.size(); ++i)
        sum += i % 4 < 3 ? std::pow(double{a[i]} - double{b[i]}, 2) : 0.0;
    return std::sqrt(sum / (0.75 * static_cast<double>(a.size())));
}

double rms(const scene::ParticleTruth& a, const scene::ParticleTruth& b) {
    double sum = 0.0;
    for (size_t i = 0; i < a.colour.size(); ++i)
        sum += std::pow(a.colour[i] - b.colour[i], 2);
    return std::sqrt(sum / static_cast<double>(a.colour.size()));
}

// -log of what comes through, over all pixels: the cloud's mass as it is seen.
double mass(const std::vector<float>& picture) {
    double sum = 0.0;
    for (size_t i = 3; i < picture.size(); i += 4)
        sum -= std::log(std::max(1.0 - double{picture[i]}, 1e-3));
    return sum;
}

Json error_json(const scene::ParticleError& error) {
    return {{"rmse", error.rmse}, {"bias", error.bias}, {"p99", error.p99}};
}

Result<Json> measure_errors(Studio& studio, const Output& output) {
    Table table({"degrees between eye and light", "setting", "RMSE", "bias %", "P99"}, 2);
    Json rows = Json::array();
    for (const double angle : {40.0, 110.0, 150.0}) {
        output.progress("particles: truth at " + fixed(angle, 0) + " degrees");
        const Frame frame = studio.frame(0.0, angle);
        const scene::ParticleTruth truth = studio.truth(frame);
        const auto measure = [&](const char* name, const ParticleVolumeParameters& parameters) -> Result<void> {
            auto picture = studio.draw(frame, parameters);
            if (!picture)
                return picture.error();
            const scene::ParticleError error = scene::particle_error(truth, *picture, 4);
            table.add({fixed(angle, 0), name, fixed(error.rmse, 4), fixed(100.0 * error.bias, 1), fixed(error.p99, 4)});
            rows.push_back({{"angle", angle}, {"setting", name}, {"error", error_json(error)}});
            return {};
        };
        ParticleVolumeParameters nothing = parameters_of(settings[0]);
        nothing.shadow_colour_r = nothing.shadow_colour_g = nothing.shadow_colour_b = 0.0f;
        if (auto done = measure("no shadows", nothing); !done)
            return done.error();
        for (const Setting& setting : settings)
            if (auto done = measure(setting.name, parameters_of(setting)); !done)
                return done.error();
    }
    output.print(table.text());
    return rows;
}

// What must not change, or little.
Result<Json> measure_invariants(Studio& studio, const Output& output) {
    Table table(
        {"setting", "flip across v.l = 0", "twice the slices", "half resolution", "mass, half / full", "repeat"}, 1);
    Json rows = Json::array();
    const scene::ParticleTruth before = studio.truth(studio.frame(0.25, 90.0));
    const scene::ParticleTruth after = studio.truth(studio.frame(-0.25, 90.0));
    table.add({"truth", fixed(rms(before, after), 4), "-", "-", "-", "-"});
    rows.push_back({{"setting", "truth"}, {"flip", rms(before, after)}});
    for (const Setting& setting : {settings[1], settings[2], settings[5]}) {
        const ParticleVolumeParameters p = parameters_of(setting);
        ParticleVolumeParameters twice = p, half = p;
        twice.slices *= 2;
        twice.layers *= 2;
        half.resolution = ParticleResolution::half;
        const auto a = studio.draw(studio.frame(0.25, 90.0), p), b = studio.draw(studio.frame(-0.25, 90.0), p);
        const auto again = studio.draw(studio.frame(-0.25, 90.0), p);
        const auto more = studio.draw(studio.frame(-0.25, 90.0), twice);
        const auto less = studio.draw(studio.frame(-0.25, 90.0), half);
        for (const auto* result : {&a, &b, &again, &more, &less})
            if (!*result)
                return result->error();
        const bool is_equal = *b == *again;
        const double kept = mass(*less) / mass(*b);
        table.add({setting.name, fixed(rms(*a, *b), 4), fixed(rms(*b, *more), 4), fixed(rms(*b, *less), 4),
                   fixed(kept, 4), is_equal ? "equal bits" : "DIFFERS"});
        rows.push_back({{"setting", setting.name},
                        {"flip", rms(*a, *b)},
                        {"twice_the_slices", rms(*b, *more)},
                        {"half_resolution", rms(*b, *less)},
                        {"mass_half_to_full", kept},
                        {"repeats_equal", is_equal}});
    }
    output.print(table.text());
    return rows;
}

// Luminances of one picture after the other, as they are shown.
class Sheet {
  public:
    Sheet(Extent cell, size_t columns, size_t rows) : cell_(cell), columns_(columns) {
        planes_.width = static_cast<int>(cell.width * columns);
        planes_.height = static_cast<int>(cell.height * rows);
        planes_.channels.assign(1, std::vector<float>(planes_.pixel_count()));
    }

    // `value` of a cell's pixel by its number.
    template <class Value>
    void add(const Value& value) {
        const size_t left = next_ % columns_ * cell_.width, top = next_ / columns_ * cell_.height;
        for (size_t y = 0; y < cell_.height; ++y)
            for (size_t x = 0; x < cell_.width; ++x)
                planes_.channels[0][(top + y) * columns_ * cell_.width + left + x] =
                    static_cast<float>(value(y * cell_.width + x));
        ++next_;
    }

    Result<void> write(const std::string& path) const { return write_png(path, planes_); }

  private:
    Extent cell_;
    size_t columns_, next_ = 0;
    media::Planes planes_;
};

double shown(double light) {
    return std::pow(std::clamp(light, 0.0, 1.0), 1.0 / 2.2);
}

// The clouds are grey under white light: the green channel tells all.
Result<void> write_pictures(Rig& rig, const std::string& folder, const Output& output) {
    constexpr Extent extent{200, 176};
    auto studio = Studio::create(rig, extent, 12000);
    if (!studio)
        return studio.error();
    std::vector<float> picture;
    const auto draw = [&](ParticleMode mode, int layers, double eye, double light) -> Result<void> {
        auto drawn = (*studio)->draw((*studio)->frame(eye, light), parameters_of({"", mode, layers}));
        if (!drawn)
            return drawn.error();
        picture = std::move(*drawn);
        return {};
    };
    const auto light_of = [&](size_t i) { return shown(double{picture[4 * i + 1]}); };
    Sheet modes(extent, 4, 2), slices(extent, 5, 1), flip(extent, 4, 1);
    const scene::ParticleTruth truth = (*studio)->truth((*studio)->frame(0.0, 60.0));
    modes.add([&](size_t i) { return shown(truth.colour[3 * i + 1]); });
    std::vector<std::vector<double>> differences = {std::vector<double>(truth.transmittance.size())};
    for (const auto& [mode, layers] :
         {std::pair{ParticleMode::light_volume, 16}, {ParticleMode::half_angle, 64}, {ParticleMode::half_angle, 256}}) {
        if (auto done = draw(mode, layers, 0.0, 60.0); !done)
            return done;
        modes.add(light_of);
        for (auto& difference = differences.emplace_back(); difference.size() < truth.transmittance.size();)
            difference.push_back(double{picture[4 * difference.size() + 1]} - truth.colour[3 * difference.size() + 1]);
    }
    for (const std::vector<double>& difference : differences)
        modes.add([&](size_t i) { return std::clamp(0.5 + 4.0 * difference[i], 0.0, 1.0); });
    for (const int count : {8, 16, 32, 64, 256}) {
        if (auto done = draw(ParticleMode::half_angle, count, 0.0, 60.0); !done)
            return done;
        slices.add(light_of);
    }
    for (const auto& [mode, layers] : {std::pair{ParticleMode::half_angle, 64}, {ParticleMode::light_volume, 32}})
        for (const double eye : {0.25, -0.25}) {
            if (auto done = draw(mode, layers, eye, 90.0); !done)
                return done;
            flip.add(light_of);
        }
    for (const auto& [name, sheet] : {std::pair{"modes", &modes}, {"slices", &slices}, {"flip", &flip}})
        if (auto done = sheet->write(folder + "/particles-" + name + ".png"); !done)
            return done;
    output.print("Pictures are in " + folder + "\n");
    return {};
}

} // namespace

Result<Json> measure_particle_quality(Rig& rig, const Options& options, const Output& output) {
    const Extent extent = !options.sizes.empty() && options.part == "quality" ? options.sizes.front()
                          : rig.is_cpu()                                      ? Extent{160, 90}
                                                                              : Extent{480, 270};
    const uint32_t count = !options.particle_counts.empty() && options.part == "quality"
                               ? static_cast<uint32_t>(options.particle_counts.front())
                           : rig.is_cpu() ? 6000
                                          : 40000;
    auto studio = Studio::create(rig, extent, count);
    if (!studio)
        return studio.error();
    output.print("Error against brute force, " + std::to_string(count) + " particles, " + std::to_string(extent.width) +
                 "x" + std::to_string(extent.height) + "\n");
    auto errors = measure_errors(**studio, output);
    if (!errors)
        return errors.error();
    auto invariants = measure_invariants(**studio, output);
    if (!invariants)
        return invariants.error();
    if (!options.pictures.empty())
        if (auto written = write_pictures(rig, options.pictures, output); !written)
            return written.error();
    return Json{{"extent", {extent.width, extent.height}},
                {"particles", count},
                {"errors", *errors},
                {"invariants", *invariants}};
}

} // namespace sfumato::bench
