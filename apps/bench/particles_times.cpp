// Times of particles by their number: a ball of simulated particles over half of the picture, as large as makes their
// mean footprint what the options say, so that only the number changes from row to row.
#include "apps/bench/particles.h"

#include "apps/bench/pictures.h"

#include "scene/particle_truth.h"
#include "sfumato/effects/particles.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace sfumato::bench {
namespace {

constexpr double focal = 1.2; // image heights
constexpr double distance = 4.0;

constexpr Extent texture{256, 256};

struct Images {
    apps::HostImage colour, depth, output, profile;
};

// A ring with spokes.
std::vector<float> texture_values() {
    std::vector<float> values;
    for (uint32_t y = 0; y < texture.height; ++y)
        for (uint32_t x = 0; x < texture.width; ++x) {
            const double u = 2.0 * (x + 0.5) / texture.width - 1.0, v = 2.0 * (y + 0.5) / texture.height - 1.0;
            const double rho = u * u + v * v;
            const double spokes = 1.0 + 0.5 * std::cos(7.0 * std::atan2(v, u));
            values.push_back(static_cast<float>(std::max(0.0, rho * (1.0 - rho)) * spokes));
        }
    return values;
}

Result<Images> make_images(Rig& rig, Extent extent) {
    Images images;
    auto& device = rig.device();
    for (auto [image, format] : {std::pair{&images.colour, VK_FORMAT_R16G16B16A16_SFLOAT},
                                 {&images.depth, VK_FORMAT_R32_SFLOAT},
                                 {&images.output, VK_FORMAT_R16G16B16A16_SFLOAT}}) {
        auto made = device.create_image(format, extent);
        if (!made)
            return made.error();
        *image = std::move(*made);
    }
    auto profile = device.create_image(VK_FORMAT_R32_SFLOAT, texture);
    if (!profile)
        return profile.error();
    images.profile = std::move(*profile);
    if (auto done = device.upload(images.profile, texture_values(), 1); !done)
        return done.error();
    const size_t pixels = size_t{extent.width} * extent.height;
    if (auto done = device.upload(images.depth, std::vector<float>(pixels, 1e10f), 1); !done)
        return done.error();
    return images;
}

// All are born at once and hang still: the simulation's work is done all the same.
ParticleVolumeParameters ball(int count, Extent extent, ParticleMode mode, ParticleResolution resolution,
                              double footprint) {
    ParticleVolumeParameters p;
    const double pixels = focal * extent.height / distance; // that a scene unit takes
    const double half = 0.5 * extent.width * extent.height; // of the picture is covered
    p.count = p.burst = count;
    p.rate = 0.0f;
    p.emitter = ParticleEmitter::sphere;
    p.emitter_size = static_cast<float>(std::sqrt(half / 3.14159265) / pixels);
    p.speed = p.gravity = p.drag = 0.0f;
    p.warm_up = 0.0f;
    p.lifetime = 1000.0f;
    p.fade_in = p.fade_out = 0.0f;
    p.radius_start = p.radius_end = static_cast<float>(0.5 * footprint / pixels);
    // Optical depth through the ball stays 6, however many there are.
    const double area = static_cast<double>(count) * 0.25 * footprint * footprint * 3.14159265 / half;
    p.extinction = static_cast<float>(6.0 / (area * 4.0 / 3.0 * double{p.radius_start}));
    // Tiles of 16 pixels that a disc touches.
    const double tiles = footprint / 16.0 + 1.0;
    p.pairs_per_particle = std::max(p.pairs_per_particle, static_cast<int>(tiles * tiles));
    p.sort_bits = ParticleSortBits::bits_16;
    p.mode = mode;
    p.layers = 32;
    p.slices = 64;
    p.resolution = resolution;
    return p;
}

using PassTimes = std::vector<std::pair<std::string, std::vector<double>>>;

void add(PassTimes& all, const std::vector<PassTime>& times) {
    std::map<std::string, double> sums; // a pass may run several times
    for (const PassTime& time : times)
        sums[time.pass] += time.milliseconds;
    for (const PassTime& time : times) {
        const auto sum = sums.find(time.pass);
        if (sum == sums.end())
            continue;
        auto row = std::ranges::find(all, time.pass, &PassTimes::value_type::first);
        if (row == all.end())
            row = all.insert(all.end(), {time.pass, {}});
        row->second.push_back(sum->second);
        sums.erase(sum);
    }
}

struct Run {
    PassTimes passes;
    std::vector<double> totals;
    ParticleStatistics statistics{};
    MemoryUsage memory;
};

Result<Run> run(Rig& rig, const ParticleVolumeParameters& parameters, Extent extent, int frames) {
    auto images = make_images(rig, extent);
    auto context = rig.create_context(1, true);
    if (!images || !context)
        return !images ? images.error() : context.error();
    auto effect = ParticleVolume::create(**context);
    auto report = rig.device().create_buffer(sizeof(ParticleStatistics));
    if (!effect || !report)
        return !effect ? effect.error() : report.error();
    ParticleVolumeImages bound{};
    bound.colour = images->colour.image();
    bound.depth = images->depth.image();
    bound.output = images->output.image();
    bound.profile = images->profile.image();
    bound.statistics = report->buffer();
    Frame frame;
    frame.camera = frame.previous_camera = scene::look_at({0, 0, distance}, {0, 0, 0}, focal, extent);
    Run result;
    constexpr int warm = 3;
    for (int i = 0; i < frames + warm; ++i) {
        frame.index = static_cast<uint64_t>(i);
        frame.reset = i == 0;
        auto commands = rig.device().begin();
        if (!commands)
            return commands.error();
        if (auto done = (*effect)->record(*commands, frame, parameters, bound); !done)
            return done.error();
        if (auto done = rig.device().submit_and_wait(); !done)
            return done.error();
        if (i < warm)
            continue;
        const std::vector<PassTime> times = (*effect)->times();
        double total = 0.0;
        for (const PassTime& time : times)
            total += time.milliseconds;
        add(result.passes, times);
        result.totals.push_back(total);
    }
    std::copy_n(report->bytes().data(), sizeof(result.statistics), reinterpret_cast<std::byte*>(&result.statistics));
    result.memory = (*context)->memory_usage();
    return result;
}

const char* name_of(ParticleMode mode) {
    return mode == ParticleMode::half_angle ? "half-angle 64" : "light-volume 32";
}

ParticleProfile profile_named(const std::string& name) {
    return name == "noise"     ? ParticleProfile::noise
           : name == "texture" ? ParticleProfile::texture
                               : ParticleProfile::sphere;
}

} // namespace

Result<Json> measure_particle_times(Rig& rig, const Options& options, const Output& output) {
    const Extent extent = !options.sizes.empty() ? options.sizes.front()
                          : rig.is_cpu()         ? Extent{256, 144}
                                                 : Extent{1920, 1080};
    const int frames = options.frames > 0 ? options.frames : rig.is_cpu() ? 3 : 100;
    std::vector<int> counts = options.particle_counts;
    if (counts.empty())
        for (int bits = 14; bits <= (rig.is_cpu() ? 16 : 22); bits += rig.is_cpu() ? 1 : 2)
            counts.push_back(1 << bits);
    Json rows = Json::array();
    Table table({"mode", "resolution", "particles", "drawn", "pairs", "left out", "MB", "GPU ms", "least"}, 2);
    std::string details;
    for (const int count : counts)
        for (const auto mode : {ParticleMode::light_volume, ParticleMode::half_angle})
            for (const auto resolution : {ParticleResolution::full, ParticleResolution::half}) {
                output.progress("particles: " + std::to_string(count));
                ParticleVolumeParameters parameters = ball(count, extent, mode, resolution, options.footprint);
                parameters.profile = profile_named(options.profile);
                const auto result = run(rig, parameters, extent, frames);
                if (!result)
                    return result.error();
                const Statistics total = statistics(result->totals);
                const ParticleStatistics& s = result->statistics;
                const uint64_t bytes = result->memory.transients + result->memory.histories;
                const char* size = resolution == ParticleResolution::full ? "full" : "half";
                table.add({name_of(mode), size, std::to_string(count), std::to_string(s.drawn), std::to_string(s.pairs),
                           std::to_string(s.pairs_wanted - s.pairs), fixed(static_cast<double>(bytes) * 1e-6, 0),
                           fixed(total.median, 3), fixed(total.minimum, 3)});
                Json passes = Json::array();
                Table pass_table({"pass", "GPU ms"}, 1);
                for (const auto& [pass, times] : result->passes) {
                    const Statistics time = statistics(times);
                    passes.push_back({{"pass", pass}, {"ms", statistics_json(time)}});
                    pass_table.add({pass, fixed(time.median, 4)});
                }
                if (options.passes && count == counts.back())
                    details += "\n" + std::string(name_of(mode)) + ", " + size + ", " + std::to_string(count) +
                               " particles\n" + pass_table.text();
                rows.push_back({{"mode", name_of(mode)},
                                {"resolution", size},
                                {"particles", count},
                                {"drawn", s.drawn},
                                {"pairs", s.pairs},
                                {"pairs_left_out", s.pairs_wanted - s.pairs},
                                {"bytes", bytes},
                                {"ms", statistics_json(total)},
                                {"passes", passes}});
            }
    output.print("Time, " + std::to_string(extent.width) + "x" + std::to_string(extent.height) + ", particles " +
                 fixed(options.footprint, 0) + " px across, profile " + options.profile +
                 ": simulation, sorting, shadows, drawing; the sum of all passes\n" + table.text() + details);
    return Json{{"extent", {extent.width, extent.height}},
                {"footprint", options.footprint},
                {"profile", options.profile},
                {"rows", rows}};
}

Result<void> measure_particles(Rig& rig, const Options& options, const Output& output) {
    if (!options.pictures.empty() && options.part == "times")
        return Error{ErrorCode::invalid_argument, "--pictures shows what --part quality measures, not times"};
    if (options.profile != "sphere" && options.part == "quality")
        return Error{ErrorCode::invalid_argument, "--profile is for the particles that --part times measures"};
    if (auto made = make_picture_folder(options.pictures); !made) // before minutes of work
        return made.error();
    output.print(header_text("particles", rig));
    Json json{{"command", "particles"}, {"device", device_json(rig)}};
    if (options.part != "times") {
        auto quality = measure_particle_quality(rig, options, output);
        if (!quality)
            return quality.error();
        json["quality"] = *quality;
    }
    if (options.part != "quality") {
        if (!rig.device().timestamps())
            return Error{ErrorCode::unsupported, "the device has no timestamps; --part quality needs none"};
        auto times = measure_particle_times(rig, options, output);
        if (!times)
            return times.error();
        json["times"] = *times;
    }
    return output.write(json);
}

} // namespace sfumato::bench
