// What every effect must keep, whatever it computes: sizes, poison, sentinels, reset, resize, determinism, formats,
// memory. A new effect is tested by standing in the list of effects.
#include "gpu/context_state.h"
#include "tests/gpu/effect_fixture.h"

#include <cmath>

namespace sfumato::test {
namespace {

constexpr Extent sizes[] = {{1, 1},   {1, 37},  {37, 1},  {7, 3},   {97, 61},  {31, 33},
                            {33, 31}, {63, 65}, {64, 64}, {65, 63}, {129, 127}};
constexpr Extent few_sizes[] = {{1, 1}, {7, 3}, {97, 61}, {65, 63}}; // for the presets
constexpr Extent usual{97, 61};

class GenericEffect : public EffectTest {};

// With transients and histories poisoned in two ways and outputs filled with two values, the bits are the same: nothing
// is read that was not written, and every output pixel is written.
TEST_P(GenericEffect, sizes_poison_and_sentinels) {
    for (const auto& [look, parameters] : looks()) {
        const auto a = make_context(0), b = make_context(1);
        EffectRig first(*a, effect()), second(*b, effect());
        first.sentinel = 12345.0f;
        second.sentinel = NAN;
        const bool is_default = look == "default";
        for (const Extent extent : is_default ? std::span<const Extent>(sizes) : std::span<const Extent>(few_sizes))
            for (const bool optional : {false, true}) {
                SCOPED_TRACE(look + " at " + extent_text(extent) + (optional ? " with all inputs" : ""));
                set_fixture(first, effect(), extent, optional);
                set_fixture(second, effect(), extent, optional);
                const Frame frame = fixture_frame(3 + extent.width, extent);
                const FloatImage x = first.run(frame, parameters.data());
                const FloatImage y = second.run(frame, parameters.data());
                ASSERT_EQ(first_difference(x, y), "");
                ASSERT_TRUE(all_finite(x));
                ASSERT_EQ(x.extent.width, extent.width);
                ASSERT_EQ(x.extent.height % extent.height, 0u); // one output below the other
            }
    }
}

TEST_P(GenericEffect, two_runs_give_the_same_bits) {
    std::vector<FloatImage> last[2];
    for (int run = 0; run < 2; ++run) {
        const auto context = make_context();
        EffectRig rig(*context, effect());
        for (const auto& [look, parameters] : looks())
            for (uint64_t frame = 0; frame < 3; ++frame) {
                set_fixture(rig, effect(), usual, true, static_cast<uint32_t>(frame));
                last[run].push_back(rig.run(fixture_frame(frame, usual), parameters.data()));
            }
    }
    for (size_t i = 0; i < last[0].size(); ++i)
        EXPECT_EQ(first_difference(last[0][i], last[1][i]), "") << "frame " << i;
}

TEST_P(GenericEffect, reset_equals_a_fresh_instance) {
    for (const auto& [look, parameters] : looks()) {
        const auto context = make_context(0);
        EffectRig used(*context, effect()), fresh(*context, effect());
        for (uint64_t frame = 0; frame < 3; ++frame) {
            set_fixture(used, effect(), usual, true, 5 + static_cast<uint32_t>(frame));
            used.run(fixture_frame(frame, usual), parameters.data());
        }
        for (uint64_t index = 10; index < 13; ++index) {
            set_fixture(used, effect(), usual, true, static_cast<uint32_t>(index));
            set_fixture(fresh, effect(), usual, true, static_cast<uint32_t>(index));
            Frame frame = fixture_frame(index, usual);
            frame.reset = index == 10;
            const FloatImage a = used.run(frame, parameters.data());
            const FloatImage b = fresh.run(frame, parameters.data());
            ASSERT_EQ(first_difference(a, b), "") << look << " frame " << index;
        }
    }
}

// What lives in the world, not in the image, outlives a change of size: such effects are reset with it.
TEST_P(GenericEffect, resize_equals_a_fresh_instance) {
    const auto context = make_context(1);
    EffectRig used(*context, effect());
    const ParameterSet parameters = defaults();
    uint64_t index = 0;
    for (const Extent extent : {Extent{64, 48}, Extent{97, 61}, Extent{33, 17}, Extent{64, 48}}) {
        EffectRig fresh(*context, effect());
        for (int i = 0; i < 2; ++i, ++index) {
            set_fixture(used, effect(), extent, true, static_cast<uint32_t>(index));
            set_fixture(fresh, effect(), extent, true, static_cast<uint32_t>(index));
            Frame frame = fixture_frame(index, extent);
            frame.reset = i == 0 && used.keeps_state(frame, parameters.data());
            const FloatImage a = used.run(frame, parameters.data());
            const FloatImage b = fresh.run(frame, parameters.data());
            ASSERT_EQ(first_difference(a, b), "") << extent_text(extent);
        }
        context->trim();
    }
}

TEST_P(GenericEffect, inputs_of_another_format) {
    // Software Vulkan compiles shaders anew for every combination, so these are few: half floats of as many channels as
    // are needed, of more, and 8 bits.
    const auto formats_of = [](const ImageRole& role) {
        constexpr VkFormat least[] = {VK_FORMAT_R16_SFLOAT, VK_FORMAT_R16G16_SFLOAT, VK_FORMAT_R16G16B16A16_SFLOAT,
                                      VK_FORMAT_R16G16B16A16_SFLOAT};
        std::vector<VkFormat> formats = {least[role.components - 1], VK_FORMAT_R32G32B32A32_SFLOAT};
        if (!role.is_signed)
            formats.push_back(role.components == 1 ? VK_FORMAT_R8_UNORM : VK_FORMAT_R8G8B8A8_UNORM);
        return formats;
    };
    const auto context = make_context(0);
    EffectRig rig(*context, effect());
    const ParameterSet parameters = defaults();
    set_fixture(rig, effect(), usual);
    for (const ImageRole& role : effect().images) {
        if (role.is_output())
            continue;
        for (const VkFormat format : formats_of(role)) {
            rig.set(role.name, fixture_image(role, usual), format);
            EXPECT_TRUE(all_finite(rig.run(fixture_frame(1, usual), parameters.data()))) << role.name << " " << format;
        }
        rig.set(role.name, fixture_image(role, usual));
    }
    for (const VkFormat format : {VK_FORMAT_R16G16B16A16_SFLOAT, VK_FORMAT_R8G8B8A8_UNORM}) {
        rig.output_format = format;
        EXPECT_TRUE(all_finite(rig.run(fixture_frame(1, usual), parameters.data()))) << "output " << format;
    }
}

// A single missing optional input, and optional inputs of another size. An effect may refuse a size, with a sentence.
TEST_P(GenericEffect, optional_inputs_missing_or_of_another_size) {
    const auto context = make_context(0);
    EffectRig rig(*context, effect());
    const ParameterSet parameters = defaults();
    set_fixture(rig, effect(), usual);
    for (const ImageRole& role : effect().images) {
        if (role.use != ImageUse::optional_input)
            continue;
        rig.remove(role.name);
        try {
            EXPECT_TRUE(all_finite(rig.run(fixture_frame(1, usual), parameters.data()))) << "without " << role.name;
        } catch (const std::runtime_error& error) { // an optional output may need it
            EXPECT_NE(std::string(error.what()).find("missing"), std::string::npos) << error.what();
        }
        for (const Extent extent : {Extent{48, 30}, Extent{1, 1}, Extent{200, 131}}) {
            rig.set(role.name, fixture_image(role, extent));
            try {
                EXPECT_TRUE(all_finite(rig.run(fixture_frame(1, usual), parameters.data())))
                    << role.name << " " << extent_text(extent);
            } catch (const std::runtime_error& error) {
                EXPECT_NE(std::string(error.what()).find(extent_text(extent)), std::string::npos) << error.what();
            }
        }
        rig.set(role.name, fixture_image(role, usual));
    }
}

TEST_P(GenericEffect, gives_its_memory_back) {
    const auto context = make_context();
    const MemoryUsage before = context->memory_usage();
    for (int round = 0; round < 2; ++round) {
        {
            EffectRig a(*context, effect()), b(*context, effect());
            for (EffectRig* rig : {&a, &b})
                for (const Extent extent : {Extent{97, 61}, Extent{32, 32}}) {
                    set_fixture(*rig, effect(), extent);
                    rig->run(fixture_frame(extent.width, extent), defaults().data());
                }
            EXPECT_GT(context->memory_usage().transients + context->memory_usage().histories, 0u);
        }
        context->trim();
        EXPECT_EQ(context->memory_usage().transients, 0u);
        EXPECT_EQ(context->memory_usage().histories, 0u);
        EXPECT_EQ(context->memory_usage().constants, before.constants);
        EXPECT_TRUE(context->state().retired.empty());
        EXPECT_TRUE(context->state().executors.empty());
    }
}

// ------------------------------------------------------------------------------------------ wild values

struct Wild {
    const char* name;
    float value;
};
constexpr Wild wild_values[] = {{"NaN", NAN},    {"infinity", INFINITY}, {"-infinity", -INFINITY},
                                {"huge", 1e30f}, {"-huge", -1e30f},      {"denormal", 1e-41f},
                                {"zero", 0.0f},  {"negative", -1.0f}};

class WildInput : public EffectTest {
  protected:
    static constexpr Extent extent{256, 64};
    static constexpr uint32_t x = 20;

    // The values stand in a column, each in a row of its own.
    void check(EffectRig& rig, const ImageRole& role, std::span<const Wild> wild, const void* parameters,
               const FloatImage& clean) {
        FloatImage input = fixture_image(role, extent);
        std::string names;
        for (size_t i = 0; i < wild.size(); ++i) {
            std::fill_n(input.at(x, row(i)), input.components, wild[i].value);
            names += std::string(i > 0 ? ", " : "") + wild[i].name;
        }
        rig.set(role.name, input);
        const FloatImage output = rig.run(first_frame(rig, parameters), parameters);
        rig.set(role.name, fixture_image(role, extent));
        const uint32_t reach = effect_facts(effect()).reach;
        size_t wrong = 0, changed = 0;
        for (uint32_t py = 0; py < output.extent.height; ++py)
            for (uint32_t px = 0; px < extent.width; ++px)
                for (uint32_t c = 0; c < output.components; ++c) {
                    const float value = output.at(px, py)[c];
                    // The pixel itself may be handed through.
                    const uint32_t input_row = py % extent.height;
                    const bool here = px == x && input_row % 8 == row(0) && input_row <= row(wild.size() - 1);
                    wrong += !std::isfinite(value) && !here;
                    changed += px > x + reach && value != clean.at(px, py)[c];
                }
        EXPECT_EQ(wrong, 0u) << role.name << " with " << names << ": values that are not finite";
        EXPECT_EQ(changed, 0u) << role.name << " with " << names << ": changes farther than " << reach << " px";
    }

    static uint32_t row(size_t i) { return static_cast<uint32_t>(5 + 8 * i); }
    // A reset makes effects without history distrust their inputs.
    static Frame first_frame(EffectRig& rig, const void* parameters) {
        Frame frame = fixture_frame(1, extent);
        frame.reset = rig.keeps_history(frame, parameters);
        return frame;
    }
};

TEST_P(WildInput, stays_local) {
    const auto context = make_context(0);
    for (const auto& [look, parameters] : looks()) {
        SCOPED_TRACE(look);
        EffectRig rig(*context, effect());
        set_fixture(rig, effect(), extent);
        const FloatImage clean = rig.run(first_frame(rig, parameters.data()), parameters.data());
        for (const ImageRole& role : effect().images) {
            if (role.is_output())
                continue;
            // One by one, so that what goes wrong has a name; for the presets all at once.
            const std::span<const Wild> all = wild_values;
            if (look != "default")
                check(rig, role, all, parameters.data(), clean);
            for (size_t i = 0; i < all.size() && look == "default"; ++i)
                check(rig, role, all.subspan(i, 1), parameters.data(), clean);
        }
    }
}

// A whole image of one wild value; afterwards good frames give good pictures: nothing of it entered a history.
TEST_P(WildInput, enters_no_history) {
    const auto context = make_context(0);
    std::vector<Look> tried = special_looks();
    tried.emplace_back("default", defaults());
    for (const auto& [look, parameters] : tried) {
        EffectRig rig(*context, effect());
        set_fixture(rig, effect(), usual);
        if (look != "default" && !rig.keeps_history(fixture_frame(0, usual), parameters.data()))
            continue;
        for (const ImageRole& role : effect().images)
            for (size_t i = 0; i < std::size(wild_values) && !role.is_output(); ++i) {
                FloatImage input = fixture_image(role, usual);
                std::fill(input.values.begin(), input.values.end(), wild_values[i].value);
                rig.set(role.name, input);
                for (uint64_t index = 0; index < 2; ++index) {
                    Frame frame = fixture_frame(index, usual);
                    frame.reset = index == 0;
                    rig.run(frame, parameters.data());
                }
                rig.set(role.name, fixture_image(role, usual));
                for (uint64_t index = 2; index < 4; ++index)
                    EXPECT_TRUE(all_finite(rig.run(fixture_frame(index, usual), parameters.data())))
                        << look << ": " << role.name << " full of " << wild_values[i].name << ", frame " << index;
            }
    }
}

INSTANTIATE_TEST_SUITE_P(effects, GenericEffect, testing::ValuesIn(all_effects()), effect_test_name);
INSTANTIATE_TEST_SUITE_P(effects, WildInput, testing::ValuesIn(all_effects()), effect_test_name);

} // namespace
} // namespace sfumato::test
