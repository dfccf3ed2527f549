// Building blocks of the executor's tests: small plans, and images to compare them on.
#pragma once

#include "gpu/context_state.h"
#include "shaders/executor_test.h"
#include "tests/gpu/gpu_test.h"

#include <array>
#include <bit>

namespace sfumato::test {

namespace shader = shaders::executor_test;
inline constexpr VkFormat real = VK_FORMAT_R32_SFLOAT;

struct Value {
    float x, y = 0, z = 0, w = 0;
};

inline apps::HostImage blank(Extent extent, VkFormat format = real) {
    return expect_value(device().create_image(format, extent), "create_image");
}

inline Access fetch(ResourceId id, uint32_t mip = 0) {
    return {id, AccessKind::fetch, mip, false};
}
inline Access filter(ResourceId id, uint32_t mip = 0) {
    return {id, AccessKind::filter, mip, false};
}
inline Access write(ResourceId id, uint32_t mip = 0) {
    return {id, AccessKind::write, mip, false};
}
inline Dispatch over(ResourceId id, uint32_t mip = 0) {
    return {DispatchKind::texels, id, mip, 0};
}

inline void fill(Planner& planner, ResourceId target, float value, uint32_t mip = 0) {
    Pass& pass = planner.pass("fill", shader::fill);
    pass.accesses = {write(target, mip)};
    pass.constants = constants_of(Value{value});
    pass.dispatch = over(target, mip);
}

inline void copy(Planner& planner, ResourceId source, ResourceId target, float factor = 1.0f, uint32_t source_mip = 0,
                 uint32_t target_mip = 0) {
    Pass& pass = planner.pass("copy", shader::copy);
    pass.specialization = {std::bit_cast<uint32_t>(factor)};
    pass.accesses = {fetch(source, source_mip), write(target, target_mip)};
    pass.dispatch = over(target, target_mip);
}

inline void combine(Planner& planner, ResourceId a, ResourceId b, ResourceId target) {
    Pass& pass = planner.pass("combine", shader::combine);
    pass.accesses = {fetch(a), fetch(b), write(target)};
    pass.dispatch = over(target);
}

// One accumulating history, shown in host image 0.
inline Plan accumulate(const Image& shown, float value) {
    Planner planner("accumulate");
    const ResourceId target = planner.host("shown", 0, shown);
    const History history = planner.history("sum", VK_FORMAT_R32G32B32A32_SFLOAT, shown.extent);
    Pass& pass = planner.pass("accumulate", shader::accumulate);
    pass.accesses = {fetch(history.previous), write(history.current), write(target)};
    pass.constants = constants_of(Value{value, value, value, value});
    pass.dispatch = over(history.current);
    return std::move(planner).finish();
}

inline void execute(Executor& executor, const Plan& plan, const Image& image, uint64_t frame = 0, bool reset = false) {
    run_commands([&](VkCommandBuffer commands) {
        expect_done(executor.execute(commands, plan, std::array{image}, frame, reset), "execute");
    });
}

inline float pattern(uint32_t x, uint32_t y) {
    return static_cast<float>(x) + 100.0f * static_cast<float>(y);
}

inline void expect_image(const apps::HostImage& image, const std::function<float(uint32_t x, uint32_t y)>& expected) {
    const FloatImage read = read_back(image);
    for (uint32_t y = 0; y < read.extent.height; ++y)
        for (uint32_t x = 0; x < read.extent.width; ++x)
            ASSERT_EQ(*read.at(x, y), expected(x, y)) << "at " << x << ", " << y;
}

class ExecutorTest : public GpuTest {
  protected:
    std::unique_ptr<Executor> make_executor(Context& context) {
        return expect_value(Executor::create(context), "Executor::create");
    }
};

} // namespace sfumato::test
