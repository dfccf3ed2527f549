// The indices of those elements whose flag is set, in order, on the device, as passes of a plan; with their number and
// commands that dispatch over them.
//
// Reduce, then scan, as in prefix_sum.h. The order is that of the input, frame by frame: what is sorted or drawn by the
// indices does not flicker, as it does where survivors are appended by atomics.
#pragma once

#include "filters/device_count.h"

#include <array>

namespace sfumato {

// Flags that one workgroup looks at.
inline constexpr uint32_t compaction_block = 2048;
inline constexpr uint32_t compaction_most = 65535 * compaction_block;

struct Compaction {
    ResourceId indices = no_resource; // buffer of count.capacity uint32; beyond the number of survivors not written
    // Buffer of 13 uint32: the number of survivors, then for each of the group sizes a VkDispatchIndirectCommand with
    // ceil(survivors / group size) groups in x and 1 in y and z (65535 groups at most).
    ResourceId survivors = no_resource;

    DeviceCount count(uint32_t capacity) const { return {survivors, 0, capacity}; }
    static constexpr uint64_t arguments_offset(uint32_t group_size_number) { return 4 + 12 * group_size_number; }
};

// `flags`: buffer of at least count.capacity uint32, 0 for what goes and anything else for what stays; what lies beyond
// the count is not read and goes. `group_sizes`: elements a workgroup of the dispatches to come, at least 1 each; for
// plan_radix_sort it is radix_sort_block. count.capacity: 1…compaction_most. Both results are transient buffers.
Compaction plan_compaction(Planner& planner, ResourceId flags, const DeviceCount& count,
                           const std::array<uint32_t, 4>& group_sizes = {256, 256, 256, 256});

// Bytes of transient buffers that plan_compaction adds to a plan, the results included.
uint64_t compaction_scratch_bytes(uint32_t capacity);

} // namespace sfumato
