// Stable ascending sort of (key, value) pairs on the device, as passes of a plan.
//
// Least significant digit first, 8 bits a pass, reduce-then-scan (Merrill and Grimshaw, Revisiting Sorting for GPGPU
// Stream Architectures, 2010): histogram of each block, scan of the histograms, stable scatter. No workgroup waits for
// another, so no forward progress is asked of the device. Three dispatches for every digit.
#pragma once

#include "filters/device_count.h"

namespace sfumato {

// Buffers of uint32, the pairs' first `count` elements.
struct SortedPairs {
    ResourceId keys = no_resource;
    ResourceId values = no_resource;
};

// Pairs that one workgroup sorts.
inline constexpr uint32_t radix_sort_block = 2048;
// A plan's dispatches have at most 65535 workgroups.
inline constexpr uint32_t radix_sort_most = 65535 * radix_sort_block;

struct RadixSortOptions {
    // Dispatches from a VkDispatchIndirectCommand with ceil(count / radix_sort_block) groups in x, 1 in y and z, at
    // `arguments_offset` bytes into this buffer, such as compaction makes. Without, the capacity is dispatched and
    // blocks beyond the count end at once: that costs less than a pass and a barrier that would make the command,
    // unless the capacity is in the millions and the count far below it.
    ResourceId arguments = no_resource;
    uint64_t arguments_offset = 0;
    // Lets the sort overwrite `keys` and `values`: of more than one digit it then needs one pair of buffers, not two,
    // and the result may be in the inputs. Ignored without values.
    bool overwrite_input = false;
};

// Sorts by the low `bits` bits (1…32) of the keys; pairs with equal bits there keep their order. Digits are made as
// even as can be: 16 bits are two digits of 8, 20 bits 7 + 7 + 6.
// `keys`: buffer of at least count.capacity uint32; `values`: the same, or no_resource for values 0, 1, 2 …, which are
// then not read. Inputs are left as they are unless the options say otherwise. What lies beyond the count is neither
// read nor written. The result is in transient buffers of the plan (or in the inputs, see overwrite_input), and holds
// whole keys, not only their low bits. count.capacity: 1…radix_sort_most.
SortedPairs plan_radix_sort(Planner& planner, ResourceId keys, ResourceId values, const DeviceCount& count,
                            uint32_t bits, const RadixSortOptions& options = {});

// Bytes of transient buffers that plan_radix_sort adds to a plan, the sorted result included.
uint64_t radix_sort_scratch_bytes(uint32_t capacity, uint32_t bits, bool overwrite_input = false);

} // namespace sfumato
