// The command line of sfumato-bench.
#pragma once

#include "apps/bench/rig.h"
#include "apps/bench/variants.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace sfumato::bench {

struct Options {
    std::string command; // "times", "quality", "frontier", "tune", "sort", "particles", "list"
    VariantRequest variants;
    std::vector<std::string> scenes; // none: those that are for the effect
    std::vector<std::string> raw_files;
    std::vector<std::string> opted_in; // roles that are bound only where asked for
    std::vector<Extent> sizes;         // of times; none: the command's own
    std::optional<Extent> quality_size;
    int frames = 0;     // 0: by the device
    int sub_frames = 0; // 0: by the device
    int rays = 0;       // 0: by the device
    int samples = 2;    // a side, of each pixel
    int batch = 0;      // 0: by the device
    int preroll = 8;    // frames before the one that is scored, where there is a history
    std::string truth_falloff = "hard";
    double warm_up = 0.3;
    bool rotate = true;
    bool passes = true;
    bool ssim = true;
    std::string pictures;
    std::string json;
    RigOptions rig;
    std::vector<int> particle_counts; // of particles; none: by the device
    double footprint = 16.0;          // of particles that are timed, pixels across on the mean
    std::string part = "all";         // of particles: "quality", "times"
    std::string profile = "sphere";   // of particles that are timed
    double budget_ms = 0.0;
    uint64_t seed = 1;
    int evaluations = 200;
    std::vector<std::string> only, fix; // parameters that tune varies, or leaves alone
    std::vector<uint32_t> counts;       // of sort; none: by the device
    std::vector<uint32_t> bits = {16, 32};
    bool sorts_indices = false;
};

struct ParsedOptions {
    Options options;
    bool is_done = false; // help or version was asked for and has been printed
};

// Errors (invalid_argument): what is wrong and what would be right, in one line.
Result<ParsedOptions> parse_options(int argc, char** argv);

} // namespace sfumato::bench
