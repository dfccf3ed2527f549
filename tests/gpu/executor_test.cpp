// The executor: histories, transients that share memory, dispatch, mips.
#include "tests/gpu/executor_support.h"

namespace sfumato::test {
namespace {

// ------------------------------------------------------------------------------------------ histories

TEST_F(ExecutorTest, histories_accumulate_over_frames) {
    for (const int poison : {-1, 0, 1}) {
        const auto context = make_context(poison);
        const auto executor = make_executor(*context);
        const auto shown = blank({33, 17});
        for (uint64_t frame = 0; frame < 5; ++frame) {
            execute(*executor, accumulate(shown.image(), 2.0f), shown.image(), 10 + frame);
            const auto expected = 2.0f * static_cast<float>(frame + 1);
            expect_image(shown, [&](uint32_t, uint32_t) { return expected; });
        }
    }
}

TEST_F(ExecutorTest, plans_of_one_frame_share_its_history) {
    const auto context = make_context();
    const auto executor = make_executor(*context);
    const auto shown = blank({8, 8});
    for (int i = 0; i < 3; ++i) // reads what the previous frame left: nothing
        execute(*executor, accumulate(shown.image(), 3.0f), shown.image(), 1);
    expect_image(shown, [](uint32_t, uint32_t) { return 3.0f; });
    execute(*executor, accumulate(shown.image(), 3.0f), shown.image(), 2);
    expect_image(shown, [](uint32_t, uint32_t) { return 6.0f; });
}

TEST_F(ExecutorTest, a_reset_clears_histories) {
    const auto context = make_context(0);
    const auto executor = make_executor(*context);
    const auto shown = blank({9, 9});
    for (uint64_t frame = 0; frame < 3; ++frame)
        execute(*executor, accumulate(shown.image(), 1.0f), shown.image(), frame);
    execute(*executor, accumulate(shown.image(), 1.0f), shown.image(), 3, true);
    expect_image(shown, [](uint32_t, uint32_t) { return 1.0f; });
    execute(*executor, accumulate(shown.image(), 1.0f), shown.image(), 4);
    expect_image(shown, [](uint32_t, uint32_t) { return 2.0f; });
}

TEST_F(ExecutorTest, a_change_of_extent_recreates_histories) {
    const auto context = make_context(0);
    const auto executor = make_executor(*context);
    const Extent extents[] = {{20, 10}, {40, 20}, {8, 30}, {20, 10}};
    uint64_t frame = 0, bytes = 0;
    for (const Extent extent : extents) {
        const auto shown = blank(extent);
        for (int i = 0; i < 3; ++i) {
            execute(*executor, accumulate(shown.image(), 1.0f), shown.image(), frame++);
            const auto expected = static_cast<float>(i + 1);
            expect_image(shown, [&](uint32_t, uint32_t) { return expected; });
        }
        context->trim();
        if (frame == 3)
            bytes = context->memory_usage().histories;
    }
    EXPECT_EQ(context->memory_usage().histories, bytes) << "what was replaced has been freed";
}

TEST_F(ExecutorTest, streams_have_their_own_histories) {
    const auto context = make_context();
    const auto a = make_executor(*context);
    const auto b = make_executor(*context);
    const auto shown_a = blank({8, 8}), shown_b = blank({8, 8});
    for (uint64_t frame = 0; frame < 3; ++frame) {
        execute(*a, accumulate(shown_a.image(), 1.0f), shown_a.image(), frame);
        execute(*b, accumulate(shown_b.image(), 10.0f), shown_b.image(), frame);
    }
    expect_image(shown_a, [](uint32_t, uint32_t) { return 3.0f; });
    expect_image(shown_b, [](uint32_t, uint32_t) { return 30.0f; });
}

// ------------------------------------------------------------------------------------------ transients

TEST_F(ExecutorTest, transients_share_memory_after_their_last_read) {
    for (const int poison : {-1, 0, 1}) {
        const auto context = make_context(poison);
        const auto executor = make_executor(*context);
        const auto shown = blank({40, 24});
        Planner planner("chain");
        const ResourceId output = planner.host("output", 0, shown.image());
        // A chain of six transients: two images will do.
        ResourceId last = planner.transient("first", real, {40, 24});
        fill(planner, last, 1.0f);
        for (int i = 0; i < 5; ++i) {
            const ResourceId next = planner.transient("next", real, {40, 24});
            copy(planner, last, next, 2.0f);
            last = next;
        }
        copy(planner, last, output);
        execute(*executor, std::move(planner).finish(), shown.image());
        expect_image(shown, [](uint32_t x, uint32_t y) { return 32.0f * (1.0f + pattern(x, y)); });
        EXPECT_EQ(context->state().transients.size(), 2u);
    }
}

// Where a transient takes over the image of one that was only just read, a barrier stands that the plan does not have.
TEST_F(ExecutorTest, a_barrier_is_forced_where_memory_is_reused) {
    const auto context = make_context(0);
    const auto executor = make_executor(*context);
    const auto shown = blank({64, 64});
    Planner planner("reuse");
    const ResourceId output = planner.host("output", 0, shown.image());
    const ResourceId a = planner.transient("a", real, {64, 64});
    const ResourceId b = planner.transient("b", VK_FORMAT_R32G32_SFLOAT, {64, 64});
    const ResourceId c = planner.transient("c", real, {64, 64}); // takes a's image, while b is being made from it
    fill(planner, a, 5.0f);
    copy(planner, a, b);
    fill(planner, c, 7.0f);
    combine(planner, b, c, output);
    const Plan plan = std::move(planner).finish();
    ASSERT_EQ(plan.passes[2].barrier, Barrier::none) << "the plan knows no hazard here";
    execute(*executor, plan, shown.image());
    EXPECT_EQ(context->state().transients.size(), 2u);
    expect_image(shown, [](uint32_t x, uint32_t y) { return 12.0f + 2.0f * pattern(x, y); });
}

TEST_F(ExecutorTest, transients_are_pooled_across_executors_and_freed_when_unused) {
    const auto context = make_context();
    const auto a = make_executor(*context);
    const auto b = make_executor(*context);
    const auto shown = blank({16, 16});
    const auto plan = [&] {
        Planner planner("pool");
        const ResourceId output = planner.host("output", 0, shown.image());
        const ResourceId one = planner.transient("one", real, {16, 16});
        fill(planner, one, 1.0f);
        copy(planner, one, output);
        return std::move(planner).finish();
    }();
    execute(*a, plan, shown.image(), 0);
    execute(*b, plan, shown.image(), 0);
    EXPECT_EQ(context->state().transients.size(), 1u);
    EXPECT_GE(context->memory_usage().transients, 16u * 16u * 4u);
    Planner direct("direct");
    fill(direct, direct.host("output", 0, shown.image()), 1.0f);
    const Plan small = std::move(direct).finish();
    for (uint64_t frame = 1; frame < 40; ++frame)
        execute(*b, small, shown.image(), frame);
    EXPECT_EQ(context->memory_usage().transients, 0u) << "unused for many frames";
}

// ------------------------------------------------------------------------------------------ dispatch

TEST_F(ExecutorTest, indirect_dispatch) {
    for (const float groups : {0.0f, 1.0f, 3.0f}) {
        const auto context = make_context(1);
        const auto executor = make_executor(*context);
        const auto shown = blank({16, 16});
        Planner planner("indirect");
        const ResourceId output = planner.host("output", 0, shown.image());
        const ResourceId commands = planner.buffer("commands", 64);
        const ResourceId other = planner.transient("other", real, {4, 4});
        Pass& command = planner.pass("command", shader::command);
        command.accesses = {{commands, AccessKind::buffer_write, 0, false}};
        command.constants = constants_of(Value{groups, 2.0f});
        command.dispatch = {DispatchKind::groups, other, 0, 0};
        // A barrier of another hazard between the writing and the dispatch.
        fill(planner, other, 0.0f);
        fill(planner, other, 1.0f);
        Pass& stamp = planner.pass("stamp", shader::stamp);
        stamp.specialization = {std::bit_cast<uint32_t>(9.0f)};
        stamp.accesses = {write(output)};
        stamp.dispatch = {DispatchKind::indirect, commands, 0, 16};
        execute(*executor, std::move(planner).finish(), shown.image());
        expect_image(shown, [&](uint32_t x, uint32_t y) {
            return x < static_cast<uint32_t>(groups) * 4 && y < 8 ? 9.0f : 0.0f;
        });
    }
}

TEST_F(ExecutorTest, dispatch_by_texels_and_by_groups) {
    const auto context = make_context();
    const auto executor = make_executor(*context);
    for (const Extent extent : {Extent{1, 1}, Extent{7, 3}, Extent{8, 8}, Extent{9, 17}, Extent{257, 2}}) {
        const auto shown = blank(extent);
        Planner texels("texels");
        fill(texels, texels.host("output", 0, shown.image()), 4.0f);
        execute(*executor, std::move(texels).finish(), shown.image());
        expect_image(shown, [](uint32_t x, uint32_t y) { return 4.0f + pattern(x, y); });
        Planner groups("groups");
        const ResourceId output = groups.host("output", 0, shown.image());
        Pass& pass = groups.pass("count", shader::count_groups);
        pass.accesses = {write(output)};
        pass.dispatch = {DispatchKind::groups, output, 0, 0};
        execute(*executor, std::move(groups).finish(), shown.image());
        expect_image(shown, [](uint32_t, uint32_t) { return 16.0f; });
    }
}

TEST_F(ExecutorTest, mips) {
    for (const int poison : {-1, 0}) {
        const auto context = make_context(poison);
        const auto executor = make_executor(*context);
        const auto shown = blank({5, 3});
        Planner planner("mips");
        const ResourceId output = planner.host("output", 0, shown.image());
        const ResourceId pyramid = planner.transient("pyramid", real, {20, 12}, 3);
        fill(planner, pyramid, 100.0f, 2); // 5×3
        fill(planner, pyramid, 10.0f, 0);
        copy(planner, pyramid, pyramid, 3.0f, 2, 1); // 10×6 from 5×3, nearest
        const ResourceId small = planner.transient("small", real, {5, 3});
        copy(planner, pyramid, small, 1.0f, 1, 0);
        const ResourceId top = planner.transient("top", real, {5, 3});
        Pass& pass = planner.pass("all", shader::copy); // through the view of all mips: level 0
        pass.specialization = {std::bit_cast<uint32_t>(1.0f)};
        pass.accesses = {fetch(pyramid, all_mips), write(top)};
        pass.dispatch = over(top);
        combine(planner, small, top, output);
        execute(*executor, std::move(planner).finish(), shown.image());
        expect_image(shown, [](uint32_t x, uint32_t y) {
            return 3.0f * (100.0f + pattern(x, y)) + 10.0f + pattern(4 * x + 2, 4 * y + 2);
        });
    }
}

TEST_F(ExecutorTest, filtered_reads_are_linear_and_absent_images_are_zero) {
    const auto context = make_context();
    const auto executor = make_executor(*context);
    const auto shown = blank({4, 4});
    for (const bool filtered : {false, true}) {
        Planner planner("filter");
        const ResourceId output = planner.host("output", 0, shown.image());
        const ResourceId source = planner.transient("source", real, {8, 8});
        fill(planner, source, 0.0f);
        Pass& pass = planner.pass("copy", shader::copy);
        pass.specialization = {std::bit_cast<uint32_t>(1.0f)};
        pass.accesses = {filtered ? filter(source) : fetch(source), write(output)};
        pass.dispatch = over(output);
        execute(*executor, std::move(planner).finish(), shown.image());
        const float corner = read_back(shown).values[0];
        EXPECT_EQ(corner, filtered ? 50.5f : 101.0f); // between the texels (0, 0) … (1, 1), or the last of them
    }
    Planner planner("absent");
    const ResourceId output = planner.host("output", 0, shown.image());
    copy(planner, no_resource, output);
    execute(*executor, std::move(planner).finish(), shown.image());
    expect_image(shown, [](uint32_t, uint32_t) { return 0.0f; });
}

} // namespace
} // namespace sfumato::test
