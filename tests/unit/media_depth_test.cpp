// Depth conventions: parsing, detection, decoding.
#include <cmath>
#include <limits>

#include "media/camera_file.h"
#include "media/depth_convention.h"
#include "media_test_support.h"

namespace sfumato::media {
namespace {

const float nan_value = std::numeric_limits<float>::quiet_NaN();
const float infinity = std::numeric_limits<float>::infinity();

std::vector<float> decode(const std::string& text, const std::vector<float>& values,
                          const Matrix4* projection = nullptr) {
    auto convention = parse_depth_convention(text);
    EXPECT_TRUE(convention) << convention.error().message;
    auto decoded = decode_depth(values, static_cast<int>(values.size()), 1, *convention, projection);
    EXPECT_TRUE(decoded) << decoded.error().message;
    return decoded ? *decoded : std::vector<float>{};
}

DepthDetection detect(const std::string& channel, const std::vector<float>& values, const std::string& attribute = "") {
    ExrImage image;
    image.parts.emplace_back();
    image.parts[0].data_window = {0, 0, static_cast<int32_t>(values.size()) - 1, 0};
    image.parts[0].set_channel(channel, values, PixelType::float32);
    if (!attribute.empty())
        image.parts[0].set_string_attribute(attribute, "");
    auto selection = select_channels(image);
    EXPECT_TRUE(selection && selection->depth.chosen);
    auto detection = detect_depth(image, *selection->depth.chosen);
    EXPECT_TRUE(detection);
    return *detection;
}

TEST(MediaDepth, EveryConventionDecodes) {
    using V = std::vector<float>;
    EXPECT_EQ(decode("blender", {2, 1e10f, nan_value, infinity, -1, 0}),
              (V{2, no_hit_depth, no_hit_depth, no_hit_depth, no_hit_depth, no_hit_depth}));
    EXPECT_EQ(decode("planar,negative", {-2, -1e30f}), (V{2, no_hit_depth}));
    EXPECT_EQ(decode("unreal", {200}), (V{2}));
    EXPECT_EQ(decode("arnold", {0, 3}), (V{no_hit_depth, 3}));
    EXPECT_EQ(decode("nuke", {0.5f, 0}), (V{2, no_hit_depth}));
    EXPECT_EQ(decode("normalised,near=10,far=20", {0, 0.5f, 1}), (V{10, 15, no_hit_depth}));
    EXPECT_EQ(decode("vray,near=10,far=20", {1, 0.25f, 0}), (V{10, 17.5f, no_hit_depth}));
    EXPECT_EQ(decode("planar,sentinel=100,scale=2", {99, 100}), (V{198, no_hit_depth}));
}

TEST(MediaDepth, DistanceBecomesPlanar) {
    // A wall 5 in front of the camera; three pixels with a field of view of 90 degrees in height and 3:1.
    const Matrix4 projection = make_projection({3.0, 90.0});
    const float edge = 5.0f * std::sqrt(1.0f + 4.0f);
    const auto depth = decode("distance", {edge, 5.0f, edge}, &projection);
    for (const float value : depth)
        EXPECT_NEAR(value, 5.0f, 1e-5f);
    EXPECT_FALSE(decode_depth({1.0f}, 1, 1, *parse_depth_convention("distance")));
    EXPECT_FALSE(decode_depth({1.0f}, 1, 1, *parse_depth_convention("vray")));
    EXPECT_FALSE(decode_depth({1.0f}, 2, 1, *parse_depth_convention("planar")));
}

TEST(MediaDepth, ParsingIsStrictAndReadsBack) {
    for (const char* text :
         {"blender", "vray,near=1,far=10", "planar,negative,scale=0.01,sentinel=1e+06", "normalised,inverted"})
        EXPECT_EQ(parse_depth_convention(parse_depth_convention(text)->text())->text(),
                  parse_depth_convention(text)->text());
    for (const char* bad :
         {"", "blendr", "planar,near=0", "planar,near=-1", "planar,near=10,far=5", "planar,scale=nan", "planar,"})
        EXPECT_FALSE(parse_depth_convention(bad)) << bad;
}

TEST(MediaDepth, StatisticsCountEverything) {
    const auto s = depth_statistics_of({nan_value, infinity, -infinity, 0, -3, 1e10f, 5, 7, 9});
    EXPECT_EQ(s.pixels, 9u);
    EXPECT_EQ(s.not_a_number, 1u);
    EXPECT_EQ(s.infinite, 2u);
    EXPECT_EQ(s.zero, 1u);
    EXPECT_EQ(s.negative, 1u);
    EXPECT_EQ(s.sentinel, 1u);
    EXPECT_EQ(s.surfaces, 4u);
    EXPECT_EQ(s.minimum, -3.0);
    EXPECT_EQ(s.maximum, 9.0);
}

TEST(MediaDepth, DetectionGivesReasons) {
    EXPECT_EQ(detect("V.Depth.Z", {3, 5, 1e10f}, "BlenderMultiChannel").convention.text(), "blender");
    EXPECT_EQ(detect("Z", {3, 5, 8}).convention.text(), "planar");
    EXPECT_EQ(detect("Z", {-3, -5, -8}).convention.text(), "planar,negative");
    EXPECT_EQ(detect("Z", {0.1f, 0.9f, 0.5f}).convention.text(), "normalised");
    EXPECT_EQ(detect("VRayZDepth.R", {0.1f, 0.9f, 0.5f}).convention.text(), "vray");
    EXPECT_EQ(detect("VRayZDepth.R", {10, 90, 50}).convention.text(), "planar");
    EXPECT_EQ(detect("Z", {0, 3, 5}).convention.text(), "planar,zero-is-far");
    EXPECT_EQ(detect("__depth.r", {3, 4, 5}).convention.text(), "distance");
    EXPECT_FALSE(detect("Z", {0.1f, 0.9f, 0.5f}).warnings.empty());
    EXPECT_FALSE(detect("Z", {nan_value, 2}).warnings.empty());
}

} // namespace
} // namespace sfumato::media
