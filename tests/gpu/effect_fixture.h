// Inputs on which the generic tests run any effect: content by the name of the image's role, cameras, and the few facts
// of an effect that cannot be read off its description.
#pragma once

#include "tests/gpu/gpu_test.h"

namespace sfumato::test {

// The parts of a role's name decide: "velocity", "next_velocity" and "layer_1" hold vectors, "…mask" shares, "depth"
// linear view depth with edges and sky, "normal" unit vectors; everything else is a textured colour. `seed` varies it.
FloatImage fixture_image(const ImageRole& role, Extent extent, uint32_t seed = 0);

// Cameras that move and turn a little from frame to frame.
Frame fixture_frame(uint64_t index, Extent extent);

// All inputs of an effect; the optional ones only if `optional`.
void set_fixture(EffectRig& rig, const EffectInfo& effect, Extent extent, bool optional = true, uint32_t seed = 0);

struct EffectFacts {
    const char* effect;
    // Pixels beyond which one input pixel has no influence with the default parameters and an image 64 pixels high.
    uint32_t reach;
    // Settings, "name=value name=value", under which parameters matter that the default and the presets leave without
    // effect. What no look shows is searched for blindly, which takes minutes.
    std::span<const char* const> looks;
    // Set in every look, after its preset and before its own; and what stands for a parameter's maximum where that
    // would take too long.
    const char* settings = "";
    const char* maxima = "";
    // More looks that show parameters, which nothing else need be tried under.
    std::span<const char* const> parameter_looks = {};
};

// An effect without a row of its own gets a reach of 128 pixels and no looks.
EffectFacts effect_facts(const EffectInfo& effect);

// Sets "name=value name=value".
void apply_settings(ParameterSet& parameters, const char* settings);

// The effects as gtest parameters: instantiate with these and every later effect is tested as well.
std::vector<const EffectInfo*> all_effects();
std::string effect_test_name(const testing::TestParamInfo<const EffectInfo*>& info);

class EffectTest : public GpuTest, public testing::WithParamInterface<const EffectInfo*> {
  protected:
    const EffectInfo& effect() const { return *GetParam(); }
    ParameterSet defaults() const;
    double maximum_of(const ParameterInfo& info) const;
    using Look = std::pair<std::string, ParameterSet>;
    // The default and every preset, by name.
    std::vector<Look> looks() const;
    // Those of the effect's facts.
    std::vector<Look> special_looks() const;
    // Those that show parameters alone.
    std::vector<Look> parameter_looks() const;

  private:
    std::vector<Look> looks_of(std::span<const char* const> all) const;
};

} // namespace sfumato::test
