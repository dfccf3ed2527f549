// Motion conventions: parsing, decoding, detection and the check by warping.
#include <cmath>
#include <random>

#include "media/motion_convention.h"
#include "media/motion_warp.h"
#include "media_test_support.h"

namespace sfumato::media {
namespace {

MotionConvention convention(const std::string& text) {
    auto parsed = parse_motion_convention(text);
    EXPECT_TRUE(parsed) << parsed.error().message;
    return parsed ? *parsed : MotionConvention{};
}

TEST(MediaMotion, EveryConventionDecodes) {
    // A surface that moves 20 right and 10 down from the last frame, the same to the next; picture 200 by 100.
    struct Row {
        const char* text;
        double first, second;
    };
    const Row rows[] = {
        {"pixels", 20, 10},
        {"blender", -20, 10},
        {"ndc", 0.2, -0.2},
        {"uv", 0.1, 0.1},
        {"unreal", 0.6, 0.4},
        {"arnold", 10, -5},
        {"vray,scale=40", 0.75, 0.375},
        {"redshift", 20, -10},
        {"redshift,encoded,scale=40", 0.75, 0.375},
        {"renderman", 20, 10},
        {"renderman-back", -20, -10},
        {"nuke-forward", 20, -10},
        {"nuke-backward", -20, 10},
        {"rsmb", 20, -10},
        {"flip-x", -20, 10},
        {"pixels,flip-y", 20, -10},
        {"pixels,swap", 10, 20},
        {"uv,swap", 0.1, 0.1},
        {"ndc,swap,flip-y", 0.2, 0.2},
        {"pixels,scale=2", 10, 5},
        {"to-previous", -20, -10},
        {"from-next", -20, -10},
        {"to-next", 20, 10},
    };
    for (const Row& row : rows) {
        const auto v = convention(row.text).decode(row.first, row.second, 200, 100);
        EXPECT_NEAR(v[0], 20.0, 1e-9) << row.text;
        EXPECT_NEAR(v[1], 10.0, 1e-9) << row.text;
    }
}

TEST(MediaMotion, TextReadsBack) {
    for (const char* text :
         {"blender", "blender,flip-y", "unreal,swap,flip-x", "vray,raw,scale=32",
          "pixels,flip-x,flip-y,swap,scale=2,to-next", "uv,encoded", "pixels,ndc", "arnold,scale=0.5"}) {
        const MotionConvention once = convention(text);
        const MotionConvention twice = convention(once.text());
        EXPECT_EQ(once.text(), twice.text());
        EXPECT_EQ(once.decode(0.3, 0.9, 64, 32), twice.decode(0.3, 0.9, 64, 32)) << text;
    }
    EXPECT_EQ(convention("blender,flip-y,flip-y").text(), "blender");
    for (const char* bad : {"", "blend", "blender,", "blender,blender", "pixels,scale=", "pixels,scale=0",
                            "pixels,scale=nan", "pixels,scale=2x", "pixels,,swap", "Blender"}) {
        auto parsed = parse_motion_convention(bad);
        EXPECT_FALSE(parsed) << bad;
    }
    EXPECT_NE(parse_motion_convention("blend").error().message.find("blender"), std::string::npos);
}

TEST(MediaMotion, FieldsHaveBothNeighbours) {
    const Planes four{1, 1, {{-20}, {10}, {-30}, {15}}};
    auto field = decode_motion(four, convention("blender"), 1, 1);
    ASSERT_TRUE(field);
    EXPECT_EQ(field->velocity, (std::vector<float>{20, 10}));
    EXPECT_EQ(field->next, (std::vector<float>{30, 15}));
    const Planes two{1, 1, {{20}, {-10}}}, back{1, 1, {{-30}, {15}}};
    auto forward = decode_motion(two, convention("nuke-forward"), 1, 1);
    ASSERT_TRUE(forward);
    EXPECT_TRUE(forward->velocity_is_next);
    EXPECT_EQ(forward->velocity, (std::vector<float>{20, 10}));
    EXPECT_EQ(forward->next, forward->velocity);
    auto both = decode_motion(back, convention("nuke-backward"), 1, 1, &two);
    ASSERT_TRUE(both);
    EXPECT_FALSE(both->velocity_is_next);
    EXPECT_EQ(both->velocity, (std::vector<float>{30, 15}));
    EXPECT_EQ(both->next, (std::vector<float>{20, 10}));
    EXPECT_FALSE(decode_motion(two, convention("blender"), 1, 1)) << "four channels are needed";
}

TEST(MediaMotion, BrokenVectorsBecomeStill) {
    const float nan = std::nanf(""), infinity = INFINITY;
    auto field = decode_motion({3, 1, {{nan, 3, 0}, {1, infinity, -0.0f}}}, convention("pixels"), 3, 1);
    ASSERT_TRUE(field);
    EXPECT_EQ(field->non_finite, 2u);
    EXPECT_EQ(field->velocity, (std::vector<float>(6, 0.0f)));
    for (const float value : field->velocity)
        EXPECT_FALSE(std::signbit(value));
}

// ---------------------------------------------------------------------------------------------- detection

struct MotionFile {
    ExrImage image;
    MotionDetection detection;
};

MotionDetection detect(const std::string& layer, const std::string& letters,
                       const std::vector<std::vector<float>>& values, const std::string& attribute = "",
                       const std::string& told = "") {
    ExrImage image;
    image.parts.emplace_back();
    ExrPart& part = image.parts[0];
    part.data_window = {0, 0, static_cast<int32_t>(values[0].size()) - 1, 0};
    for (size_t i = 0; i < letters.size(); ++i)
        part.set_channel(layer + "." + letters[i], values[i], PixelType::float32);
    if (!attribute.empty())
        part.set_string_attribute(attribute, "1");
    auto selection = select_channels(image);
    EXPECT_TRUE(selection && selection->motion.chosen);
    auto detection = detect_motion(image, *selection->motion.chosen, told);
    EXPECT_TRUE(detection) << detection.error().message;
    return *detection;
}

std::vector<float> spread(float middle, float width) {
    std::vector<float> values(1001);
    for (size_t i = 0; i < values.size(); ++i)
        values[i] = i % 3 == 0 ? middle + width * (static_cast<float>(i) / 500.0f - 1.0f) : middle;
    return values;
}

TEST(MediaMotionDetection, NameThenHeaderThenValues) {
    const auto raw = spread(0.0f, 30.0f), encoded = spread(0.5f, 0.4f), small = spread(0.0f, 0.1f);
    EXPECT_EQ(detect("V.Vector", "XYZW", {raw, raw, raw, raw}).convention.text(), "blender");
    EXPECT_EQ(detect("motionvector", "XY", {raw, raw}).convention.text(), "arnold");
    EXPECT_EQ(detect("velocity", "RGB", {encoded, encoded, encoded}).convention.text(), "vray");
    EXPECT_EQ(detect("velocity", "RGB", {raw, raw, raw}).convention.text(), "vray,raw");
    EXPECT_EQ(detect("velocity", "RG", {raw, raw}, "arnold/version").convention.text(), "arnold");
    EXPECT_EQ(detect("Motion Vectors", "RG", {encoded, encoded}, "rs/version").convention.text(), "redshift,encoded");
    EXPECT_EQ(detect("motion", "RG", {raw, raw}).convention.text(), "pixels");
    EXPECT_EQ(detect("motion", "RG", {raw, raw}).confidence, Confidence::values);
    EXPECT_EQ(detect("motion", "RG", {encoded, encoded}).convention.text(), "ndc,encoded");
    EXPECT_EQ(detect("motion", "RG", {small, small}).convention.text(), "uv");
    EXPECT_EQ(detect("motion", "RG", {raw, raw}, "rman_version").convention.text(), "renderman");
    EXPECT_EQ(detect("motion", "RG", {raw, raw}, "", "ndc,flip-x").convention.text(), "ndc,flip-x");
    EXPECT_FALSE(detect("motion", "RG", {raw, raw}).reasons.empty());
    EXPECT_FALSE(detect("motion", "RG", {encoded, encoded}, "", "pixels").warnings.empty()) << "values contradict";
}

TEST(MediaMotionDetection, ZerosAreReported) {
    const std::vector<float> zero(100, 0.0f);
    const auto found = detect("V.Vector", "XYZW", {zero, zero, zero, zero});
    EXPECT_TRUE(found.all_zero);
    EXPECT_NE(found.warnings.back().find("all vectors are zero"), std::string::npos);
}

// -------------------------------------------------------------------------------------------- warp check

// Smooth random texture, larger than the picture, sampled at an offset.
float texture(double x, double y, unsigned seed) {
    auto corner = [seed](int64_t u, int64_t v) {
        uint64_t h = static_cast<uint64_t>(u * 73856093 ^ v * 19349663) + seed * 83492791u;
        h = (h ^ (h >> 31)) * 0x9e3779b97f4a7c15u;
        h = (h ^ (h >> 29)) * 0xbf58476d1ce4e5b9u;
        return static_cast<double>((h >> 40) & 0xffff) / 65535.0;
    };
    x /= 3.0;
    y /= 3.0;
    const double fx = x - std::floor(x), fy = y - std::floor(y);
    const auto u = static_cast<int64_t>(std::floor(x)), v = static_cast<int64_t>(std::floor(y));
    const double top = corner(u, v) * (1 - fx) + corner(u + 1, v) * fx;
    const double bottom = corner(u, v + 1) * (1 - fx) + corner(u + 1, v + 1) * fx;
    return static_cast<float>(top * (1 - fy) + bottom * fy);
}

constexpr int size = 96;

// The frame at `time` of a texture that moves (7.5, 4.25) pixels a frame, with noise.
Planes moving_frame(double time, float noise = 0.0f) {
    Planes planes{size, size, {}};
    std::mt19937 random(static_cast<unsigned>(time + 100.0));
    std::uniform_real_distribution<float> jitter(-noise, noise);
    for (unsigned c = 0; c < 3; ++c) {
        std::vector<float>& plane = planes.channels.emplace_back();
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x)
                plane.push_back(texture(x - 7.5 * time + 1000, y - 4.25 * time + 1000, c) + jitter(random));
    }
    return planes;
}

Planes constant_motion(float x, float y) {
    return {size, size, {std::vector<float>(size * size, x), std::vector<float>(size * size, y)}};
}

WarpReport warp(const Planes& motion, const std::string& text, bool previous, bool next, float noise = 0.0f) {
    const Planes now = moving_frame(0, noise), before = moving_frame(-1, noise), after = moving_frame(1, noise);
    WarpInput input;
    input.colour = &now;
    input.motion = &motion;
    input.previous_colour = previous ? &before : nullptr;
    input.next_colour = next ? &after : nullptr;
    auto report = check_by_warping(input, convention(text));
    EXPECT_TRUE(report) << report.error().message;
    return report ? *report : WarpReport{};
}

TEST(MediaMotionWarp, TruthIsConfirmedWithEitherNeighbourAndNoise) {
    const Planes truth = constant_motion(7.5f, 4.25f);
    EXPECT_EQ(warp(truth, "pixels", true, false).verdict, WarpVerdict::confirmed);
    EXPECT_EQ(warp(truth, "pixels", false, true).verdict, WarpVerdict::confirmed);
    EXPECT_EQ(warp(truth, "pixels", true, true, 0.3f).verdict, WarpVerdict::confirmed);
    EXPECT_EQ(warp(truth, "to-next", true, true).verdict, WarpVerdict::confirmed);
    EXPECT_TRUE(warp(truth, "pixels", true, false).text().starts_with("confirmed"));
}

TEST(MediaMotionWarp, EveryWrongSignSwapAndScaleIsNamed) {
    const std::pair<const char*, const char*> changes[] = {
        {"flip-x", "flip-x"},
        {"flip-y", "flip-y"},
        {"to-previous", "time reversed"},
        {"swap", "swap"},
        {"swap,flip-x", "swap,flip-x"},
        {"swap,flip-y", "swap,flip-y"},
        {"swap,to-previous", "swap,time reversed"},
        {"scale=2", "scale=0.5"},
        {"scale=0.5", "scale=2"},
        {"flip-y,scale=2", "flip-y,scale=0.5"},
        {"flip-x,flip-y", "time reversed"},
    };
    const Planes truth = constant_motion(7.5f, 4.25f);
    for (const auto& [forced, better] : changes)
        for (const bool next : {false, true}) {
            const WarpReport report = warp(truth, std::string("pixels,") + forced, !next, next, 0.05f);
            EXPECT_EQ(report.verdict, WarpVerdict::wrong) << forced;
            EXPECT_EQ(report.best_other.change, better) << forced;
            // The suggestion decodes to the truth.
            const auto v = report.best_other.convention.decode(7.5, 4.25, size, size);
            EXPECT_NEAR(v[0], 7.5, 1e-9) << forced;
            EXPECT_NEAR(v[1], 4.25, 1e-9) << forced;
            EXPECT_LT(report.margin, 0.9);
        }
}

TEST(MediaMotionWarp, WhatCannotBeToldIsInconclusive) {
    EXPECT_EQ(warp(constant_motion(0, 0), "pixels", true, false).verdict, WarpVerdict::inconclusive);
    EXPECT_NE(warp(constant_motion(0, 0), "pixels", true, false).text().find("all vectors are zero"),
              std::string::npos);
    for (const auto& [x, y] : {std::pair{1.3f, -9.0f}, {-3.0f, 17.0f}, {0.6f, 0.6f}, {14.0f, -1.0f}}) {
        const WarpReport nonsense = warp(constant_motion(x, y), "pixels", true, false);
        EXPECT_EQ(nonsense.verdict, WarpVerdict::inconclusive) << nonsense.text();
    }
    const Planes flat{size, size, std::vector<std::vector<float>>(3, std::vector<float>(size * size, 0.5f))};
    const Planes motion = constant_motion(5, 3);
    WarpInput input;
    input.colour = input.previous_colour = &flat;
    input.motion = &motion;
    EXPECT_EQ(check_by_warping(input, convention("pixels"))->verdict, WarpVerdict::inconclusive);
}

TEST(MediaMotionWarp, AnAxisWithoutMotionIsMentioned) {
    Planes now = moving_frame(0), before{size, size, {}};
    for (unsigned c = 0; c < 3; ++c) {
        std::vector<float>& plane = before.channels.emplace_back();
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x)
                plane.push_back(texture(x + 6 + 1000, y + 1000, c));
    }
    const Planes motion = constant_motion(6, 0);
    WarpInput input;
    input.colour = &now;
    input.previous_colour = &before;
    input.motion = &motion;
    auto report = check_by_warping(input, convention("pixels"));
    ASSERT_TRUE(report);
    EXPECT_EQ(report->verdict, WarpVerdict::confirmed) << report->text();
    EXPECT_NE(report->text().find("no difference on these frames: flip-y"), std::string::npos) << report->text();
}

TEST(MediaMotionWarp, MistakesAreErrors) {
    const Planes now = moving_frame(0), motion = constant_motion(1, 1), small{4, 4, {{}, {}}};
    WarpInput input;
    EXPECT_FALSE(check_by_warping(input, convention("pixels")));
    input.colour = &now;
    input.motion = &motion;
    EXPECT_FALSE(check_by_warping(input, convention("pixels"))) << "no neighbour";
    input.previous_colour = &small;
    EXPECT_FALSE(check_by_warping(input, convention("pixels")));
    input.previous_colour = &now;
    EXPECT_FALSE(check_by_warping(input, convention("blender"))) << "four channels are needed";
}

TEST(MediaMotionWarp, RenderedFrames) {
    SKIP_WITHOUT_KINETIC();
    auto now = read_exr(test::kinetic_folder() / "kinetic.0006.exr"),
         before = read_exr(test::kinetic_folder() / "kinetic.0005.exr"),
         after = read_exr(test::kinetic_folder() / "kinetic.0007.exr");
    ASSERT_TRUE(now && before && after);
    auto selection = select_channels(*now);
    ASSERT_TRUE(selection);
    EXPECT_EQ(detect_motion(*now, *selection->motion.chosen)->convention.text(), "blender");
    const Planes colour = colour_planes_of(*now, *selection->colour.chosen);
    const Planes previous = colour_planes_of(*before, *selection->colour.chosen);
    const Planes next = colour_planes_of(*after, *selection->colour.chosen);
    const Planes motion = planes_of(*now, *selection->motion.chosen);
    const std::pair<const char*, const char*> cases[] = {
        {"blender", ""},
        {"blender,flip-x", "blender"},
        {"blender,flip-y", "blender"},
        {"blender,swap", "blender"},
        {"blender,from-previous", "blender"},
        {"blender,scale=2", "blender"},
        {"blender,to-next", "blender"},
    };
    for (const auto& [forced, better] : cases) {
        WarpInput input;
        input.colour = &colour;
        input.motion = &motion;
        input.previous_colour = &previous;
        input.next_colour = &next;
        auto report = check_by_warping(input, convention(forced));
        ASSERT_TRUE(report);
        EXPECT_EQ(report->verdict, *better ? WarpVerdict::wrong : WarpVerdict::confirmed)
            << forced << ": " << report->text();
        if (*better) {
            EXPECT_EQ(report->best_other.convention.text(), better) << forced;
        }
    }
}

} // namespace
} // namespace sfumato::media
