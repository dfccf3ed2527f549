// The passes of the prefix sum.
#include "filters/prefix_sum.h"

#include "filters/prefix_sum_shared.h"
#include "shaders/prefix_sum.h"

namespace sfumato {

namespace {
namespace shader = shaders::prefix_sum;
// Blocks whose sums every block adds up itself. At the limit it reads 4 KiB on average, half of its own numbers.
constexpr uint32_t most_unscanned_blocks = 2048;
} // namespace

PrefixSum plan_prefix_sum(Planner& planner, ResourceId numbers, const DeviceCount& count, PrefixSumKind kind) {
    const uint32_t capacity = std::clamp(count.capacity, 1u, prefix_sum_most);
    const uint32_t blocks = blocks_of(capacity, prefix_sum_block);
    const bool scans_blocks = blocks > most_unscanned_blocks;
    const ResourceId block_sums = planner.buffer("block sums", uint64_t{4} * blocks);
    const PrefixSum result{planner.buffer("prefix sums", uint64_t{4} * capacity), planner.buffer("sum of all", 4)};
    const auto constants = constants_of(gpu::PrefixSumConstants{capacity, count_word(count), 0, 0});

    Pass& reduce = planner.pass("sum blocks", shader::reduce);
    reduce.subgroup_shader = shader::reduce_subgroups;
    reduce.accesses = {read_buffer(numbers), count_access(count, numbers), write_buffer(block_sums)};
    reduce.constants = constants;
    reduce.dispatch = dispatch_groups(planner, blocks);

    if (scans_blocks) {
        Pass& middle = planner.pass("sum block sums", shader::scan_blocks);
        middle.subgroup_shader = shader::scan_blocks_subgroups;
        middle.accesses = {count_access(count, numbers), write_buffer(block_sums)};
        middle.constants = constants;
        middle.dispatch = dispatch_groups(planner, 1);
    }

    Pass& scan = planner.pass("prefix sum", shader::scan);
    scan.subgroup_shader = shader::scan_subgroups;
    scan.specialization = {kind == PrefixSumKind::inclusive, scans_blocks};
    scan.accesses = {read_buffer(numbers), count_access(count, numbers), read_buffer(block_sums),
                     write_buffer(result.sums), write_buffer(result.total)};
    scan.constants = constants;
    scan.dispatch = dispatch_groups(planner, blocks);
    return result;
}

uint64_t prefix_sum_scratch_bytes(uint32_t capacity) {
    capacity = std::clamp(capacity, 1u, prefix_sum_most);
    return uint64_t{4} * capacity + uint64_t{4} * blocks_of(capacity, prefix_sum_block) + 4;
}

} // namespace sfumato
