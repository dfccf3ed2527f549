// Metrics against values worked out by hand, and pictures as PNG.
#include "media/metrics.h"

#include <cmath>

#include "media/channels.h"
#include "media/colour.h"
#include "media/png_file.h"
#include "media_test_support.h"

namespace sfumato::media {
namespace {

TEST(MediaMetrics, HandComputedValues) {
    const Planes a{2, 1, {{0.5f, 0.25f}, {1.0f, 0.0f}}}, b{2, 1, {{0.25f, 0.25f}, {1.0f, 0.5f}}};
    auto m = measure(a, b);
    ASSERT_TRUE(m);
    // Squares: 1/16, 0, 0, 1/4; mean 5/64.
    EXPECT_NEAR(m->rmse, std::sqrt(5.0 / 64.0), 1e-12);
    EXPECT_NEAR(m->psnr, -10.0 * std::log10(5.0 / 64.0), 1e-12);
    EXPECT_NEAR(m->bias, -1.0 / 16.0, 1e-12);
    EXPECT_EQ(m->max_error, 0.5);
    EXPECT_EQ(m->pixels, 2u);
    EXPECT_TRUE(std::isnan(m->ssim)) << "smaller than the window";
    const Mask first = {1, 0};
    m = measure(a, b, {&first, true});
    ASSERT_TRUE(m);
    EXPECT_NEAR(m->rmse, std::sqrt(1.0 / 32.0), 1e-12);
    EXPECT_NEAR(measure(a, a)->psnr, 120.0, 1e-9);
}

TEST(MediaMetrics, BrokenPixelsAreCountedAndLeftOut) {
    const Planes a{3, 1, {{NAN, INFINITY, 0.5f}}}, b{3, 1, {{0, 0, 0}}};
    auto m = measure(a, b);
    ASSERT_TRUE(m);
    EXPECT_EQ(m->non_finite, 2u);
    EXPECT_EQ(m->pixels, 1u);
    EXPECT_EQ(m->rmse, 0.5);
    const Mask none = {0, 0, 0};
    EXPECT_TRUE(std::isnan(measure(a, b, {&none, true})->psnr));
    EXPECT_FALSE(measure(a, Planes{1, 3, {{0, 0, 0}}}));
    EXPECT_FALSE(measure(a, Planes{3, 1, {}}));
    const Mask wrong = {1};
    EXPECT_FALSE(measure(a, b, {&wrong, true}));
}

TEST(MediaMetrics, SimilarityOfConstantsAndOfItself) {
    auto constant = [](float value) { return Planes{16, 16, {std::vector<float>(256, value)}}; };
    EXPECT_NEAR(structural_similarity(constant(0.3f), constant(0.3f)), 1.0, 1e-12);
    // Without variance only the means count: (2ab + c1) / (a^2 + b^2 + c1).
    EXPECT_NEAR(structural_similarity(constant(0.5f), constant(0.25f)), (0.25 + 1e-4) / (0.3125 + 1e-4), 1e-9);
    Planes noise = constant(0.0f), inverted = constant(0.0f);
    for (size_t i = 0; i < 256; ++i) {
        noise.channels[0][i] = static_cast<float>((i * 37) % 64) / 64.0f;
        inverted.channels[0][i] = 1.0f - noise.channels[0][i];
    }
    EXPECT_NEAR(structural_similarity(noise, noise), 1.0, 1e-12);
    EXPECT_LT(structural_similarity(noise, inverted), -0.5);
    Mask mask(256, 0);
    EXPECT_TRUE(std::isnan(structural_similarity(noise, noise, &mask)));
}

TEST(MediaMetrics, MovingRegionGrowsAsADiamond) {
    Planes sharp{9, 9, {std::vector<float>(81, 0.5f)}}, truth = sharp;
    truth.channels[0][40] = 0.5f + 0.05f; // square 0.0025
    const Mask grown = moving_region(sharp, truth);
    size_t inside = 0;
    for (size_t i = 0; i < 81; ++i) {
        const int distance = std::abs(static_cast<int>(i % 9) - 4) + std::abs(static_cast<int>(i / 9) - 4);
        EXPECT_EQ(grown[i], distance <= 3 ? 1 : 0) << i;
        inside += grown[i];
    }
    EXPECT_EQ(inside, 25u);
    truth.channels[0][40] = 0.5f + 0.04f; // 0.0016
    EXPECT_EQ(moving_region(sharp, truth), Mask(81, 0));
    EXPECT_EQ(inverse(grown)[40], 0);
    // At an edge nothing wraps around.
    truth.channels[0][8] = 1.0f;
    EXPECT_EQ(moving_region(sharp, truth, 0.002, 1)[9], 0);
}

TEST(MediaMetrics, DisplayEncodingAndDifference) {
    const Planes encoded = encode_for_display({4, 1, {{-1.0f, 0.5f, 7.0f, NAN}}});
    EXPECT_EQ(encoded.channels[0][0], 0.0f);
    EXPECT_NEAR(encoded.channels[0][1], 0.7353569, 1e-5);
    EXPECT_EQ(encoded.channels[0][2], 1.0f);
    EXPECT_TRUE(std::isnan(encoded.channels[0][3]));
    EXPECT_EQ(difference_picture({1, 1, {{0.25f}}}, {1, 1, {{0.75f}}}, 2.0f).channels[0][0], 1.0f);
    for (float value = 0.0f; value < 1.0f; value += 0.01f)
        EXPECT_NEAR(srgb_decode(srgb_encode(value)), value, 1e-5f);
    EXPECT_EQ(display_8bit(0.5f), 188);
    EXPECT_EQ(display_8bit(0.25f, 1.0f), 188);
    EXPECT_EQ(display_8bit(NAN), 0);
    EXPECT_EQ(display_16bit(2.0f), 65535);
}

TEST(MediaMetrics, RenderedFramesScoreAsTheReferenceScript) {
    SKIP_WITHOUT_KINETIC();
    auto sharp_file = read_exr(test::kinetic_folder() / "kinetic.0006.exr");
    auto truth_file = read_exr(test::kinetic_folder() / "kinetic-blur.0006.exr");
    ASSERT_TRUE(sharp_file && truth_file);
    const Planes sharp =
        encode_for_display(colour_planes_of(*sharp_file, *select_channels(*sharp_file)->colour.chosen));
    const Planes truth =
        encode_for_display(colour_planes_of(*truth_file, *select_channels(*truth_file)->colour.chosen));
    const Mask moving = moving_region(sharp, truth), still = inverse(moving);
    // Figures of the reference script for the sharp frame.
    EXPECT_NEAR(measure(sharp, truth, {nullptr, false})->psnr, 27.4907, 0.01);
    EXPECT_NEAR(measure(sharp, truth, {&moving, false})->psnr, 19.2867, 0.01);
    EXPECT_NEAR(measure(sharp, truth, {&still, false})->psnr, 43.4975, 0.01);
}

// ---------------------------------------------------------------------------------------------------- PNG

TEST(MediaPng, EightBitsRoundTrip) {
    test::TemporaryDirectory directory;
    for (const int channels : {3, 4}) {
        PngImage image{5, 3, channels, 8, {}};
        for (int i = 0; i < 15 * channels; ++i)
            image.samples.push_back(static_cast<uint16_t>((i * 41) % 256));
        ASSERT_TRUE(write_png(directory / "a.png", image));
        auto back = read_png(directory / "a.png");
        ASSERT_TRUE(back) << back.error().message;
        EXPECT_EQ(back->width, 5);
        EXPECT_EQ(back->height, 3);
        EXPECT_EQ(back->channels, channels);
        EXPECT_EQ(back->samples, image.samples);
    }
}

TEST(MediaPng, SixteenBitsAreWritten) {
    test::TemporaryDirectory directory;
    const PngImage image{1, 1, 3, 16, {65535, 32896, 257}};
    ASSERT_TRUE(write_png(directory / "a.png", image));
    auto back = read_png(directory / "a.png");
    ASSERT_TRUE(back);
    EXPECT_EQ(back->samples, (std::vector<uint16_t>{255, 128, 1}));
}

TEST(MediaPng, BrokenFilesAndBadRequestsAreErrors) {
    test::TemporaryDirectory directory;
    const PngImage image{4, 4, 3, 8, std::vector<uint16_t>(48, 7)};
    ASSERT_TRUE(write_png(directory / "a.png", image));
    const std::vector<char> whole = test::read_bytes(directory / "a.png");
    for (size_t length = 0; length + 13 < whole.size(); ++length) {
        test::write_bytes(directory / "cut.png", {whole.begin(), whole.begin() + static_cast<ptrdiff_t>(length)});
        EXPECT_FALSE(read_png(directory / "cut.png")) << length;
    }
    for (size_t bit = 0; bit < whole.size() * 8; ++bit) {
        std::vector<char> broken = whole;
        broken[bit / 8] = static_cast<char>(broken[bit / 8] ^ (1 << (bit % 8)));
        test::write_bytes(directory / "cut.png", broken);
        (void)static_cast<bool>(read_png(directory / "cut.png"));
    }
    EXPECT_FALSE(write_png(directory / "no/b.png", image));
    EXPECT_FALSE(write_png(directory / "b.png", {4, 4, 3, 8, {}}));
    EXPECT_FALSE(write_png(directory / "b.png", {4, 4, 2, 8, std::vector<uint16_t>(32)}));
    EXPECT_FALSE(write_png(directory / "a.png", image, {true, true}));
    EXPECT_EQ(directory.file_count(), 2u);
}

TEST(MediaPng, PicturesAreExposedAndUnpremultiplied) {
    const float half_grey = 0.25f, half_opaque = 0.5f;
    const PngImage picture = make_picture(1, 1, &half_grey, &half_grey, &half_grey, &half_opaque);
    EXPECT_EQ(picture.samples, (std::vector<uint16_t>{188, 188, 188, 128}));
    EXPECT_EQ(make_picture(1, 1, &half_grey, &half_grey, &half_grey, nullptr, 1.0f).samples[0], 188);
    EXPECT_EQ(make_picture(1, 1, &half_grey, &half_grey, &half_grey, nullptr, 1.0f, 16).bits, 16);
}

} // namespace
} // namespace sfumato::media
