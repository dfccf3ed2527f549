// Cameras from TOML and from EXR attributes.
#include "media/camera_file.h"

#include <cmath>
#include <cstring>

#include "media/depth_convention.h"
#include "media/motion_convention.h"
#include "media_test_support.h"

namespace sfumato::media {
namespace {

std::array<double, 4> transform(const Matrix4& m, const std::array<double, 4>& p) {
    std::array<double, 4> result = {};
    for (size_t row = 0; row < 4; ++row)
        for (size_t column = 0; column < 4; ++column)
            result[row] += double{m[column * 4 + row]} * p[column];
    return result;
}

// Where a point of the world lands: x and y in -1...1 with y down, depth, and w.
std::array<double, 4> project(const Camera& camera, double x, double y, double z) {
    auto clip = transform(camera.projection, transform(camera.world_to_view, {x, y, z, 1.0}));
    return {clip[0] / clip[3], clip[1] / clip[3], clip[2] / clip[3], clip[3]};
}

const std::string head = "width = 200\nheight = 100\nnear = 1\nfar = 10\nvertical_fov_degrees = 90\n";
const std::string identity_frame =
    "[[frame]]\nnumber = 1\nworld_to_camera = [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]\n";

CameraTrack track_of(const std::string& text) {
    auto track = parse_camera_text(text, "camera.toml");
    EXPECT_TRUE(track) << track.error().message;
    return track ? *track : CameraTrack{};
}

TEST(MediaCamera, PerspectiveFollowsVulkan) {
    const Camera camera = *track_of(head + identity_frame).find(1);
    const auto corner = project(camera, 2.0, 1.0, -1.0); // the upper right of the near plane
    EXPECT_NEAR(corner[0], 1.0, 1e-6);
    EXPECT_NEAR(corner[1], -1.0, 1e-6) << "y down";
    EXPECT_NEAR(corner[2], 0.0, 1e-6);
    EXPECT_NEAR(corner[3], 1.0, 1e-6);
    EXPECT_NEAR(project(camera, 0, 0, -10)[2], 1.0, 1e-6);
    EXPECT_EQ(track_of(head + identity_frame).find(2), nullptr);
}

TEST(MediaCamera, RowsAreRowsOfAMatrixForColumnVectors) {
    const auto track =
        track_of(head + "[[frame]]\nnumber = -3\nworld_to_camera = [[1,0,0,5],[0,1,0,6],[0,0,1,7],[0,0,0,1]]\n");
    const Matrix4& view = track.find(-3)->world_to_view;
    EXPECT_EQ(view[12], 5.0f);
    EXPECT_EQ(view[13], 6.0f);
    EXPECT_EQ(view[14], 7.0f);
    EXPECT_EQ(view[3], 0.0f);
}

TEST(MediaCamera, OptionsOfAFrameWin) {
    const auto track = track_of(head + identity_frame + "vertical_fov_degrees = 53.13010235\n" +
                                "[[frame]]\nnumber = 2\northographic_height = 4\nworld_to_camera = "
                                "[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]\n" +
                                "[[frame]]\nnumber = 3\nshift = [0.25, 0.5]\nfar = inf\nworld_to_camera = "
                                "[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]\n");
    EXPECT_NEAR(project(*track.find(1), 0, 1, -2)[1], -1.0, 1e-6);
    const Camera& flat = *track.find(2);
    EXPECT_NEAR(project(flat, 4, 2, -1)[0], 1.0, 1e-6);
    EXPECT_NEAR(project(flat, 4, 2, -7)[1], -1.0, 1e-6);
    EXPECT_NEAR(project(flat, 0, 0, -1)[2], 0.0, 1e-6);
    EXPECT_NEAR(project(flat, 0, 0, -10)[2], 1.0, 1e-6);
    // The window moves right by a quarter of its width and up by half its height; the content goes left and down.
    const auto centre = project(*track.find(3), 0, 0, -2);
    EXPECT_NEAR(centre[0], -0.5, 1e-6);
    EXPECT_NEAR(centre[1], 1.0, 1e-6);
    EXPECT_NEAR(project(*track.find(3), 0, 0, -1e7)[2], 1.0, 1e-6) << "no far plane";
}

TEST(MediaCamera, ErrorsNameFileKeyValueAndWhatIsAllowed) {
    const std::pair<std::string, std::vector<const char*>> table[] = {
        {"width = \n", {"camera.toml:1:9"}},
        {"width = 200\nheight = -5\n" + identity_frame, {"camera.toml:2", "height", "-5", "from 1"}},
        {"width = 200\n", {"width or height is missing"}},
        {head + "vertical_fov_degrees = 90\n", {"camera.toml:6"}},
        {"width=2\nheight=1\nvertical_fov_degrees = 190\n" + identity_frame, {"vertical_fov_degrees", "190", "179.9"}},
        {"width=2\nheight=1\nvertical_fov_degrees = \"wide\"\n" + identity_frame, {"\"wide\""}},
        {"width=2\nheight=1\nvertical_fov_degrees = nan\n" + identity_frame, {"nan"}},
        {"width=2\nheight=1\nnear=5\nfar=2\n" + identity_frame, {"far is 2", "near 5"}},
        {"width=2\nheight=1\n" + identity_frame, {"vertical_fov_degrees or orthographic_height"}},
        {"widht=2\n" + head + identity_frame, {"widht", "unknown", "width"}},
        {head, {"no [[frame]]"}},
        {head + "frame = 3\n", {"no [[frame]]"}},
        {head + "frame = [3]\n", {"frame 1"}},
        {head + identity_frame + identity_frame, {"number 1 occurs twice"}},
        {head + "[[frame]]\nnumber = 1\n", {"world_to_camera is missing"}},
        {head + "[[frame]]\nnumber = 1.5\nworld_to_camera = 1\n", {"number", "1.5"}},
        {head + "[[frame]]\nnumber = 99999999999\n", {"99999999999"}},
        {head + "[[frame]]\nnumber = 1\nworld_to_camera = [[1,0,0],[0,1,0],[0,0,1]]\n", {"four rows of four"}},
        {head + "[[frame]]\nnumber = 1\nworld_to_camera = [[1,0,0,0],[0,1,0,0],[0,0,1,0],[5,6,7,1]]\n",
         {"last row", "5"}},
        {head + "[[frame]]\nnumber = 1\nworld_to_camera = [[1,0,0,0],[0,1,0,0],[0,0,0,0],[0,0,0,1]]\n", {"inverted"}},
        {head + "[[frame]]\nnumber = 1\nworld_to_camera = [[1,0,0,inf],[0,1,0,0],[0,0,1,0],[0,0,0,1]]\n", {"finite"}},
        {head + "shift = [1]\n" + identity_frame, {"shift", "two numbers"}},
        {std::string(300, '[') + "\n", {"camera.toml:1"}},
        {"a = " + std::string(5000, '['), {"camera.toml"}},
        {std::string("\xff\xfe\0garbage", 10), {"camera.toml"}},
    };
    for (const auto& [text, parts] : table) {
        auto track = parse_camera_text(text, "camera.toml");
        ASSERT_FALSE(track) << text;
        EXPECT_EQ(track.error().message.find('\n'), std::string::npos);
        for (const char* part : parts)
            EXPECT_NE(track.error().message.find(part), std::string::npos)
                << part << " not in: " << track.error().message;
    }
    EXPECT_FALSE(read_camera_file("/no/such/camera.toml"));
}

TEST(MediaCamera, InverseAndProduct) {
    const Matrix4 m = {1, 2, 0, 0, 0, 3, 1, 0, 4, 0, 2, 0, 5, 6, 7, 1};
    const Matrix4 product = multiply(m, *inverse_of(m));
    for (size_t i = 0; i < 16; ++i)
        EXPECT_NEAR(product[i], identity_matrix[i], 1e-5) << i;
    EXPECT_FALSE(inverse_of(Matrix4{}));
}

void add_matrix(ExrPart& part, const char* name, const std::array<float, 16>& values) {
    std::vector<char> bytes(64);
    std::memcpy(bytes.data(), values.data(), 64);
    part.attributes.push_back({name, "m44f", bytes});
}

TEST(MediaCamera, ExrAttributesAreConverted) {
    ExrPart part;
    EXPECT_FALSE(camera_from_attributes(part, "a.exr")->has_value());
    // World: y up, right-handed. The camera stands at (0, 0, 5) and looks along -Z, which is +Z of its own space.
    add_matrix(part, "worldToCamera", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0, 5, 1});
    EXPECT_FALSE(camera_from_attributes(part, "a.exr")) << "one alone";
    // x = 0.5 (X/2w + 1), y = 0.5 (1 - Y/w), w = 5 - z: a view of 90 degrees in height, 2:1.
    add_matrix(part, "worldToNDC", {0.25, 0, 0, 0, 0, -0.5, 0, 0, -0.5, -0.5, 0, -1, 2.5, 2.5, 0, 5});
    auto camera = camera_from_attributes(part, "a.exr");
    ASSERT_TRUE(camera) << camera.error().message;
    ASSERT_TRUE(camera->has_value());
    const auto corner = project(**camera, 4, 2, 3); // 2 in front of the camera
    EXPECT_NEAR(corner[0], 1.0, 1e-5);
    EXPECT_NEAR(corner[1], -1.0, 1e-5);
    EXPECT_NEAR(corner[3], 2.0, 1e-5);
    EXPECT_NEAR(transform((*camera)->world_to_view, {0, 0, 3, 1})[2], -2.0, 1e-6) << "looks along -Z";
    EXPECT_GT(project(**camera, 0, 0, 0)[2], project(**camera, 0, 0, 3)[2]) << "depth grows";
}

TEST(MediaCamera, HostileAttributesAreErrors) {
    ExrPart part;
    std::array<float, 16> broken = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0, 5, 1};
    broken[3] = NAN;
    add_matrix(part, "worldToCamera", broken);
    add_matrix(part, "worldToNDC", {});
    EXPECT_FALSE(camera_from_attributes(part, "a.exr"));
    part.attributes.clear();
    add_matrix(part, "worldToCamera", {});
    add_matrix(part, "worldToNDC", {});
    EXPECT_FALSE(camera_from_attributes(part, "a.exr"));
}

// The camera file, the depth and the vectors of a rendered frame agree: still ground moves as the camera says.
TEST(MediaCamera, RenderedFramesMoveAsTheCameraSays) {
    SKIP_WITHOUT_KINETIC();
    auto track = read_camera_file(test::kinetic_folder() / "camera.toml");
    ASSERT_TRUE(track) << track.error().message;
    EXPECT_EQ(track->frames.size(), 6u);
    EXPECT_EQ(track->shutter, 0.5);
    auto image = read_exr(test::kinetic_folder() / "kinetic.0006.exr");
    ASSERT_TRUE(image);
    auto selection = select_channels(*image);
    const Planes depth = planes_of(*image, *selection->depth.chosen);
    auto field =
        decode_motion(planes_of(*image, *selection->motion.chosen), *parse_motion_convention("blender"), 960, 540);
    ASSERT_TRUE(field);
    const Camera &now = *track->find(6), &before = *track->find(5), &after = *track->find(7);
    const auto to_world = inverse_of(multiply(now.projection, now.world_to_view));
    ASSERT_TRUE(to_world);
    for (const auto& [x, y] : {std::pair{100, 520}, {850, 500}, {600, 530}}) { // ground
        const size_t i = static_cast<size_t>(y) * 960 + static_cast<size_t>(x);
        const double z = depth.channels[0][i];
        const double nx = (x + 0.5) / 480.0 - 1.0, ny = (y + 0.5) / 270.0 - 1.0;
        const double clip_z = double{now.projection[10]} * -z + double{now.projection[14]};
        const auto world = transform(*to_world, {nx * z, ny * z, clip_z, z});
        const auto past = project(before, world[0] / world[3], world[1] / world[3], world[2] / world[3]);
        const auto future = project(after, world[0] / world[3], world[1] / world[3], world[2] / world[3]);
        EXPECT_NEAR(field->velocity[2 * i], (nx - past[0]) * 480.0, 0.05);
        EXPECT_NEAR(field->velocity[2 * i + 1], (ny - past[1]) * 270.0, 0.05);
        EXPECT_NEAR(field->next[2 * i], (future[0] - nx) * 480.0, 0.05);
        EXPECT_GT(std::abs(field->velocity[2 * i]), 1.0f);
    }
}

} // namespace
} // namespace sfumato::media
