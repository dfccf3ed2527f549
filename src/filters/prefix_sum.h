// Sums of all earlier numbers of an array, on the device, as passes of a plan.
//
// Reduce, then scan: sums of blocks of 2048 numbers first, then each block again with what stands before it. Up to
// 2048 blocks (4 million numbers) each block adds up the sums of the blocks before it itself, which costs less than the
// dispatch and the barrier of a pass between; beyond that there is one. No workgroup waits for another.
#pragma once

#include "filters/device_count.h"

namespace sfumato {

// Numbers that one workgroup sums.
inline constexpr uint32_t prefix_sum_block = 2048;
inline constexpr uint32_t prefix_sum_most = 65535 * prefix_sum_block;

enum class PrefixSumKind {
    exclusive, // sums[i] = numbers[0] + … + numbers[i - 1]
    inclusive, // sums[i] = numbers[0] + … + numbers[i]
};

struct PrefixSum {
    ResourceId sums = no_resource;  // buffer of count.capacity uint32; beyond the count not written
    ResourceId total = no_resource; // buffer of one uint32: the sum of all; 0 where the count is 0
};

// `numbers`: buffer of at least count.capacity uint32, left as it is; what lies beyond the count is not read. Sums wrap
// around at 2^32. count.capacity: 1…prefix_sum_most. Both results are transient buffers of the plan.
PrefixSum plan_prefix_sum(Planner& planner, ResourceId numbers, const DeviceCount& count, PrefixSumKind kind);

// Bytes of transient buffers that plan_prefix_sum adds to a plan, the results included.
uint64_t prefix_sum_scratch_bytes(uint32_t capacity);

} // namespace sfumato
