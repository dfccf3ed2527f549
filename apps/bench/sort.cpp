// `sort`: what the building blocks on arrays cost: radix sort, prefix sum and compaction, for rising counts, with and
// without subgroups. The count stands on the device, as it does in use. Every result is checked against the CPU.
#include "shaders/sort.h"
#include "apps/bench/commands.h"
#include "apps/bench/machine.h"
#include "filters/compaction.h"
#include "filters/prefix_sum.h"
#include "filters/radix_sort.h"

#include <algorithm>
#include <cstring>
#include <functional>
#include <numeric>

#include <fmt/format.h>

namespace sfumato::bench {
namespace {

constexpr uint32_t row = 4096; // as in sort.comp

using Words = std::vector<uint32_t>;

struct BuildingBlock {
    std::string name; // "sort", "prefix sum", "compaction"
    uint32_t bits = 0;
    uint64_t bytes = 0; // that move, at least
    // Adds the input's passes to a plan, then, if it is wanted, the block's; returns what shall be checked.
    std::function<std::vector<ResourceId>(Planner& planner, bool with_block)> plan;
    std::function<std::vector<Words>()> expected;
};

struct Row {
    const BuildingBlock* block;
    uint32_t count;
    bool subgroups;
    double milliseconds = 0.0; // median of the whole less that of making the input
    Statistics with_input, input;
    std::vector<PassStatistics> passes;
    uint64_t held = 0;
};

uint32_t hash(uint32_t i) { // as in sort.comp
    const uint32_t state = i * 747796405u + 2891336453u;
    const uint32_t word = ((state >> ((state >> 28) + 4)) ^ state) * 277803737u;
    return (word >> 22) ^ word;
}

ResourceId make(Planner& planner, const char* name, uint32_t number, uint32_t base, uint32_t index_mask,
                uint32_t hash_mask) {
    const ResourceId words = planner.buffer(name, uint64_t{4} * number);
    const ResourceId shape =
        planner.transient("invocations", VK_FORMAT_R8G8B8A8_UNORM, {std::min(number, row), (number + row - 1) / row});
    Pass& pass = planner.pass(std::string("make ") + name, shaders::sort::make);
    pass.specialization = {number, base, index_mask, hash_mask};
    pass.accesses = {write_buffer(words)};
    pass.dispatch = {DispatchKind::texels, shape};
    return words;
}

DeviceCount make_count(Planner& planner, uint32_t count) {
    return {make(planner, "count", 1, count, 0, 0), 0, count};
}

Words hashes(uint32_t count, uint32_t mask) {
    Words words(count);
    for (uint32_t i = 0; i < count; ++i)
        words[i] = hash(i) & mask;
    return words;
}

BuildingBlock sort_block(uint32_t count, uint32_t bits, bool indices) {
    const auto plan = [=](Planner& planner, bool with_block) -> std::vector<ResourceId> {
        const ResourceId keys = make(planner, "keys", count, 0, 0, ~0u);
        const ResourceId values = indices ? no_resource : make(planner, "values", count, 0, ~0u, 0);
        const DeviceCount counted = make_count(planner, count);
        if (!with_block)
            return {};
        const SortedPairs pairs = plan_radix_sort(planner, keys, values, counted, bits);
        return {pairs.keys, pairs.values};
    };
    const auto expected = [=] {
        const uint32_t mask = bits < 32 ? (1u << bits) - 1 : ~0u;
        std::vector<uint64_t> order(count); // the key's bits, then the place: no two are equal
        for (uint32_t i = 0; i < count; ++i)
            order[i] = uint64_t{hash(i) & mask} << 32 | i;
        std::ranges::sort(order);
        std::vector<Words> words(2);
        for (const uint64_t pair : order) {
            words[0].push_back(hash(static_cast<uint32_t>(pair)));
            words[1].push_back(static_cast<uint32_t>(pair));
        }
        return words;
    };
    // Every digit reads keys twice and values once, writes both, and passes its table of 256 words a block four times.
    const uint64_t digits = (bits + 7) / 8;
    const uint64_t bytes = (digits * (20 + 2) - (indices ? 4 : 0)) * count;
    return {fmt::format("sort, {} bits", bits), bits, bytes, plan, expected};
}

BuildingBlock sum_block(uint32_t count) {
    constexpr uint32_t mask = 255;
    const auto plan = [=](Planner& planner, bool with_block) -> std::vector<ResourceId> {
        const ResourceId numbers = make(planner, "numbers", count, 0, 0, mask);
        const DeviceCount counted = make_count(planner, count);
        if (!with_block)
            return {};
        const PrefixSum sum = plan_prefix_sum(planner, numbers, counted, PrefixSumKind::exclusive);
        return {sum.sums};
    };
    const auto expected = [=] {
        const Words numbers = hashes(count, mask);
        Words sums(count);
        std::exclusive_scan(numbers.begin(), numbers.end(), sums.begin(), 0u);
        return std::vector<Words>{sums};
    };
    return {"prefix sum", 0, uint64_t{12} * count, plan, expected};
}

BuildingBlock compaction_block_of(uint32_t count) {
    const auto plan = [=](Planner& planner, bool with_block) -> std::vector<ResourceId> {
        const ResourceId flags = make(planner, "flags", count, 0, 0, 1);
        const DeviceCount counted = make_count(planner, count);
        if (!with_block)
            return {};
        return {plan_compaction(planner, flags, counted).indices};
    };
    const auto expected = [=] {
        Words survivors;
        for (uint32_t i = 0; i < count; ++i)
            if (hash(i) & 1)
                survivors.push_back(i);
        return std::vector<Words>{survivors};
    };
    return {"compaction of half", 0, uint64_t{10} * count, plan, expected};
}

// The executor of one plan, and everything that it uses.
class Runner {
  public:
    static Result<std::unique_ptr<Runner>> create(Rig& rig, const BuildingBlock& block, bool with_block, bool subgroups,
                                                  uint32_t frames_in_flight, bool timestamps) {
        std::unique_ptr<Runner> runner(new Runner);
        auto context = rig.create_context(frames_in_flight, timestamps, subgroups);
        if (!context)
            return context.error();
        runner->context_ = std::move(*context);
        auto executor = Executor::create(*runner->context_);
        if (!executor)
            return executor.error();
        runner->executor_ = std::move(*executor);
        Planner planner("array");
        block.plan(planner, with_block);
        runner->plan_ = std::move(planner).finish();
        return runner;
    }

    Result<void> record(VkCommandBuffer commands) { return executor_->execute(commands, plan_, {}, frame_++); }
    Executor& executor() { return *executor_; }
    Context& context() { return *context_; }

  private:
    Runner() = default;
    std::unique_ptr<Context> context_;
    std::unique_ptr<Executor> executor_; // goes before its context
    Plan plan_;
    uint64_t frame_ = 0;
};

// Runs the block once and compares every word of its results.
Result<void> check(Rig& rig, const BuildingBlock& block, const std::vector<Words>& expected, uint32_t count,
                   bool subgroups) {
    auto context = rig.create_context(1, false, subgroups);
    if (!context)
        return context.error();
    auto executor = Executor::create(**context);
    if (!executor)
        return executor.error();
    Planner planner("check");
    const std::vector<ResourceId> results = block.plan(planner, true);
    std::vector<apps::HostImage> hosts;
    std::vector<Image> images;
    for (size_t i = 0; i < results.size(); ++i) {
        const auto number = static_cast<uint32_t>(expected[i].size());
        auto host = rig.device().create_image(VK_FORMAT_R8G8B8A8_UNORM, {row, std::max(1u, (number + row - 1) / row)});
        if (!host)
            return host.error();
        const ResourceId target = planner.host("shown", static_cast<uint32_t>(i), host->image());
        Pass& pass = planner.pass("show", shaders::sort::show);
        pass.specialization = {number};
        pass.accesses = {read_buffer(results[i]), {target, AccessKind::write}};
        pass.dispatch = {DispatchKind::texels, target};
        images.push_back(host->image());
        hosts.push_back(std::move(*host));
    }
    auto commands = rig.device().begin();
    if (!commands)
        return commands.error();
    if (auto recorded = (*executor)->execute(*commands, std::move(planner).finish(), images, 0); !recorded)
        return recorded;
    if (auto done = rig.device().submit_and_wait(); !done)
        return done;
    for (size_t i = 0; i < results.size(); ++i) {
        const auto bytes = rig.device().readback_bytes(hosts[i]);
        if (!bytes)
            return bytes.error();
        for (size_t at = 0; at < expected[i].size(); ++at) {
            uint32_t word = 0;
            std::memcpy(&word, bytes->data() + 4 * at, 4);
            if (word != expected[i][at])
                return Error{ErrorCode::internal,
                             fmt::format("{} of {} {}: word {} of result {} is {:#x}, but the CPU has {:#x}",
                                         block.name, count, subgroups ? "with subgroups" : "in shared memory", at, i,
                                         word, expected[i][at])};
        }
    }
    return {};
}

Result<Statistics> time_plan(Rig& rig, const BuildingBlock& block, bool with_block, bool subgroups,
                             const TimingOptions& timing, uint64_t* held) {
    auto runner = Runner::create(rig, block, with_block, subgroups, 2 * timing.batch, false);
    if (!runner)
        return runner.error();
    auto time = time_frames(
        rig, [&](VkCommandBuffer commands) { return (*runner)->record(commands); }, timing);
    if (time && held)
        *held = (*runner)->context().memory_usage().transients;
    return time;
}

Result<Row> measure(Rig& rig, const Options& options, const BuildingBlock& block, uint32_t count, bool subgroups,
                    double warm_up) {
    Row result{&block, count, subgroups, 0.0, {}, {}, {}, 0};
    TimingOptions timing = timing_options(options, rig, warm_up);
    auto whole = time_plan(rig, block, true, subgroups, timing, &result.held);
    if (!whole)
        return whole.error();
    timing.warm_up = 0.02;
    auto input = time_plan(rig, block, false, subgroups, timing, nullptr);
    if (!input)
        return input.error();
    result.with_input = *whole;
    result.input = *input;
    result.milliseconds = whole->median - input->median;
    if (!options.passes)
        return result;
    auto runner = Runner::create(rig, block, true, subgroups, timing.batch, true);
    if (!runner)
        return runner.error();
    auto passes = time_passes(
        rig, [&](VkCommandBuffer commands) { return (*runner)->record(commands); },
        [&] { return (*runner)->executor().times(); }, timing);
    if (!passes)
        return passes.error();
    for (PassStatistics& pass : *passes)
        if (pass.pass.rfind("make ", 0) != 0)
            result.passes.push_back(std::move(pass));
    return result;
}

const char* path_name(bool subgroups) {
    return subgroups ? "subgroups" : "shared memory";
}

std::string block_table(const std::vector<Row>& rows, const Machine& machine) {
    Table table({"block", "path", "count", "median ms", "M/s", "moves MB", "limit ms", "held MB", "result"}, 2);
    for (const Row& r : rows) {
        const double rate = r.milliseconds > 0.0 ? r.count / r.milliseconds * 1e-3 : 0.0;
        const double limit =
            machine.bandwidth() > 0.0 ? static_cast<double>(r.block->bytes) / machine.bandwidth() : 0.0;
        table.add({r.block->name, path_name(r.subgroups), std::to_string(r.count), fixed(r.milliseconds, 4),
                   fixed(rate, 0), fixed(static_cast<double>(r.block->bytes) * 1e-6, 1), fixed(limit * 1e3, 4),
                   fixed(static_cast<double>(r.held) / 1048576.0, 1), "checked"});
    }
    return table.text() + "median: a frame with the block less one that only makes its input; limit: the bytes at the "
                          "copy's speed, caches left aside.\n";
}

// A sort goes through the same passes for every digit: their sums.
std::string pass_table(const std::vector<Row>& rows) {
    Table table({"block", "path", "pass", "count", "times", "ms in all"}, 3);
    for (const Row& r : rows) {
        std::vector<std::string> names;
        for (const PassStatistics& pass : r.passes)
            if (std::ranges::find(names, pass.pass) == names.end())
                names.push_back(pass.pass);
        for (const std::string& name : names) {
            int times = 0;
            double sum = 0.0;
            for (const PassStatistics& pass : r.passes)
                if (pass.pass == name) {
                    ++times;
                    sum += pass.time.median;
                }
            table.add({r.block->name, path_name(r.subgroups), name, std::to_string(r.count), std::to_string(times),
                       fixed(sum, 4)});
        }
    }
    return "Passes, medians; a stamp after each costs a little itself.\n" + table.text();
}

Json row_json(const Row& r) {
    Json passes = Json::array();
    for (const PassStatistics& pass : r.passes)
        passes.push_back({{"pass", pass.pass}, {"time", statistics_json(pass.time)}});
    return {{"block", r.block->name},
            {"bits", r.block->bits},
            {"count", r.count},
            {"path", path_name(r.subgroups)},
            {"median_ms", r.milliseconds},
            {"with_input", statistics_json(r.with_input)},
            {"input", statistics_json(r.input)},
            {"moved_bytes", r.block->bytes},
            {"transient_bytes", r.held},
            {"checked", true},
            {"passes", passes}};
}

std::vector<uint32_t> counts_of(const Options& options, const Rig& rig) {
    if (!options.counts.empty())
        return options.counts;
    std::vector<uint32_t> counts;
    for (uint32_t power = 14; power <= (rig.is_cpu() ? 16u : 22u); ++power)
        counts.push_back(1u << power);
    return counts;
}

std::vector<BuildingBlock> blocks_of_count(const Options& options, uint32_t count) {
    std::vector<BuildingBlock> blocks;
    for (const uint32_t bits : options.bits)
        blocks.push_back(sort_block(count, bits, options.sorts_indices));
    blocks.push_back(sum_block(count));
    blocks.push_back(compaction_block_of(count));
    return blocks;
}

} // namespace

Result<void> measure_sort(Rig& rig, const Options& options, const Output& output) {
    const auto machine = measure_machine(rig);
    if (!machine)
        return machine.error();
    output.print(header_text("sort", rig) + machine_text(*machine) + "\n");
    std::vector<std::vector<BuildingBlock>> blocks; // by count; rows point at them
    for (const uint32_t count : counts_of(options, rig))
        blocks.push_back(blocks_of_count(options, count));
    std::vector<Row> rows;
    for (size_t i = 0; i < blocks.size(); ++i)
        for (const BuildingBlock& block : blocks[i]) {
            const uint32_t count = counts_of(options, rig)[i];
            const std::vector<Words> expected = block.expected();
            for (const bool subgroups : {false, true}) {
                output.progress(fmt::format("{} {} {}", block.name, count, path_name(subgroups)));
                if (auto checked = check(rig, block, expected, count, subgroups); !checked)
                    return checked;
                const double warm_up = rows.empty() ? options.warm_up : std::min(options.warm_up, 0.05);
                auto measured = measure(rig, options, block, count, subgroups, warm_up);
                if (!measured)
                    return measured.error();
                rows.push_back(std::move(*measured));
            }
        }
    std::ranges::stable_sort(rows, {}, [](const Row& r) { return std::pair(r.block->name, r.subgroups); });
    output.print(block_table(rows, *machine) + "\n");
    if (options.passes)
        output.print(pass_table(rows));
    Json json = {{"program", "sfumato-bench"},       {"command", "sort"},
                 {"device", device_json(rig)},       {"machine", machine_json(*machine)},
                 {"indices", options.sorts_indices}, {"rows", Json::array()}};
    for (const Row& r : rows)
        json["rows"].push_back(row_json(r));
    return output.write(json);
}

} // namespace sfumato::bench
