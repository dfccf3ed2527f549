// Parameters: every row of every effect's table does what it says.
#include "sfumato/sfumato.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <set>

namespace sfumato {
namespace {

std::vector<const ParameterTable*> tables() {
    std::vector<const ParameterTable*> result;
    for (const EffectInfo* effect : effects())
        result.push_back(effect->parameters);
    return result;
}

// Values to try: the ends, the default, and some between.
std::vector<double> values_of(const ParameterInfo& info, const ParameterTable& table) {
    const ParameterSet defaults(table);
    std::vector<double> values = {info.minimum, info.maximum, info.get(defaults.data())};
    const double step = info.kind == ParameterKind::real ? (info.maximum - info.minimum) / 7.0 : 1.0;
    for (int i = 1; i < 7; ++i)
        if (info.minimum + i * step <= info.maximum)
            values.push_back(info.minimum + i * step);
    return values;
}

TEST(Parameters, tables_are_complete) {
    ASSERT_FALSE(tables().empty());
    for (const ParameterTable* table : tables()) {
        std::set<std::string> names;
        for (const ParameterInfo& info : table->parameters) {
            SCOPED_TRACE(std::string(table->effect) + "." + info.name);
            EXPECT_TRUE(names.insert(info.name).second) << "twice in the table";
            for (const char* c = info.name; *c; ++c)
                EXPECT_TRUE((*c >= 'a' && *c <= 'z') || (*c >= '0' && *c <= '9') || *c == '_') << "not snake_case";
            EXPECT_GE(std::strlen(info.doc), 10u);
            EXPECT_EQ(info.doc[std::strlen(info.doc) - 1], '.') << "the doc is a sentence";
            EXPECT_LT(info.minimum, info.maximum);
            EXPECT_EQ(info.kind == ParameterKind::choice, !info.choices.empty());
            EXPECT_TRUE(!(info.flags & parameter_logarithmic) || info.minimum > 0.0);
            EXPECT_EQ(table->find(info.name), &info);
        }
    }
}

TEST(Parameters, defaults_are_valid) {
    for (const ParameterTable* table : tables()) {
        const ParameterSet set(*table);
        const auto valid = validate_parameters(*table, set.data());
        EXPECT_TRUE(valid) << valid.error().message;
    }
}

TEST(Parameters, text_round_trips) {
    for (const ParameterTable* table : tables())
        for (const ParameterInfo& info : table->parameters)
            for (const double value : values_of(info, *table)) {
                SCOPED_TRACE(std::string(table->effect) + "." + info.name + " = " + std::to_string(value));
                ParameterSet set(*table);
                info.set(set.data(), value);
                EXPECT_NEAR(info.get(set.data()), value, 1e-6 * std::max(1.0, std::abs(value)));
                const double stored = info.get(set.data());
                const std::string text = parameter_text(info, set.data());
                ParameterSet again(*table);
                const auto done = set_parameter(*table, again.data(), info.name, text);
                ASSERT_TRUE(done) << done.error().message;
                EXPECT_EQ(info.get(again.data()), stored) << text;
                EXPECT_EQ(parameter_text(info, again.data()), text);
            }
}

// A row that reads or writes another row's member would pass the round trip.
TEST(Parameters, a_row_changes_its_own_member_alone) {
    for (const ParameterTable* table : tables())
        for (const ParameterInfo& info : table->parameters) {
            const ParameterSet defaults(*table);
            ParameterSet set(*table);
            const double old = info.get(set.data());
            info.set(set.data(), old == info.maximum ? info.minimum : info.maximum);
            EXPECT_NE(info.get(set.data()), old) << info.name;
            for (const ParameterInfo& other : table->parameters)
                EXPECT_TRUE(&other == &info || other.get(set.data()) == other.get(defaults.data()))
                    << info.name << ", " << other.name;
        }
}

TEST(Parameters, booleans_and_choices_by_name) {
    for (const ParameterTable* table : tables())
        for (const ParameterInfo& info : table->parameters) {
            ParameterSet set(*table);
            const auto sets = [&](const char* text, double value) {
                return set_parameter(*table, set.data(), info.name, text) && info.get(set.data()) == value;
            };
            if (info.kind == ParameterKind::boolean) {
                for (const char* text : {"true", "on", "yes", "1"})
                    EXPECT_TRUE(sets(text, 1.0)) << info.name << " " << text;
                for (const char* text : {"false", "off", "no", "0"})
                    EXPECT_TRUE(sets(text, 0.0)) << info.name << " " << text;
            }
            for (size_t i = 0; i < info.choices.size(); ++i)
                EXPECT_TRUE(sets(info.choices[i], static_cast<double>(i))) << info.name << " " << info.choices[i];
        }
}

TEST(Parameters, bad_text_is_an_error_that_says_what_is_allowed) {
    for (const ParameterTable* table : tables())
        for (const ParameterInfo& info : table->parameters)
            for (const char* text : {"", " ", "nonsense", "1e999", "nan", "inf", "-inf", "0x10", "1,5", "1 2", "--1"}) {
                ParameterSet set(*table);
                const std::string before = parameter_text(info, set.data());
                const auto done = set_parameter(*table, set.data(), info.name, text);
                ASSERT_FALSE(done) << info.name << " took '" << text << "'";
                EXPECT_EQ(done.error().code, ErrorCode::invalid_argument);
                const std::string& message = done.error().message;
                const std::string full =
                    std::string(table->effect) + "." + info.name + " is '" + text + "'; allowed is ";
                EXPECT_EQ(message.rfind(full, 0), 0u) << message;
                for (const char* choice : info.choices)
                    EXPECT_NE(message.find(choice), std::string::npos) << message;
                EXPECT_EQ(parameter_text(info, set.data()), before) << "changed by an error";
            }
}

TEST(Parameters, out_of_range_is_an_error) {
    const double not_a_number = std::numeric_limits<double>::quiet_NaN();
    const double infinite = std::numeric_limits<double>::infinity();
    for (const ParameterTable* table : tables())
        for (const ParameterInfo& info : table->parameters) {
            std::vector<double> values;
            if (info.kind == ParameterKind::real)
                values = {not_a_number, infinite, -infinite};
            if (info.kind != ParameterKind::boolean) {
                const double step =
                    info.kind == ParameterKind::real ? 1e-3 * (info.maximum - info.minimum) + 1e-3 : 1.0;
                values.push_back(info.minimum - step);
                values.push_back(info.maximum + step);
            }
            for (const double value : values) {
                ParameterSet set(*table);
                info.set(set.data(), value);
                const auto valid = validate_parameters(*table, set.data());
                ASSERT_FALSE(valid) << info.name << " = " << value;
                EXPECT_NE(valid.error().message.find(std::string(table->effect) + "." + info.name), std::string::npos)
                    << valid.error().message;
                EXPECT_NE(valid.error().message.find("allowed is"), std::string::npos) << valid.error().message;
            }
        }
}

TEST(Parameters, whole_numbers_only_where_they_are_integers) {
    for (const ParameterTable* table : tables())
        for (const ParameterInfo& info : table->parameters)
            if (info.kind == ParameterKind::integer) {
                ParameterSet set(*table);
                const std::string text = std::to_string(static_cast<int>(info.minimum)) + ".5";
                EXPECT_FALSE(set_parameter(*table, set.data(), info.name, text)) << info.name;
            }
}

TEST(Parameters, unknown_names_get_the_nearest) {
    for (const ParameterTable* table : tables())
        for (const ParameterInfo& info : table->parameters) {
            ParameterSet set(*table);
            const std::string misspelt = std::string(info.name) + "~";
            const auto done = set_parameter(*table, set.data(), misspelt, "1");
            ASSERT_FALSE(done);
            EXPECT_NE(done.error().message.find("did you mean '" + std::string(info.name) + "'"), std::string::npos)
                << done.error().message;
            EXPECT_NE(done.error().message.find("'" + misspelt + "'"), std::string::npos);
        }
    ParameterSet set(*tables().front());
    const auto done = set_parameter(*tables().front(), set.data(), "qqqqqqqqqq", "1");
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().message.find("did you mean"), std::string::npos) << done.error().message;
}

TEST(Parameters, nearest_name_is_the_nearest) {
    const std::vector<std::string> names = {"radius", "taps", "shutter", "shutter_position"};
    EXPECT_EQ(nearest_name("radios", names), "radius");
    EXPECT_EQ(nearest_name("tap", names), "taps");
    EXPECT_EQ(nearest_name("shuter", names), "shutter");
    EXPECT_EQ(nearest_name("shutter-position", names), "shutter_position");
    EXPECT_EQ(nearest_name("intensity", names), "");
    EXPECT_EQ(nearest_name("", names), "");
    EXPECT_EQ(nearest_name("x", {}), "");
}

TEST(Presets, are_valid_and_say_what_they_are_for) {
    for (const ParameterTable* table : tables()) {
        std::set<std::string> names;
        for (const char* needed : {"low", "medium", "high", "ultra"})
            EXPECT_NE(table->find_preset(needed), nullptr) << table->effect << " has no preset " << needed;
        for (const Preset& preset : table->presets) {
            SCOPED_TRACE(std::string(table->effect) + " " + preset.name);
            EXPECT_TRUE(names.insert(preset.name).second);
            EXPECT_STRNE(preset.name, "default") << "is the name of the defaults";
            EXPECT_GE(std::strlen(preset.doc), 5u);
            ParameterSet set(*table);
            const auto applied = apply_preset(*table, set.data(), preset.name);
            ASSERT_TRUE(applied) << applied.error().message;
            const auto valid = validate_parameters(*table, set.data());
            EXPECT_TRUE(valid) << valid.error().message;
            for (const auto& [name, value] : preset.overrides) {
                const ParameterInfo* info = table->find(name);
                ASSERT_NE(info, nullptr) << name;
                ParameterSet one(*table);
                ASSERT_TRUE(set_parameter(*table, one.data(), name, value));
                EXPECT_EQ(info->get(set.data()), info->get(one.data())) << name << " is overridden twice";
            }
        }
    }
}

TEST(Presets, start_from_the_defaults) {
    for (const ParameterTable* table : tables())
        for (const char* name : {"", "default"}) {
            const ParameterSet defaults(*table);
            ParameterSet set(*table);
            for (const ParameterInfo& info : table->parameters)
                info.set(set.data(), info.maximum);
            ASSERT_TRUE(apply_preset(*table, set.data(), name));
            for (const ParameterInfo& info : table->parameters)
                EXPECT_EQ(info.get(set.data()), info.get(defaults.data())) << info.name;
        }
}

TEST(Presets, unknown_ones_are_an_error_with_the_names_there_are) {
    for (const ParameterTable* table : tables()) {
        ParameterSet set(*table);
        const auto applied = apply_preset(*table, set.data(), "ultr");
        ASSERT_FALSE(applied);
        EXPECT_NE(applied.error().message.find("'ultr'"), std::string::npos);
        EXPECT_NE(applied.error().message.find("did you mean 'ultra'"), std::string::npos);
        EXPECT_NE(applied.error().message.find("default"), std::string::npos);
    }
    EXPECT_TRUE(preset<MotionBlurParameters>("ultra"));
    EXPECT_FALSE(preset<MotionBlurParameters>("nothing like it"));
}

TEST(Effects, describe_themselves) {
    std::set<std::string> names;
    for (const EffectInfo* effect : effects()) {
        SCOPED_TRACE(effect->name);
        EXPECT_TRUE(names.insert(effect->name).second);
        EXPECT_STREQ(effect->name, effect->parameters->effect);
        EXPECT_EQ(find_effect(effect->name), effect);
        EXPECT_GE(std::strlen(effect->summary), 10u);
        EXPECT_GE(std::strlen(effect->source), 10u);
        ASSERT_FALSE(effect->images.empty());
        EXPECT_EQ(effect->images.front().use, ImageUse::input) << "the first image is what the effect works on";
        std::vector<std::byte> images(effect->images_size);
        std::set<std::string> roles;
        std::set<const Image*> members;
        bool has_output = false;
        for (const ImageRole& role : effect->images) {
            EXPECT_TRUE(roles.insert(role.name).second) << role.name;
            EXPECT_TRUE(members.insert(&role.get(images.data())).second) << role.name << " shares a member";
            EXPECT_GE(std::strlen(role.doc), 5u);
            EXPECT_TRUE(role.components >= 1 && role.components <= 4);
            has_output = has_output || role.is_output();
        }
        EXPECT_TRUE(has_output);
        for (const BufferRole& role : effect->buffers) {
            EXPECT_TRUE(roles.insert(role.name).second) << role.name;
            EXPECT_GE(std::strlen(role.doc), 5u);
            EXPECT_TRUE(role.element_bytes > 0 && role.largest_bytes % role.element_bytes == 0);
            EXPECT_TRUE(!role.shortfalls || role.is_output()) << "only what the device has written tells anything";
        }
        EXPECT_EQ(effect->images_size, effect->images.size() * sizeof(Image) + effect->buffers.size() * sizeof(Buffer))
            << "an image or buffer without a role";
    }
    EXPECT_EQ(find_effect("motion_blur"), nullptr);
}

// A remedy is a setting that the table takes, and the least that helps.
TEST(Shortfalls, particles_tell_what_helps) {
    const EffectInfo& effect = ParticleVolumeImages::effect();
    const auto tell = [&](uint32_t pairs, uint32_t wanted, uint32_t overflow, ParticleVolumeParameters parameters) {
        const ParticleStatistics statistics{900, 800, pairs, wanted, overflow, 0, 0, 0};
        std::vector<std::string> remedies;
        for (const BufferRole& role : effect.buffers)
            for (const Shortfall& found :
                 role.shortfalls ? role.shortfalls(&statistics, &parameters) : std::vector<Shortfall>{}) {
                EXPECT_GT(found.excess, 0.0);
                EXPECT_FALSE(found.text.empty());
                const size_t equals = found.remedy.find('=');
                if (equals != std::string::npos) {
                    EXPECT_TRUE(set_parameter(*effect.parameters, &parameters, found.remedy.substr(0, equals),
                                              found.remedy.substr(equals + 1)))
                        << found.remedy;
                }
                remedies.push_back(found.remedy);
            }
        return remedies;
    };
    using Remedies = std::vector<std::string>;
    ParticleVolumeParameters p;
    p.count = 1000;
    p.pairs_per_particle = 2;
    EXPECT_EQ(tell(2100, 2100, 0, p), Remedies{});
    EXPECT_EQ(tell(2100, 2101, 1, p), Remedies{"pairs_per_particle=3"});
    EXPECT_EQ(tell(2100, 4100, 1, p), Remedies{"pairs_per_particle=4"});
    EXPECT_EQ(tell(2100, 900000, 1, p), Remedies{"resolution=half"});
    p.resolution = ParticleResolution::half;
    EXPECT_EQ(tell(2100, 900000, 1, p), Remedies{"resolution=quarter"});
    p.resolution = ParticleResolution::quarter;
    EXPECT_EQ(tell(2100, 900000, 1, p), Remedies{""});
    // More than the device can have.
    p.resolution = ParticleResolution::full;
    p.count = 4000000;
    EXPECT_EQ(tell(67107840, 90000000, 1, p), Remedies{"resolution=half"});
    // The deepest is at birth while mass is kept, at the end where the extinction stays.
    p.radius_start = 0.5f;
    p.radius_end = 2.0f;
    p.dilution = 1.0f;
    EXPECT_EQ(tell(1, 1, 2, p), Remedies{"extinction=15.8"});
    p.dilution = 0.0f;
    EXPECT_EQ(tell(1, 1, 2, p), Remedies{"extinction=3.96"});
}

} // namespace
} // namespace sfumato
