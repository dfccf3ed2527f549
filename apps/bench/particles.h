// What the command `particles` measures: errors against the brute-force truth, and times by the number of particles.
#pragma once

#include "apps/bench/options.h"
#include "apps/bench/report.h"

namespace sfumato::bench {

// Both parts, or the one that options.part names.
Result<void> measure_particles(Rig& rig, const Options& options, const Output& output);

Result<Json> measure_particle_quality(Rig& rig, const Options& options, const Output& output);
Result<Json> measure_particle_times(Rig& rig, const Options& options, const Output& output);

} // namespace sfumato::bench
