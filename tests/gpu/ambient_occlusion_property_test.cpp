// What must hold of the estimate whatever its method: planes, units, cameras, resolutions, edges, truth.
#include "tests/gpu/ambient_occlusion_support.h"

#include <cmath>

namespace sfumato::test {
namespace {

constexpr double step = 1.0 / 255.0;
constexpr Extent extent{150, 90}; // neither is a multiple of the pyramid's 32

struct Method {
    const char* name;
    OcclusionEstimator estimator;
    HorizonMeasure measure;
    OcclusionFalloff falloff;
};
constexpr Method methods[] = {
    {"obscurance", OcclusionEstimator::obscurance, HorizonMeasure::hbao, OcclusionFalloff::linear},
    {"hbao", OcclusionEstimator::horizon, HorizonMeasure::hbao, OcclusionFalloff::quadratic},
    {"cosine", OcclusionEstimator::horizon, HorizonMeasure::cosine, OcclusionFalloff::hard},
    {"bitmask", OcclusionEstimator::horizon, HorizonMeasure::bitmask, OcclusionFalloff::hard},
};

AmbientOcclusionParameters parameters_of(const Method& method) {
    AmbientOcclusionParameters p = plain_parameters();
    p.estimator = method.estimator;
    p.measure = method.measure;
    p.falloff = method.falloff;
    return p;
}

class AmbientOcclusionMethod : public GpuTest, public testing::WithParamInterface<Method> {};
void PrintTo(const Method& method, std::ostream* stream) {
    *stream << method.name;
}
INSTANTIATE_TEST_SUITE_P(All, AmbientOcclusionMethod, testing::ValuesIn(methods),
                         [](const auto& method) { return std::string(method.param.name); });

double least_of(const OcclusionOutput& output) {
    double least = 2.0;
    for (size_t i = 0; i < output.visibility.values.size(); i += output.visibility.components)
        least = std::min(least, double{output.visibility.values[i]});
    return least;
}

// ------------------------------------------------------------------------------------------------ planes

struct Tilt {
    const char* name;
    std::array<double, 3> normal;
};
constexpr Tilt tilts[] = {
    {"facing", {0, 0, 1}},   {"sideways", {1, 0, 0.6}}, {"leaning", {-0.4, 0.9, 0.5}},
    {"floor", {0, 1, 0.12}}, {"grazing", {0, 1, 0}},    {"grazing wall", {-1, 0.05, 0}},
};

// Visibility 1 at every tilt and distance, under every kind of camera, from normals given and derived, at both
// resolutions.
TEST_P(AmbientOcclusionMethod, PlanesAreOpen) {
    for (const bool perspective : {true, false})
        for (const double shift : {0.0, 0.2})
            for (const Tilt& tilt : tilts)
                for (const double distance : {0.8, 6.0, 60.0}) {
                    // Seen by an orthographic camera a grazing plane is a line.
                    if (!perspective && tilt.normal[2] < 0.1)
                        continue;
                    const Frame frame =
                        perspective ? perspective_frame(extent, 1.0, shift) : orthographic_frame(extent, 8.0, shift);
                    OcclusionInput input = plane_input(frame, extent, tilt.normal, distance);
                    for (const NormalSource source : {NormalSource::given, NormalSource::derived})
                        for (const OcclusionResolution resolution :
                             {OcclusionResolution::full, OcclusionResolution::half}) {
                            AmbientOcclusionParameters p = parameters_of(GetParam());
                            p.normals = source;
                            p.resolution = resolution;
                            EXPECT_GE(least_of(occlude(input, p)), 1.0 - step)
                                << tilt.name << " at " << distance << (perspective ? "" : " orthographic") << " shift "
                                << shift << (source == NormalSource::given ? " given" : " derived")
                                << (resolution == OcclusionResolution::half ? " half" : " full");
                        }
                }
}

// With the pyramid at its coarsest, and with 16 bits of depth and the bias that those need.
TEST_P(AmbientOcclusionMethod, PlanesAreOpenAtAnyMip) {
    for (const DepthMips mips : {DepthMips::none, DepthMips::rotated, DepthMips::farthest, DepthMips::centre})
        for (const DepthStorage storage : {DepthStorage::full, DepthStorage::half})
            for (const OcclusionResolution resolution : {OcclusionResolution::full, OcclusionResolution::half})
                for (const Tilt& tilt : {tilts[1], tilts[3]}) {
                    AmbientOcclusionParameters p = parameters_of(GetParam());
                    p.depth_mips = mips;
                    p.depth_storage = storage;
                    p.resolution = resolution;
                    p.mip_rate = mips == DepthMips::rotated || mips == DepthMips::centre ? 0.0f : 3.0f;
                    if (storage == DepthStorage::half) {
                        p.depth_bias = 0.001f;
                        p.bias = 0.1f;
                    }
                    // Averages of depth are not on the plane: what is left is small.
                    const double tolerance = mips == DepthMips::farthest ? 8.0 * step : step;
                    const OcclusionInput input = plane_input(perspective_frame(extent, 1.0), extent, tilt.normal, 3.0);
                    EXPECT_GE(least_of(occlude(input, p)), 1.0 - tolerance)
                        << tilt.name << " mips " << static_cast<int>(mips) << " storage " << static_cast<int>(storage)
                        << (resolution == OcclusionResolution::half ? " half" : " full");
                }
}

// --------------------------------------------------------------------------------------- invariance

const OcclusionInput& contact() {
    static const OcclusionInput input = render_input(*scene::find_scene("contact"), 12, extent);
    return input;
}

// Every length a hundred times as long.
TEST_P(AmbientOcclusionMethod, UnitsDoNotMatter) {
    const scene::Scene centimetres = scene::in_units(*scene::find_scene("contact"), 100.0);
    const OcclusionInput scaled = render_input(centimetres, 12, extent);
    for (const bool half : {false, true}) {
        AmbientOcclusionParameters p = parameters_of(GetParam());
        p.filter_radius = 3;
        p.filter_comparison = half ? DepthDifference::radius : DepthDifference::relative;
        p.filter_depth = half ? 0.05f : 0.02f;
        p.resolution = half ? OcclusionResolution::half : OcclusionResolution::full;
        p.upsample = half ? OcclusionUpsample::soma : OcclusionUpsample::relative;
        const OcclusionOutput metres = occlude(contact(), p);
        p.radius *= 100.0f;
        const Deviation d = deviation(metres, occlude(scaled, p), 2.0 * step);
        // Rounding moves some taps to the next texel.
        EXPECT_LT(d.share_beyond, 0.01) << d.largest;
        EXPECT_LT(d.mean, 0.5 * step);
        EXPECT_LT(least_of(metres), 0.85);
    }
}

// The host's depth buffer instead of linear depth.
TEST_P(AmbientOcclusionMethod, KindsOfDepthDoNotMatter) {
    for (const double orthographic_height : {0.0, 5.0}) {
        scene::Scene scene = *scene::find_scene("contact");
        scene.camera.lens.orthographic_height = orthographic_height;
        if (orthographic_height > 0.0) // nothing behind the eye's plane
            scene.camera.eye = {0.5, 4.1, 13.1};
        AmbientOcclusionParameters p = parameters_of(GetParam());
        p.filter_radius = 3;
        const OcclusionOutput linear = occlude(render_input(scene, 12, extent), p);
        EXPECT_LT(least_of(linear), 0.9);
        for (const auto range :
             {scene::DepthRange::reversed_infinite, scene::DepthRange::reversed, scene::DepthRange::standard}) {
            scene.camera.lens.range = range;
            scene.camera.lens.depth_kind = DepthKind::device;
            // With 0 near the eye single precision leaves too little for the far plane; keep it near.
            scene.camera.lens.near_plane = 0.5;
            scene.camera.lens.far_plane = 30.0;
            const Deviation d = deviation(linear, occlude(render_input(scene, 12, extent), p), 2.0 * step);
            EXPECT_LT(d.share_beyond, 0.01) << static_cast<int>(range) << " largest " << d.largest;
            EXPECT_LT(d.mean, 0.5 * step) << static_cast<int>(range);
            scene.camera.lens.depth_kind = DepthKind::linear;
        }
    }
}

// Blocks of 10 by 10 pixels at one size have the mean of 20 by 20 at twice the size.
TEST_P(AmbientOcclusionMethod, ResolutionDoesNotMatter) {
    const Extent twice{2 * extent.width, 2 * extent.height};
    AmbientOcclusionParameters p = parameters_of(GetParam());
    p.taps = 32;
    p.steps = 16;
    const OcclusionOutput small = occlude(contact(), p);
    const OcclusionOutput large = occlude(render_input(*scene::find_scene("contact"), 12, twice), p);
    const auto mean = [](const OcclusionOutput& output, uint32_t x, uint32_t y, uint32_t side) {
        double total = 0.0;
        for (uint32_t i = 0; i < side * side; ++i)
            total += output.at(x * side + i % side, y * side + i / side);
        return total / (side * side);
    };
    const Deviation d = deviation(
        extent.width / 10, extent.height / 10, 0.03, [&](uint32_t x, uint32_t y) { return mean(small, x, y, 10); },
        [&](uint32_t x, uint32_t y) { return mean(large, x, y, 20); });
    EXPECT_LT(d.share_beyond, 0.05) << d.largest;
    EXPECT_LT(d.mean, 0.01);
}

// ------------------------------------------------------------------------------------------------ truth

class AmbientOcclusionProperty : public GpuTest {};

// Against ray tracing: high counts come close, low counts are farther, more iterations converge.
TEST_F(AmbientOcclusionProperty, ComesNearTheTruth) {
    struct Bound {
        const char* scene;
        double error;
    };
    for (const auto& [name, bound] : {Bound{"contact", 0.06}, Bound{"interior", 0.09}, Bound{"columns", 0.09}}) {
        const OcclusionInput input = render_input(*scene::find_scene(name), 12, extent, 64);
        AmbientOcclusionParameters p = plain_parameters();
        p.slices = 8;
        p.steps = 16;
        const double high = error_of(occlude(input, p), input).mean;
        p.slices = 1;
        p.steps = 3;
        const double low = error_of(occlude(input, p), input).mean;
        EXPECT_LT(high, bound) << name;
        EXPECT_GT(low, 1.2 * high) << name;
    }
}

// Iterations approach what very many of them give.
TEST_P(AmbientOcclusionMethod, IterationsConverge) {
    AmbientOcclusionParameters p = parameters_of(GetParam());
    p.steps = 6;
    p.iterations = 16;
    p.slices = 4;
    p.taps = 24;
    const OcclusionOutput converged = occlude(contact(), p);
    p.slices = 1;
    p.taps = 6;
    double last = 1.0;
    for (const int iterations : {1, 4, 16}) {
        p.iterations = iterations;
        const double error = deviation(occlude(contact(), p), converged, 1.0).mean;
        EXPECT_LT(error, 0.7 * last) << iterations;
        last = error;
    }
    EXPECT_LT(last, 5.0 * step);
}

// -------------------------------------------------------------------------------------------- edges and sky

// What is outside of the screen is not known and does not darken; and taps that leave the screen take no weight from
// the others.
TEST_P(AmbientOcclusionMethod, ScreenEdgesDoNotDarken) {
    const Frame frame = perspective_frame(extent, 1.0);
    // A leaning floor runs out of the screen on all sides, as before a wall that is not in the picture.
    const OcclusionInput open = plane_input(frame, extent, {0, 1, 0.3}, 2.0);
    EXPECT_GE(least_of(occlude(open, parameters_of(GetParam()))), 1.0 - step);
    // A dent across the whole picture looks the same at the edge as in the middle: an upright step at every height.
    OcclusionInput dent = plane_input(orthographic_frame(extent, 8.0), extent, {0, 0, 1}, 10.0);
    for (uint32_t y = extent.height / 2; y < extent.height; ++y)
        for (uint32_t x = 0; x < extent.width; ++x)
            *dent.depth.at(x, y) = 9.4f;
    AmbientOcclusionParameters p = parameters_of(GetParam());
    p.iterations = 8;
    const OcclusionOutput output = occlude(dent, p);
    const uint32_t y = extent.height / 2 - 2; // just above the step
    const auto mean = [&](uint32_t first) {
        double total = 0.0;
        for (uint32_t x = first; x < first + 4; ++x)
            total += output.at(x, y);
        return total / 4.0;
    };
    const double middle = mean(extent.width / 2);
    EXPECT_LT(middle, 0.9);
    EXPECT_NEAR(mean(0), middle, 0.06);
    EXPECT_NEAR(mean(extent.width - 4), middle, 0.06);
}

TEST_P(AmbientOcclusionMethod, GuardBandIsOpen) {
    for (const int guard : {7, 8})
        for (const bool half : {false, true}) {
            AmbientOcclusionParameters p = parameters_of(GetParam());
            p.resolution = half ? OcclusionResolution::half : OcclusionResolution::full;
            p.filter_radius = 3;
            const OcclusionOutput without = occlude(contact(), p);
            p.guard_band = guard;
            const OcclusionOutput with = occlude(contact(), p);
            double band = 1.0, inside = 0.0;
            const auto g = static_cast<uint32_t>(guard);
            for (uint32_t y = 0; y < extent.height; ++y)
                for (uint32_t x = 0; x < extent.width; ++x) {
                    const bool in_band = x < g || y < g || x >= extent.width - g || y >= extent.height - g;
                    if (in_band)
                        band = std::min(band, with.at(x, y));
                    const uint32_t far = g + 8; // beyond what filters mix
                    if (x >= far && y >= far && x < extent.width - far && y < extent.height - far)
                        inside = std::max(inside, std::fabs(with.at(x, y) - without.at(x, y)));
                }
            EXPECT_EQ(band, 1.0) << guard << (half ? " half" : " full");
            // Taps in the band count as before.
            EXPECT_LT(inside, 1e-3) << guard << (half ? " half" : " full");
        }
}

TEST_P(AmbientOcclusionMethod, SkyIsOpenAndHidesNothing) {
    const Frame frame = perspective_frame(extent, 1.0);
    const OcclusionInput floor = plane_input(frame, extent, {0, 1, 0}, 1.5); // its horizon and sky above
    for (const float value : {1e10f, INFINITY, NAN, 3e38f})
        for (const DepthStorage storage : {DepthStorage::full, DepthStorage::half})
            for (const DepthMips mips : {DepthMips::none, DepthMips::rotated, DepthMips::farthest, DepthMips::centre}) {
                OcclusionInput input = floor;
                for (float& z : input.depth.values)
                    z = z >= 1e9f ? value : z;
                AmbientOcclusionParameters p = parameters_of(GetParam());
                p.depth_storage = storage;
                p.depth_mips = mips;
                p.filter_radius = 3;
                if (storage == DepthStorage::half) {
                    p.depth_bias = 0.001f;
                    p.bias = 0.1f;
                }
                const OcclusionOutput output = occlude(input, p);
                double sky = 1.0, ground = 1.0;
                for (uint32_t y = 0; y < extent.height; ++y)
                    for (uint32_t x = 0; x < extent.width; ++x)
                        (*floor.depth.at(x, y) >= 1e9f ? sky : ground) =
                            std::min(*floor.depth.at(x, y) >= 1e9f ? sky : ground, output.at(x, y));
                EXPECT_EQ(sky, 1.0) << value;
                EXPECT_GE(ground, 1.0 - (mips == DepthMips::farthest ? 10.0 : 1.0) * step)
                    << value << " storage " << static_cast<int>(storage) << " mips " << static_cast<int>(mips);
            }
}

// A radius of less than a pixel gives 1, and there is no jump on the way there.
TEST_P(AmbientOcclusionMethod, RadiusBelowAPixelFadesOut) {
    AmbientOcclusionParameters p = parameters_of(GetParam());
    double last = 1.0;
    for (const float radius : {0.004f, 0.01f, 0.02f, 0.03f, 0.04f, 0.06f, 0.08f, 0.12f}) {
        p.radius = radius;
        const OcclusionOutput output = occlude(contact(), p);
        double mean = 0.0;
        for (uint32_t i = 0; i < extent.width * extent.height; ++i)
            mean += output.at(i % extent.width, i / extent.width) / (extent.width * extent.height);
        if (radius == 0.004f) {
            EXPECT_EQ(least_of(output), 1.0); // 0.25 px at 1.5 m
        }
        EXPECT_LT(std::fabs(mean - last), 0.02) << radius;
        last = mean;
    }
    EXPECT_LT(last, 0.9995);
}

// One depth that is not a number changes nothing farther away than the radius and the filter reach, and gives no NaN.
TEST_P(AmbientOcclusionMethod, NanDepthIsLocal) {
    for (const bool half : {false, true}) {
        AmbientOcclusionParameters p = parameters_of(GetParam());
        p.radius = 0.4f;
        p.resolution = half ? OcclusionResolution::half : OcclusionResolution::full;
        p.filter_radius = 2;
        OcclusionInput input = contact();
        const OcclusionOutput clean = occlude(input, p);
        constexpr uint32_t px = 75, py = 60;
        const double reach = 0.4 * extent.height * 1.4 / double{*input.depth.at(px, py)} + 20.0; // mips, filter
        *input.depth.at(px, py) = NAN;
        const OcclusionOutput spoiled = occlude(input, p);
        for (uint32_t y = 0; y < extent.height; ++y)
            for (uint32_t x = 0; x < extent.width; ++x) {
                ASSERT_TRUE(std::isfinite(spoiled.at(x, y)));
                if (std::hypot(double(x) - px, double(y) - py) > reach) {
                    ASSERT_EQ(spoiled.at(x, y), clean.at(x, y)) << x << ", " << y;
                }
            }
    }
}

// --------------------------------------------------------------------------- bent normals and shadows

TEST_F(AmbientOcclusionProperty, BentNormals) {
    // On a plane: the normal.
    AmbientOcclusionParameters p = plain_parameters();
    p.filter_radius = 2;
    p.iterations = 4;
    OcclusionInput plane = plane_input(perspective_frame(extent, 1.0), extent, {0.3, 0.8, 0.6}, 3.0);
    plane.shadow = plane.colour = plane.ambient = contact().colour;
    const OcclusionOutput open = occlude(plane, p, true);
    double worst = 1.0, longest = 0.0, shortest = 2.0;
    for (uint32_t y = 0; y < extent.height; ++y)
        for (uint32_t x = 0; x < extent.width; ++x) {
            const float *bent = open.bent_normal.at(x, y), *n = plane.normal.at(x, y);
            if (*plane.depth.at(x, y) >= 1e9f)
                continue;
            worst = std::min(worst, double{bent[0] * n[0] + bent[1] * n[1] + bent[2] * n[2]});
        }
    EXPECT_GT(worst, 0.9999);
    // In a scene: unit, and nearer to the true mean open direction than the normal is.
    scene::Scene corner = *scene::find_scene("contact");
    const scene::Primitive floor = {scene::Shape::plane, {1, 1, 1}, 0, {}, true};
    const scene::Primitive wall = {scene::Shape::plane, {1, 1, 1}, 0, {.tilt = {90, 0, 0}}, true};
    corner.primitives = {floor, wall};
    corner.camera = {.eye = {0.3, 1.4, 3.0}, .target = {0, 0.3, 0}};
    for (const int filter_radius : {0, 2})
        for (const auto measure : {HorizonMeasure::cosine, HorizonMeasure::bitmask}) {
            OcclusionInput input = render_input(corner, 0, extent, 256);
            input.velocity = {};
            p.measure = measure;
            p.filter_radius = filter_radius;
            const OcclusionOutput output = occlude(input, p, true);
            double bent_agrees = 0.0, normal_agrees = 0.0, leans = 0.0, truly_leans = 0.0;
            size_t count = 0;
            for (uint32_t y = 0; y < extent.height; ++y)
                for (uint32_t x = 0; x < extent.width; ++x) {
                    const float *bent = output.bent_normal.at(x, y), *n = input.normal.at(x, y);
                    const float* truth = input.true_bent_normal.at(x, y);
                    const double length = std::hypot(double{bent[0]}, double{bent[1]}, double{bent[2]});
                    longest = std::max(longest, length);
                    shortest = std::min(shortest, length);
                    if (*input.depth.at(x, y) >= 1e9f || *input.truth.at(x, y) > 0.9f)
                        continue;
                    ++count;
                    const auto dot = [](const float* a, const float* b) {
                        return double{a[0] * b[0] + a[1] * b[1] + a[2] * b[2]};
                    };
                    bent_agrees += dot(bent, truth);
                    normal_agrees += dot(n, truth);
                    leans += std::acos(std::min(1.0, dot(bent, n)));
                    truly_leans += std::acos(std::min(1.0, dot(truth, n)));
                }
            const auto number = static_cast<double>(count);
            EXPECT_GT(count, 2000u);
            EXPECT_GT(bent_agrees, 0.98 * number);
            EXPECT_GT(bent_agrees, normal_agrees + 0.03 * number);
            EXPECT_NEAR(leans / truly_leans, 0.85, 0.15); // away from the other wall, by as much as in truth
        }
    EXPECT_NEAR(longest, 1.0, 1e-4);
    EXPECT_NEAR(shortest, 1.0, 1e-4);
}

// The foot of an endless wall is the same all along it: what the left and right edges of the screen cut off must not
// make it brighter there.
TEST_F(AmbientOcclusionProperty, OcclusionLastsToTheEdgesOfTheScreen) {
    scene::Scene corner = *scene::find_scene("contact");
    corner.primitives = {{scene::Shape::plane, {1, 1, 1}, 0, {}, true},
                         {scene::Shape::plane, {1, 1, 1}, 0, {.tilt = {90, 0, 0}}, true}};
    corner.camera = {.eye = {0, 0.8, 3.0}, .target = {0, 0.3, 0}};
    const OcclusionInput input = render_input(corner, 0, extent);
    AmbientOcclusionParameters p = plain_parameters();
    p.slices = 8;
    p.steps = 16;
    for (const auto measure : {HorizonMeasure::cosine, HorizonMeasure::bitmask}) {
        p.measure = measure;
        const FloatImage visibility = occlude(input, p).visibility;
        double edge = 0.0, middle = 0.0;
        size_t count = 0;
        for (uint32_t y = 0; y < extent.height; ++y)
            for (uint32_t x = 0; x < 8; ++x) {
                const double inside = *visibility.at(extent.width / 2 - 4 + x, y);
                if (inside > 0.8)
                    continue;
                ++count;
                middle += 1.0 - inside;
                edge += 1.0 - 0.5 * (*visibility.at(x, y) + *visibility.at(extent.width - 1 - x, y));
            }
        EXPECT_GT(count, 100u);
        EXPECT_NEAR(edge / middle, 1.0, 0.06) << static_cast<int>(measure);
    }
}

// Along a wall that does not change upwards visibility does not either, however steeply it is seen: the filter must
// find that texels of half resolution lie on one plane, though their depths are those of pixels that lie askew.
TEST_F(AmbientOcclusionProperty, NoPatternOnSteepWallsAtHalfResolution) {
    const std::pair<Frame, std::array<double, 3>> cases[] = {{perspective_frame(extent, 1.0), {1, 0, 0}},
                                                             {orthographic_frame(extent, 6.0), {1, 0, 0.2}}};
    for (const auto& [frame, normal] : cases) {
        OcclusionInput corner = plane_input(frame, extent, normal, 2.0);
        const OcclusionInput back = plane_input(frame, extent, {0, 0, 1}, 6.0);
        const auto is_wall = [&](uint32_t x, uint32_t y) { return *corner.depth.at(x, y) < *back.depth.at(x, y); };
        std::vector<uint32_t> columns; // of the wall, within the radius of the corner
        for (uint32_t x = 0; x < extent.width; ++x)
            if (*back.depth.at(x, 0) - *corner.depth.at(x, 0) < 2.5f && is_wall(x, 0))
                columns.push_back(x);
        for (uint32_t y = 0; y < extent.height; ++y)
            for (uint32_t x = 0; x < extent.width; ++x)
                if (!is_wall(x, y)) {
                    *corner.depth.at(x, y) = *back.depth.at(x, y);
                    std::copy_n(back.normal.at(x, y), 3, corner.normal.at(x, y));
                }
        AmbientOcclusionParameters p;
        expect_done(apply_preset(AmbientOcclusionParameters::table(), &p, "medium"), "apply_preset");
        p.radius = 1.5f;
        const FloatImage visibility = occlude(corner, p).visibility;
        double largest = 0.0, darkest = 1.0;
        ASSERT_GT(columns.size(), 4u);
        for (const uint32_t x : columns) {
            double sum = 0.0, squares = 0.0, count = 0.0;
            for (uint32_t y = extent.height / 3; y < extent.height * 2 / 3; ++y, ++count) {
                const double value = *visibility.at(x, y);
                sum += value;
                squares += value * value;
                darkest = std::min(darkest, value);
            }
            largest = std::max(largest, std::sqrt(std::max(squares / count - sum * sum / count / count, 0.0)));
        }
        EXPECT_LT(darkest, 0.85);
        EXPECT_LT(largest, 0.003);
    }
}

// The same normals in world space, octahedral, and of another length give the same picture; where they are not numbers
// they are derived.
TEST_F(AmbientOcclusionProperty, KindsOfNormalsDoNotMatter) {
    AmbientOcclusionParameters p = plain_parameters();
    const OcclusionOutput expected = occlude(contact(), p);
    OcclusionInput other = contact();
    const Matrix4& view = other.frame.camera->world_to_view;
    other.normal = make_image(extent, 3, [&](uint32_t x, uint32_t y, float* pixel) {
        const float* n = contact().normal.at(x, y);
        for (size_t axis = 0; axis < 3; ++axis) // the inverse of a rotation is its transpose
            pixel[axis] = 1.7f * (view[4 * axis] * n[0] + view[4 * axis + 1] * n[1] + view[4 * axis + 2] * n[2]);
    });
    p.normal_space = NormalSpace::world;
    EXPECT_LT(deviation(expected, occlude(other, p), 2.0 * step).share_beyond, 0.005);
    p.normal_space = NormalSpace::view;
    EXPECT_GT(deviation(expected, occlude(other, p), 2.0 * step).share_beyond, 0.1);
    other.normal = make_image(extent, 2, [&](uint32_t x, uint32_t y, float* pixel) {
        const float* n = contact().normal.at(x, y);
        const float sum = std::max(1e-6f, std::fabs(n[0]) + std::fabs(n[1]) + std::fabs(n[2]));
        pixel[0] = n[0] / sum;
        pixel[1] = n[1] / sum;
        if (n[2] < 0.0f) {
            const float u = pixel[0], v = pixel[1];
            pixel[0] = (1.0f - std::fabs(v)) * std::copysign(1.0f, u);
            pixel[1] = (1.0f - std::fabs(u)) * std::copysign(1.0f, v);
        }
    });
    EXPECT_LT(deviation(expected, occlude(other, p), 2.0 * step).share_beyond, 0.005);
    // Where they are not numbers, the direction to the eye stands for them.
    other.normal = contact().normal;
    std::fill(other.normal.values.begin(), other.normal.values.end(), NAN);
    OcclusionInput to_eye = contact();
    const Matrix4& m = other.frame.camera->projection;
    const auto extent_of = other.depth.extent;
    to_eye.normal = make_image(other.depth.extent, 3, [&](uint32_t x, uint32_t y, float* pixel) {
        const float vx =
            ((static_cast<float>(x) + 0.5f) / static_cast<float>(extent_of.width) * 2.0f - 1.0f + m[8]) / m[0];
        const float vy =
            ((static_cast<float>(y) + 0.5f) / static_cast<float>(extent_of.height) * 2.0f - 1.0f + m[9]) / m[5];
        const float length = std::sqrt(vx * vx + vy * vy + 1.0f);
        pixel[0] = -vx / length;
        pixel[1] = -vy / length;
        pixel[2] = 1.0f / length;
    });
    EXPECT_LT(deviation(occlude(to_eye, p), occlude(other, p), 2.0 * step).share_beyond, 0.005);
}

// The shadow goes through the same filter as the visibility: with a shadow that equals the estimate, both come out
// alike.
TEST_F(AmbientOcclusionProperty, ShadowIsFilteredAlike) {
    AmbientOcclusionParameters p = plain_parameters();
    OcclusionInput input = contact();
    const OcclusionOutput estimate = occlude(input, p);
    input.shadow = make_image(
        extent, 1, [&](uint32_t x, uint32_t y, float* pixel) { *pixel = static_cast<float>(estimate.at(x, y)); });
    p.filter_radius = 4;
    const OcclusionOutput output = occlude(input, p, true);
    double worst = 0.0;
    for (uint32_t y = 0; y < extent.height; ++y)
        for (uint32_t x = 0; x < extent.width; ++x)
            if (*input.depth.at(x, y) < 1e9f)
                worst = std::max(worst, std::fabs(double{output.soft_shadow.at(x, y)[0]} - output.at(x, y)));
    EXPECT_LT(worst, 2e-3);
    // Wild shadows stay in 0…1.
    for (size_t i = 0; i < input.shadow.values.size(); i += 7)
        input.shadow.values[i] = i % 2 == 0 ? NAN : i % 3 == 0 ? -5.0f : 9.0f;
    const OcclusionOutput wild = occlude(input, p, true);
    for (size_t i = 0; i < wild.soft_shadow.values.size(); i += wild.soft_shadow.components) {
        ASSERT_GE(wild.soft_shadow.values[i], 0.0f);
        ASSERT_LE(wild.soft_shadow.values[i], 1.0f);
    }
}

} // namespace
} // namespace sfumato::test
