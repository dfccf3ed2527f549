// What must hold of filters, history and enlargement: no halo, nothing stale, no trail, no flicker.
#include "tests/gpu/ambient_occlusion_support.h"

#include <cmath>

namespace sfumato::test {
namespace {

constexpr double step = 1.0 / 255.0;
constexpr Extent extent{160, 96};

AmbientOcclusionParameters temporal_parameters() {
    AmbientOcclusionParameters p = plain_parameters();
    p.radius = 1.0f;
    p.slices = 1;
    p.steps = 6;
    p.animate_noise = true;
    p.filter_radius = 2;
    p.filter_sigma = 2.0f;
    p.temporal = true;
    p.second_filter = true;
    p.history_position = 9.0f;
    p.history_visibility = 5.0f;
    p.history_time = 1.0f;
    return p;
}

// A frame of `scene` whose camera and things stand still.
OcclusionInput still_frame(const OcclusionInput& input, uint64_t index) {
    OcclusionInput result = input;
    result.frame.index = index;
    result.frame.previous_camera = result.frame.camera;
    result.velocity = {};
    return result;
}

class AmbientOcclusionHistory : public GpuTest {};

// ------------------------------------------------------------------------------------------------ halo

// A fluted wall, and a thin bar far before it. Next to the bar the flutes are as dark at half resolution as at full;
// with plain bilinear enlargement the bar's own visibility leaks onto them.
TEST_F(AmbientOcclusionHistory, NoHaloInTheEnlargement) {
    OcclusionInput input = plane_input(perspective_frame(extent, 1.0), extent, {0, 0, 1}, 6.0);
    const auto wall = [](float y) { return 6.0f + 0.35f * std::cos(0.3f * y); };
    for (uint32_t y = 0; y < extent.height; ++y)
        for (uint32_t x = 0; x < extent.width; ++x) {
            // The flutes run along x: their normal is at a right angle to the way from one row to the next.
            const auto row = static_cast<float>(y);
            const auto height = [&](float at) { return (0.5f - (at + 0.5f) / extent.height) * wall(at); };
            const float up = height(row - 0.5f) - height(row + 0.5f), towards = wall(row + 0.5f) - wall(row - 0.5f);
            float* normal = input.normal.at(x, y);
            normal[0] = 0.0f;
            normal[1] = -towards / std::hypot(up, towards);
            normal[2] = up / std::hypot(up, towards);
            *input.depth.at(x, y) = wall(row);
            if (x >= 77 && x < 82) // the bar, odd so that half resolution cuts it
                *input.depth.at(x, y) = 2.0f;
        }
    AmbientOcclusionParameters p = plain_parameters();
    p.radius = 0.6f;
    p.iterations = 4;
    const OcclusionOutput full = occlude(input, p);
    // How much brighter the dark rows are beside the bar.
    const auto halo = [&](OcclusionUpsample kind) {
        p.resolution = OcclusionResolution::half;
        p.upsample = kind;
        const OcclusionOutput half = occlude(input, p);
        double total = 0.0;
        size_t count = 0;
        for (uint32_t y = 2; y < extent.height - 2; ++y)
            for (const uint32_t x : {76u, 82u})
                if (full.at(x, y) < 0.85) {
                    total += half.at(x, y) - full.at(x, y);
                    ++count;
                }
        EXPECT_GT(count, 20u);
        return total / static_cast<double>(count);
    };
    EXPECT_LT(std::fabs(halo(OcclusionUpsample::relative)), 0.02);
    p.half_depth = HalfDepthChoice::checkerboard; // as in the presets: SOMA's weights need both sides of an edge nearby
    EXPECT_LT(std::fabs(halo(OcclusionUpsample::soma)), 0.02);
    EXPECT_LT(std::fabs(halo(OcclusionUpsample::relative)), 0.02);
    EXPECT_GT(halo(OcclusionUpsample::bilinear), 0.025);
}

// A box that floats close above a floor, its lower edge within the blocks of four pixels. Every column is like the next
// one, and so must be its occlusion; with a checkerboard of near and far depths every second column lacks the darkest
// floor.
TEST_F(AmbientOcclusionHistory, NoTeethBelowAnEdgeAtHalfResolution) {
    constexpr uint32_t edge = 77; // the first row of the floor
    OcclusionInput input = plane_input(perspective_frame(extent, 1.0), extent, {0, 0, 1}, 3.0);
    for (uint32_t y = edge; y < extent.height; ++y)
        for (uint32_t x = 0; x < extent.width; ++x) {
            *input.depth.at(x, y) = 1.0f / ((static_cast<float>(y) + 0.5f) / extent.height - 0.5f);
            float* normal = input.normal.at(x, y);
            normal[0] = normal[2] = 0.0f;
            normal[1] = 1.0f;
        }
    ASSERT_GT(*input.depth.at(0, edge), 3.2f);
    const auto teeth = [&](const char* preset, HalfDepthChoice choice) {
        AmbientOcclusionParameters p;
        expect_done(apply_preset(AmbientOcclusionParameters::table(), &p, preset), "apply_preset");
        EXPECT_EQ(p.resolution, OcclusionResolution::half) << preset;
        p.radius = 1.0f;
        p.half_depth = choice;
        const OcclusionOutput visibility = occlude(input, p);
        double largest = 0.0, darkest = 1.0;
        for (uint32_t y = edge; y < extent.height; ++y) {
            double sum = 0.0, squares = 0.0, count = 0.0;
            for (uint32_t x = extent.width / 3; x < extent.width * 2 / 3; ++x, ++count) {
                const double value = visibility.at(x, y);
                sum += value;
                squares += value * value;
                darkest = std::min(darkest, value);
            }
            largest = std::max(largest, std::sqrt(std::max(squares / count - sum * sum / count / count, 0.0)));
        }
        EXPECT_LT(darkest, 0.7) << preset;
        std::printf("  %s: %.4f\n", preset, largest);
        return largest;
    };
    for (const char* preset : {"low", "medium", "high", "dx11", "hbao"})
        EXPECT_LT(teeth(preset, AmbientOcclusionParameters().half_depth), 0.01) << preset;
    EXPECT_GT(teeth("high", HalfDepthChoice::checkerboard), 0.03);
}

// ------------------------------------------------------------------------------------------- disocclusion

// A box that hid part of a shelved wall is gone: what it uncovers is the present's estimate, bit for bit.
TEST_F(AmbientOcclusionHistory, DisocclusionTakesThePresent) {
    OcclusionInput after = plane_input(perspective_frame(extent, 1.0), extent, {0, 0, 1}, 6.0);
    for (uint32_t y = 0; y < extent.height; ++y)
        for (uint32_t x = 0; x < extent.width; ++x)
            if (y % 24 < 12)
                *after.depth.at(x, y) = 5.5f;
    OcclusionInput before = after;
    const auto covered = [](uint32_t x, uint32_t y) { return x >= 60 && x < 100 && y >= 30 && y < 70; };
    for (uint32_t y = 0; y < extent.height; ++y)
        for (uint32_t x = 0; x < extent.width; ++x)
            if (covered(x, y))
                *before.depth.at(x, y) = 3.0f;
    AmbientOcclusionParameters p = temporal_parameters();
    p.filter_radius = 0;
    p.history_visibility = 0.0f;
    for (const bool growing : {false, true}) {
        p.history_length = growing ? 16 : 0;
        OcclusionStream stream;
        for (uint64_t index = 0; index < 4; ++index)
            stream.run(still_frame(before, index), p);
        const OcclusionOutput uncovered = stream.run(still_frame(after, 4), p);
        const OcclusionOutput present = occlude(still_frame(after, 4), p);
        double worst = 0.0, elsewhere = 0.0;
        for (uint32_t y = 0; y < extent.height; ++y)
            for (uint32_t x = 0; x < extent.width; ++x)
                (covered(x, y) ? worst : elsewhere) =
                    std::max(covered(x, y) ? worst : elsewhere, std::fabs(uncovered.at(x, y) - present.at(x, y)));
        EXPECT_LT(worst, 1e-3);
        EXPECT_GT(elsewhere, 0.05); // history did something
    }
}

// What stands still is found again where it was, under any camera: the least share of the present is taken everywhere.
TEST_F(AmbientOcclusionHistory, StillFramesFindTheirHistory) {
    for (const bool perspective : {true, false})
        for (const double shift : {0.0, 0.2})
            for (const bool half : {false, true}) {
                const Frame frame =
                    perspective ? perspective_frame(extent, 1.0, shift) : orthographic_frame(extent, 8.0, shift);
                const OcclusionInput input = plane_input(frame, extent, {0.3, 0.4, 1}, 5.0);
                AmbientOcclusionParameters p = temporal_parameters();
                p.resolution = half ? OcclusionResolution::half : OcclusionResolution::full;
                p.filter_radius = 0;
                p.history_time = 12.0f; // of a second: 0.2 a frame
                OcclusionStream stream;
                stream.run(still_frame(input, 0), p);
                p.debug_view = OcclusionView::history_weight;
                const OcclusionOutput share = stream.run(still_frame(input, 1), p);
                const Deviation d = deviation(
                    extent.width, extent.height, 0.01, [&](uint32_t x, uint32_t y) { return share.at(x, y); },
                    [](uint32_t, uint32_t) { return 0.2; });
                EXPECT_EQ(d.share_beyond, 0.0) << perspective << shift << half << " largest " << d.largest;
            }
}

// The velocity image takes precedence over the camera: a plane that moves along itself by a whole number of pixels.
TEST_F(AmbientOcclusionHistory, VelocityFindsHistory) {
    const OcclusionInput input = plane_input(perspective_frame(extent, 1.0), extent, {0, 0, 1}, 5.0);
    AmbientOcclusionParameters p = temporal_parameters();
    p.filter_radius = 0;
    p.history_visibility = 0.0f;
    p.history_time = 0.0f;
    // The first frame has a groove that darkens; the second has none but says that all has moved 20 pixels to the
    // right.
    OcclusionInput grooved = still_frame(input, 0);
    for (uint32_t y = 0; y < extent.height; ++y)
        for (uint32_t x = 60; x < 64; ++x)
            *grooved.depth.at(x, y) = 5.05f;
    p.history_position = 1.0f;
    p.radius = 0.5f;
    p.iterations = 4;
    OcclusionStream stream;
    const OcclusionOutput first = stream.run(grooved, p);
    OcclusionInput moved = still_frame(input, 1);
    moved.velocity = make_image(extent, 2, [](uint32_t, uint32_t, float* pixel) {
        pixel[0] = 20.0f;
        pixel[1] = 0.0f;
    });
    const OcclusionOutput second = stream.run(moved, p);
    double darkest = 1.0, worst = 0.0;
    for (uint32_t y = 0; y < extent.height; ++y)
        for (uint32_t x = 20; x < extent.width; ++x) {
            darkest = std::min(darkest, first.at(x - 20, y));
            // The stored depth differs by 5 cm in the groove: a share of 0.1 of the present.
            worst = std::max(worst, std::fabs(second.at(x, y) - first.at(x - 20, y)));
        }
    EXPECT_LT(darkest, 0.8);
    EXPECT_LT(worst, 0.12 * (1.0 - darkest) + 0.01);
    // What comes in from outside of the screen has no history.
    for (uint32_t y = 0; y < extent.height; ++y)
        EXPECT_EQ(second.at(10, y), 1.0);
}

// ---------------------------------------------------------------------------------------------- trailing

// Behind the rolling ball of `contact`, where its shadow was: not worse with history than without.
TEST_F(AmbientOcclusionHistory, NothingTrailsAMovingBall) {
    scene::Scene scene = *scene::find_scene("contact");
    AmbientOcclusionParameters p = temporal_parameters();
    const auto error_in_trail = [&](const AmbientOcclusionParameters& parameters) {
        OcclusionStream stream;
        OcclusionOutput output;
        OcclusionInput last;
        for (int frame = 6; frame <= 13; ++frame) {
            last = render_input(scene, frame, extent, frame == 13 ? 64 : 0, scene::Falloff::hard, 1.0);
            output = stream.run(last, parameters);
        }
        const OcclusionInput earlier = render_input(scene, 9, extent, 64, scene::Falloff::hard, 1.0);
        // What was darker four frames before than it is now.
        double too_dark = 0.0;
        size_t count = 0;
        for (uint32_t y = 0; y < extent.height; ++y)
            for (uint32_t x = 0; x < extent.width; ++x)
                if (*earlier.truth.at(x, y) < *last.truth.at(x, y) - 0.06f &&
                    std::fabs(*earlier.depth.at(x, y) - *last.depth.at(x, y)) < 0.01f) {
                    too_dark += double{*last.truth.at(x, y)} - output.at(x, y);
                    ++count;
                }
        EXPECT_GT(count, 50u);
        return too_dark / static_cast<double>(count);
    };
    const double with = error_in_trail(p);
    p.history_visibility = 0.0f;
    const double trailing = error_in_trail(p);
    p.history_position = 60.0f; // 2 cm
    const double strict = error_in_trail(p);
    p.history_occluders = true;
    const double tested = error_in_trail(p);
    p.history_occluders = false;
    p.temporal = false;
    const double without = error_in_trail(p);
    // 0.158 by position alone, 0.041 with the test of visibility, 0.003 without history.
    EXPECT_LT(with, without + 0.06);
    EXPECT_LT(tested, strict - 0.02);
    // Without the test of visibility there is a trail, so that this can fail.
    EXPECT_GT(trailing, without + 0.12);
}

// ----------------------------------------------------------------------------------------- temporal blur

struct Smoothness {
    double flicker = 0.0; // mean change from the last frame but one
    double grain = 0.0;   // what differs from a clean picture, against the mean of its 3×3 neighbours; RMS
};

std::vector<OcclusionOutput> frames_of(const OcclusionInput& input, const AmbientOcclusionParameters& p, int frames) {
    OcclusionStream stream;
    std::vector<OcclusionOutput> result;
    for (int frame = 0; frame < frames; ++frame)
        result.push_back(stream.run(still_frame(input, static_cast<uint64_t>(frame)), p));
    return result;
}

Smoothness smoothness(const AmbientOcclusionParameters& p, int frames) {
    const OcclusionInput input = render_input(*scene::find_scene("contact"), 12, extent);
    const auto outputs = frames_of(input, p, frames);
    const OcclusionOutput& last = outputs.back();
    Smoothness result;
    result.flicker = deviation(last, outputs[outputs.size() - 2], step).mean;
    // The same filters on an estimate without grain: what differs is grain.
    AmbientOcclusionParameters clean_parameters = p;
    clean_parameters.iterations = 8;
    clean_parameters.slices = 4;
    clean_parameters.animate_noise = false;
    const OcclusionOutput clean = frames_of(input, clean_parameters, p.temporal ? 4 : 1).back();
    const auto noise = [&](uint32_t x, uint32_t y) { return last.at(x, y) - clean.at(x, y); };
    for (uint32_t y = 1; y + 1 < extent.height; ++y)
        for (uint32_t x = 1; x + 1 < extent.width; ++x) {
            double mean = 0.0;
            for (uint32_t i = 0; i < 9; ++i)
                mean += noise(x + i % 3 - 1, y + i / 3 - 1) / 9.0;
            result.grain += (noise(x, y) - mean) * (noise(x, y) - mean);
        }
    result.grain = std::sqrt(result.grain / (extent.width * extent.height));
    return result;
}

// SOMA: "even a 5x5 blur will cause the resulting image to look as smooth as a 64x64 blur after a few frames".
TEST_F(AmbientOcclusionHistory, TemporalBlurIsSmoothAndStill) {
    const AmbientOcclusionParameters blur = temporal_parameters();
    const Smoothness chain = smoothness(blur, 12);
    AmbientOcclusionParameters spatial = blur;
    spatial.temporal = false;
    const Smoothness small = smoothness(spatial, 2);
    spatial.filter_radius = 8;
    spatial.filter_sigma = 5.0f;
    const Smoothness wide = smoothness(spatial, 2);
    // Flicker 0.0027 against 0.0140 and 0.0056 of the spatial filters; grain 0.0031 against 0.0147 and 0.0043.
    EXPECT_LT(chain.flicker, step);
    EXPECT_LT(chain.flicker, 0.3 * small.flicker);
    EXPECT_LT(chain.grain, wide.grain);
    EXPECT_LT(chain.grain, 0.4 * small.grain);
}

// A still picture under animated noise converges to the mean over the noise when weights grow.
TEST_F(AmbientOcclusionHistory, GrowingWeightsConverge) {
    const OcclusionInput input = render_input(*scene::find_scene("contact"), 12, extent);
    AmbientOcclusionParameters p = temporal_parameters();
    p.filter_radius = 0;
    p.history_visibility = 0.0f;
    p.history_time = 0.0f;
    p.history_length = 30;
    AmbientOcclusionParameters many = p;
    many.temporal = false;
    many.iterations = 16;
    many.slices = 4;
    many.filter_radius = 0;
    const OcclusionOutput converged = occlude(still_frame(input, 0), many);
    OcclusionStream stream;
    double first = 0.0, last = 0.0;
    for (uint64_t index = 0; index < 24; ++index) {
        last = deviation(stream.run(still_frame(input, index), p), converged, step).mean;
        first = index == 0 ? last : first;
    }
    EXPECT_LT(last, 0.3 * first) << first;
}

} // namespace
} // namespace sfumato::test
