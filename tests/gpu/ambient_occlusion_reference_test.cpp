// Every stage of ambient occlusion on the device against the double-precision reference.
//
// Tolerances. Signals travel in half floats, which cost 1/4096; a tap that lands within rounding of a texel's border
// may be fetched from the neighbour, and what that changes is one tap's share: 12/255 on a horizon here, 36/255 of
// twelve taps that sum up to 1.6. So all but a few pixels in a thousand agree within 1/255. The bitmask rounds to 32
// sectors, and a face within 3e-4 radians (the device's arc cosine) of a sector's border moves that sector: 1/128 with
// four slices.
#include "effects/ambient_occlusion/ambient_occlusion_plan.h"
#include "tests/gpu/ambient_occlusion_support.h"
#include "tests/reference/soma_listings.h"

#include <cmath>
#include <numbers>

namespace sfumato::test {
namespace {

constexpr Extent extent{107, 61}; // odd, so that half resolution has texels of fewer than four pixels
constexpr double step = 1.0 / 255.0;

const OcclusionInput& columns(int frame = 12) {
    static std::map<int, OcclusionInput> made;
    if (!made.contains(frame)) {
        OcclusionInput input = render_input(*scene::find_scene("columns"), frame, extent);
        input.velocity = {}; // reprojection by the camera alone
        made[frame] = std::move(input);
    }
    return made[frame];
}

using reference::OcclusionSignal;

// Depths travel in half floats, as planar depth in radii, unless a history or a shadow goes along.
double travelled(double z, double radius) {
    if (z == reference::sky)
        return z;
    int exponent = 0;
    const double mantissa = std::frexp(radius / z, &exponent);
    return radius / std::ldexp(std::nearbyint(mantissa * 2048.0) / 2048.0, exponent);
}

// What the device shows at the working resolution.
OcclusionSignal shown_signal(const OcclusionInput& input, AmbientOcclusionParameters p, OcclusionView view,
                             bool narrow = true) {
    p.debug_view = view;
    const OcclusionOutput output = occlude(input, p);
    const auto reference = reference_of(input, p);
    OcclusionSignal signal(reference.working_width(), reference.working_height());
    const uint32_t scale = p.resolution == OcclusionResolution::half ? 2 : 1;
    for (int y = 0; y < signal.height; ++y)
        for (int x = 0; x < signal.width; ++x)
            signal.at(x, y) = {output.at(static_cast<uint32_t>(x) * scale, static_cast<uint32_t>(y) * scale),
                               narrow ? travelled(reference.depth_in_middle(x, y), double{p.radius})
                                      : reference.depth_in_middle(x, y),
                               1.0, 0.0};
    return signal;
}

Deviation difference(const OcclusionSignal& a, const OcclusionSignal& b, double tolerance) {
    EXPECT_EQ(a.width, b.width);
    return deviation(
        static_cast<uint32_t>(a.width), static_cast<uint32_t>(a.height), tolerance,
        [&](uint32_t x, uint32_t y) {
            return std::clamp(a.at(static_cast<int>(x), static_cast<int>(y)).visibility, 0.0, 1.0);
        },
        [&](uint32_t x, uint32_t y) { return b.at(static_cast<int>(x), static_cast<int>(y)).visibility; });
}

// The test says nothing where all is alike.
double spread(const OcclusionSignal& signal) {
    double least = 1.0, most = 0.0;
    for (const auto& texel : signal.texels) {
        least = std::min(least, texel.visibility);
        most = std::max(most, texel.visibility);
    }
    return most - least;
}

OcclusionSignal signal_of(const OcclusionOutput& output, const reference::AmbientOcclusionReference& reference) {
    OcclusionSignal signal(reference.width(), reference.height());
    for (int y = 0; y < signal.height; ++y)
        for (int x = 0; x < signal.width; ++x)
            signal.at(x, y).visibility = output.at(static_cast<uint32_t>(x), static_cast<uint32_t>(y));
    return signal;
}

struct Case {
    const char* name;
    void (*set)(AmbientOcclusionParameters& p);
};
std::string case_name(const testing::TestParamInfo<Case>& info) {
    return info.param.name;
}
void PrintTo(const Case& c, std::ostream* stream) {
    *stream << c.name;
}

// ---------------------------------------------------------------------------------------------- estimators

class AmbientOcclusionEstimate : public GpuTest, public testing::WithParamInterface<Case> {};

TEST_P(AmbientOcclusionEstimate, Matches) {
    AmbientOcclusionParameters p = plain_parameters();
    GetParam().set(p);
    // Calibrated, one tap that snaps to another texel would weigh up to half of everything.
    if (p.estimator == OcclusionEstimator::obscurance && p.normalisation == OcclusionNormalisation::calibrated)
        p.intensity *= 1.6f / occlusion_calibration(p);
    const OcclusionSignal expected = reference_of(columns(), p).estimates();
    const OcclusionSignal got = shown_signal(columns(), p, OcclusionView::estimate);
    const bool bitmask = p.estimator == OcclusionEstimator::horizon && p.measure == HorizonMeasure::bitmask;
    const Deviation d = difference(expected, got, bitmask ? 2.1 * step : step);
    EXPECT_LT(d.share_beyond, bitmask ? 0.01 : 0.004) << "largest " << d.largest * 255 << "/255";
    const bool sums = p.estimator == OcclusionEstimator::obscurance;
    EXPECT_LT(d.largest, sums ? 36.0 * step : 12.0 * step);
    EXPECT_LT(d.mean, 0.25 * step);
    EXPECT_GT(spread(expected), 0.2);
}

using enum OcclusionFalloff;
void obscurance(AmbientOcclusionParameters& p, OcclusionFalloff falloff, TapPattern pattern) {
    p.estimator = OcclusionEstimator::obscurance;
    p.falloff = falloff;
    p.pattern = pattern;
}
void horizon(AmbientOcclusionParameters& p, HorizonMeasure measure, OcclusionFalloff falloff) {
    p.measure = measure;
    p.falloff = falloff;
}

constexpr Case estimates[] = {
    {"obscurance_hard_spiral", [](auto& p) { obscurance(p, hard, TapPattern::spiral); }},
    {"obscurance_linear_circle", [](auto& p) { obscurance(p, linear, TapPattern::growing_circle); }},
    {"obscurance_quadratic_mirrored", [](auto& p) { obscurance(p, quadratic, TapPattern::mirrored_spiral); }},
    {"obscurance_sao", [](auto& p) { obscurance(p, sao, TapPattern::spiral); }},
    {"obscurance_contact_mirrored_odd",
     [](auto& p) {
         obscurance(p, contact, TapPattern::mirrored_spiral);
         p.taps = 7;
     }},
    {"obscurance_wide_squared",
     [](auto& p) {
         obscurance(p, wide, TapPattern::spiral);
         p.normalisation = OcclusionNormalisation::vicarious_visions;
     }},
    {"hbao_quadratic", [](auto& p) { horizon(p, HorizonMeasure::hbao, quadratic); }},
    {"hbao_hard_biased",
     [](auto& p) {
         horizon(p, HorizonMeasure::hbao, hard);
         p.bias = 0.25f;
     }},
    {"cosine_hard", [](auto& p) { horizon(p, HorizonMeasure::cosine, hard); }},
    {"cosine_linear_uneven_steps",
     [](auto& p) {
         horizon(p, HorizonMeasure::cosine, linear);
         p.step_power = 2.0f;
     }},
    {"bitmask_hard", [](auto& p) { horizon(p, HorizonMeasure::bitmask, hard); }},
    {"bitmask_wide_thin",
     [](auto& p) {
         horizon(p, HorizonMeasure::bitmask, wide);
         p.thickness = 0.1f;
     }},
    {"bitmask_endless",
     [](auto& p) {
         horizon(p, HorizonMeasure::bitmask, quadratic);
         p.thickness = 100.0f;
     }},
    {"short_radius_limit",
     [](auto& p) {
         horizon(p, HorizonMeasure::cosine, linear);
         p.radius_limit = 0.1f;
     }},
    {"radius_of_few_pixels",
     [](auto& p) {
         horizon(p, HorizonMeasure::cosine, hard);
         p.radius = 0.22f;
     }},
    {"half_checkerboard",
     [](auto& p) {
         horizon(p, HorizonMeasure::cosine, quadratic);
         p.resolution = OcclusionResolution::half;
     }},
    {"half_nearest_without_mips",
     [](auto& p) {
         horizon(p, HorizonMeasure::cosine, quadratic);
         p.resolution = OcclusionResolution::half;
         p.half_depth = HalfDepthChoice::nearest;
         p.depth_mips = DepthMips::none;
     }},
    {"half_farthest_derived_normals",
     [](auto& p) {
         obscurance(p, quadratic, TapPattern::growing_circle);
         p.resolution = OcclusionResolution::half;
         p.half_depth = HalfDepthChoice::farthest;
         p.normals = NormalSource::derived;
     }},
    {"farthest_mips",
     [](auto& p) {
         horizon(p, HorizonMeasure::cosine, quadratic);
         p.depth_mips = DepthMips::farthest;
         p.mip_rate = 1.0f;
     }},
    {"coarse_rotated_mips",
     [](auto& p) {
         obscurance(p, linear, TapPattern::spiral);
         p.mip_rate = 0.0f;
         p.bias = 0.1f;
     }},
    {"derived_normals",
     [](auto& p) {
         horizon(p, HorizonMeasure::cosine, linear);
         p.normals = NormalSource::derived;
     }},
    {"iterations",
     [](auto& p) {
         horizon(p, HorizonMeasure::cosine, linear);
         p.iterations = 3;
         p.slices = 2;
     }},
    {"hash_noise",
     [](auto& p) {
         obscurance(p, linear, TapPattern::spiral);
         p.noise = OcclusionNoise::hash;
     }},
    {"guard_band",
     [](auto& p) {
         horizon(p, HorizonMeasure::cosine, linear);
         p.guard_band = 9;
     }},
};
INSTANTIATE_TEST_SUITE_P(All, AmbientOcclusionEstimate, testing::ValuesIn(estimates), case_name);

class AmbientOcclusionStage : public GpuTest {};

// Gradient noise amplifies the rounding of its argument by 53, so that tap positions differ by a hundredth of a pixel
// and some texels flip: the means agree.
TEST_F(AmbientOcclusionStage, GradientNoise) {
    AmbientOcclusionParameters p = plain_parameters();
    p.measure = HorizonMeasure::cosine;
    p.falloff = quadratic;
    p.noise = OcclusionNoise::gradient_noise;
    p.animate_noise = true;
    const Deviation d = difference(reference_of(columns(), p).estimates(),
                                   shown_signal(columns(), p, OcclusionView::estimate), 4.0 * step);
    EXPECT_LT(d.share_beyond, 0.01);
    EXPECT_LT(d.mean, 0.5 * step);
}

TEST_F(AmbientOcclusionStage, DepthsAtHalfResolution) {
    for (const auto choice : {HalfDepthChoice::checkerboard, HalfDepthChoice::nearest, HalfDepthChoice::farthest}) {
        AmbientOcclusionParameters p = plain_parameters();
        p.resolution = OcclusionResolution::half;
        p.half_depth = choice;
        const OcclusionSignal got = shown_signal(columns(), p, OcclusionView::depth, false);
        const auto reference = reference_of(columns(), p);
        OcclusionSignal expected = got;
        for (int y = 0; y < expected.height; ++y)
            for (int x = 0; x < expected.width; ++x) { // as the view shows depth
                const double z = reference.level(0).at(x, y).z;
                expected.at(x, y).visibility = z == reference::sky ? 1.0 : 1.5 / (1.5 + 0.1 * z);
            }
        EXPECT_LT(difference(expected, got, 1e-3).largest, 1e-3) << static_cast<int>(choice);
    }
}

TEST_F(AmbientOcclusionStage, Normals) {
    for (const auto source : {NormalSource::given, NormalSource::derived}) {
        AmbientOcclusionParameters p = plain_parameters();
        p.normals = source;
        OcclusionSignal expected = shown_signal(columns(), p, OcclusionView::normal);
        const OcclusionSignal got = expected;
        const auto reference = reference_of(columns(), p);
        for (int y = 0; y < expected.height; ++y)
            for (int x = 0; x < expected.width; ++x)
                if (expected.at(x, y).z < reference::sky) {
                    const reference::Place n = reference.normal(x, y);
                    expected.at(x, y).visibility = 0.5 + 0.5 * (n.y + n.z - n.x) / std::sqrt(3.0);
                }
        const Deviation d = difference(expected, got, step);
        EXPECT_LT(d.share_beyond, 0.002) << d.largest;
    }
}

// SOMA's main loop as printed, on rolling ground without sky, is the obscurance with the growing circle.
TEST_F(AmbientOcclusionStage, SomaListing) {
    OcclusionInput input = plane_input(perspective_frame(extent, 1.1), extent, {0, 0.3, 1}, 4.0);
    for (uint32_t y = 0; y < extent.height; ++y)
        for (uint32_t x = 0; x < extent.width; ++x)
            *input.depth.at(x, y) +=
                0.25f * std::sin(0.2f * static_cast<float>(x)) * std::cos(0.3f * static_cast<float>(y));
    AmbientOcclusionParameters p = plain_parameters();
    p.radius = 1.0f;
    obscurance(p, linear, TapPattern::growing_circle);
    p.taps = 16;
    p.bias = 0.0f;
    p.depth_bias = 0.0f;
    p.normalisation = OcclusionNormalisation::plain;
    p.noise = OcclusionNoise::none;
    p.depth_mips = DepthMips::none;
    const auto reference = reference_of(input, p);
    const OcclusionSignal general = reference.estimates();
    const OcclusionSignal device = shown_signal(input, p, OcclusionView::estimate);
    const double turn = std::numbers::pi * (3.0 - std::sqrt(5.0));
    const auto rotate = [&](reference::SomaVec2 v) {
        return reference::SomaVec2{v.x * std::cos(turn) - v.y * std::sin(turn),
                                   v.x * std::sin(turn) + v.y * std::cos(turn)};
    };
    const auto view_position = [&](double x, double y) {
        const auto& texel = reference.level(0).at(static_cast<int>(x), static_cast<int>(y));
        const reference::Place at = reference.position(texel.x, texel.y, texel.z);
        return reference::SomaVec3{at.x, at.y, -at.z}; // the article's z grows away from the eye
    };
    double worst = 0.0, worst_on_device = 0.0, darkest = 1.0;
    for (int y = 26; y < static_cast<int>(extent.height) - 26; ++y) // no tap leaves the screen
        for (int x = 26; x < static_cast<int>(extent.width) - 26; ++x) {
            const reference::Place n = reference.normal(x, y);
            const auto here = view_position(x + 0.5, y + 0.5);
            const double listing = reference::soma_listing_ssao(view_position, rotate,
                                                                {std::cos(-turn), std::sin(-turn)}, {x + 0.5, y + 0.5},
                                                                here, {n.x, n.y, -n.z}, 2.0 * 1.1 * extent.height, 1.0);
            worst = std::max(worst, std::fabs(listing - general.at(x, y).visibility));
            worst_on_device = std::max(worst_on_device, std::fabs(listing - device.at(x, y).visibility));
            darkest = std::min(darkest, listing);
        }
    EXPECT_LT(worst, 1e-9);
    EXPECT_LT(worst_on_device, 8.0 * step);
    EXPECT_LT(darkest, 0.95);
}

// ---------------------------------------------------------------------------------------------- filter

class AmbientOcclusionFilter : public GpuTest, public testing::WithParamInterface<Case> {};

// From the device's own estimate, so that only the filter is compared.
TEST_P(AmbientOcclusionFilter, Matches) {
    AmbientOcclusionParameters p = plain_parameters();
    horizon(p, HorizonMeasure::cosine, linear);
    p.filter_radius = 3;
    GetParam().set(p);
    const OcclusionSignal estimate = shown_signal(columns(), p, OcclusionView::estimate);
    const OcclusionSignal expected = reference_of(columns(), p).filtered(estimate);
    const OcclusionSignal got = shown_signal(columns(), p, OcclusionView::filtered);
    // Depth travels in eleven bits: all-or-nothing weights may fall otherwise at their limit.
    const bool abrupt = p.filter_weight == DepthWeight::limit;
    const Deviation d = difference(expected, got, step);
    EXPECT_LT(d.share_beyond, abrupt ? 0.03 : 0.005) << "largest " << d.largest * 255 << "/255";
    EXPECT_LT(d.largest, abrupt ? 40.0 * step : 12.0 * step);
    EXPECT_LT(d.mean, 0.25 * step);
    EXPECT_GT(difference(expected, estimate, step).mean, step);
}

constexpr Case filters[] = {
    {"bell", [](auto&) {}},
    {"limit", [](auto& p) { p.filter_weight = DepthWeight::limit; }},
    {"tent", [](auto& p) { p.filter_weight = DepthWeight::tent; }},
    {"of_the_radius",
     [](auto& p) {
         p.filter_comparison = DepthDifference::radius;
         p.filter_depth = 0.1f;
     }},
    {"without_slope",
     [](auto& p) {
         p.filter_slope = false;
         p.filter_depth = 0.1f;
     }},
    {"normals", [](auto& p) { p.filter_normal = 16.0f; }},
    {"steps",
     [](auto& p) {
         p.filter_radius = 2;
         p.filter_step = 4;
         p.filter_sigma = 4.0f;
     }},
    {"radius_8_step_limited",
     [](auto& p) {
         p.filter_radius = 8;
         p.filter_step = 3;
         p.filter_sigma = 5.0f;
     }},
    {"half_resolution", [](auto& p) { p.resolution = OcclusionResolution::half; }},
};
INSTANTIATE_TEST_SUITE_P(All, AmbientOcclusionFilter, testing::ValuesIn(filters), case_name);

// ---------------------------------------------------------------------------------------------- enlargement

TEST_F(AmbientOcclusionStage, Upsample) {
    for (const auto kind : {OcclusionUpsample::nearest, OcclusionUpsample::bilinear, OcclusionUpsample::soma,
                            OcclusionUpsample::relative}) {
        AmbientOcclusionParameters p = plain_parameters();
        horizon(p, HorizonMeasure::cosine, linear);
        p.resolution = OcclusionResolution::half;
        p.upsample = kind;
        const auto reference = reference_of(columns(), p);
        const OcclusionSignal expected = reference.upsampled(shown_signal(columns(), p, OcclusionView::estimate));
        const Deviation d = difference(expected, signal_of(occlude(columns(), p), reference), step);
        // Two taps alike in depth to eleven bits: either may stand for all, which `relative` lets them do more often.
        EXPECT_LT(d.share_beyond, kind == OcclusionUpsample::relative ? 0.006 : 0.004)
            << static_cast<int>(kind) << ": largest " << d.largest * 255 << "/255";
    }
}

// The listing's bilinear factor is negative for two of the four taps as printed; its absolute values are the bilinear
// weights, and only those sum to 1.
TEST(SomaUpsampleListing, SignOfTheBilinearFactor) {
    for (const reference::SomaVec2 at : {reference::SomaVec2{0.5, 0.5}, {7.5, 2.5}, {4.5, 9.5}, {3.5, 3.5}}) {
        const auto printed = reference::soma_listing_bilinear(at);
        int negative = 0;
        double sum = 0.0, absolute = 0.0;
        for (const double weight : printed) {
            negative += weight < 0.0;
            sum += weight;
            absolute += std::fabs(weight);
        }
        EXPECT_EQ(negative, 2);
        EXPECT_LT(sum, 0.3);
        EXPECT_NEAR(absolute, 1.0, 1e-12);
        const double fx = at.x / 2.0 - std::floor(at.x / 2.0), fy = at.y / 2.0 - std::floor(at.y / 2.0);
        const auto ours =
            reference::upsample_weights(OcclusionUpsample::soma, fx, fy, {sfumato::reference::sky, 0.0, 0.5, 2.0});
        for (size_t i = 0; i < 4; ++i) {
            const double difference[4] = {1e30, 0.0, 0.05, 0.2}; // metres, of the tolerated 0.1
            EXPECT_NEAR(ours[i], std::fabs(printed[i]) + reference::soma_listing_depth_weight(2.0 + difference[i], 2.0),
                        1e-9);
        }
    }
}

// ---------------------------------------------------------------------------------------------- temporal filter

class AmbientOcclusionTemporal : public GpuTest, public testing::WithParamInterface<Case> {};

// Three frames of a moving camera.
TEST_P(AmbientOcclusionTemporal, Matches) {
    AmbientOcclusionParameters p = plain_parameters();
    horizon(p, HorizonMeasure::cosine, linear);
    p.temporal = true;
    p.animate_noise = true;
    p.second_filter = false;
    GetParam().set(p);
    OcclusionStream stream;
    std::optional<OcclusionSignal> history;
    double moved = 0.0;
    for (int frame = 4; frame < 7; ++frame) {
        const OcclusionInput& input = columns(frame);
        AmbientOcclusionParameters single = p;
        single.temporal = false;
        const auto reference = reference_of(input, p);
        OcclusionSignal now = shown_signal(input, single, OcclusionView::estimate, false);
        const OcclusionSignal estimate = now;
        if (p.filter_radius > 0)
            now = reference.filtered(now);
        if (history)
            now = reference.blended(now, *history);
        if (p.second_filter && p.filter_radius > 0)
            now = reference.filtered(now);
        history = now;
        const OcclusionSignal expected = p.resolution == OcclusionResolution::half ? reference.upsampled(now) : now;
        const Deviation d = difference(expected, signal_of(stream.run(input, p), reference), 1.5 * step);
        EXPECT_LT(d.share_beyond, 0.01) << frame << ": largest " << d.largest * 255 << "/255";
        EXPECT_LT(d.mean, 0.3 * step) << frame;
        moved = difference(now, estimate, step).mean;
    }
    EXPECT_GT(moved, step);
}

constexpr Case temporals[] = {
    {"soma", [](auto&) {}},
    {"slow_history",
     [](auto& p) {
         p.history_position = 1.0f;
         p.history_visibility = 0.5f;
         p.history_time = 10.0f;
     }},
    {"growing_weight",
     [](auto& p) {
         p.history_position = 2.0f;
         p.history_visibility = 0.0f;
         p.history_time = 0.0f;
         p.history_length = 8;
     }},
    {"temporal_blur",
     [](auto& p) {
         p.filter_radius = 2;
         p.second_filter = true;
     }},
    {"half_resolution", [](auto& p) { p.resolution = OcclusionResolution::half; }},
};
INSTANTIATE_TEST_SUITE_P(All, AmbientOcclusionTemporal, testing::ValuesIn(temporals), case_name);

// The listing's blend, number by number: 9 a metre is 13.5 a radius of 1.5 m.
TEST_F(AmbientOcclusionStage, SomaTemporalListing) {
    const OcclusionInput &first = columns(4), &second = columns(5);
    AmbientOcclusionParameters p = plain_parameters();
    p.history_position = 13.5f;
    const auto before = reference_of(first, p), now = reference_of(second, p);
    const OcclusionSignal past = before.estimates(), present = now.estimates();
    std::vector<double> shares;
    const OcclusionSignal result = now.blended(present, past, &shares);
    const double least = double{p.history_time} * double{second.frame.time_step};
    size_t compared = 0;
    for (size_t i = 0; i < shares.size(); ++i) {
        if (shares[i] >= 1.0)
            continue;
        ++compared;
        // What the listing does with the same old visibility, at the distance that is left of the share.
        const double old = (result.texels[i].visibility - shares[i] * present.texels[i].visibility) / (1.0 - shares[i]);
        const double distance = std::max(0.0, (shares[i] - 5.0 * std::fabs(old - present.texels[i].visibility)) / 9.0);
        EXPECT_NEAR(reference::soma_listing_temporal(present.texels[i].visibility, old, {}, {distance, 0, 0}, least),
                    result.texels[i].visibility, 1e-9);
    }
    EXPECT_GT(compared, shares.size() / 4);
}

// ---------------------------------------------------------------------------------------------- application

TEST_F(AmbientOcclusionStage, Application) {
    for (const auto application :
         {OcclusionApplication::none, OcclusionApplication::ambient, OcclusionApplication::everything}) {
        AmbientOcclusionParameters p = plain_parameters();
        p.application = application;
        p.power = 1.7f;
        const OcclusionOutput output = occlude(columns(), p, true);
        double worst = 0.0, worst_alpha = 0.0;
        for (uint32_t y = 0; y < extent.height; ++y)
            for (uint32_t x = 0; x < extent.width; ++x) {
                const float *c = columns().colour.at(x, y), *a = columns().ambient.at(x, y);
                const float* got = output.output.at(x, y);
                const auto expected = reference::applied(application, {double{c[0]}, double{c[1]}, double{c[2]}},
                                                         {double{a[0]}, double{a[1]}, double{a[2]}}, output.at(x, y));
                worst = std::max({worst, std::fabs(expected.x - double{got[0]}), std::fabs(expected.y - double{got[1]}),
                                  std::fabs(expected.z - double{got[2]})});
                worst_alpha = std::max(worst_alpha, std::fabs(double{got[3]} - double{c[3]}));
            }
        EXPECT_LT(worst, 2e-6) << static_cast<int>(application);
        EXPECT_EQ(worst_alpha, 0.0);
        p.power = 1.0f;
        const Deviation d = deviation(
            extent.width, extent.height, 1e-5,
            [&, straight = occlude(columns(), p)](uint32_t x, uint32_t y) { return std::pow(straight.at(x, y), 1.7); },
            [&](uint32_t x, uint32_t y) { return output.at(x, y); });
        EXPECT_LT(d.largest, 2e-3); // the shadow goes along: signals are packed otherwise
    }
}

} // namespace
} // namespace sfumato::test
