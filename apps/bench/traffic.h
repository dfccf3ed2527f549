// The least memory traffic of a plan: every image that a pass touches, read or written once.
#pragma once

#include "sfumato/plan.h"

#include <cstdint>
#include <string>
#include <vector>

namespace sfumato::bench {

struct PassTraffic {
    std::string pass;
    uint64_t bytes = 0;
    // An indirect dispatch touches a part that only the device knows: `bytes` is the most. Passes of one group share
    // their images between them; each of them is told the group's bytes, and the plan counts them once.
    bool is_upper_bound = false;
    int group = -1;
};

struct PlanTraffic {
    std::vector<PassTraffic> passes;
    uint64_t bytes = 0;   // sum over passes and groups
    uint64_t minimum = 0; // host images alone, each once: what no implementation can do without
};

uint64_t texel_bytes(VkFormat format); // 0 where unknown
PlanTraffic traffic_of(const Plan& plan);

} // namespace sfumato::bench
