// The scatter pass of the radix sort. A warp here is 32 threads that follow one another, whatever the subgroups are: it
// owns 256 pairs that follow one another, and takes them 32 at a time, so that loads lie together. Of each 32 it finds
// which threads share a digit, by ballots or through masks in shared memory, and counts digits as it goes along: a
// pair's rank among those of its digit is what the warp counted before, plus the sharing threads to its left. That is
// the order of the input, hence the stability; nothing depends on which thread comes first.
#define SCAN_TYPE uvec2
#include "radix_digit.glsl"
#include "workgroup_scan.glsl"

layout(constant_id = 1) const bool values_are_indices = false;

layout(set = 0, binding = 0) readonly buffer Keys { uint keys[]; };
layout(set = 0, binding = 1) readonly buffer Values { uint values[]; };
layout(set = 0, binding = 2) readonly buffer Count { uint count_words[]; };
layout(set = 0, binding = 3) readonly buffer Table { uint table[]; };
layout(set = 0, binding = 4) writeonly buffer SortedKeys { uint sorted_keys[]; };
layout(set = 0, binding = 5) writeonly buffer SortedValues { uint sorted_values[]; };

const uint warp_width = 32u;
const uint warps = threads / warp_width;
const uint half_bins = radix_bins / 2u;

// Digits d and d + 128 of a warp share a word, 16 bits each: only that warp touches it while ranking.
shared uint warp_counts[warps * half_bins];
shared uint staged[block]; // pairs in order; before that, masks of the threads that share a digit
shared uint digit_start[radix_bins];  // of the digit's run in the block
shared uint digit_target[radix_bins]; // what a place in the block lacks to the place in the output

uint half_shift(uint digit) { return digit / half_bins * 16u; }

#ifdef SUBGROUPS

// Where a subgroup is a whole warp or several, it waits for itself alone.
void wait_for_warp(uint width) {
    if (width == warp_width)
        subgroupBarrier();
    else
        barrier();
}

// Narrower subgroups of a warp take turns, so that earlier threads count first.
uint rank_in_warp(uint digit, uint warp, uint lane) {
    const uint width = min(subgroup_width(), warp_width);
    uint peers = 0xffffffffu >> (warp_width - width);
    for (uint i = 0u; i < digit_bits; ++i) {
        const bool is_set = (digit >> i & 1u) != 0u;
        const uvec4 all = subgroupBallot(is_set);
        const uint ballot = gl_SubgroupSize <= 32u ? all.x : all[gl_SubgroupInvocationID / 32u];
        peers &= is_set ? ballot : ~ballot;
    }
    const uint rank = bitCount(peers & ((1u << lane % width) - 1u));
    const uint word = warp * half_bins + digit % half_bins;
    uint before = 0u;
    for (uint turn = 0u; turn < warp_width / width; ++turn) {
        const bool is_mine = turn == lane / width;
        if (is_mine)
            before = warp_counts[word] >> half_shift(digit) & 0xffffu;
        wait_for_warp(width);
        if (is_mine && rank == 0u)
            atomicAdd(warp_counts[word], bitCount(peers) << half_shift(digit));
        wait_for_warp(width);
    }
    return before + rank;
}

void clear_masks(uint thread) {}

#else

uint rank_in_warp(uint digit, uint warp, uint lane) {
    const uint mask = warp * radix_bins + digit;
    const uint word = warp * half_bins + digit % half_bins;
    atomicOr(staged[mask], 1u << lane);
    barrier();
    const uint peers = staged[mask];
    const uint before = warp_counts[word] >> half_shift(digit) & 0xffffu;
    barrier();
    // Each clears its own bit: another thread may have set one for its next pair already.
    atomicAnd(staged[mask], ~(1u << lane));
    const uint rank = bitCount(peers & ((1u << lane) - 1u));
    if (rank == 0u)
        atomicAdd(warp_counts[word], bitCount(peers) << half_shift(digit));
    return before + rank;
}

void clear_masks(uint thread) {
    [[unroll]] for (uint i = 0u; i < items; ++i)
        staged[i * threads + thread] = 0u;
}

#endif

// Counts of warps become those of the warps before; the block's own go to digit_start. Both halves of a word at once:
// no sum exceeds a block, so none carries over.
void sum_over_warps(uint thread) {
    if (thread < half_bins) {
        uint sums = 0u;
        [[unroll]] for (uint warp = 0u; warp < warps; ++warp) {
            const uint counts = warp_counts[warp * half_bins + thread];
            warp_counts[warp * half_bins + thread] = sums;
            sums += counts;
        }
        digit_start[thread] = sums & 0xffffu;
        digit_start[thread + half_bins] = sums >> 16u;
    }
}

void main() {
    const uint thread = thread_index();
    const uint warp = thread / warp_width, lane = thread % warp_width;
    const uint count = element_count(count_words, constants.count_word, constants.capacity);
    const uint first = gl_WorkGroupID.x * block;
    if (first >= count)
        return;
    const uint valid = min(count - first, block);

    // What lies beyond the count takes part as the greatest key: it ranks behind all others and is not written.
    uint my_keys[items], my_values[items], ranks[items];
    [[unroll]] for (uint i = 0u; i < items; ++i) {
        const uint at = (warp * items + i) * warp_width + lane;
        my_keys[i] = at < valid ? keys[first + at] : 0xffffffffu;
        if (values_are_indices)
            my_values[i] = first + at;
        else
            my_values[i] = at < valid ? values[first + at] : 0u;
    }
    const uint digits_before = table[gl_WorkGroupID.x * radix_bins + thread];
    const uint digit_total = table[constants.totals + thread];

    for (uint i = thread; i < warps * half_bins; i += threads)
        warp_counts[i] = 0u;
    clear_masks(thread);
    barrier();
    [[unroll]] for (uint i = 0u; i < items; ++i)
        ranks[i] = rank_in_warp(digit_of(my_keys[i]), warp, lane);
    barrier();
    sum_over_warps(thread);
    barrier();
    uvec2 ignored;
    const uvec2 starts = workgroup_exclusive_add(uvec2(digit_start[thread], digit_total), ignored);
    digit_start[thread] = starts.x;
    digit_target[thread] = starts.y + digits_before - starts.x;
    barrier();

    [[unroll]] for (uint i = 0u; i < items; ++i) {
        const uint digit = digit_of(my_keys[i]);
        const uint counts = warp_counts[warp * half_bins + digit % half_bins];
        ranks[i] += digit_start[digit] + (counts >> half_shift(digit) & 0xffffu);
        staged[ranks[i]] = my_keys[i];
    }
    barrier();
    uint targets[items];
    [[unroll]] for (uint i = 0u; i < items; ++i) {
        const uint at = i * threads + thread;
        const uint key = staged[at];
        targets[i] = digit_target[digit_of(key)] + at;
        if (at < valid)
            sorted_keys[targets[i]] = key;
    }
    barrier();
    [[unroll]] for (uint i = 0u; i < items; ++i)
        staged[ranks[i]] = my_values[i];
    barrier();
    [[unroll]] for (uint i = 0u; i < items; ++i) {
        const uint at = i * threads + thread;
        if (at < valid)
            sorted_values[targets[i]] = staged[at];
    }
}
