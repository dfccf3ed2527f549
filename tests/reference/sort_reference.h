// Sorting, prefix sums and compaction as anyone would write them.
#pragma once

#include <cstdint>
#include <vector>

namespace sfumato::test {

struct ReferencePairs {
    std::vector<uint32_t> keys, values;
};

// Stable and ascending by the low `bits` bits (1…32).
ReferencePairs sort_pairs(const std::vector<uint32_t>& keys, const std::vector<uint32_t>& values, uint32_t bits);

// Modulo 2^32.
std::vector<uint32_t> exclusive_sums(const std::vector<uint32_t>& numbers);
std::vector<uint32_t> inclusive_sums(const std::vector<uint32_t>& numbers);
uint32_t sum_of(const std::vector<uint32_t>& numbers);

// Indices of the flags that are not 0, in order.
std::vector<uint32_t> surviving_indices(const std::vector<uint32_t>& flags);

} // namespace sfumato::test
