// Slow and obvious.
#include "tests/reference/sort_reference.h"

#include <algorithm>
#include <numeric>

namespace sfumato::test {

ReferencePairs sort_pairs(const std::vector<uint32_t>& keys, const std::vector<uint32_t>& values, uint32_t bits) {
    std::vector<size_t> order(keys.size());
    std::iota(order.begin(), order.end(), size_t{0});
    const auto low = [&](size_t i) { return bits < 32 ? keys[i] % (1u << bits) : keys[i]; };
    std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return low(a) < low(b); });
    ReferencePairs sorted;
    for (const size_t i : order) {
        sorted.keys.push_back(keys[i]);
        sorted.values.push_back(values[i]);
    }
    return sorted;
}

std::vector<uint32_t> exclusive_sums(const std::vector<uint32_t>& numbers) {
    std::vector<uint32_t> sums;
    uint32_t sum = 0;
    for (const uint32_t number : numbers) {
        sums.push_back(sum);
        sum += number;
    }
    return sums;
}

std::vector<uint32_t> inclusive_sums(const std::vector<uint32_t>& numbers) {
    std::vector<uint32_t> sums;
    uint32_t sum = 0;
    for (const uint32_t number : numbers) {
        sum += number;
        sums.push_back(sum);
    }
    return sums;
}

uint32_t sum_of(const std::vector<uint32_t>& numbers) {
    uint32_t sum = 0;
    for (const uint32_t number : numbers)
        sum += number;
    return sum;
}

std::vector<uint32_t> surviving_indices(const std::vector<uint32_t>& flags) {
    std::vector<uint32_t> indices;
    for (size_t i = 0; i < flags.size(); ++i)
        if (flags[i] != 0)
            indices.push_back(static_cast<uint32_t>(i));
    return indices;
}

} // namespace sfumato::test
