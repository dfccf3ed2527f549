// The passes of the radix sort.
#include "filters/radix_sort.h"

#include "filters/radix_sort_shared.h"
#include "shaders/radix_sort.h"

#include <array>

namespace sfumato {

namespace {

namespace shader = shaders::radix_sort;

constexpr uint32_t bins = 256;
constexpr uint32_t bins_per_scan_group = 4; // as in radix_sort.comp

uint32_t digits_of(uint32_t bits) {
    return (std::clamp(bits, 1u, 32u) + 7) / 8;
}

uint64_t table_bytes(uint32_t capacity) {
    return uint64_t{4} * bins * (blocks_of(capacity, radix_sort_block) + 1);
}

// Buffers that the digits' passes write in turn.
uint32_t ping_pong_pairs(uint32_t digits, bool overwrite_input) {
    return digits == 1 || overwrite_input ? 1 : 2;
}

struct Digit {
    uint32_t shift, bits;
};

struct Sort {
    Planner& planner;
    const DeviceCount& count;
    const RadixSortOptions& options;
    gpu::RadixSortConstants constants;
    ResourceId table;

    Dispatch over_blocks() const {
        if (options.arguments != no_resource)
            return {DispatchKind::indirect, options.arguments, 0, options.arguments_offset};
        return dispatch_groups(planner, blocks_of(count.capacity, radix_sort_block));
    }

    void sort_by(const Digit& digit, const SortedPairs& from, const SortedPairs& to) {
        constants.shift = digit.shift;
        const bool values_are_indices = from.values == no_resource;
        Pass& histogram = planner.pass("sort histogram", shader::histogram);
        histogram.specialization = {digit.bits};
        histogram.accesses = {read_buffer(from.keys), count_access(count, from.keys), write_buffer(table)};
        histogram.constants = constants_of(constants);
        histogram.dispatch = over_blocks();

        Pass& scan = planner.pass("sort scan", shader::scan);
        scan.accesses = {count_access(count, from.keys), write_buffer(table)};
        scan.constants = constants_of(constants);
        scan.dispatch = dispatch_groups(planner, bins / bins_per_scan_group);

        Pass& scatter = planner.pass("sort scatter", shader::scatter);
        scatter.subgroup_shader = shader::scatter_subgroups;
        scatter.specialization = {digit.bits, values_are_indices};
        scatter.accesses = {read_buffer(from.keys),         read_buffer(values_are_indices ? from.keys : from.values),
                            count_access(count, from.keys), read_buffer(table),
                            write_buffer(to.keys),          write_buffer(to.values)};
        scatter.constants = constants_of(constants);
        scatter.dispatch = over_blocks();
    }
};

} // namespace

SortedPairs plan_radix_sort(Planner& planner, ResourceId keys, ResourceId values, const DeviceCount& count,
                            uint32_t bits, const RadixSortOptions& options) {
    const uint32_t capacity = std::clamp(count.capacity, 1u, radix_sort_most);
    const bool overwrites = options.overwrite_input && values != no_resource;
    const uint32_t digits = digits_of(bits);
    const uint64_t bytes = uint64_t{4} * capacity;
    std::array<SortedPairs, 2> pairs;
    for (uint32_t i = 0; i < ping_pong_pairs(digits, overwrites); ++i)
        pairs[i] = {planner.buffer("sorted keys", bytes), planner.buffer("sorted values", bytes)};
    if (overwrites)
        pairs[1] = {keys, values};

    const gpu::RadixSortConstants constants{capacity, count_word(count), bins * blocks_of(capacity, radix_sort_block),
                                            0};
    Sort sort{planner, count, options, constants, planner.buffer("sort table", table_bytes(capacity))};
    SortedPairs from{keys, values};
    uint32_t left = std::clamp(bits, 1u, 32u), shift = 0;
    for (uint32_t i = 0; i < digits; ++i) {
        const uint32_t width = (left + digits - i - 1) / (digits - i);
        sort.sort_by({shift, width}, from, pairs[i % 2]);
        from = pairs[i % 2];
        shift += width;
        left -= width;
    }
    return from;
}

uint64_t radix_sort_scratch_bytes(uint32_t capacity, uint32_t bits, bool overwrite_input) {
    capacity = std::clamp(capacity, 1u, radix_sort_most);
    return uint64_t{8} * capacity * ping_pong_pairs(digits_of(bits), overwrite_input) + table_bytes(capacity);
}

} // namespace sfumato
