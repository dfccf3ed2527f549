// Blocks of 2048 numbers and workgroups of 256 invocations: loads and stores lie together in memory, sums run over eight
// numbers that follow one another in each invocation, and shared memory turns one into the other.
#ifndef BLOCK_SCAN_GLSL
#define BLOCK_SCAN_GLSL

#include "workgroup_scan.glsl"

const uint scan_items = 8u;
const uint scan_block = scan_threads * scan_items;

// One word in 33 is left out, so that strides of eight meet different banks.
shared uint scan_staged[scan_block + scan_block / 32u];
uint scan_place(uint at) { return at + at / 32u; }

// The sum of what the blocks before `block` summed to, by all invocations together.
#define sum_of_earlier_blocks(block_sums, block, result)                                                               \
    {                                                                                                                  \
        uint my_share_ = 0u;                                                                                           \
        for (uint i_ = thread_index(); i_ < (block); i_ += scan_threads)                                               \
            my_share_ += (block_sums)[i_];                                                                             \
        workgroup_exclusive_add(my_share_, result);                                                                    \
    }

// Turns the sums of the blocks of `count` numbers into sums of the blocks before. One workgroup, 256 sums at a time:
// only very long arrays need it, whose other passes take far longer.
#define scan_all_blocks(block_sums, count)                                                                             \
    {                                                                                                                  \
        const uint blocks_ = ((count) + scan_block - 1u) / scan_block;                                                 \
        uint before_ = 0u;                                                                                             \
        for (uint first_ = 0u; first_ < blocks_; first_ += scan_threads) {                                             \
            const uint at_ = first_ + thread_index();                                                                  \
            uint total_;                                                                                               \
            const uint sum_ = workgroup_exclusive_add(at_ < blocks_ ? (block_sums)[at_] : 0u, total_);                 \
            if (at_ < blocks_)                                                                                         \
                (block_sums)[at_] = before_ + sum_;                                                                    \
            before_ += total_;                                                                                         \
        }                                                                                                              \
    }

#endif
