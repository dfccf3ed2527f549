// passes: histogram scan scatter scatter_subgroups
// One digit of a stable radix sort of (key, value) pairs. A block of 2048 pairs belongs to one workgroup of 256:
//   histogram  counts the block's digits: table[block][digit]
//   scan       turns each column of the table into how many pairs of earlier blocks have that digit; and its total
//   scatter    ranks the block's pairs by digit, puts them in order in shared memory, and writes each digit's run
// Bytes that move for n pairs: 4 n read by the histogram; 8 n read (4 n where values are indices) and 8 n written by the
// scatter; 4 n / 2048 * 256 = n / 2 of table written once, read and written once, read once: 22 n a digit.
#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require

#ifdef PASS_scatter_subgroups
#define PASS_scatter
#define SUBGROUPS
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#endif

#include "radix_sort_shared.h"
#include "device_count.glsl"

layout(local_size_x = 256) in;
layout(set = 1, binding = 0) uniform Constants { RadixSortConstants constants; };

const uint threads = 256u;
const uint items = 8u; // pairs of a thread
const uint block = threads * items;

#ifdef PASS_histogram
#include "radix_digit.glsl"

layout(set = 0, binding = 0) readonly buffer Keys { uint keys[]; };
layout(set = 0, binding = 1) readonly buffer Count { uint count_words[]; };
layout(set = 0, binding = 2) writeonly buffer Table { uint table[]; };

shared uint bins[radix_bins];

void main() {
    const uint thread = gl_LocalInvocationIndex;
    const uint count = element_count(count_words, constants.count_word, constants.capacity);
    const uint first = gl_WorkGroupID.x * block;
    if (first >= count)
        return;
    uint mine[items]; // all on their way before the first is used
    [[unroll]] for (uint i = 0u; i < items; ++i)
        mine[i] = keys[min(first + i * threads + thread, count - 1u)];
    bins[thread] = 0u;
    barrier();
    [[unroll]] for (uint i = 0u; i < items; ++i)
        if (first + i * threads + thread < count)
            atomicAdd(bins[digit_of(mine[i])], 1u);
    barrier();
    table[gl_WorkGroupID.x * radix_bins + thread] = bins[thread];
}
#endif

#ifdef PASS_scan
// A workgroup has four neighbouring columns and cuts them into 64 stretches of blocks, so that neighbouring threads read
// neighbouring words. Few numbers: waiting for memory is what it costs, hence the batches.
layout(set = 0, binding = 0) readonly buffer Count { uint count_words[]; };
layout(set = 0, binding = 1) buffer Table { uint table[]; };

const uint bins_of_group = 4u; // as in radix_sort.cpp
const uint stretches = threads / bins_of_group;
const uint batch = 8u;

shared uint sums[threads];

void main() {
    const uint thread = gl_LocalInvocationIndex;
    const uint count = element_count(count_words, constants.count_word, constants.capacity);
    const uint blocks = (count + block - 1u) / block;
    const uint bin = gl_WorkGroupID.x * bins_of_group + thread % bins_of_group;
    const uint stretch = thread / bins_of_group;
    const uint length_of_stretch = (blocks + stretches - 1u) / stretches;
    const uint begin = min(stretch * length_of_stretch, blocks);
    const uint end = min(begin + length_of_stretch, blocks);
    uint sum = 0u;
    for (uint at = begin; at < end; at += batch) {
        [[unroll]] for (uint i = 0u; i < batch; ++i)
            sum += at + i < end ? table[(at + i) * 256u + bin] : 0u;
    }
    sums[thread] = sum;
    barrier();
    for (uint step = bins_of_group; step < threads; step *= 2u) {
        const uint left = thread >= step ? sums[thread - step] : 0u;
        barrier();
        sums[thread] += left;
        barrier();
    }
    uint before = sums[thread] - sum;
    if (stretch == stretches - 1u)
        table[constants.totals + bin] = sums[thread];
    for (uint at = begin; at < end; at += batch) {
        uint counts[batch];
        [[unroll]] for (uint i = 0u; i < batch; ++i)
            counts[i] = at + i < end ? table[(at + i) * 256u + bin] : 0u;
        [[unroll]] for (uint i = 0u; i < batch; ++i) {
            if (at + i < end)
                table[(at + i) * 256u + bin] = before;
            before += counts[i];
        }
    }
}
#endif

#ifdef PASS_scatter
#include "radix_scatter.glsl"
#endif
