// Prefix sums and compaction against their slow references, with and without subgroups, at awkward sizes.
#include "filters/compaction.h"
#include "filters/prefix_sum.h"
#include "filters/radix_sort.h"
#include "tests/gpu/words_support.h"
#include "tests/reference/sort_reference.h"

#include <algorithm>
#include <random>

namespace sfumato::test {
namespace {

constexpr int poison = 0x5b;
constexpr uint32_t block = prefix_sum_block;
static_assert(compaction_block == block);

class PrefixSumTest : public GpuTest {
  protected:
    // Pipelines are made once for all tests.
    static void SetUpTestSuite() {
        contexts_[0] = make_context(poison, [](ContextInfo& info) { info.subgroups = false; });
        contexts_[1] = make_context(poison);
    }
    static void TearDownTestSuite() {
        for (auto& context : contexts_)
            context.reset();
    }

    // The words that are there before; then what nobody may have written.
    static void expect_words(const Words& found, const Words& expected, const std::string& what) {
        for (size_t i = 0; i < found.size(); ++i)
            ASSERT_EQ(found[i], i < expected.size() ? expected[i] : WordsRig::poisoned(poison)) << what << " at " << i;
    }

    // `counted`: what the device is told; the capacity is that of the array unless it is given.
    void check_sums(const Words& numbers, uint32_t counted, uint32_t capacity = 0, int runs = 1) {
        capacity = capacity ? capacity : static_cast<uint32_t>(numbers.size());
        const Words present(numbers.begin(), numbers.begin() + std::min(counted, capacity));
        for (const bool subgroups : {false, true})
            for (const PrefixSumKind kind : {PrefixSumKind::exclusive, PrefixSumKind::inclusive}) {
                WordsRig rig(*contexts_[subgroups]);
                const ResourceId input = rig.upload(numbers);
                const ResourceId count = rig.upload({1u, counted, 1u});
                const PrefixSum sum = plan_prefix_sum(rig.planner(), input, {count, 4, capacity}, kind);
                rig.read(sum.sums, capacity);
                rig.read(sum.total, 1);
                const std::vector<Words>& results = rig.run(runs);
                const bool exclusive = kind == PrefixSumKind::exclusive;
                const std::string what = std::to_string(counted) + (exclusive ? " exclusive" : " inclusive") +
                                         (subgroups ? ", subgroups" : ", shared memory");
                expect_words(results[0], exclusive ? exclusive_sums(present) : inclusive_sums(present), what);
                EXPECT_EQ(results[1][0], sum_of(present)) << what << ", total";
            }
    }

    void check_survivors(const Words& flags, uint32_t counted, uint32_t capacity = 0, int runs = 1) {
        capacity = capacity ? capacity : static_cast<uint32_t>(flags.size());
        const Words present(flags.begin(), flags.begin() + std::min(counted, capacity));
        const Words expected = surviving_indices(present);
        const std::array<uint32_t, 4> group_sizes{1, 64, 256, radix_sort_block};
        for (const bool subgroups : {false, true}) {
            WordsRig rig(*contexts_[subgroups]);
            const ResourceId input = rig.upload(flags);
            const ResourceId count = rig.upload({1u, counted, 1u});
            const Compaction compaction = plan_compaction(rig.planner(), input, {count, 4, capacity}, group_sizes);
            rig.read(compaction.indices, capacity);
            rig.read(compaction.survivors, 13);
            const std::vector<Words>& results = rig.run(runs);
            const std::string what = std::to_string(counted) + (subgroups ? ", subgroups" : ", shared memory");
            expect_words(results[0], expected, what);
            const auto survivors = static_cast<uint32_t>(expected.size());
            Words commands{survivors};
            for (const uint32_t size : group_sizes)
                commands.insert(commands.end(), {std::min(65535u, (survivors + size - 1) / size), 1u, 1u});
            EXPECT_EQ(results[1], commands) << what;
        }
    }

    // Without and with subgroups.
    static inline std::unique_ptr<Context> contexts_[2];
};

Words random_words(size_t number, uint32_t seed) {
    std::mt19937 random(seed);
    Words words(number);
    for (uint32_t& word : words)
        word = static_cast<uint32_t>(random());
    return words;
}

// About one in `rarity` is not 0.
Words random_flags(size_t number, uint32_t seed, uint32_t rarity) {
    Words flags = random_words(number, seed);
    for (uint32_t& flag : flags)
        flag = flag % rarity == 0 ? flag | 0x80000000u : 0u;
    return flags;
}

constexpr uint32_t awkward[] = {
    0, 1, 2, 63, 64, 65, block - 1, block, block + 1, 3 * block - 1, 3 * block, 3 * block + 1};

TEST_F(PrefixSumTest, sums_at_awkward_counts) {
    for (const uint32_t count : awkward)
        check_sums(random_words(std::max(1u, count), count), count);
}

TEST_F(PrefixSumTest, sums_beyond_the_count_are_left_alone_and_counts_clamped) {
    for (const uint32_t count : {0u, 1u, 2048u, 2049u, 4500u})
        check_sums(random_words(5000, count), count);
    for (const uint32_t count : {3001u, 0x80000000u, 0xffffffffu})
        check_sums(random_words(5000, count), count, 3000);
}

TEST_F(PrefixSumTest, sums_of_a_hundred_thousand_are_the_same_every_time) {
    check_sums(random_words(100003, 4), 100003, 0, 2);
}

TEST_F(PrefixSumTest, sums_without_a_count) {
    WordsRig rig(*contexts_[1]);
    const Words numbers = random_words(3000, 9);
    const PrefixSum sum =
        plan_prefix_sum(rig.planner(), rig.upload(numbers), {no_resource, 0, 3000}, PrefixSumKind::exclusive);
    rig.read(sum.sums, 3000);
    expect_words(rig.run()[0], exclusive_sums(numbers), "no count");
}

TEST_F(PrefixSumTest, survivors_at_awkward_counts) {
    for (const uint32_t count : awkward)
        check_survivors(random_flags(std::max(1u, count), count, 2), count);
}

TEST_F(PrefixSumTest, none_all_few_and_most_survive) {
    check_survivors(Words(5000, 0), 5000);
    check_survivors(Words(5000, 0x100), 5000);
    check_survivors(random_flags(5000, 1, 200), 5000);
    Words most = random_flags(5000, 2, 200);
    for (uint32_t& flag : most)
        flag = flag == 0;
    check_survivors(most, 5000);
}

TEST_F(PrefixSumTest, survivors_beyond_the_count_are_ignored_and_counts_clamped) {
    for (const uint32_t count : {0u, 1u, 2048u, 2049u, 4500u})
        check_survivors(random_flags(5000, count, 3), count);
    for (const uint32_t count : {3001u, 0x80000000u, 0xffffffffu})
        check_survivors(random_flags(5000, count, 3), count, 3000);
}

TEST_F(PrefixSumTest, survivors_of_a_hundred_thousand_are_the_same_every_time) {
    check_survivors(random_flags(100003, 5, 3), 100003, 0, 2);
}

// More blocks than each adds up itself: the pass between comes in.
TEST_F(PrefixSumTest, more_blocks_than_are_added_up_directly) {
    constexpr uint32_t capacity = 2049 * block;
    constexpr uint32_t present = 20 * block + 77;
    WordsRig rig(*contexts_[1]);
    Words numbers = random_flags(present, 6, 3);
    const ResourceId input = rig.upload(numbers);
    const ResourceId count = rig.upload({present});
    const PrefixSum sum = plan_prefix_sum(rig.planner(), input, {count, 0, capacity}, PrefixSumKind::exclusive);
    const Compaction compaction = plan_compaction(rig.planner(), input, {count, 0, capacity});
    rig.read(sum.sums, present);
    rig.read(compaction.indices, present);
    const std::vector<Words>& results = rig.run();
    expect_words(results[0], exclusive_sums(numbers), "sums");
    expect_words(results[1], surviving_indices(numbers), "survivors");
}

// What particles do: those alive, sorted by what is read at their index; the count never leaves the device.
TEST_F(PrefixSumTest, compaction_dispatches_a_sort) {
    for (const uint32_t rarity : {1u, 3u, 1000000u}) {
        const Words flags = random_flags(10000, 7, rarity), keys = random_words(10000, 8);
        const Words alive = surviving_indices(flags);
        Words alive_keys(keys.begin(), keys.begin() + static_cast<std::ptrdiff_t>(alive.size()));
        const ReferencePairs expected = sort_pairs(alive_keys, alive, 16);
        for (const bool subgroups : {false, true}) {
            WordsRig rig(*contexts_[subgroups]);
            const Compaction compaction = plan_compaction(rig.planner(), rig.upload(flags), {no_resource, 0, 10000},
                                                          {64, 256, radix_sort_block, 1});
            const SortedPairs pairs =
                plan_radix_sort(rig.planner(), rig.upload(keys), compaction.indices, compaction.count(10000), 16,
                                {compaction.survivors, Compaction::arguments_offset(2)});
            rig.read(pairs.keys, 10000);
            rig.read(pairs.values, 10000);
            const std::vector<Words>& results = rig.run();
            expect_words(results[0], expected.keys, "keys");
            expect_words(results[1], expected.values, "values");
        }
    }
}

TEST_F(PrefixSumTest, scratch_is_what_the_plan_holds) {
    for (const uint32_t capacity : {1u, block, block + 1, 5000000u}) {
        const auto bytes_of = [&](auto plan_block) {
            Planner planner("scratch");
            plan_block(planner, planner.buffer("input", 0));
            uint64_t bytes = 0;
            for (const Resource& resource : std::move(planner).finish().resources)
                bytes += resource.bytes;
            return bytes;
        };
        EXPECT_EQ(bytes_of([&](Planner& planner, ResourceId input) {
                      plan_prefix_sum(planner, input, {no_resource, 0, capacity}, PrefixSumKind::exclusive);
                  }),
                  prefix_sum_scratch_bytes(capacity));
        EXPECT_EQ(bytes_of([&](Planner& planner, ResourceId input) {
                      plan_compaction(planner, input, {no_resource, 0, capacity});
                  }),
                  compaction_scratch_bytes(capacity));
    }
}

} // namespace
} // namespace sfumato::test
