// What all GPU tests share: one device with validation and synchronisation validation, contexts on it, and effects run
// on images that lie in host memory.
#pragma once

#include "apps/common/device.h"
#include "sfumato/sfumato.h"

#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace sfumato::test {

// Interleaved floats, row by row from the top.
struct FloatImage {
    Extent extent;
    uint32_t components = 0;
    std::vector<float> values;

    float* at(uint32_t x, uint32_t y) { return &values[(size_t{y} * extent.width + x) * components]; }
    const float* at(uint32_t x, uint32_t y) const { return &values[(size_t{y} * extent.width + x) * components]; }
};

FloatImage make_image(Extent extent, uint32_t components,
                      const std::function<void(uint32_t x, uint32_t y, float* pixel)>& fill);

// Bit for bit, NaN included. Where they differ: the first pixel, as text.
std::string first_difference(const FloatImage& a, const FloatImage& b);
bool all_finite(const FloatImage& image);

// Four-channel float formats and the like: what a role's fixture is uploaded as by default.
VkFormat float_format(uint32_t components);

// The process's device; tests fail where there is none.
apps::Device& device();

// Fails the test if the validation layers said anything while it ran.
class GpuTest : public testing::Test {
  protected:
    void SetUp() override;
    void TearDown() override;
};

// The value of a result, or a failure that shows its error and ends the test by an exception.
template <class T>
T expect_value(Result<T> result, const char* what) {
    if (!result)
        throw std::runtime_error(std::string(what) + ": " + result.error().message);
    return std::move(result).value();
}
void expect_done(const Result<void>& result, const char* what);

std::unique_ptr<Context> make_context(int poison = -1, const std::function<void(ContextInfo&)>& change = {});

apps::HostImage upload(const FloatImage& image, VkFormat format);
apps::HostImage upload(const FloatImage& image);
FloatImage read_back(const apps::HostImage& image);

// Records with `record`, submits, waits.
void run_commands(const std::function<void(VkCommandBuffer)>& record);

// Makes what shaders wrote to buffers in host memory readable there, once the commands have finished.
void show_host(VkCommandBuffer commands);

// One effect instance, with its images on the device: inputs are set by role name and stay until they are set again;
// outputs are made for the first image's extent.
class EffectRig {
  public:
    EffectRig(Context& context, const EffectInfo& effect);

    void set(const std::string& role, const FloatImage& image, std::optional<VkFormat> format = {});
    void remove(const std::string& role);
    // The buffer stays the caller's.
    void set_buffer(const std::string& role, const Buffer& buffer);

    VkFormat output_format = VK_FORMAT_R32G32B32A32_SFLOAT;
    bool optional_outputs = true;
    float sentinel = 0.0f; // outputs are filled with it before the effect runs

    // Whether what comes out depends on the frames before: by images or buffers; by buffers alone.
    bool keeps_history(const Frame& frame, const void* parameters);
    bool keeps_state(const Frame& frame, const void* parameters);
    // Records, submits, waits, reads the outputs back, one below the other.
    FloatImage run(const Frame& frame, const void* parameters);
    // The same up to recording, with the images changed by `change`: for what must be refused.
    Result<void> record(VkCommandBuffer commands, const Frame& frame, const void* parameters,
                        const std::function<void(void* images)>& change = {});

  private:
    void make_outputs();
    bool has_kind(const Frame& frame, const void* parameters, std::initializer_list<ResourceKind> kinds);
    const EffectInfo* effect_;
    std::unique_ptr<AnyEffect> instance_;
    std::map<std::string, apps::HostImage> images_;
    std::vector<std::byte> storage_;
};

} // namespace sfumato::test
