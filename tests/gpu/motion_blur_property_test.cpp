// What must hold of motion blur whatever its weighting: the traps, each with a test.
#include "effects/motion_blur/motion_blur_plan.h"
#include "tests/gpu/motion_blur_support.h"

#include <cmath>
#include <random>

namespace sfumato::test {
namespace {

constexpr BlurWeighting all_weightings[] = {BlurWeighting::talk, BlurWeighting::guertin, BlurWeighting::jimenez,
                                            BlurWeighting::coverage};

MotionBlurParameters base(BlurWeighting weighting = BlurWeighting::coverage) {
    MotionBlurParameters p;
    p.tile = 16;
    p.radius = 0.12f;
    p.weighting = weighting;
    return p;
}

// Largest difference over the pixels for which `where` holds.
template <class Where>
double worst_where(const reference::Grid<4>& a, const reference::Grid<4>& b, Where where) {
    double worst = 0.0;
    for (int y = 0; y < a.height; ++y)
        for (int x = 0; x < a.width; ++x)
            for (size_t c = 0; where(x, y) && c < 4; ++c)
                worst = std::max(worst, std::fabs(a.at(x, y)[c] - b.at(x, y)[c]));
    return worst;
}

// Colours that survive the way to the device and back unchanged.
BlurInput as_floats(BlurInput input) {
    for (auto& texel : input.colour.texels)
        for (double& value : texel)
            value = double{static_cast<float>(value)};
    return input;
}

TEST(MotionBlurProperty, ZeroMotionIsTheIdentityBitForBit) {
    BlurInput input = as_floats(disc_scene(97, 61));
    for (auto& v : input.velocity.texels)
        v = {0.0, 0.0};
    for (const BlurWeighting weighting : all_weightings)
        for (const VelocityStorage storage : {VelocityStorage::half, VelocityStorage::packed}) {
            MotionBlurParameters p = base(weighting);
            p.storage = storage;
            p.iterations = 2;
            EXPECT_EQ(difference(input.colour, blur_on_device(input, p)).largest, 0.0);
        }
}

TEST(MotionBlurProperty, AZeroShutterIsTheIdentityBitForBit) {
    const BlurInput input = as_floats(disc_scene(97, 61));
    MotionBlurParameters p = base();
    p.shutter = 0.0f;
    EXPECT_EQ(difference(input.colour, blur_on_device(input, p)).largest, 0.0);
}

TEST(MotionBlurProperty, ACameraCutCopies) {
    const BlurInput input = as_floats(disc_scene(97, 61));
    Frame frame;
    frame.reset = true;
    EXPECT_EQ(difference(input.colour, blur_on_device(input, base(), frame)).largest, 0.0);
}

// A still pillar before a moving background, the background's vectors in every tile of the pillar.
TEST(MotionBlurProperty, AStaticForegroundStaysBitExact) {
    BlurInput input = as_floats(pan_scene(120, 64, -14.0, 3.0));
    for (int y = 0; y < 64; ++y)
        for (int x = 50; x < 62; ++x) {
            input.depth.at(x, y) = {2.0};
            input.velocity.at(x, y) = {0.0, 0.0};
        }
    for (const BlurWeighting weighting : all_weightings)
        for (const VelocityStorage storage : {VelocityStorage::half, VelocityStorage::packed}) {
            MotionBlurParameters p = base(weighting);
            p.storage = storage;
            const auto blurred = blur_on_device(input, p);
            EXPECT_EQ(worst_where(input.colour, blurred, [](int x, int) { return x >= 50 && x < 62; }), 0.0)
                << "weighting " << static_cast<int>(weighting);
            // And what moves is blurred.
            EXPECT_GT(difference(input.colour, blurred).root_mean_square, 0.02);
        }
}

// Where everything moves alike, the exact answer is the mean along the path.
TEST(MotionBlurProperty, APanIsTheMeanAlongThePath) {
    const int width = 128, height = 64;
    const BlurInput input = pan_scene(width, height, 16.0, 0.0); // half displacement 4 px
    MotionBlurParameters p = base();
    p.taps = 64;
    p.jitter = TapJitter::none;
    const auto blurred = blur_on_device(input, p);
    double worst = 0.0;
    for (int y = 0; y < height; ++y)
        for (int x = 8; x < width - 8; ++x) {
            double mean = 0.0;
            for (int i = 0; i < 1024; ++i) {
                const double place = x - 4.0 + 8.0 * (i + 0.5) / 1024.0;
                const int left = static_cast<int>(std::floor(place));
                const double t = place - left;
                mean += ((1.0 - t) * input.colour.at(left, y)[0] + t * input.colour.at(left + 1, y)[0]) / 1024.0;
            }
            worst = std::max(worst, std::fabs(mean - blurred.at(x, y)[0]));
        }
    EXPECT_LT(worst, 4e-3);
}

TEST(MotionBlurProperty, AnEvenPictureStaysEven) {
    BlurInput input = disc_scene(97, 61);
    for (auto& texel : input.colour.texels)
        texel = {0.25, 0.5, 2.0, 1.0};
    for (const BlurWeighting weighting : all_weightings)
        EXPECT_LT(difference(input.colour, blur_on_device(input, base(weighting))).largest, 1e-5);
}

// The sign of all velocities does not matter with a centred shutter, up to the noise's own asymmetry.
TEST(MotionBlurProperty, TheSignOfMotionDoesNotMatterWhenCentred) {
    BlurInput input = disc_scene(120, 77);
    MotionBlurParameters p = base();
    p.jitter = TapJitter::none;
    p.tile_jitter = false;
    p.taps = p.search_taps = 32;
    const auto forward = blur_on_device(input, p);
    for (auto& v : input.velocity.texels)
        v = {-v[0], -v[1]};
    const Difference d = difference(forward, blur_on_device(input, p), 0.02);
    EXPECT_LT(d.share_above, 0.02) << d.largest;
}

// No seam at tile borders: under a constant velocity the result does not know where the tiles are.
TEST(MotionBlurProperty, TilesDoNotShow) {
    const BlurInput input = pan_scene(128, 96, 10.0, 6.0);
    for (const BlurWeighting weighting : all_weightings) {
        MotionBlurParameters p = base(weighting);
        p.tile_classes = false;
        const auto coarse = blur_on_device(input, p);
        p.tile = 24;
        EXPECT_LT(difference(coarse, blur_on_device(input, p)).largest, 1e-4);
    }
}

// Iterations differ in their jitter and converge to the picture with many taps.
TEST(MotionBlurProperty, IterationsConverge) {
    const BlurInput input = disc_scene(120, 77);
    MotionBlurParameters p = base();
    p.taps = p.search_taps = 128;
    p.iterations = 4;
    const auto many = blur_on_device(input, p);
    p.taps = p.search_taps = 8;
    p.iterations = 1;
    const double once = difference(many, blur_on_device(input, p)).root_mean_square;
    p.iterations = 16;
    const double often = difference(many, blur_on_device(input, p)).root_mean_square;
    EXPECT_LT(often, 0.6 * once) << once;
}

// Twice the resolution, twice the velocity in pixels: the same look.
TEST(MotionBlurProperty, ResolutionDoesNotChangeTheLook) {
    const auto scene = [](int scale) {
        BlurInput input = pan_scene(80 * scale, 48 * scale, 0.0, 0.0);
        for (int y = 0; y < 48 * scale; ++y)
            for (int x = 0; x < 80 * scale; ++x) {
                const double u = (x + 0.5) / scale, v = (y + 0.5) / scale;
                const bool disc = std::hypot(u - 40.0, v - 24.0) < 12.0;
                input.colour.at(x, y) = {disc ? 0.9 : 0.4 + 0.2 * std::sin(u), disc ? 0.2 : 0.4, 0.3, 1.0};
                input.depth.at(x, y) = {disc ? 2.0 : 6.0};
                input.velocity.at(x, y) = {disc ? 12.0 * scale : 0.0, 0.0};
            }
        return input;
    };
    MotionBlurParameters p = base();
    p.taps = p.search_taps = 48;
    p.iterations = 4;
    const auto small = blur_on_device(scene(2), p);
    const auto large = blur_on_device(scene(4), p);
    double sum = 0.0;
    for (int y = 0; y < small.height; ++y)
        for (int x = 0; x < small.width; ++x) {
            double mean = 0.0;
            for (int k = 0; k < 4; ++k)
                mean += 0.25 * large.at(2 * x + k % 2, 2 * y + k / 2)[0];
            sum += (mean - small.at(x, y)[0]) * (mean - small.at(x, y)[0]);
        }
    EXPECT_LT(std::sqrt(sum / (small.width * small.height)), 0.012);
}

// The exclusion mask and layers do what they say.
TEST(MotionBlurProperty, AnExcludedThingStaysSharp) {
    BlurInput input = as_floats(pan_scene(96, 64, 12.0, 0.0));
    input.exclusion = reference::Grid<1>(96, 64);
    for (auto& mask : input.exclusion.texels)
        mask = {1.0};
    EXPECT_EQ(difference(input.colour, blur_on_device(input, base())).largest, 0.0);
}

TEST(MotionBlurProperty, ALayerAloneBlurs) {
    BlurInput input = pan_scene(96, 64, 0.0, 0.0);
    reference::VelocityLayer layer;
    layer.velocity = reference::Grid<2>(96, 64);
    for (auto& v : layer.velocity.texels)
        v = {12.0, 0.0};
    input.layers = {layer};
    const BlurInput same = pan_scene(96, 64, 12.0, 0.0);
    EXPECT_LT(difference(blur_on_device(same, base()), blur_on_device(input, base())).largest, 1e-5);
}

TEST(MotionBlurProperty, SubgroupOperationsDoNotChangeABit) {
    const BlurInput input = disc_scene(120, 77);
    for (const VelocityStorage storage : {VelocityStorage::half, VelocityStorage::packed}) {
        MotionBlurParameters p = base();
        p.storage = storage;
        EXPECT_EQ(difference(blur_on_device(input, p), blur_on_device(input, p, {}, false)).largest, 0.0);
    }
}

// A camera that stands still says nothing of the next velocity of things that move.
TEST(MotionBlurProperty, ANextCameraDoesNotStopThings) {
    const BlurInput input = disc_scene(96, 64);
    Frame frame;
    frame.camera = frame.previous_camera =
        Camera{.world_to_view = identity_matrix, .projection = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, -1, 0, 0, 0.1f, 0}};
    const auto without = blur_on_device(input, base(), frame);
    frame.next_camera = frame.camera;
    EXPECT_EQ(difference(without, blur_on_device(input, base(), frame)).largest, 0.0);
}

// Frame rate modes: the open time in fractions of this frame.
TEST(MotionBlurShutter, FrameRateModes) {
    MotionBlurParameters p;
    p.shutter = 0.5f;
    p.reference_frame_rate = 30.0f;
    Frame slow, fast;
    slow.time_step = 1.0f / 15.0f;
    fast.time_step = 1.0f / 120.0f;
    EXPECT_FLOAT_EQ(effective_shutter(slow, p), 0.5f);
    EXPECT_FLOAT_EQ(effective_shutter(fast, p), 0.5f);
    p.frame_rate_mode = FrameRateMode::reference; // never more than native
    EXPECT_FLOAT_EQ(effective_shutter(slow, p), 0.25f);
    EXPECT_FLOAT_EQ(effective_shutter(fast, p), 0.5f);
    p.frame_rate_mode = FrameRateMode::fixed;
    EXPECT_FLOAT_EQ(effective_shutter(slow, p), 0.25f);
    EXPECT_FLOAT_EQ(effective_shutter(fast, p), 2.0f);
    p.generated_frames = 2;
    EXPECT_FLOAT_EQ(effective_shutter(fast, p), 1.0f);
}

// Dilation misses nothing: on random fields, whatever pixel's path crosses a tile, the tile's neighbour maximum is at
// least as long as that pixel's vector.
TEST(MotionBlurDilation, NoPixelThatReachesATileIsMissed) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    for (const auto dilation : {reference::Dilation::box, reference::Dilation::selective, reference::Dilation::line})
        for (int round = 0; round < 40; ++round) {
            reference::MotionBlurSettings s;
            s.tile_size = 8;
            s.dilation = dilation;
            s.test_edge_neighbours = round % 2 == 0;
            const double radius = 4.0 + round % 5 * 5.0; // up to three rings
            reference::Grid<3> surface(75, 53);
            for (auto& texel : surface.texels) {
                const double length = uniform(random) > 0.98 ? radius : 0.3 * radius;
                const double angle = 3.14159265 * uniform(random);
                texel = {length * std::cos(angle), length * std::sin(angle), 1.0};
            }
            const auto neighbours = reference::neighbour_maximum(reference::tile_maximum(surface, s), s, radius);
            for (int y = 0; y < surface.height; ++y)
                for (int x = 0; x < surface.width; ++x) {
                    const auto& v = surface.at(x, y);
                    for (int i = -20; i <= 20; ++i) {
                        const int tx = static_cast<int>(std::floor((x + 0.5 + v[0] * i / 20.0) / s.tile_size));
                        const int ty = static_cast<int>(std::floor((y + 0.5 + v[1] * i / 20.0) / s.tile_size));
                        if (tx < 0 || ty < 0 || tx >= neighbours.width || ty >= neighbours.height)
                            continue;
                        const auto& n = neighbours.at(tx, ty);
                        ASSERT_GE(std::hypot(n[0], n[1]) + 1e-9, std::hypot(v[0], v[1]))
                            << "dilation " << static_cast<int>(dilation) << " pixel " << x << "," << y;
                    }
                }
        }
}

TEST(MotionBlurStorage, EightBitZeroIsZero) {
    for (const double radius : {1.0, 10.0, 18.0, 65.0}) {
        const auto decoded = reference::unpack(reference::pack({0.0, 0.0}, 3.0, radius), radius);
        EXPECT_EQ(decoded[0], 0.0);
        EXPECT_EQ(decoded[1], 0.0);
        EXPECT_NEAR(decoded[2], 3.0, 3.0 * 4e-4);
    }
}

} // namespace
} // namespace sfumato::test
