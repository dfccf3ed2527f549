// A driver that runs out of memory, loses the device or lacks functions: an Error every time, nothing leaked, no crash,
// and success once it works again.
#include "tests/gpu/failing_driver.h"

#include "gpu/functions.h"
#include "shaders/executor_test.h"
#include "tests/gpu/effect_fixture.h"

#include <array>

namespace sfumato::test {
namespace {

namespace shader = shaders::executor_test;

class FailingDriverTest : public GpuTest {};

// Two frames that need everything an executor can make: history, transients with mips, buffer, constants, pipelines.
Plan everything(const Image& shown) {
    Planner planner("everything");
    const ResourceId output = planner.host("output", 0, shown);
    const History history = planner.history("history", VK_FORMAT_R32G32B32A32_SFLOAT, shown.extent);
    const ResourceId middle = planner.transient("middle", VK_FORMAT_R32_SFLOAT, shown.extent, 2);
    const ResourceId buffer = planner.buffer("buffer", 64);
    const std::array<float, 4> one = {1, 1, 1, 1}, two = {2, 2, 2, 2};
    Pass& accumulate = planner.pass("accumulate", shader::accumulate);
    accumulate.accesses = {{history.previous}, {history.current, AccessKind::write}, {middle, AccessKind::write}};
    accumulate.constants = constants_of(one);
    accumulate.dispatch = {DispatchKind::texels, output};
    Pass& command = planner.pass("command", shader::command);
    command.accesses = {{buffer, AccessKind::buffer_write}};
    command.constants = constants_of(two);
    command.dispatch = {DispatchKind::groups, planner.transient("one", VK_FORMAT_R32_SFLOAT, {1, 1})};
    Pass& stamp = planner.pass("stamp", shader::stamp);
    stamp.accesses = {{middle, AccessKind::write, 1}};
    stamp.dispatch = {DispatchKind::indirect, buffer, 0, 16};
    Pass& copy = planner.pass("copy", shader::copy);
    copy.accesses = {{middle}, {output, AccessKind::write}};
    copy.dispatch = {DispatchKind::texels, output};
    return std::move(planner).finish();
}

Result<void> execute(Executor& executor, const Image& shown, uint64_t frame) {
    Result<void> done;
    run_commands([&](VkCommandBuffer commands) {
        done = executor.execute(commands, everything(shown), std::array{shown}, frame);
    });
    return done;
}

ContextInfo info_with(FailingDriver& driver) {
    ContextInfo info = device().context_info();
    info.timestamps = device().timestamps();
    driver.install(info);
    return info;
}

// What the driver refused must come out as an error that says so, whatever was being done.
void expect_error(const Error& error, const FailingDriver& driver) {
    EXPECT_NE(error.message.find(driver.last_failed), std::string::npos)
        << "'" << error.message << "' does not name " << driver.last_failed;
    const ErrorCode code = driver.result == VK_ERROR_DEVICE_LOST ? ErrorCode::device_lost : ErrorCode::out_of_memory;
    EXPECT_EQ(error.code, code) << error.message;
}

// One life of a context: creation and three frames. Returns whether an error came up, after which the driver works
// again and all three frames must succeed.
bool live(FailingDriver& driver, const apps::HostImage& shown) {
    const ContextInfo info = info_with(driver);
    bool error_seen = false;
    const auto heal = [&](const Error& error) {
        error_seen = true;
        expect_error(error, driver);
        driver.fail_at = -1;
        driver.fail_always.clear();
    };
    auto context = Context::create(info);
    if (!context) {
        heal(context.error());
        EXPECT_EQ(driver.total_alive(), 0) << "leaked by a failed Context::create";
        context = Context::create(info);
    }
    if (!context) {
        ADD_FAILURE() << "no context although the driver works again: " << context.error().message;
        return error_seen;
    }
    {
        auto executor = Executor::create(**context);
        for (uint64_t frame = 0; frame < 3; ++frame) {
            auto done = execute(**executor, shown.image(), frame);
            if (!done) {
                heal(done.error());
                done = execute(**executor, shown.image(), frame);
            }
            EXPECT_TRUE(done) << "frame " << frame << " after the failure: " << (done ? "" : done.error().message);
        }
        EXPECT_EQ(read_back(shown).values[0], 3.0f) << "after " << driver.last_failed;
    }
    *context = nullptr;
    EXPECT_EQ(driver.total_alive(), 0) << "leaked after " << driver.last_failed << " failed";
    return error_seen;
}

TEST_F(FailingDriverTest, each_call_in_turn) {
    const auto shown = expect_value(device().create_image(VK_FORMAT_R32_SFLOAT, {9, 5}), "create_image");
    FailingDriver counting;
    ASSERT_FALSE(live(counting, shown));
    ASSERT_GT(counting.calls, 40);
    int errors = 0;
    for (const VkResult result : {VK_ERROR_OUT_OF_DEVICE_MEMORY, VK_ERROR_OUT_OF_HOST_MEMORY, VK_ERROR_DEVICE_LOST})
        for (int n = 0; n < counting.calls; ++n) {
            FailingDriver driver;
            driver.fail_at = n;
            driver.result = result;
            errors += live(driver, shown);
            ASSERT_EQ(driver.failed, 1) << n;
            if (HasFailure()) {
                ADD_FAILURE() << "call " << n << ", " << driver.last_failed;
                return;
            }
        }
    // Memory may come from another heap instead, nothing else is tried twice.
    EXPECT_GE(errors, 2 * counting.calls);
}

TEST_F(FailingDriverTest, each_function_for_good) {
    const auto shown = expect_value(device().create_image(VK_FORMAT_R32_SFLOAT, {9, 5}), "create_image");
    for (const char* name : {"vkAllocateMemory", "vkCreateImage", "vkCreateImageView", "vkCreateBuffer", "vkMapMemory",
                             "vkCreateComputePipelines", "vkCreateShaderModule", "vkCreateDescriptorPool",
                             "vkAllocateDescriptorSets", "vkBindImageMemory", "vkCreateSampler"})
        for (const VkResult result : {VK_ERROR_OUT_OF_DEVICE_MEMORY, VK_ERROR_OUT_OF_POOL_MEMORY}) {
            SCOPED_TRACE(name);
            FailingDriver driver;
            driver.fail_always = name;
            driver.result = result;
            EXPECT_TRUE(live(driver, shown));
        }
}

// Failing over and over uses nothing up.
TEST_F(FailingDriverTest, many_failures_in_a_row) {
    const auto shown = expect_value(device().create_image(VK_FORMAT_R32_SFLOAT, {9, 5}), "create_image");
    for (const char* name : {"vkMapMemory", "vkCreateComputePipelines", "vkCreateBuffer"}) {
        FailingDriver driver;
        const auto context = expect_value(Context::create(info_with(driver)), "Context::create");
        {
            const auto executor = expect_value(Executor::create(*context), "Executor::create");
            driver.fail_always = name;
            for (uint64_t frame = 0; frame < 150; ++frame)
                ASSERT_FALSE(execute(*executor, shown.image(), frame / 2));
            driver.fail_always.clear();
            const auto done = execute(*executor, shown.image(), 100);
            EXPECT_TRUE(done) << name << ": " << (done ? "" : done.error().message);
        }
    }
}

TEST_F(FailingDriverTest, missing_functions_are_named) {
#define NAME(name) #name,
    const char* needed[] = {SFUMATO_DEVICE_FUNCTIONS(NAME)};
    const char* optional[] = {SFUMATO_OPTIONAL_FUNCTIONS(NAME)};
#undef NAME
    for (const char* name : needed) {
        FailingDriver driver;
        driver.hidden = {name};
        const auto context = Context::create(info_with(driver));
        ASSERT_FALSE(context) << name;
        EXPECT_EQ(context.error().code, ErrorCode::unsupported);
        EXPECT_NE(context.error().message.find(name), std::string::npos) << context.error().message;
        EXPECT_EQ(driver.total_alive(), 0);
    }
    const auto shown = expect_value(device().create_image(VK_FORMAT_R32_SFLOAT, {9, 5}), "create_image");
    for (const char* name : optional) {
        FailingDriver driver;
        driver.hidden = {name};
        EXPECT_FALSE(live(driver, shown)) << name;
    }
}

// Every effect: a failure somewhere in its first frame, then the frame again.
class FailingEffect : public EffectTest {};

TEST_P(FailingEffect, recovers_and_leaks_nothing) {
    constexpr Extent extent{40, 24};
    const ParameterSet parameters = defaults();
    const auto run = [&](FailingDriver& driver, Context& context) {
        EffectRig rig(context, effect());
        set_fixture(rig, effect(), extent);
        const int first = driver.calls;
        FloatImage output;
        try {
            output = rig.run(fixture_frame(1, extent), parameters.data());
        } catch (const std::runtime_error& error) {
            EXPECT_EQ(driver.failed, 1) << error.what();
            EXPECT_NE(std::string(error.what()).find(driver.last_failed), std::string::npos) << error.what();
            expect_done(device().submit_and_wait(), "submit"); // what was begun
            driver.fail_at = -1;
            output = rig.run(fixture_frame(1, extent), parameters.data());
        }
        return std::pair(output, driver.calls - first);
    };
    FailingDriver counting;
    std::pair<FloatImage, int> good;
    int first = 0;
    {
        const auto context = expect_value(Context::create(info_with(counting)), "Context::create");
        first = counting.calls;
        good = run(counting, *context);
    }
    EXPECT_EQ(counting.total_alive(), 0);
    const int step = std::max(1, good.second / 25); // some of them: pipelines take long
    for (int n = 0; n < good.second; n += step) {
        FailingDriver driver;
        {
            const auto context = expect_value(Context::create(info_with(driver)), "Context::create");
            driver.fail_at = first + n;
            EXPECT_EQ(first_difference(run(driver, *context).first, good.first), "") << driver.last_failed;
        }
        EXPECT_EQ(driver.total_alive(), 0) << driver.last_failed;
    }
}

INSTANTIATE_TEST_SUITE_P(effects, FailingEffect, testing::ValuesIn(all_effects()), effect_test_name);

} // namespace
} // namespace sfumato::test
