// The radix sort against std::stable_sort, with and without subgroups, at awkward sizes.
#include "filters/radix_sort.h"
#include "tests/gpu/words_support.h"
#include "tests/reference/sort_reference.h"

#include <algorithm>
#include <functional>
#include <numeric>
#include <random>

namespace sfumato::test {
namespace {

constexpr int poison = 0x5b;

struct Case {
    Words keys;
    Words values;          // empty: indices
    uint32_t count = 0;    // as the device is told
    uint32_t capacity = 0; // 0: the number of keys
    uint32_t bits = 32;
    bool count_on_device = true;
    bool overwrite_input = false;
    int runs = 1;
};

class RadixSortTest : public GpuTest {
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

    // Sorts on both paths; whole buffers must agree with the reference, untouched words included.
    void check(const Case& c, const std::string& what) {
        const uint32_t capacity = c.capacity ? c.capacity : static_cast<uint32_t>(c.keys.size());
        const uint32_t sorted = std::min(c.count, capacity);
        const Words keys(c.keys.begin(), c.keys.begin() + sorted);
        Words values(sorted);
        std::iota(values.begin(), values.end(), 0u);
        if (!c.values.empty())
            values.assign(c.values.begin(), c.values.begin() + sorted);
        const ReferencePairs expected = sort_pairs(keys, values, c.bits);
        for (const bool subgroups : {false, true}) {
            WordsRig rig(*contexts_[subgroups]);
            const ResourceId key_buffer = rig.upload(c.keys);
            const ResourceId value_buffer = c.values.empty() ? no_resource : rig.upload(c.values);
            DeviceCount count{no_resource, 0, capacity};
            if (c.count_on_device) {
                count.buffer = rig.upload({7777u, 1u, c.count, 7777u});
                count.offset = 8;
            }
            const SortedPairs pairs = plan_radix_sort(rig.planner(), key_buffer, value_buffer, count, c.bits,
                                                      {.overwrite_input = c.overwrite_input});
            rig.read(pairs.keys, capacity);
            rig.read(pairs.values, capacity);
            if (!c.overwrite_input)
                rig.read(key_buffer, c.keys.size());
            const std::vector<Words>& results = rig.run(c.runs);
            const std::string name = what + (subgroups ? ", subgroups" : ", shared memory");
            expect_words(results[0], expected.keys, name + ", keys", c.overwrite_input);
            expect_words(results[1], expected.values, name + ", values", c.overwrite_input);
            if (!c.overwrite_input) {
                EXPECT_EQ(results[2], c.keys) << name << ": the input has changed";
            }
        }
    }

    // Without and with subgroups.
    static inline std::unique_ptr<Context> contexts_[2];

  private:
    static void expect_words(const Words& found, const Words& expected, const std::string& what, bool any_rest) {
        for (size_t i = 0; i < found.size() && (i < expected.size() || !any_rest); ++i)
            ASSERT_EQ(found[i], i < expected.size() ? expected[i] : WordsRig::poisoned(poison)) << what << " at " << i;
    }
};

Words random_words(size_t number, uint32_t seed, uint32_t distinct = 0) {
    std::mt19937 random(seed);
    Words words(number);
    for (uint32_t& word : words)
        word = distinct ? static_cast<uint32_t>(random() % distinct) * 0x01234567u : static_cast<uint32_t>(random());
    return words;
}

Case whole(Words keys, uint32_t bits) {
    Case c;
    c.count = static_cast<uint32_t>(keys.size());
    c.keys = std::move(keys);
    c.bits = bits;
    return c;
}

TEST_F(RadixSortTest, awkward_counts) {
    constexpr uint32_t b = radix_sort_block;
    for (const uint32_t count : {0u, 1u, 2u, 63u, 64u, 65u, b - 1, b, b + 1, 3 * b - 1, 3 * b, 3 * b + 1}) {
        Case c = whole(random_words(std::max(1u, count), count + 1), 16);
        c.count = count;
        check(c, std::to_string(count) + " pairs");
    }
}

TEST_F(RadixSortTest, every_number_of_bits) {
    for (uint32_t bits : {1u, 8u, 12u, 16u, 20u, 24u, 32u}) {
        Case c = whole(random_words(5000, bits), bits);
        c.values = random_words(5000, 100 + bits);
        check(c, std::to_string(bits) + " bits");
        c.overwrite_input = true;
        if (bits % 8 == 0)
            check(c, std::to_string(bits) + " bits, input overwritten");
    }
}

TEST_F(RadixSortTest, orders_of_keys) {
    constexpr size_t number = 3 * radix_sort_block + 100;
    Words ascending(number), descending(number);
    for (size_t i = 0; i < number; ++i) {
        ascending[i] = static_cast<uint32_t>(i * 0x1000);
        descending[i] = ~ascending[i];
    }
    Words greatest = random_words(number, 5, 3);
    for (size_t i = 0; i < number; i += 2)
        greatest[i] = 0xffffffffu; // as what stands for missing pairs of the last block
    const std::pair<const char*, Words> orders[] = {{"equal keys", Words(number, 0x80ff7f00u)},
                                                    {"ascending", ascending},
                                                    {"descending", descending},
                                                    {"two distinct", random_words(number, 6, 2)},
                                                    {"seven distinct", random_words(number, 7, 7)},
                                                    {"greatest keys", greatest}};
    for (const auto& [name, keys] : orders) {
        check(whole(keys, 32), name);
        check(whole(keys, 16), std::string(name) + ", 16 bits");
    }
}

TEST_F(RadixSortTest, what_lies_beyond_the_count_is_left_alone) {
    for (const uint32_t count : {0u, 1u, 1999u, 2048u, 2049u, 4100u}) {
        Case c = whole(random_words(6000, count), 16);
        c.values = random_words(6000, count + 1);
        c.count = count;
        check(c, std::to_string(count) + " of 6000");
    }
}

TEST_F(RadixSortTest, counts_beyond_the_capacity_are_clamped) {
    for (const uint32_t capacity : {1u, 100u, 2048u, 2500u})
        for (const uint32_t count : {capacity + 1, 2999u, 0xffffffffu, 0x80000000u}) {
            Case c = whole(random_words(3000, capacity), 16);
            c.capacity = capacity;
            c.count = count;
            check(c, std::to_string(count) + " with room for " + std::to_string(capacity));
        }
}

TEST_F(RadixSortTest, without_a_count_the_capacity_is_sorted) {
    Case c = whole(random_words(2500, 3), 24);
    c.count_on_device = false;
    check(c, "no count");
}

TEST_F(RadixSortTest, repeated_runs_give_the_same_bits) {
    Case c = whole(random_words(100003, 11, 1000), 24);
    c.runs = 3;
    check(c, "repeated");
}

TEST_F(RadixSortTest, a_million_pairs) {
    check(whole(random_words(1048577, 12), 16), "a million");
}

// Dispatches and barriers are what small sorts cost.
TEST_F(RadixSortTest, three_dispatches_a_digit) {
    for (const uint32_t bits : {8u, 12u, 16u, 24u, 32u}) {
        Planner planner("passes");
        const ResourceId keys = planner.buffer("keys", 400);
        plan_radix_sort(planner, keys, no_resource, {no_resource, 0, 100}, bits);
        const Plan plan = std::move(planner).finish();
        ASSERT_EQ(plan.passes.size(), 3 * ((bits + 7) / 8));
        for (size_t i = 1; i < plan.passes.size(); ++i)
            EXPECT_EQ(plan.passes[i].barrier, Barrier::memory) << plan.passes[i].name;
    }
}

TEST_F(RadixSortTest, scratch_is_what_the_plan_holds) {
    for (const uint32_t capacity : {1u, 2048u, 2049u, 100003u})
        for (const uint32_t bits : {8u, 16u, 24u, 32u})
            for (const bool overwrites : {false, true}) {
                Planner planner("scratch");
                const ResourceId keys = planner.buffer("keys", 4 * capacity);
                const ResourceId values = planner.buffer("values", 4 * capacity);
                plan_radix_sort(planner, keys, values, {no_resource, 0, capacity}, bits,
                                {.overwrite_input = overwrites});
                uint64_t bytes = 0;
                for (const Resource& resource : std::move(planner).finish().resources)
                    bytes += resource.bytes;
                EXPECT_EQ(bytes - 8 * capacity, radix_sort_scratch_bytes(capacity, bits, overwrites));
            }
}

} // namespace
} // namespace sfumato::test
