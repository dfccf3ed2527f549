// The passes of the compaction.
#include "filters/compaction.h"

#include "filters/compaction_shared.h"
#include "shaders/compaction.h"

namespace sfumato {

namespace {
namespace shader = shaders::compaction;
constexpr uint64_t survivors_bytes = 4 + 4 * 12;
// Blocks whose sums every block adds up itself; see prefix_sum.cpp.
constexpr uint32_t most_unscanned_blocks = 2048;
} // namespace

Compaction plan_compaction(Planner& planner, ResourceId flags, const DeviceCount& count,
                           const std::array<uint32_t, 4>& group_sizes) {
    const uint32_t capacity = std::clamp(count.capacity, 1u, compaction_most);
    const uint32_t blocks = blocks_of(capacity, compaction_block);
    const bool scans_blocks = blocks > most_unscanned_blocks;
    const ResourceId block_sums = planner.buffer("survivors of blocks", uint64_t{4} * blocks);
    const Compaction result{planner.buffer("surviving indices", uint64_t{4} * capacity),
                            planner.buffer("survivors", survivors_bytes)};
    const auto size = [&](size_t i) { return std::max(1u, group_sizes[i]); };
    const auto constants =
        constants_of(gpu::CompactionConstants{capacity, count_word(count), size(0), size(1), size(2), size(3), 0, 0});

    Pass& reduce = planner.pass("count survivors", shader::reduce);
    reduce.subgroup_shader = shader::reduce_subgroups;
    reduce.accesses = {read_buffer(flags), count_access(count, flags), write_buffer(block_sums)};
    reduce.constants = constants;
    reduce.dispatch = dispatch_groups(planner, blocks);

    if (scans_blocks) {
        Pass& middle = planner.pass("sum counts", shader::scan_blocks);
        middle.subgroup_shader = shader::scan_blocks_subgroups;
        middle.accesses = {count_access(count, flags), write_buffer(block_sums)};
        middle.constants = constants;
        middle.dispatch = dispatch_groups(planner, 1);
    }

    Pass& compact = planner.pass("compact", shader::compact);
    compact.subgroup_shader = shader::compact_subgroups;
    compact.specialization = {scans_blocks};
    compact.accesses = {read_buffer(flags), count_access(count, flags), read_buffer(block_sums),
                        write_buffer(result.indices), write_buffer(result.survivors)};
    compact.constants = constants;
    compact.dispatch = dispatch_groups(planner, blocks);
    return result;
}

uint64_t compaction_scratch_bytes(uint32_t capacity) {
    capacity = std::clamp(capacity, 1u, compaction_most);
    return uint64_t{4} * capacity + uint64_t{4} * blocks_of(capacity, compaction_block) + survivors_bytes;
}

} // namespace sfumato
