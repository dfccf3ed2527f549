// The executor: host buffers, and states, which are kept from frame to frame.
#include "tests/gpu/executor_support.h"

#include <cstring>

namespace sfumato::test {
namespace {

class ExecutorBuffers : public ExecutorTest {
  protected:
    static constexpr uint32_t count = 100;

    // Words at `offset` of a buffer that holds nothing else.
    apps::HostBuffer make(size_t offset, const std::function<uint32_t(uint32_t)>& value) {
        apps::HostBuffer made = expect_value(device().create_buffer(offset + 4 * count), "create_buffer");
        std::memset(made.bytes().data(), 0xab, made.bytes().size());
        for (uint32_t i = 0; i < count; ++i) {
            const uint32_t word = value(i);
            std::memcpy(made.bytes().data() + offset + 4 * i, &word, 4);
        }
        return made;
    }
    static uint32_t word(const apps::HostBuffer& buffer, size_t offset, uint32_t i) {
        uint32_t value;
        std::memcpy(&value, buffer.bytes().data() + offset + 4 * i, 4);
        return value;
    }

    // state += given + 1; shown += state + 1.
    static Plan accumulate_words(const Buffer& given, const Buffer& shown, uint32_t words = count) {
        Planner planner("words");
        const ResourceId source = planner.host_buffer("given", 0, given, words);
        const ResourceId target = planner.host_buffer("shown", 1, shown, words);
        const ResourceId sum = planner.state("sum", 4 * words, words);
        const auto add = [&](ResourceId from, ResourceId to) {
            Pass& pass = planner.pass("add", shader::add_words);
            pass.accesses = {{from, AccessKind::buffer_read}, {to, AccessKind::buffer_write}};
            pass.dispatch = over(to);
        };
        add(source, sum);
        add(sum, target);
        return std::move(planner).finish();
    }

    static void run(Executor& executor, const Plan& plan, std::span<const Buffer> buffers, uint64_t frame,
                    bool reset = false) {
        run_commands([&](VkCommandBuffer commands) {
            expect_done(executor.execute(commands, plan, {}, frame, reset, buffers), "execute");
            show_host(commands);
        });
    }
};

TEST_F(ExecutorBuffers, states_are_kept_until_a_reset) {
    for (const int poison : {-1, 0, 1}) {
        const auto context = make_context(poison);
        const auto executor = make_executor(*context);
        constexpr size_t offset = 512;
        const apps::HostBuffer given = make(offset, [](uint32_t i) { return 10 * i; });
        uint32_t sum = 0; // of the given words' ones
        for (uint64_t frame = 0; frame < 6; ++frame) {
            const apps::HostBuffer shown = make(0, [](uint32_t i) { return i; });
            const std::array buffers = {Buffer{given.handle(), offset, 4 * count}, shown.buffer()};
            const bool reset = frame == 4;
            sum = reset ? 1 : sum + 1;
            run(*executor, accumulate_words(buffers[0], buffers[1]), buffers, frame, reset);
            for (uint32_t i = 0; i < count; ++i)
                ASSERT_EQ(word(shown, 0, i), i + sum * (10 * i + 1) + 1) << "frame " << frame << " word " << i;
            EXPECT_EQ(word(given, 0, 0), 0xababababu) << "before the offset";
        }
    }
}

TEST_F(ExecutorBuffers, states_are_zero_after_a_change_of_size) {
    const auto context = make_context(1);
    const auto executor = make_executor(*context);
    const apps::HostBuffer given = make(0, [](uint32_t) { return 0u; });
    uint64_t frame = 0, bytes = 0;
    for (const uint32_t words : {count, 40u, count}) {
        for (uint32_t round = 1; round <= 2; ++round) {
            const apps::HostBuffer shown = make(0, [](uint32_t) { return 0u; });
            const std::array buffers = {Buffer{given.handle(), 0, 4 * words}, Buffer{shown.handle(), 0, 4 * words}};
            run(*executor, accumulate_words(buffers[0], buffers[1], words), buffers, frame++);
            ASSERT_EQ(word(shown, 0, 7), round + 1);
            ASSERT_EQ(word(shown, 0, words - 1), round + 1);
            if (words < count) {
                EXPECT_EQ(word(shown, 0, words), 0u) << "behind the range";
            }
        }
        for (int i = 0; i < 3; ++i)
            run_commands([&](VkCommandBuffer commands) {
                expect_done(executor->execute(commands, Plan{"nothing", {}, {}}, {}, frame, false), "execute");
                ++frame;
            });
        context->trim();
        if (words == count && bytes == 0)
            bytes = context->memory_usage().histories;
    }
    EXPECT_EQ(context->memory_usage().histories, bytes);
    EXPECT_TRUE(context->state().retired_buffers.empty()) << "what was replaced has been freed";
}

TEST_F(ExecutorBuffers, streams_have_their_own_states) {
    const auto context = make_context();
    auto a = make_executor(*context);
    const auto b = make_executor(*context);
    const apps::HostBuffer given = make(0, [](uint32_t) { return 4u; });
    for (uint32_t frame = 0; frame < 3; ++frame)
        for (Executor* executor : {a.get(), b.get()}) {
            const apps::HostBuffer shown = make(0, [](uint32_t) { return 0u; });
            const std::array buffers = {given.buffer(), shown.buffer()};
            run(*executor, accumulate_words(buffers[0], buffers[1]), buffers, frame);
            ASSERT_EQ(word(shown, 0, 0), 5 * (frame + 1) + 1);
        }
    const uint64_t both = context->memory_usage().histories;
    a.reset();
    EXPECT_LT(context->memory_usage().histories, both);
}

TEST_F(ExecutorBuffers, missing_or_short_buffers_are_refused) {
    const auto context = make_context();
    const auto executor = make_executor(*context);
    const apps::HostBuffer given = make(0, [](uint32_t) { return 0u; });
    const Plan plan = accumulate_words({VK_NULL_HANDLE, 0, 4 * count}, {VK_NULL_HANDLE, 0, 4 * count});
    const auto refusal = [&](std::span<const Buffer> buffers) {
        std::string text;
        run_commands([&](VkCommandBuffer commands) {
            const auto done = executor->execute(commands, plan, {}, 0, false, buffers);
            EXPECT_FALSE(done);
            if (!done)
                text = done.error().message;
        });
        return text;
    };
    const std::array one = {given.buffer()};
    EXPECT_NE(refusal(one).find("buffer 1 ('shown')"), std::string::npos) << refusal(one);
    const std::array null = {given.buffer(), Buffer{VK_NULL_HANDLE, 0, 4 * count}};
    EXPECT_NE(refusal(null).find("'shown' is a null handle"), std::string::npos) << refusal(null);
    const std::array small = {given.buffer(), Buffer{given.handle(), 0, 4 * count - 4}};
    EXPECT_NE(refusal(small).find("'shown' is 396 bytes long"), std::string::npos) << refusal(small);
    // More than shaders of the device reach.
    Planner planner("large");
    const ResourceId large = planner.buffer("large", context->state().largest_buffer + 4, 1);
    Pass& pass = planner.pass("add", shader::add_words);
    pass.accesses = {{planner.state("source", 4), AccessKind::buffer_read}, {large, AccessKind::buffer_write}};
    pass.dispatch = over(large);
    run_commands([&](VkCommandBuffer commands) {
        const auto done = executor->execute(commands, std::move(planner).finish(), {}, 0);
        EXPECT_TRUE(!done && done.error().code == ErrorCode::unsupported);
    });
}

} // namespace
} // namespace sfumato::test
