// Every parameter of every effect changes the picture under some settings of the others, and both its limits give
// finite pictures.
#include "tests/gpu/effect_fixture.h"

#include <algorithm>

namespace sfumato::test {
namespace {

constexpr Extent extent{192, 72};
constexpr Extent small{61, 33}; // for the limits, which are slow

class GenericParameter : public EffectTest {
  protected:
    void SetUp() override {
        EffectTest::SetUp();
        context_ = make_context();
        rig_ = std::make_unique<EffectRig>(*context_, effect());
        use(extent);
    }
    void use(Extent size) { set_fixture(*rig_, effect(), size); }
    void TearDown() override {
        rig_.reset();
        context_.reset();
        EffectTest::TearDown();
    }

    // The same picture in every call: where there is a history, that of one frame after a reset.
    FloatImage run(const ParameterSet& parameters, Extent size = extent) {
        Frame frame = fixture_frame(5, size);
        if (rig_->keeps_history(frame, parameters.data())) {
            frame.reset = true;
            rig_->run(frame, parameters.data());
            frame = fixture_frame(6, size);
        }
        return rig_->run(frame, parameters.data());
    }

    // Values that ought to look different: the ends, and some between, where ends may saturate alike.
    std::vector<double> values_of(const ParameterInfo& info, const ParameterSet& base) const {
        if (info.kind == ParameterKind::boolean)
            return {0.0, 1.0};
        std::vector<double> values;
        if (info.kind == ParameterKind::choice) {
            for (size_t i = 0; i < info.choices.size(); ++i)
                values.push_back(static_cast<double>(i));
            return values;
        }
        const double own = info.get(base.data());
        const double maximum = maximum_of(info);
        values = {own, maximum, info.minimum};
        for (const double share : {0.05, 0.3})
            values.push_back(info.minimum + share * (maximum - info.minimum));
        values.push_back(std::max(info.minimum, 0.25 * own));
        if (info.kind == ParameterKind::integer)
            for (double& value : values)
                value = static_cast<double>(static_cast<int>(value));
        return values;
    }

    bool matters(const ParameterInfo& info, ParameterSet parameters) {
        const std::vector<double> values = values_of(info, parameters);
        info.set(parameters.data(), values[0]);
        const FloatImage first = run(parameters);
        for (size_t i = 1; i < values.size(); ++i) {
            info.set(parameters.data(), values[i]);
            if (!first_difference(first, run(parameters)).empty())
                return true;
        }
        return false;
    }

    // Settings of the other parameters to look under: as they are, then each choice and switch in turn, then numbers at
    // their limits. Debug views replace the picture, so they come last.
    std::vector<ParameterSet> surroundings(const ParameterInfo& info, const ParameterSet& base) const {
        std::vector<ParameterSet> result = {base}, last;
        for (const ParameterInfo& other : effect().parameters->parameters) {
            if (&other == &info)
                continue;
            std::vector<double> values = {other.minimum, maximum_of(other)};
            if (other.kind == ParameterKind::choice) {
                values.clear();
                for (size_t i = 0; i < other.choices.size(); ++i)
                    values.push_back(static_cast<double>(i));
            }
            const bool first = other.kind == ParameterKind::choice || other.kind == ParameterKind::boolean;
            for (const double value : values)
                if (value != other.get(base.data())) {
                    ParameterSet changed = base;
                    other.set(changed.data(), value);
                    (first && !(other.flags & parameter_debug) ? result : last).push_back(changed);
                }
        }
        result.insert(result.end(), last.begin(), last.end());
        return result;
    }

  private:
    std::unique_ptr<Context> context_;
    std::unique_ptr<EffectRig> rig_;
};

TEST_P(GenericParameter, every_parameter_matters) {
    // The looks as they are before anything is varied, those first that name the parameter: made to show it.
    std::vector<Look> tried = {{"default", defaults()}};
    for (const std::vector<Look>& more : {special_looks(), looks(), parameter_looks()})
        tried.insert(tried.end(), more.begin(), more.end());
    for (const ParameterInfo& info : effect().parameters->parameters) {
        const std::string assignment = std::string(info.name) + "=";
        std::stable_partition(tried.begin(), tried.end(),
                              [&](const Look& look) { return look.first.find(assignment) != std::string::npos; });
        bool found =
            std::any_of(tried.begin(), tried.end(), [&](const Look& look) { return matters(info, look.second); });
        for (size_t i = 0; i < tried.size() && !found; ++i)
            for (const ParameterSet& parameters : surroundings(info, tried[i].second)) {
                found = matters(info, parameters);
                if (found)
                    break;
            }
        EXPECT_TRUE(found) << info.name << " never changes a picture";
    }
}

TEST_P(GenericParameter, limits_and_choices_give_finite_pictures) {
    use(small);
    for (const ParameterInfo& info : effect().parameters->parameters) {
        std::vector<double> values = {info.minimum, maximum_of(info)};
        for (size_t i = 1; i + 1 < info.choices.size(); ++i)
            values.push_back(static_cast<double>(i));
        for (const double value : values) {
            ParameterSet parameters = defaults();
            info.set(parameters.data(), value);
            EXPECT_TRUE(all_finite(run(parameters, small))) << info.name << " = " << value;
        }
    }
}

TEST_P(GenericParameter, all_at_their_limits) {
    use(small);
    for (const bool maximum : {false, true}) {
        ParameterSet parameters = defaults();
        for (const ParameterInfo& info : effect().parameters->parameters)
            if (!(info.flags & parameter_debug))
                info.set(parameters.data(), maximum ? maximum_of(info) : info.minimum);
        EXPECT_TRUE(all_finite(run(parameters, small))) << (maximum ? "maximum" : "minimum");
    }
}

INSTANTIATE_TEST_SUITE_P(effects, GenericParameter, testing::ValuesIn(all_effects()), effect_test_name);

} // namespace
} // namespace sfumato::test
