// passes: reduce reduce_subgroups scan_blocks scan_blocks_subgroups compact compact_subgroups
// Stable compaction by reduce-then-scan; see compaction.h. Bytes that move for n flags of which m are set: 4 n read,
// then 4 n read and 4 m written.
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
#ifdef PASS_compact_subgroups
#define PASS_compact
#define SUBGROUPS
#endif
#ifdef SUBGROUPS
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#endif

#include "compaction_shared.h"
#include "device_count.glsl"
#include "block_scan.glsl"

layout(local_size_x = 256) in;
layout(set = 1, binding = 0) uniform Constants { CompactionConstants constants; };

#ifdef PASS_reduce
layout(set = 0, binding = 0) readonly buffer Flags { uint flags[]; };
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
        sum += at < count && flags[min(at, count - 1u)] != 0u ? 1u : 0u;
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

#ifdef PASS_compact
layout(constant_id = 0) const bool blocks_are_scanned = false;

layout(set = 0, binding = 0) readonly buffer Flags { uint flags[]; };
layout(set = 0, binding = 1) readonly buffer Count { uint count_words[]; };
layout(set = 0, binding = 2) readonly buffer BlockSums { uint block_sums[]; };
layout(set = 0, binding = 3) writeonly buffer Indices { uint indices[]; };
layout(set = 0, binding = 4) writeonly buffer Survivors { uint survivors[]; };

void write_survivors(uint number) {
    survivors[0] = number;
    const uint group_sizes[4] = uint[4](constants.group_size_0, constants.group_size_1, constants.group_size_2,
                                        constants.group_size_3);
    for (uint i = 0u; i < 4u; ++i) {
        const uint groups = number / group_sizes[i] + (number % group_sizes[i] != 0u ? 1u : 0u);
        survivors[1u + 3u * i] = min(groups, 65535u);
        survivors[2u + 3u * i] = 1u;
        survivors[3u + 3u * i] = 1u;
    }
}

void main() {
    const uint thread = thread_index();
    const uint count = element_count(count_words, constants.count_word, constants.capacity);
    const uint first = gl_WorkGroupID.x * scan_block;
    if (count == 0u && gl_WorkGroupID.x == 0u && thread == 0u)
        write_survivors(0u);
    if (first >= count)
        return;
    [[unroll]] for (uint i = 0u; i < scan_items; ++i) {
        const uint at = i * scan_threads + thread;
        scan_staged[scan_place(at)] = first + at < count ? flags[first + at] : 0u;
    }
    uint before_block = 0u;
    if (blocks_are_scanned)
        before_block = block_sums[gl_WorkGroupID.x];
    else
        sum_of_earlier_blocks(block_sums, gl_WorkGroupID.x, before_block);
    barrier();
    uint set_bits = 0u;
    [[unroll]] for (uint i = 0u; i < scan_items; ++i)
        if (scan_staged[scan_place(thread * scan_items + i)] != 0u)
            set_bits |= 1u << i;
    uint total;
    uint place = workgroup_exclusive_add(bitCount(set_bits), total); // has barriers: all have read their flags
    [[unroll]] for (uint i = 0u; i < scan_items; ++i)
        if ((set_bits >> i & 1u) != 0u)
            scan_staged[scan_place(place++)] = first + thread * scan_items + i;
    barrier();
    for (uint at = thread; at < total; at += scan_threads)
        indices[before_block + at] = scan_staged[scan_place(at)];
    if (count - first <= scan_block && thread == 0u) // the last block
        write_survivors(before_block + total);
}
#endif
