// Which channels play which role, for the names that renderers use.
#include "media/channels.h"

#include "media_test_support.h"

namespace sfumato::media {
namespace {

ExrImage image_of(const std::vector<std::vector<std::string>>& parts, const std::vector<std::string>& names = {}) {
    ExrImage image;
    image.path = "test.exr";
    for (size_t i = 0; i < parts.size(); ++i) {
        ExrPart part;
        part.name = i < names.size() ? names[i] : "";
        part.data_window = {0, 0, 1, 0};
        for (const std::string& channel : parts[i])
            part.set_channel(channel, {1.0f, 2.0f});
        image.parts.push_back(part);
    }
    return image;
}

std::string chosen(const ChannelChoice& choice) {
    return choice.chosen ? choice.chosen->text() : "";
}

ChannelSelection select(const ExrImage& image, const std::string& layer = "") {
    auto selection = select_channels(image, layer);
    EXPECT_TRUE(selection) << selection.error().message;
    return selection ? *selection : ChannelSelection{};
}

TEST(MediaChannels, BlenderLayers) {
    const auto s =
        select(image_of({{"View.AO.R", "View.AO.G", "View.AO.B", "View.Combined.R", "View.Combined.G",
                          "View.Combined.B", "View.Combined.A", "View.Depth.Z", "View.Normal.X", "View.Normal.Y",
                          "View.Normal.Z", "View.Vector.X", "View.Vector.Y", "View.Vector.Z", "View.Vector.W"}}));
    EXPECT_EQ(chosen(s.colour), "View.Combined (RGBA)");
    EXPECT_EQ(chosen(s.depth), "View.Depth (Z)");
    EXPECT_EQ(chosen(s.normal), "View.Normal (XYZ)");
    EXPECT_EQ(chosen(s.motion), "View.Vector (XYZW)");
    EXPECT_EQ(s.motion.chosen->convention, "blender");
    EXPECT_FALSE(s.colour.reasons.empty());
}

TEST(MediaChannels, ColourNames) {
    const std::pair<std::vector<std::string>, std::string> table[] = {
        {{"R", "G", "B", "A"}, "RGBA"},
        {{"R", "G", "B", "spec.R", "spec.G", "spec.B"}, "RGB"},
        {{"rgba.R", "rgba.G", "rgba.B", "rgba.A"}, "rgba (RGBA)"},
        {{"beauty.red", "beauty.green", "beauty.blue", "diff.R", "diff.G", "diff.B"}, "beauty (RGB)"},
        {{"r", "g", "b"}, "RGB"},
        {{"weird.R", "weird.G", "weird.B"}, "weird (RGB)"},
        {{"Y"}, "Y"},
        {{"AO.R", "AO.G", "AO.B"}, ""},
        {{"N.R", "N.G", "N.B"}, ""},
        {{"velocity.R", "velocity.G", "velocity.B"}, ""},
        {{"R", "G"}, ""},
    };
    for (const auto& [names, expected] : table)
        EXPECT_EQ(chosen(select(image_of({names})).colour), expected) << names[0];
}

TEST(MediaChannels, DepthNames) {
    const std::tuple<std::vector<std::string>, std::string, std::string> table[] = {
        {{"Z"}, "Z", ""},
        {{"depth.Z"}, "depth (Z)", ""},
        {{"depth.V"}, "depth (V)", ""},
        {{"A.Depth.Z"}, "A.Depth (Z)", ""},
        {{"rgba.Z"}, "rgba (Z)", ""},
        {{"VRayZDepth"}, "vrayzdepth", "vray"},
        {{"VRayZDepth.R", "VRayZDepth.G", "VRayZDepth.B"}, "VRayZDepth (R)", "vray"},
        {{"FinalImageMovieRenderQueue_WorldDepth.R", "FinalImageMovieRenderQueue_WorldDepth.G"},
         "FinalImageMovieRenderQueue_WorldDepth (R)",
         "unreal"},
        {{"__depth.r"}, "__depth (R)", "distance"},
        {{"N.X", "N.Y", "N.Z"}, "", ""},
        {{"P.X", "P.Y", "P.Z"}, "", ""},
    };
    for (const auto& [names, expected, convention] : table) {
        const auto choice = select(image_of({names})).depth;
        EXPECT_EQ(chosen(choice), expected) << names[0];
        if (choice.chosen) {
            EXPECT_EQ(choice.chosen->convention, convention) << names[0];
        }
    }
}

TEST(MediaChannels, MotionNames) {
    const std::tuple<std::vector<std::string>, std::string, std::string> table[] = {
        {{"FinalImageMovieRenderQueue_MotionVectors.R", "FinalImageMovieRenderQueue_MotionVectors.G"},
         "FinalImageMovieRenderQueue_MotionVectors (RG)",
         "unreal"},
        {{"FinalImageMovieRenderQueue_MotionVectors_CusCamera_00.R",
          "FinalImageMovieRenderQueue_MotionVectors_CusCamera_00.G"},
         "FinalImageMovieRenderQueue_MotionVectors_CusCamera_00 (RG)",
         "unreal"},
        {{"motionvector.X", "motionvector.Y"}, "motionvector (XY)", "arnold"},
        {{"motionvector.u", "motionvector.v"}, "motionvector (UV)", "arnold"},
        {{"motionvec.R", "motionvec.G"}, "motionvec (RG)", "ndc"},
        {{"velocity.R", "velocity.G", "velocity.B"}, "velocity (RG)", "vray"},
        {{"Motion Vectors.R", "Motion Vectors.G"}, "Motion Vectors (RG)", "redshift"},
        {{"motionFore.x", "motionFore.y"}, "motionFore (XY)", "renderman"},
        {{"forward.u", "forward.v"}, "forward (UV)", "nuke-forward"},
        {{"motion.R", "motion.G"}, "motion (RG)", ""},
        {{"dPdtime.R", "dPdtime.G", "dPdtime.B"}, "", ""},
        {{"UV.X", "UV.Y"}, "", ""},
    };
    for (const auto& [names, expected, convention] : table) {
        const auto choice = select(image_of({names})).motion;
        EXPECT_EQ(chosen(choice), expected) << names[0];
        if (choice.chosen) {
            EXPECT_EQ(choice.chosen->convention, convention) << names[0];
        }
    }
}

TEST(MediaChannels, ThreeDimensionalVelocityIsRejectedWithAReason) {
    const auto s = select(image_of({{"R", "G", "B", "dPcameradtime.X", "dPcameradtime.Y", "dPcameradtime.Z"}}));
    EXPECT_FALSE(s.motion.chosen);
    EXPECT_NE(s.motion.reasons.back().find("three dimensions"), std::string::npos);
}

TEST(MediaChannels, BothHalvesOfNukesMotionBelongTogether) {
    const auto s = select(image_of({{"forward.u", "forward.v", "backward.u", "backward.v"}}));
    EXPECT_EQ(chosen(s.motion), "backward (UV)");
    ASSERT_TRUE(s.motion.companion);
    EXPECT_EQ(s.motion.companion->text(), "forward (UV)");
}

TEST(MediaChannels, PartsAreLayers) {
    const ExrImage image =
        image_of({{"R", "G", "B"}, {"Z"}, {"View.Vector.X", "View.Vector.Y", "View.Vector.Z", "View.Vector.W"}},
                 {"rgb", "depth", "View.Vector"});
    const auto s = select(image);
    EXPECT_EQ(chosen(s.colour), "rgb (RGB)");
    EXPECT_EQ(s.depth.chosen->part, 1u);
    EXPECT_EQ(chosen(s.motion), "View.Vector (XYZW)");
    EXPECT_EQ(s.motion.chosen->part, 2u);
    EXPECT_EQ(planes_of(image, *s.depth.chosen).channels[0], (std::vector<float>{1.0f, 2.0f}));
}

TEST(MediaChannels, LayersAreChosenAndExplained) {
    const ExrImage image = image_of({{"B.Combined.R", "B.Combined.G", "B.Combined.B", "A.Combined.R", "A.Combined.G",
                                      "A.Combined.B", "B.Depth.Z"}});
    EXPECT_EQ(chosen(select(image).colour), "A.Combined (RGB)");
    EXPECT_NE(select(image).colour.reasons.back().find("B.Combined (RGB)"), std::string::npos);
    EXPECT_EQ(chosen(select(image, "b").colour), "B.Combined (RGB)");
    EXPECT_EQ(chosen(select(image, "B.combined").colour), "B.Combined (RGB)");
    const auto fallen_back = select(image, "A");
    EXPECT_EQ(chosen(fallen_back.depth), "B.Depth (Z)");
    EXPECT_NE(fallen_back.depth.reasons.front().find("rest of the file"), std::string::npos);
    auto unknown = select_channels(image, "C");
    ASSERT_FALSE(unknown);
    EXPECT_NE(unknown.error().message.find("A.Combined"), std::string::npos);
    EXPECT_FALSE(select_channels(image, "Comb")) << "only whole components count";
}

TEST(MediaChannels, GreyBecomesColour) {
    const ExrImage image = image_of({{"Y"}});
    EXPECT_EQ(colour_planes_of(image, *select(image).colour.chosen).channels.size(), 3u);
}

} // namespace
} // namespace sfumato::media
