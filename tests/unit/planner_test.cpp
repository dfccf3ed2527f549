// Barriers and the check of plans: a barrier exactly where there is a hazard, and every defect found.
#include "sfumato/plan.h"

#include <gtest/gtest.h>

#include <functional>
#include <random>

namespace sfumato {
namespace {

constexpr uint32_t no_code[] = {0};
constexpr Shader shader{"test/none", no_code};
constexpr VkFormat format = VK_FORMAT_R16_SFLOAT;
constexpr Extent extent{8, 8};

Access fetch(ResourceId id, uint32_t mip = 0) {
    return {id, AccessKind::fetch, mip, false};
}
Access write(ResourceId id, uint32_t mip = 0, bool disjoint = false) {
    return {id, AccessKind::write, mip, disjoint};
}
Access read_buffer(ResourceId id) {
    return {id, AccessKind::buffer_read, 0, false};
}
Access write_buffer(ResourceId id) {
    return {id, AccessKind::buffer_write, 0, false};
}

void add(Planner& planner, std::vector<Access> accesses, Dispatch dispatch) {
    Pass& pass = planner.pass("pass", shader);
    pass.accesses = std::move(accesses);
    pass.dispatch = dispatch;
}

Dispatch over(ResourceId id) {
    return {DispatchKind::texels, id, 0, 0};
}
Dispatch from(ResourceId id, uint64_t offset = 0) {
    return {DispatchKind::indirect, id, 0, offset};
}

std::vector<Barrier> barriers(const Plan& plan) {
    std::vector<Barrier> result;
    for (const Pass& pass : plan.passes)
        result.push_back(pass.barrier);
    return result;
}

using B = Barrier;

TEST(Barriers, read_after_write) {
    Planner planner("test");
    const ResourceId a = planner.transient("a", format, extent);
    const ResourceId b = planner.transient("b", format, extent);
    add(planner, {write(a)}, over(a));
    add(planner, {fetch(a), write(b)}, over(b));
    add(planner, {fetch(a)}, over(a)); // a has been made visible
    EXPECT_EQ(barriers(std::move(planner).finish()), (std::vector{B::none, B::memory, B::none}));
}

TEST(Barriers, write_after_read_and_write_after_write) {
    Planner planner("test");
    const Image image{VK_NULL_HANDLE, VK_NULL_HANDLE, format, extent, VK_IMAGE_LAYOUT_GENERAL};
    const ResourceId a = planner.host("a", 0, image);
    add(planner, {fetch(a)}, over(a));
    add(planner, {write(a)}, over(a));
    add(planner, {write(a)}, over(a));
    EXPECT_EQ(barriers(std::move(planner).finish()), (std::vector{B::none, B::memory, B::memory}));
}

TEST(Barriers, reads_and_unrelated_writes_need_none) {
    Planner planner("test");
    const Image image{VK_NULL_HANDLE, VK_NULL_HANDLE, format, extent, VK_IMAGE_LAYOUT_GENERAL};
    const ResourceId a = planner.host("a", 0, image);
    const ResourceId b = planner.transient("b", format, extent);
    const ResourceId c = planner.transient("c", format, extent);
    add(planner, {fetch(a), write(b)}, over(b));
    add(planner, {fetch(a), fetch(no_resource), write(c)}, over(c));
    EXPECT_EQ(barriers(std::move(planner).finish()), (std::vector{B::none, B::none}));
}

TEST(Barriers, disjoint_writes_need_none_between_each_other) {
    Planner planner("test");
    const ResourceId a = planner.transient("a", format, extent);
    add(planner, {write(a, 0, true)}, over(a));
    add(planner, {write(a, 0, true)}, over(a));
    add(planner, {write(a, 0, false)}, over(a)); // touches theirs
    add(planner, {write(a, 0, true)}, over(a));
    add(planner, {fetch(a)}, over(a));
    EXPECT_EQ(barriers(std::move(planner).finish()), (std::vector{B::none, B::none, B::memory, B::memory, B::memory}));
}

TEST(Barriers, mips_are_tracked_apart) {
    Planner planner("test");
    const ResourceId a = planner.transient("a", format, extent, 3);
    add(planner, {write(a, 0)}, over(a));
    add(planner, {write(a, 1)}, over(a));              // another mip
    add(planner, {fetch(a, 0), write(a, 2)}, over(a)); // reads the first
    add(planner, {fetch(a, 1)}, over(a));              // covered by that barrier
    add(planner, {fetch(a, all_mips)}, over(a));       // mip 2 is new
    EXPECT_EQ(barriers(std::move(planner).finish()), (std::vector{B::none, B::none, B::memory, B::none, B::memory}));
}

TEST(Barriers, commands_are_guarded) {
    Planner planner("test");
    const ResourceId a = planner.transient("a", format, extent);
    const ResourceId commands = planner.buffer("commands", 64);
    add(planner, {write_buffer(commands)}, over(a));
    add(planner, {write(a)}, from(commands));
    add(planner, {write_buffer(commands)}, over(a)); // what was dispatched from is written again
    EXPECT_EQ(barriers(std::move(planner).finish()), (std::vector{B::none, B::memory_and_indirect, B::memory}));
}

// A barrier for other reasons between the writing and the dispatch must cover reading commands as well.
TEST(Barriers, a_barrier_on_the_way_is_widened_to_commands) {
    Planner planner("test");
    const ResourceId a = planner.transient("a", format, extent);
    const ResourceId b = planner.transient("b", format, extent);
    const ResourceId c = planner.transient("c", format, extent);
    const ResourceId commands = planner.buffer("commands", 64);
    add(planner, {write(a), write_buffer(commands)}, over(a));
    add(planner, {fetch(a), write(b)}, over(b));
    add(planner, {write(c)}, from(commands));
    EXPECT_EQ(barriers(std::move(planner).finish()), (std::vector{B::none, B::memory_and_indirect, B::none}));
}

TEST(Barriers, states_and_host_buffers_are_tracked_like_other_resources) {
    Planner planner("test");
    const ResourceId given = planner.host_buffer("given", 0, {VK_NULL_HANDLE, 0, 64}, 16);
    const ResourceId state = planner.state("state", 64, 16);
    const ResourceId other = planner.state("other", 64, 16);
    add(planner, {read_buffer(given), write_buffer(state)}, over(state));
    add(planner, {read_buffer(given), write_buffer(other)}, over(other)); // another state
    add(planner, {read_buffer(state), write_buffer(given)}, over(given));
    add(planner, {write_buffer(state)}, over(state)); // was read
    const Plan plan = std::move(planner).finish();
    EXPECT_EQ(barriers(plan), (std::vector{B::none, B::none, B::memory, B::memory}));
    EXPECT_EQ(plan.resources[state].index, 0u);
    EXPECT_EQ(plan.resources[other].index, 1u);
}

// ------------------------------------------------------------------------------------------ random plans

bool conflict(const Access& a, const Access& b) {
    if (a.resource != b.resource || a.resource == no_resource)
        return false;
    if (a.mip != b.mip && a.mip != all_mips && b.mip != all_mips)
        return false;
    const auto writes = [](const Access& x) {
        return x.kind == AccessKind::write || x.kind == AccessKind::buffer_write;
    };
    return (writes(a) || writes(b)) && !(a.disjoint && b.disjoint);
}

// What a pass touches, its commands included.
std::vector<Access> touched(const Pass& pass) {
    std::vector<Access> all = pass.accesses;
    if (pass.dispatch.kind == DispatchKind::indirect)
        all.push_back(read_buffer(pass.dispatch.target));
    return all;
}

bool conflict(const Pass& a, const Pass& b) {
    for (const Access& x : touched(a))
        for (const Access& y : touched(b))
            if (conflict(x, y))
                return true;
    return false;
}

bool writes_commands_of(const Pass& writer, const Pass& dispatcher) {
    if (dispatcher.dispatch.kind != DispatchKind::indirect)
        return false;
    for (const Access& access : writer.accesses)
        if (access.resource == dispatcher.dispatch.target && access.kind == AccessKind::buffer_write)
            return true;
    return false;
}

// The definition, pair by pair, without any of the planner's bookkeeping.
std::string unguarded_hazard(const Plan& plan) {
    for (size_t j = 0; j < plan.passes.size(); ++j)
        for (size_t i = 0; i < j; ++i) {
            bool any = false, indirect = false;
            for (size_t k = i + 1; k <= j; ++k) {
                any = any || plan.passes[k].barrier != Barrier::none;
                indirect = indirect || plan.passes[k].barrier == Barrier::memory_and_indirect;
            }
            if (conflict(plan.passes[i], plan.passes[j]) && !any)
                return "passes " + std::to_string(i) + " and " + std::to_string(j);
            if (writes_commands_of(plan.passes[i], plan.passes[j]) && !indirect)
                return "commands of pass " + std::to_string(j) + " from pass " + std::to_string(i);
        }
    return "";
}

std::string superfluous_barrier(const Plan& plan) {
    size_t last = 0;
    for (size_t k = 0; k < plan.passes.size(); ++k) {
        if (plan.passes[k].barrier == Barrier::none)
            continue;
        bool needed = false;
        for (size_t i = last; i < k; ++i)
            needed = needed || conflict(plan.passes[i], plan.passes[k]);
        if (!needed)
            return "before pass " + std::to_string(k);
        last = k;
    }
    return "";
}

TEST(Barriers, random_plans_have_no_unguarded_hazard_and_no_superfluous_barrier) {
    std::mt19937 random(7);
    const auto below = [&](uint32_t n) { return static_cast<uint32_t>(random() % n); };
    for (int round = 0; round < 3000; ++round) {
        Planner planner("random");
        std::vector<ResourceId> images, buffers;
        for (uint32_t i = 0, n = 1 + below(4); i < n; ++i)
            images.push_back(planner.transient("image", format, extent, 1 + below(3)));
        for (uint32_t i = 0, n = 1 + below(2); i < n; ++i)
            buffers.push_back(below(2) ? planner.buffer("buffer", 64) : planner.state("state", 64));
        for (uint32_t p = 0, n = 1 + below(10); p < n; ++p) {
            std::vector<Access> accesses;
            for (uint32_t a = 0, m = below(4); a < m; ++a) {
                const ResourceId id = images[below(static_cast<uint32_t>(images.size()))];
                if (below(5) == 0)
                    accesses.push_back({buffers[below(static_cast<uint32_t>(buffers.size()))],
                                        below(2) ? AccessKind::buffer_read : AccessKind::buffer_write, 0, false});
                else if (below(2))
                    accesses.push_back(write(id, below(3), below(3) == 0));
                else
                    accesses.push_back(fetch(below(8) == 0 ? no_resource : id, below(4) == 0 ? all_mips : below(3)));
            }
            const bool indirect = below(4) == 0;
            add(planner, std::move(accesses),
                indirect ? from(buffers[below(static_cast<uint32_t>(buffers.size()))]) : over(images[0]));
        }
        const Plan plan = std::move(planner).finish();
        ASSERT_EQ(unguarded_hazard(plan), "") << "round " << round;
        ASSERT_EQ(superfluous_barrier(plan), "") << "round " << round;
    }
}

// ------------------------------------------------------------------------------------------ defects

std::string defect_of(const std::function<void(Planner&)>& build) {
    Planner planner("test");
    build(planner);
    return check_plan(std::move(planner).finish());
}

Image host_image() {
    return {VK_NULL_HANDLE, VK_NULL_HANDLE, format, extent, VK_IMAGE_LAYOUT_GENERAL};
}

Buffer host_buffer() {
    return {VK_NULL_HANDLE, 0, 64};
}

TEST(CheckPlan, sound_plans_pass) {
    EXPECT_EQ(defect_of([](Planner& p) {
                  const ResourceId input = p.host("input", 0, host_image());
                  const ResourceId output = p.host("output", 1, host_image());
                  const ResourceId commands = p.buffer("commands", 12);
                  const ResourceId mips = p.transient("mips", format, extent, 2);
                  const History history = p.history("history", format, extent);
                  add(p, {fetch(input), write(mips, 0), write_buffer(commands)}, over(mips));
                  add(p, {fetch(mips, 0), write(mips, 1)}, {DispatchKind::texels, mips, 1, 0});
                  add(p, {fetch(mips, all_mips), fetch(history.previous), write(history.current)}, from(commands));
                  add(p, {fetch(history.current), write(output), read_buffer(commands)}, over(output));
              }),
              "");
}

// Host buffers and states hold something from the start, and passes are dispatched over the elements of any buffer.
TEST(CheckPlan, buffers_that_outlive_the_plan_may_be_read_first) {
    EXPECT_EQ(defect_of([](Planner& p) {
                  const ResourceId given = p.host_buffer("given", 0, host_buffer(), 16);
                  const ResourceId state = p.state("state", 256, 16);
                  const ResourceId made = p.buffer("made", 64, 16);
                  add(p, {read_buffer(given), read_buffer(state), write_buffer(made)}, over(made));
                  add(p, {read_buffer(made), write_buffer(state)}, over(state));
                  add(p, {read_buffer(state), write_buffer(given)}, {DispatchKind::groups, given, 0, 0, {4, 1}});
              }),
              "");
}

TEST(CheckPlan, names_the_pass_and_the_resource) {
    const std::string defect = defect_of([](Planner& p) {
        const ResourceId a = p.transient("velocity", format, extent);
        add(p, {fetch(a)}, over(a));
    });
    EXPECT_EQ(defect, "test/pass reads velocity before anything wrote it");
}

TEST(CheckPlan, finds_every_defect) {
    struct Case {
        const char* expected;
        std::function<void(Planner&)> build;
    };
    const Case cases[] = {
        {"before anything wrote it",
         [](Planner& p) {
             const ResourceId a = p.buffer("a", 64);
             const ResourceId b = p.transient("b", format, extent);
             add(p, {read_buffer(a), write(b)}, over(b));
         }},
        {"before anything wrote it", // this mip
         [](Planner& p) {
             const ResourceId a = p.transient("a", format, extent, 2);
             add(p, {write(a, 0)}, over(a));
             add(p, {fetch(a, 1)}, over(a));
         }},
        {"before anything wrote it", // all mips
         [](Planner& p) {
             const ResourceId a = p.transient("a", format, extent, 2);
             add(p, {write(a, 0)}, over(a));
             add(p, {fetch(a, all_mips)}, over(a));
         }},
        {"before anything wrote it", // commands
         [](Planner& p) {
             const ResourceId a = p.transient("a", format, extent);
             add(p, {write(a)}, from(p.buffer("commands", 12)));
         }},
        {"twice, once for writing",
         [](Planner& p) {
             const ResourceId a = p.transient("a", format, extent);
             add(p, {write(a)}, over(a));
             add(p, {fetch(a), write(a)}, over(a));
         }},
        {"twice, once for writing",
         [](Planner& p) {
             const ResourceId a = p.transient("a", format, extent);
             add(p, {write(a), write(a)}, over(a));
         }},
        {"does not exist",
         [](Planner& p) {
             const ResourceId a = p.transient("a", format, extent);
             add(p, {write(a), fetch(99)}, over(a));
         }},
        {"that does not exist",
         [](Planner& p) {
             const ResourceId a = p.transient("a", format, extent);
             add(p, {write(a, 1)}, over(a));
         }},
        {"wrong kind",
         [](Planner& p) {
             const ResourceId a = p.transient("a", format, extent);
             add(p, {write_buffer(a)}, over(a));
         }},
        {"wrong kind",
         [](Planner& p) {
             const ResourceId a = p.buffer("a", 64);
             add(p, {write(a)}, over(p.transient("b", format, extent)));
         }},
        {"binds nothing for writing",
         [](Planner& p) { add(p, {write(no_resource)}, over(p.transient("a", format, extent))); }},
        {"writes the history",
         [](Planner& p) {
             const History history = p.history("a", format, extent);
             add(p, {write(history.previous)}, over(history.previous));
         }},
        {"all mips",
         [](Planner& p) {
             const ResourceId a = p.transient("a", format, extent, 2);
             add(p, {write(a, all_mips)}, over(a));
         }},
        {"dispatches over no resource", [](Planner& p) { add(p, {}, over(no_resource)); }},
        {"no texels", [](Planner& p) { add(p, {}, over(p.buffer("a", 64))); }},
        {"no texels",
         [](Planner& p) {
             add(p, {}, {DispatchKind::texels, p.transient("a", format, extent), 1, 0});
         }},
        {"blocks of no texels",
         [](Planner& p) {
             add(p, {}, {DispatchKind::groups, p.transient("a", format, extent), 0, 0, {4, 0}});
         }},
        {"holds no command",
         [](Planner& p) {
             const ResourceId a = p.buffer("a", 20);
             add(p, {write_buffer(a)}, over(p.transient("b", format, extent)));
             add(p, {}, from(a, 12));
         }},
        {"holds no command",
         [](Planner& p) {
             const ResourceId a = p.buffer("a", 64);
             add(p, {write_buffer(a)}, over(p.transient("b", format, extent)));
             add(p, {}, from(a, 2));
         }},
        {"while it is dispatched from it",
         [](Planner& p) {
             const ResourceId a = p.buffer("a", 64);
             add(p, {write_buffer(a)}, over(p.transient("b", format, extent)));
             add(p, {write_buffer(a)}, from(a));
         }},
        {"twice, as a and b",
         [](Planner& p) {
             p.host("a", 3, host_image());
             add(p, {}, over(p.host("b", 3, host_image())));
         }},
        {"host buffer 3 twice, as a and b",
         [](Planner& p) {
             p.host_buffer("a", 3, host_buffer(), 4);
             add(p, {}, over(p.host_buffer("b", 3, host_buffer(), 4)));
         }},
        {"wrong kind",
         [](Planner& p) {
             const ResourceId a = p.state("a", 64, 4);
             add(p, {fetch(a)}, over(a));
         }},
        {"wrong kind",
         [](Planner& p) {
             const ResourceId a = p.host_buffer("a", 0, host_buffer(), 4);
             add(p, {write(a)}, over(a));
         }},
        {"before anything wrote it", // a transient buffer, whatever the others are
         [](Planner& p) {
             const ResourceId a = p.buffer("a", 64, 4);
             add(p, {read_buffer(a), write_buffer(p.state("b", 64, 4))}, over(a));
         }},
        {"twice, once for writing",
         [](Planner& p) {
             const ResourceId a = p.state("a", 64, 4);
             add(p, {read_buffer(a), write_buffer(a)}, over(a));
         }},
        {"holds no command", // of an earlier frame
         [](Planner& p) {
             const ResourceId a = p.state("a", 64, 4);
             add(p, {write_buffer(a)}, over(a));
             add(p, {}, from(a));
         }},
        {"whole words", [](Planner& p) { p.buffer("a", 0); }},
        {"whole words", [](Planner& p) { p.state("a", 6); }},
        {"0 mips", [](Planner& p) { p.transient("a", format, extent, 0); }},
    };
    for (const Case& item : cases) {
        const std::string defect = defect_of(item.build);
        EXPECT_NE(defect.find(item.expected), std::string::npos) << "found '" << defect << "', not " << item.expected;
    }
}

TEST(Planner, absent_host_images_are_no_resource) {
    Planner planner("test");
    EXPECT_EQ(planner.host("a", 0, Image{}), no_resource);
    EXPECT_EQ(planner.host_buffer("a", 0, Buffer{}, 4), no_resource);
    EXPECT_EQ(planner.host("b", 1, host_image()), 0u);
    EXPECT_EQ(planner.extent(0), extent);
    EXPECT_EQ(extent_text(extent), "8×8");
}

} // namespace
} // namespace sfumato
