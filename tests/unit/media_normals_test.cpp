// Conventions of normals: words, evidence from depth, decoding.
#include "media/normal_convention.h"

#include "media/camera_file.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace sfumato::media {
namespace {

constexpr int width = 64, height = 48;

struct Picture {
    ExrImage image;
    ChannelGroup group;
    Planes normals;
    std::vector<float> depth;
    Camera camera;
};

// A floor one below a camera that looks down by 30° and a wall five away, with true normals in view space.
Picture make_picture(double orthographic_height = 0.0) {
    Picture picture;
    picture.image.parts.resize(1);
    picture.image.parts[0].data_window = {0, 0, width - 1, height - 1};
    picture.group = {0, "N", {0, 1, 2}, "XYZ", "", 0};
    const double c = std::cos(0.5235988), s = std::sin(0.5235988);
    // Columns: right, up and back of the camera seen from the world.
    picture.camera.world_to_view = {1, 0, 0, 0, 0, float(c), float(s), 0, 0, float(-s), float(c), 0, 0, 0, 0, 1};
    Lens lens;
    lens.aspect = double{width} / height;
    lens.vertical_fov_degrees = 50.0;
    lens.orthographic_height = orthographic_height;
    lens.far_distance = orthographic_height > 0.0 ? 100.0 : 0.0;
    picture.camera.projection = make_projection(lens);
    const Matrix4& p = picture.camera.projection;
    picture.normals = {width, height, std::vector<std::vector<float>>(3, std::vector<float>(width * height))};
    picture.depth.resize(width * height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const double u = 2.0 * (x + 0.5) / width - 1.0, v = 2.0 * (y + 0.5) / height - 1.0;
            // View space: the ray from `from` along `way`.
            std::array<double, 3> from = {0, 0, 0}, way = {u / double{p[0]}, v / double{p[5]}, -1.0};
            if (orthographic_height > 0.0) {
                from = {way[0], way[1], 0.0};
                way = {0.0, 0.0, -1.0};
            }
            const std::array<double, 3> up = {0, c, s}, back = {0, -s, c};
            const auto meet = [&](const std::array<double, 3>& n, double distance) {
                const double along = n[0] * way[0] + n[1] * way[1] + n[2] * way[2];
                const double start = n[0] * from[0] + n[1] * from[1] + n[2] * from[2];
                const double t = (-distance - start) / along;
                return t > 0.0 ? t : 1e10;
            };
            const double floor = meet(up, 1.0), wall = meet(back, 5.0);
            const auto i = static_cast<size_t>(y * width + x);
            picture.depth[i] = static_cast<float>(std::min(floor, wall));
            for (size_t axis = 0; axis < 3; ++axis)
                picture.normals.channels[axis][i] = static_cast<float>(floor < wall ? up[axis] : back[axis]);
        }
    return picture;
}

NormalDetection detect(const Picture& picture, std::string_view told = {}) {
    auto found = detect_normals(picture.image, picture.group, told, picture.normals, picture.depth, &picture.camera);
    EXPECT_TRUE(found) << found.error().message;
    return found ? *found : NormalDetection{};
}

void to_world(Picture& picture) {
    const Matrix4& m = picture.camera.world_to_view;
    for (size_t i = 0; i < picture.normals.pixel_count(); ++i) {
        std::array<float, 3> v{};
        for (size_t axis = 0; axis < 3; ++axis)
            for (size_t k = 0; k < 3; ++k)
                v[axis] += m[axis * 4 + k] * picture.normals.channels[k][i];
        for (size_t axis = 0; axis < 3; ++axis)
            picture.normals.channels[axis][i] = v[axis];
    }
}

} // namespace

TEST(MediaNormals, words_read_back) {
    for (const char* text : {"view", "world", "world,unsigned", "view,z-forward,unsigned,flipped", "world,flipped"}) {
        const auto parsed = parse_normal_convention(text);
        ASSERT_TRUE(parsed) << text;
        EXPECT_EQ(parsed->text(), text);
    }
    for (const char* text : {"", "wolrd", "world,z-forward", "view,", "unsigned"})
        EXPECT_FALSE(parse_normal_convention(text)) << text;
}

TEST(MediaNormals, the_space_shows_against_depth) {
    for (const double orthographic : {0.0, 3.0}) {
        Picture picture = make_picture(orthographic);
        NormalDetection found = detect(picture);
        EXPECT_FALSE(found.convention.is_world);
        EXPECT_GT(found.readings.front().agreement, 0.999);
        to_world(picture);
        found = detect(picture);
        EXPECT_TRUE(found.convention.is_world);
        EXPECT_EQ(found.confidence, Confidence::values);
        EXPECT_TRUE(found.warnings.empty());
        EXPECT_EQ(detect(picture, "view").warnings.size(), 1u);
        EXPECT_EQ(detect(picture, "view").convention.text(), "view");
        EXPECT_TRUE(detect(picture, "world").warnings.empty());
    }
}

TEST(MediaNormals, sign_and_encoding_show_and_are_undone) {
    for (const char* text : {"view,flipped", "view,unsigned", "view,z-forward", "view,unsigned,flipped"}) {
        const NormalConvention wanted = *parse_normal_convention(text);
        const Picture truth = make_picture();
        Picture picture = truth;
        for (size_t axis = 0; axis < 3; ++axis)
            for (float& value : picture.normals.channels[axis]) {
                value = wanted.is_flipped || (wanted.is_z_forward && axis == 2) ? -value : value;
                value = wanted.is_unsigned ? 0.5f * value + 0.5f : value;
            }
        const NormalDetection found = detect(picture);
        EXPECT_EQ(found.convention.text(), text);
        EXPECT_EQ(found.warnings.size(), 1u) << text;
        decode_normals(picture.normals, found.convention);
        for (size_t i = 0; i < truth.depth.size(); ++i)
            for (size_t axis = 0; axis < 3; ++axis)
                ASSERT_NEAR(picture.normals.channels[axis][i], truth.normals.channels[axis][i], 1e-6) << text;
    }
}

TEST(MediaNormals, without_evidence_names_decide) {
    const Picture picture = make_picture();
    const auto without = [&](const std::string& layer) {
        ChannelGroup group = picture.group;
        group.layer = layer;
        const auto found = detect_normals(picture.image, group, {}, picture.normals, {}, nullptr);
        return std::pair(found->convention.is_world, found->confidence);
    };
    EXPECT_EQ(without("WorldNormal"), std::pair(true, Confidence::named));
    EXPECT_EQ(without("a.VRayNormals"), std::pair(false, Confidence::named));
    EXPECT_EQ(without("N"), std::pair(false, Confidence::guess));
}

TEST(MediaNormals, nonsense_is_told) {
    Picture picture = make_picture();
    for (size_t axis = 0; axis < 3; ++axis)
        for (size_t i = 0; i < picture.depth.size(); ++i)
            picture.normals.channels[axis][i] = i % 3 == axis ? 1.0f : -0.5f;
    EXPECT_EQ(detect(picture).warnings.size(), 1u);
    for (float& value : picture.normals.channels[0])
        value = NAN;
    EXPECT_EQ(detect(picture).warnings.size(), 1u);
}

} // namespace sfumato::media
