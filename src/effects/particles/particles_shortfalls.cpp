// What a frame of particles lacks, in words, and the setting that would help.
#include "effects/particles/particles_plan.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace sfumato {

namespace {

constexpr double deepest = 16.0; // optical depth through one particle, as particles_draw_common.glsl has it

// The least room for everything, or less detail where the room cannot grow so far.
std::string remedy_of_pairs(uint64_t wanted, uint64_t room, const ParticleVolumeParameters& p) {
    const auto count = static_cast<uint64_t>(p.count);
    const uint64_t needed = static_cast<uint64_t>(p.pairs_per_particle) + (wanted - room + count - 1) / count;
    const ParameterInfo* info = ParticleVolumeParameters::table().find("pairs_per_particle");
    if (wanted <= most_pairs && needed <= static_cast<uint64_t>(info->maximum))
        return "pairs_per_particle=" + std::to_string(needed);
    if (p.resolution == ParticleResolution::quarter)
        return "";
    return p.resolution == ParticleResolution::full ? "resolution=half" : "resolution=quarter";
}

// The largest extinction with which no particle is too deep at any age.
std::string remedy_of_depths(const ParticleVolumeParameters& p) {
    const double start = p.radius_start, end = p.radius_end;
    // Radius times extinction is a power of the radius: its greatest value lies at an end.
    const double last = end * std::pow(start / end, 3.0 * p.dilution);
    char text[64];
    std::snprintf(text, sizeof text, "extinction=%.3g", 0.99 * deepest / (2.0 * std::max(start, last)));
    return text;
}

} // namespace

std::vector<Shortfall> particle_shortfalls(const ParticleStatistics& statistics,
                                           const ParticleVolumeParameters& parameters) {
    std::vector<Shortfall> result;
    const uint64_t wanted = statistics.pairs_wanted, room = statistics.pairs;
    if (wanted > room)
        result.push_back({"pairs", static_cast<double>(wanted - room),
                          std::to_string(wanted) + " pairs of particle and screen tile wanted, room for " +
                              std::to_string(room) + ", the farthest are left out",
                          remedy_of_pairs(wanted, room, parameters)});
    if (statistics.overflow & 2u)
        result.push_back(
            {"optical depth", 1.0, "optical depths of single particles were cut at 16", remedy_of_depths(parameters)});
    return result;
}

} // namespace sfumato
