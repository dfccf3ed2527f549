// Every path through motion blur's shaders against the double-precision reference. Single precision moves a tap across
// a pixel's border now and then, so a small share of pixels may differ by more than rounding; the rest must agree.
#include "tests/gpu/motion_blur_support.h"

#include <cmath>
#include <limits>

namespace sfumato::test {
namespace {

struct Case {
    const char* name;
    void (*set)(MotionBlurParameters& parameters);
};

MotionBlurParameters base() {
    MotionBlurParameters p;
    p.tile = 16;
    p.radius = 0.12f;
    p.tile_jitter = false;
    return p;
}

void expect_match(const BlurInput& input, const MotionBlurParameters& parameters, const Frame& frame = {},
                  const reference::MotionBlurSettings* settings = nullptr) {
    const auto expected = reference::motion_blur(input, settings ? *settings : settings_of(parameters, frame));
    const auto got = blur_on_device(input, parameters, frame);
    const Difference d = difference(expected, got);
    EXPECT_LT(d.share_above, 0.01) << "largest " << d.largest;
    EXPECT_LT(d.root_mean_square, 2e-3) << "largest " << d.largest;
    // The test says nothing where nothing is blurred.
    EXPECT_GT(difference(expected, input.colour).root_mean_square, 1e-3);
}

class MotionBlurReference : public testing::TestWithParam<Case> {};

TEST_P(MotionBlurReference, ShaderMatches) {
    MotionBlurParameters p = base();
    GetParam().set(p);
    expect_match(disc_scene(120, 77), p);
}

constexpr Case cases[] = {
    {"coverage", [](auto& p) { p.weighting = BlurWeighting::coverage; }},
    {"talk", [](auto& p) { p.weighting = BlurWeighting::talk; }},
    {"guertin", [](auto& p) { p.weighting = BlurWeighting::guertin; }},
    {"jimenez", [](auto& p) { p.weighting = BlurWeighting::jimenez; }},
    {"talk_alternate_packed_ordered",
     [](auto& p) {
         p.weighting = BlurWeighting::talk;
         p.alternate = true;
         p.storage = VelocityStorage::packed;
         p.jitter = TapJitter::ordered;
     }},
    {"talk_weights",
     [](auto& p) {
         p.weighting = BlurWeighting::talk;
         p.weight_background = 0.5f;
         p.weight_foreground = 3.0f;
         p.weight_mutual = 0.2f;
         p.weight_centre = 4.0f;
         p.depth_comparison = DepthComparison::absolute;
         p.soft_extent = 1.5f;
     }},
    {"checkerboard",
     [](auto& p) {
         p.weighting = BlurWeighting::talk;
         p.jitter = TapJitter::checkerboard;
     }},
    {"no_jitter", [](auto& p) { p.jitter = TapJitter::none; }},
    {"nearest_taps", [](auto& p) { p.filter_taps = false; }},
    {"hdr_coverage", [](auto& p) { p.hdr_weighting = true; }},
    {"hdr_jimenez",
     [](auto& p) {
         p.hdr_weighting = true;
         p.weighting = BlurWeighting::jimenez;
     }},
    {"start", [](auto& p) { p.shutter_position = ShutterPosition::start; }},
    {"end_talk",
     [](auto& p) {
         p.shutter_position = ShutterPosition::end;
         p.weighting = BlurWeighting::talk;
     }},
    {"triangle", [](auto& p) { p.shutter_curve = ShutterCurve::triangle; }},
    {"smooth_guertin",
     [](auto& p) {
         p.shutter_curve = ShutterCurve::smooth;
         p.weighting = BlurWeighting::guertin;
     }},
    {"box_dilation", [](auto& p) { p.dilation = Dilation::box; }},
    {"line_dilation", [](auto& p) { p.dilation = Dilation::line; }},
    {"corners_only", [](auto& p) { p.test_edge_neighbours = false; }},
    {"tile_8", [](auto& p) { p.tile = 8; }},
    {"tile_24", [](auto& p) { p.tile = 24; }},
    {"no_classes", [](auto& p) { p.tile_classes = false; }},
    {"wide_classes", [](auto& p) { p.uniform_tolerance = 0.3f; }},
    {"iterations", [](auto& p) { p.iterations = 3; }},
    {"taps_follow_length", [](auto& p) { p.taps_per_pixel = 0.05f; }},
    {"second_direction", [](auto& p) { p.second_direction = true; }},
    {"short_shutter", [](auto& p) { p.shutter = 0.2f; }},
    {"clamped", [](auto& p) { p.radius = 0.03f; }},
    {"repair", [](auto& p) { p.repair_edges = true; }},
};

INSTANTIATE_TEST_SUITE_P(Paths, MotionBlurReference, testing::ValuesIn(cases),
                         [](const auto& parameter) { return std::string(parameter.param.name); });

TEST(MotionBlurReferenceInputs, TileJitter) {
    MotionBlurParameters p = base();
    p.tile_jitter = true;
    expect_match(disc_scene(120, 77), p);
}

TEST(MotionBlurReferenceInputs, AnimatedJitter) {
    MotionBlurParameters p = base();
    p.animate_jitter = true;
    Frame frame;
    frame.index = 5;
    expect_match(disc_scene(120, 77), p, frame);
}

TEST(MotionBlurReferenceInputs, NextVelocity) {
    BlurInput input = disc_scene(120, 77);
    input.next_velocity = input.velocity;
    for (auto& v : input.next_velocity.texels)
        v = {0.5 * v[0] - 0.2 * v[1], v[1] + 0.3 * v[0]};
    for (const ShutterPosition position : {ShutterPosition::start, ShutterPosition::centre, ShutterPosition::end}) {
        MotionBlurParameters p = base();
        p.shutter_position = position;
        expect_match(input, p);
    }
}

TEST(MotionBlurReferenceInputs, LayersMasksAndExclusion) {
    BlurInput input = disc_scene(120, 77);
    for (const auto& [blend, other] :
         {std::pair{LayerBlend::add, LayerBlend::larger}, std::pair{LayerBlend::replace, LayerBlend::add},
          std::pair{LayerBlend::larger, LayerBlend::replace}}) {
        input.layers.clear();
        reference::VelocityLayer first, second;
        first.velocity = reference::Grid<2>(60, 40); // another size than the picture's
        for (int y = 0; y < 40; ++y)
            for (int x = 0; x < 60; ++x)
                first.velocity.at(x, y) = {0.1 * (x - 30), 0.1 * (y - 20)};
        first.mask = reference::Grid<1>(120, 77);
        for (size_t i = 0; i < first.mask.texels.size(); ++i)
            first.mask.texels[i] = {static_cast<double>(i % 120) / 119.0};
        first.blend = static_cast<reference::LayerBlend>(blend);
        first.strength = 1.5;
        second.velocity = reference::Grid<2>(120, 77);
        for (auto& v : second.velocity.texels)
            v = {12.0, -8.0};
        second.blend = static_cast<reference::LayerBlend>(other);
        second.strength = -0.5;
        input.layers = {first, second};
        input.exclusion = reference::Grid<1>(120, 77);
        for (int y = 50; y < 77; ++y)
            for (int x = 0; x < 120; ++x)
                input.exclusion.at(x, y) = {y > 60 ? 1.0 : 0.5};
        MotionBlurParameters p = base();
        p.layer_1_blend = blend;
        p.layer_1_strength = 1.5f;
        p.layer_2_blend = other;
        p.layer_2_strength = -0.5f;
        expect_match(input, p);
    }
}

TEST(MotionBlurReferenceInputs, VelocityOfAnotherResolution) {
    BlurInput input = disc_scene(120, 77);
    const BlurInput half = disc_scene(60, 38);
    input.velocity = half.velocity;
    input.depth = half.depth;
    expect_match(input, base());
}

TEST(MotionBlurReferenceInputs, NoDepth) {
    BlurInput input = disc_scene(120, 77);
    input.depth = {};
    expect_match(input, base());
}

// ---- camera motion from depth ----

Matrix4 perspective(float near_plane, bool reversed_infinite) {
    // Off-centre on purpose. Clip space is Vulkan's: y down, depth 0…1.
    const float far_plane = 50.0f;
    const float a = reversed_infinite ? 0.0f : far_plane / (near_plane - far_plane);
    const float b = reversed_infinite ? near_plane : near_plane * far_plane / (near_plane - far_plane);
    return {1.2f, 0, 0, 0, 0, -1.9f, 0, 0, 0.1f, -0.05f, a, -1, 0, 0, b, 0};
}

// The camera moves 0.3 m to the right and turns by 2° about y from frame to frame.
Camera camera_at(int frame, const Matrix4& projection) {
    const float angle = 0.035f * static_cast<float>(frame), c = std::cos(angle), s = std::sin(angle);
    const float x = 0.3f * static_cast<float>(frame);
    return {.world_to_view = {c, 0, s, 0, 0, 1, 0, 0, -s, 0, c, 0, -c * x, 0, -s * x, 1}, .projection = projection};
}

Frame camera_frame(const Matrix4& projection) {
    Frame frame;
    frame.camera = camera_at(0, projection); // world space is this frame's view space
    frame.previous_camera = camera_at(-1, projection);
    frame.next_camera = camera_at(1, projection);
    return frame;
}

reference::Matrix product(const Matrix4& a, const Matrix4& b) {
    reference::Matrix result{};
    for (size_t column = 0; column < 4; ++column)
        for (size_t row = 0; row < 4; ++row)
            for (size_t k = 0; k < 4; ++k)
                result[column * 4 + row] += double{a[k * 4 + row]} * double{b[column * 4 + k]};
    return result;
}

// A disc before a wall and a strip of sky, with the camera's motion alone.
BlurInput camera_scene(const Frame& frame) {
    BlurInput input = disc_scene(120, 77);
    for (int y = 0; y < 10; ++y)
        for (int x = 0; x < 120; ++x)
            input.depth.at(x, y) = {1e10};
    input.velocity = {};
    input.camera.given = input.camera.next_given = true;
    input.camera.clip_from_view = product(frame.camera->projection, identity_matrix);
    input.camera.previous_clip_from_view =
        product(frame.previous_camera->projection, frame.previous_camera->world_to_view);
    input.camera.next_clip_from_view = product(frame.next_camera->projection, frame.next_camera->world_to_view);
    return input;
}

TEST(MotionBlurReferenceCamera, MotionFromDepthSkyIncluded) {
    const Frame frame = camera_frame(perspective(0.1f, true));
    expect_match(camera_scene(frame), base(), frame);
}

TEST(MotionBlurReferenceCamera, FillsPixelsWithoutVelocity) {
    const Frame frame = camera_frame(perspective(0.1f, false));
    BlurInput input = camera_scene(frame);
    input.velocity = disc_scene(120, 77).velocity;
    for (int y = 0; y < 77; ++y)
        for (int x = 60; x < 120; ++x)
            input.velocity.at(x, y) = {std::numeric_limits<double>::quiet_NaN(), 0.0};
    expect_match(input, base(), frame);
}

// The depth buffer's own values, standard and reversed infinite, give what linear depth gives.
TEST(MotionBlurReferenceCamera, DeviceDepthEqualsLinearDepth) {
    for (const bool reversed : {false, true}) {
        Frame frame = camera_frame(perspective(0.1f, reversed));
        BlurInput input = camera_scene(frame);
        const auto linear = blur_on_device(input, base(), frame);
        const Matrix4& p = frame.camera->projection;
        for (auto& texel : input.depth.texels) {
            const double z = -std::min(texel[0], 1e9);
            texel = {(double{p[10]} * z + double{p[14]}) / (double{p[11]} * z + double{p[15]})};
        }
        frame.depth_kind = DepthKind::device;
        // A standard depth buffer has no value for the sky's infinity: its strip lies at the far plane's side.
        const Difference d = difference(linear, blur_on_device(input, base(), frame), 0.02);
        EXPECT_LT(d.share_above, reversed ? 0.01 : 0.05) << d.largest;
    }
}

// NaN and infinity in every input; the reference says what each counts as.
TEST(MotionBlurReferenceInputs, ValuesThatAreNotNumbers) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    constexpr double infinity = std::numeric_limits<double>::infinity();
    BlurInput input = disc_scene(120, 77);
    input.velocity.at(40, 30) = {nan, 1.0};
    input.velocity.at(70, 12) = {infinity, -infinity};
    input.depth.at(20, 60) = {nan};
    input.depth.at(50, 40) = {infinity};
    input.depth.at(90, 40) = {-3.0};
    expect_match(input, base());
}

} // namespace
} // namespace sfumato::test
