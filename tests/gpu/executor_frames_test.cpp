// The executor: constants, frames in flight, timestamps, labels, and what it refuses.
#include "tests/gpu/executor_support.h"

namespace sfumato::test {
namespace {

class ExecutorFrames : public ExecutorTest {};

// ------------------------------------------------------------------------------------------ constants

TEST_F(ExecutorFrames, constants_larger_than_128_bytes) {
    const auto context = make_context();
    const auto executor = make_executor(*context);
    const auto shown = blank({16, 16});
    Planner planner("large");
    const ResourceId output = planner.host("output", 0, shown.image());
    std::array<Value, 256> values;
    for (size_t i = 0; i < values.size(); ++i)
        values[i] = {static_cast<float>(i) * 0.5f};
    Pass& pass = planner.pass("large", shader::large);
    pass.accesses = {write(output)};
    pass.constants = constants_of(values);
    pass.dispatch = over(output);
    execute(*executor, std::move(planner).finish(), shown.image());
    expect_image(shown, [](uint32_t x, uint32_t y) { return 0.5f * static_cast<float>(x + 16 * y); });
}

TEST_F(ExecutorFrames, many_passes_in_one_frame) {
    const auto context = make_context();
    const auto executor = make_executor(*context);
    const auto shown = blank({8, 8}, VK_FORMAT_R32_SFLOAT);
    // More sets than a pool, more constants than a chunk: 150 passes of 4 KiB.
    Planner planner("many");
    const ResourceId output = planner.host("output", 0, shown.image());
    for (int i = 0; i < 150; ++i) {
        std::array<Value, 256> values{};
        values[9] = {static_cast<float>(i)};
        Pass& pass = planner.pass("large", shader::large);
        pass.accesses = {write(output)};
        pass.constants = constants_of(values);
        pass.dispatch = over(output);
    }
    const Plan plan = std::move(planner).finish();
    for (uint64_t frame = 0; frame < 4; ++frame) {
        execute(*executor, plan, shown.image(), frame);
        EXPECT_EQ(*read_back(shown).at(1, 1), 149.0f);
    }
    const uint64_t held = context->memory_usage().constants;
    for (uint64_t frame = 4; frame < 8; ++frame)
        execute(*executor, plan, shown.image(), frame);
    EXPECT_EQ(context->memory_usage().constants, held) << "slots are reused";
}

// ------------------------------------------------------------------------------------------ frames in flight

TEST_F(ExecutorFrames, frames_in_flight_do_not_disturb_each_other) {
    for (const uint32_t in_flight : {1u, 2u, 3u}) {
        const auto context = make_context(-1, [&](ContextInfo& info) { info.frames_in_flight = in_flight; });
        const auto executor = make_executor(*context);
        std::vector<apps::Commands> commands;
        std::vector<apps::HostImage> shown;
        for (uint32_t i = 0; i < in_flight; ++i) {
            commands.push_back(expect_value(device().create_commands(), "create_commands"));
            shown.push_back(blank({128, 64}));
        }
        const auto expect_frame = [&](uint64_t frame) {
            // Constants and descriptor sets of a frame were still its own when it ran.
            expect_image(shown[frame % in_flight],
                         [&](uint32_t, uint32_t) { return static_cast<float>((frame + 1) * (frame + 2) / 2); });
        };
        constexpr uint64_t frames = 9;
        for (uint64_t frame = 0; frame < frames; ++frame) {
            apps::Commands& mine = commands[frame % in_flight];
            expect_done(device().wait(mine), "wait");
            if (frame >= in_flight)
                expect_frame(frame - in_flight);
            expect_done(device().begin(mine), "begin");
            const Image image = shown[frame % in_flight].image();
            const Plan plan = accumulate(image, static_cast<float>(frame + 1));
            expect_done(executor->execute(mine.buffer(), plan, std::array{image}, frame), "execute");
            expect_done(device().submit(mine), "submit");
        }
        expect_done(device().wait_idle(), "wait_idle");
        for (uint64_t frame = frames - in_flight; frame < frames; ++frame)
            expect_frame(frame);
        // One slot each, and no more.
        const uint64_t chunk = context->memory_usage().constants;
        const auto other = make_context(-1, [](ContextInfo& info) { info.frames_in_flight = 1; });
        const auto single = make_executor(*other);
        execute(*single, accumulate(shown[0].image(), 1.0f), shown[0].image());
        const uint64_t zero_image = make_context()->memory_usage().constants;
        EXPECT_EQ(chunk - zero_image, in_flight * (other->memory_usage().constants - zero_image));
    }
}

// A command buffer that was recorded and thrown away leaves nothing behind that a later one depends on.
TEST_F(ExecutorFrames, transients_survive_a_recording_that_was_never_submitted) {
    const auto context = make_context();
    const auto executor = make_executor(*context);
    const auto shown = blank({16, 16});
    Planner planner("chain");
    const ResourceId output = planner.host("output", 0, shown.image());
    const ResourceId middle = planner.transient("middle", real, {16, 16});
    fill(planner, middle, 2.0f);
    copy(planner, middle, output);
    const Plan plan = std::move(planner).finish();
    const VkCommandBuffer thrown_away = expect_value(device().begin(), "begin");
    expect_done(executor->execute(thrown_away, plan, std::array{shown.image()}, 0), "execute");
    execute(*executor, plan, shown.image(), 1); // begins the same command buffer anew
    expect_image(shown, [](uint32_t x, uint32_t y) { return 2.0f + pattern(x, y); });
}

// ------------------------------------------------------------------------------------------ timestamps and labels

TEST_F(ExecutorFrames, timestamps_name_every_pass) {
    if (!device().timestamps())
        GTEST_SKIP() << "the device's queue has no timestamps";
    const auto context = make_context(-1, [](ContextInfo& info) { info.timestamps = true; });
    const auto executor = make_executor(*context);
    EXPECT_TRUE(executor->times().empty());
    const auto shown = blank({256, 256});
    for (uint64_t frame = 0; frame < 5; ++frame) {
        Planner planner("timed");
        const ResourceId output = planner.host("output", 0, shown.image());
        const ResourceId middle = planner.transient("middle", real, {256, 256});
        fill(planner, middle, 2.0f);
        copy(planner, middle, output);
        execute(*executor, std::move(planner).finish(), shown.image(), frame);
        const auto times = executor->times();
        ASSERT_EQ(times.size(), 2u);
        EXPECT_EQ(times[0].pass, "timed/fill");
        EXPECT_EQ(times[1].pass, "timed/copy");
        for (const PassTime& time : times)
            EXPECT_TRUE(time.milliseconds > 0.0 && time.milliseconds < 10000.0) << time.milliseconds;
    }
}

TEST_F(ExecutorFrames, without_timestamps_there_are_no_times) {
    const auto context = make_context();
    const auto executor = make_executor(*context);
    const auto shown = blank({8, 8});
    execute(*executor, accumulate(shown.image(), 1.0f), shown.image());
    EXPECT_TRUE(executor->times().empty());
}

struct Labels {
    static inline PFN_vkGetDeviceProcAddr real_get = nullptr;
    static inline std::vector<std::string> begun;
    static inline int depth = 0;
    static VKAPI_ATTR void VKAPI_CALL begin(VkCommandBuffer, const VkDebugUtilsLabelEXT* label) {
        begun.push_back(std::string(static_cast<size_t>(2 * depth++), ' ') + label->pLabelName);
    }
    static VKAPI_ATTR void VKAPI_CALL end(VkCommandBuffer) { --depth; }
    static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL get(VkDevice handle, const char* name) {
        if (std::string(name) == "vkCmdBeginDebugUtilsLabelEXT")
            return reinterpret_cast<PFN_vkVoidFunction>(&begin);
        if (std::string(name) == "vkCmdEndDebugUtilsLabelEXT")
            return reinterpret_cast<PFN_vkVoidFunction>(&end);
        return real_get(handle, name);
    }
};

TEST_F(ExecutorFrames, labels_nest_passes_in_their_effect) {
    Labels::begun.clear();
    const auto context = make_context(-1, [](ContextInfo& info) {
        Labels::real_get = info.get_device_proc_addr;
        info.get_device_proc_addr = &Labels::get;
        info.labels = true;
    });
    const auto executor = make_executor(*context);
    const auto shown = blank({8, 8});
    execute(*executor, accumulate(shown.image(), 1.0f), shown.image());
    EXPECT_EQ(Labels::begun, (std::vector<std::string>{"accumulate", "  accumulate"}));
    EXPECT_EQ(Labels::depth, 0);
}

// ------------------------------------------------------------------------------------------ refusals

TEST_F(ExecutorFrames, bindings_that_do_not_fit_are_an_error_with_pass_and_binding) {
    const auto context = make_context();
    const auto executor = make_executor(*context);
    const auto shown = blank({8, 8});
    const auto error_of = [&](const std::function<void(Pass&, ResourceId output, ResourceId buffer)>& change) {
        Planner planner("misfit");
        const ResourceId output = planner.host("output", 0, shown.image());
        const ResourceId buffer = planner.buffer("buffer", 64);
        Pass& pass = planner.pass("gather", shader::fill);
        pass.accesses = {write(output)};
        pass.constants = constants_of(Value{1.0f});
        pass.dispatch = over(output);
        change(pass, output, buffer);
        const Plan plan = std::move(planner).finish();
        std::string message;
        run_commands([&](VkCommandBuffer commands) {
            const auto done = executor->execute(commands, plan, std::array{shown.image()}, 0);
            message = done ? "" : done.error().message;
        });
        return message;
    };
    const auto expect = [](const std::string& message, std::initializer_list<const char*> parts) {
        for (const char* part : parts)
            EXPECT_NE(message.find(part), std::string::npos) << "'" << message << "' lacks " << part;
    };
    EXPECT_EQ(error_of([](Pass&, ResourceId, ResourceId) {}), "");
    expect(error_of([](Pass& pass, ResourceId, ResourceId) { pass.constants.clear(); }),
           {"misfit/gather", "executor_test/fill", "binding 0 of set 1", "constants"});
    expect(error_of([](Pass& pass, ResourceId, ResourceId) { pass.accesses.clear(); }),
           {"misfit/gather", "binding 0 of set 0", "not bound"});
    expect(error_of([](Pass& pass, ResourceId, ResourceId buffer) {
               pass.accesses = {{buffer, AccessKind::buffer_write, 0, false}};
           }),
           {"misfit/gather", "binding 0 of set 0", "storage image", "storage buffer"});
    expect(error_of([](Pass& pass, ResourceId output, ResourceId) { pass.accesses = {fetch(output)}; }),
           {"misfit/gather", "binding 0", "storage image", "sampled image"});
    expect(error_of([](Pass& pass, ResourceId output, ResourceId) {
               pass.shader = shader::combine;
               pass.accesses = {fetch(no_resource), write(output)};
           }),
           {"misfit/gather", "executor_test/combine", "binding"});
}

TEST_F(ExecutorFrames, defects_and_missing_images_are_errors) {
    const auto context = make_context();
    const auto executor = make_executor(*context);
    const auto shown = blank({8, 8});
    const VkCommandBuffer commands = expect_value(device().begin(), "begin");
    Planner unwritten("defect");
    copy(unwritten, unwritten.transient("a", real, {8, 8}), unwritten.host("output", 0, shown.image()));
    const auto defect = executor->execute(commands, std::move(unwritten).finish(), std::array{shown.image()}, 0);
    ASSERT_FALSE(defect);
    EXPECT_EQ(defect.error().code, ErrorCode::internal);
    EXPECT_EQ(defect.error().message, "defect/copy reads a before anything wrote it");
    const auto missing = executor->execute(commands, accumulate(shown.image(), 1.0f), {}, 0);
    ASSERT_FALSE(missing);
    EXPECT_NE(missing.error().message.find("'shown'"), std::string::npos) << missing.error().message;
    const auto no_commands =
        executor->execute(VK_NULL_HANDLE, accumulate(shown.image(), 1.0f), std::array{shown.image()}, 0);
    ASSERT_FALSE(no_commands);
    EXPECT_EQ(no_commands.error().code, ErrorCode::invalid_argument);
    Planner huge("huge");
    const ResourceId wide = huge.transient("wide", real, {1u << 20, 4});
    fill(huge, wide, 1.0f);
    const auto too_wide = executor->execute(commands, std::move(huge).finish(), std::array{shown.image()}, 0);
    ASSERT_FALSE(too_wide);
    EXPECT_EQ(too_wide.error().code, ErrorCode::unsupported) << too_wide.error().message;
    Planner fat("fat");
    fill(fat, fat.host("output", 0, shown.image()), 1.0f);
    Plan fat_plan = std::move(fat).finish();
    fat_plan.passes[0].constants.resize(20000);
    EXPECT_FALSE(executor->execute(commands, fat_plan, std::array{shown.image()}, 0));
    expect_done(device().submit_and_wait(), "submit");
    execute(*executor, accumulate(shown.image(), 1.0f), shown.image(), 5);
    expect_image(shown, [](uint32_t, uint32_t) { return 1.0f; });
}

// Vulkan guarantees few bindings a shader: a device that has no more gets an error, not an invalid pipeline.
TEST_F(ExecutorFrames, passes_that_bind_more_than_the_device_allows_are_refused) {
    const auto shown = blank({4, 4});
    Planner planner("wide");
    const ResourceId output = planner.host("output", 0, shown.image());
    const ResourceId a = planner.transient("a", real, {4, 4});
    const ResourceId b = planner.transient("b", real, {4, 4});
    fill(planner, a, 1.0f);
    fill(planner, b, 2.0f);
    combine(planner, a, b, output);
    const Plan plan = std::move(planner).finish();
    const auto message = [&](const auto& lower) {
        const auto context = make_context();
        const auto executor = make_executor(*context);
        lower(context->state().most_bindings);
        std::string result;
        run_commands([&](VkCommandBuffer commands) {
            const auto done = executor->execute(commands, plan, std::array{shown.image()}, 0, false);
            result = done ? "" : done.error().message;
            EXPECT_TRUE(done || done.error().code == ErrorCode::unsupported);
        });
        return result;
    };
    const std::string end = "; a shader of this device may bind ";
    EXPECT_EQ(message([](auto& most) { most.sampled_images = 1; }),
              "wide: pass combine binds 2 sampled images" + end + "1");
    EXPECT_EQ(message([](auto& most) { most.storage_images = 0; }),
              "wide: pass fill binds 1 storage images" + end + "0");
    EXPECT_EQ(message([](auto& most) { most.all = 2; }), "wide: pass combine binds 3 resources" + end + "2");
    EXPECT_EQ(message([](auto& most) { most.sampled_images = 2, most.storage_images = 1, most.all = 3; }), "");
}

TEST_F(ExecutorFrames, contexts_refuse_what_they_cannot_use) {
    const auto error_of = [](const std::function<void(ContextInfo&)>& change) {
        ContextInfo info = device().context_info();
        change(info);
        const auto context = Context::create(info);
        return context ? "" : context.error().message;
    };
    const std::pair<const char*, std::function<void(ContextInfo&)>> cases[] = {
        {"instance is null", [](ContextInfo& info) { info.instance = VK_NULL_HANDLE; }},
        {"physical_device is null", [](ContextInfo& info) { info.physical_device = VK_NULL_HANDLE; }},
        {"device is null", [](ContextInfo& info) { info.device = VK_NULL_HANDLE; }},
        {"get_instance_proc_addr is null", [](ContextInfo& info) { info.get_instance_proc_addr = nullptr; }},
        {"get_device_proc_addr is null", [](ContextInfo& info) { info.get_device_proc_addr = nullptr; }},
        {"frames_in_flight is 0", [](ContextInfo& info) { info.frames_in_flight = 0; }},
        {"frames_in_flight is 17", [](ContextInfo& info) { info.frames_in_flight = 17; }},
        {"headers of version 9.8", [](ContextInfo& info) { info.header_version = 9u << 20 | 8u << 10; }},
    };
    for (const auto& [expected, change] : cases)
        EXPECT_NE(error_of(change).find(expected), std::string::npos) << error_of(change);
    EXPECT_EQ(error_of([](ContextInfo&) {}), "");
}

} // namespace
} // namespace sfumato::test
