// passes: reduce reduce_subgroups scan_blocks scan_blocks_subgroups scan scan_subgroups
// Prefix sums by reduce-then-scan; see prefix_sum.h. Bytes that move for n numbers: 4 n read, then 4 n read and 4 n
// written; block sums are n / 512 bytes, of which every block of the last pass reads half on average, from a cache.
#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require

#ifdef PASS_reduce_subgroups
#define PASS_reduce
#define SUBGROUPS
#endif
#ifdef PASS_scan_blocks_subgroups
#define PASS_scan_blocks
#define SUBGROUPS
#endif
#ifdef PASS_scan_subgroups
#define PASS_scan
#define SUBGROUPS
#endif
#ifdef SUBGROUPS
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#endif

#include "prefix_sum_shared.h"
#include "device_count.glsl"
#include "block_scan.glsl"

layout(local_size_x = 256) in;
layout(set = 1, binding = 0) uniform Constants { PrefixSumConstants constants; };

#ifdef PASS_reduce
layout(set = 0, binding = 0) readonly buffer Numbers { uint numbers[]; };
layout(set = 0, binding = 1) readonly buffer Count { uint count_words[]; };
layout(set = 0, binding = 2) writeonly buffer BlockSums { uint block_sums[]; };

void main() {
    const uint count = element_count(count_words, constants.count_word, constants.capacity);
    const uint first = gl_WorkGroupID.x * scan_block;
    if (first >= count)
        return;
    uint sum = 0u;
    [[unroll]] for (uint i = 0u; i < scan_items; ++i) {
        const uint at = first + i * scan_threads + thread_index();
        sum += at < count ? numbers[at] : 0u;
    }
    uint total;
    workgroup_exclusive_add(sum, total);
    if (thread_index() == 0u)
        block_sums[gl_WorkGroupID.x] = total;
}
#endif

#ifdef PASS_scan_blocks
layout(set = 0, binding = 0) readonly buffer Count { uint count_words[]; };
layout(set = 0, binding = 1) buffer BlockSums { uint block_sums[]; };

void main() {
    scan_all_blocks(block_sums, element_count(count_words, constants.count_word, constants.capacity));
}
#endif

#ifdef PASS_scan
layout(constant_id = 0) const bool is_inclusive = false;
layout(constant_id = 1) const bool blocks_are_scanned = false;

layout(set = 0, binding = 0) readonly buffer Numbers { uint numbers[]; };
layout(set = 0, binding = 1) readonly buffer Count { uint count_words[]; };
layout(set = 0, binding = 2) readonly buffer BlockSums { uint block_sums[]; };
layout(set = 0, binding = 3) writeonly buffer Sums { uint sums[]; };
layout(set = 0, binding = 4) writeonly buffer Total { uint sum_of_all; };

void main() {
    const uint thread = thread_index();
    const uint count = element_count(count_words, constants.count_word, constants.capacity);
    const uint first = gl_WorkGroupID.x * scan_block;
    if (count == 0u && gl_WorkGroupID.x == 0u && thread == 0u)
        sum_of_all = 0u;
    if (first >= count)
        return;
    [[unroll]] for (uint i = 0u; i < scan_items; ++i) {
        const uint at = i * scan_threads + thread;
        scan_staged[scan_place(at)] = first + at < count ? numbers[first + at] : 0u;
    }
    uint before_block = 0u;
    if (blocks_are_scanned)
        before_block = block_sums[gl_WorkGroupID.x];
    else
        sum_of_earlier_blocks(block_sums, gl_WorkGroupID.x, before_block);
    barrier();
    uint mine[scan_items];
    uint sum = 0u;
    [[unroll]] for (uint i = 0u; i < scan_items; ++i) {
        mine[i] = scan_staged[scan_place(thread * scan_items + i)];
        sum += mine[i];
    }
    uint total;
    uint before = before_block + workgroup_exclusive_add(sum, total);
    [[unroll]] for (uint i = 0u; i < scan_items; ++i) {
        const uint after = before + mine[i];
        scan_staged[scan_place(thread * scan_items + i)] = is_inclusive ? after : before;
        before = after;
    }
    barrier();
    [[unroll]] for (uint i = 0u; i < scan_items; ++i) {
        const uint at = i * scan_threads + thread;
        if (first + at < count)
            sums[first + at] = scan_staged[scan_place(at)];
    }
    if (count - first <= scan_block && thread == 0u) // the last block
        sum_of_all = before_block + total;
}
#endif
