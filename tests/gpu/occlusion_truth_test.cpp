// Ray-traced occlusion against what is known in closed form: a plane, two planes at right angles, a sphere over a
// plane.
#include "scene/scene.h"
#include "tests/gpu/gpu_test.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

namespace sfumato::scene {
namespace {

using test::FloatImage;
using test::GpuTest;

struct Point {
    double x = 0.0, y = 0.0, z = 0.0;
};

struct Truth {
    FloatImage visibility, bent_normal, depth, normal;
};

class OcclusionTruthTest : public GpuTest {
  protected:
    void SetUp() override {
        GpuTest::SetUp();
        context_ = test::make_context(0x7a); // what is not written would show
        renderer_ = test::expect_value(SceneRenderer::create(*context_), "renderer");
    }

    Truth trace(const Scene& scene, Extent extent, const OcclusionTruth& occlusion, double frame = 0.0) {
        const apps::HostImage visibility = make(VK_FORMAT_R32_SFLOAT, extent),
                              depth = make(VK_FORMAT_R32_SFLOAT, extent);
        const apps::HostImage bent = make(VK_FORMAT_R32G32B32A32_SFLOAT, extent);
        const apps::HostImage normal = make(VK_FORMAT_R32G32B32A32_SFLOAT, extent);
        SceneImages images;
        images.depth = depth.image();
        images.normal = normal.image();
        images.true_visibility = visibility.image();
        images.true_bent_normal = bent.image();
        render(scene, images, occlusion, frame);
        return {test::read_back(visibility), test::read_back(bent), test::read_back(depth), test::read_back(normal)};
    }

    void render(const Scene& scene, const SceneImages& images, const OcclusionTruth& occlusion, double frame) {
        RenderOptions options;
        options.occlusion = occlusion;
        test::run_commands([&](VkCommandBuffer commands) {
            test::expect_done(renderer_->record(commands, scene, frame, options, images, index_++), "record");
        });
    }

    apps::HostImage make(VkFormat format, Extent extent) {
        return test::expect_value(test::device().create_image(format, extent), "image");
    }

  private:
    std::unique_ptr<Context> context_;
    std::unique_ptr<SceneRenderer> renderer_;
    uint64_t index_ = 0;
};

Scene bare_scene(std::vector<Primitive> primitives) {
    Scene scene;
    scene.info.name = "test";
    scene.info.key_frame = 0;
    scene.materials = {{.pattern = Pattern::solid, .colour_a = {0.5, 0.5, 0.5}}};
    scene.primitives = std::move(primitives);
    return scene;
}

const Primitive floor_plane = {Shape::plane, {1, 1, 1}, 0, {}, true};
const Primitive wall_plane = {Shape::plane, {1, 1, 1}, 0, {.tilt = {90, 0, 0}}, true}; // z = 0

// A floor in front of a wall, both endless.
Scene corner() {
    Scene scene = bare_scene({floor_plane, wall_plane});
    scene.camera = {.eye = {0.3, 1.4, 3.0}, .target = {0, 0.3, 0}};
    return scene;
}

// The world point at the centre of a pixel, by the camera's matrices alone.
Point point_at(const Camera& camera, uint32_t x, uint32_t y, double depth, Extent extent) {
    const auto p = [&](size_t i) { return static_cast<double>(camera.projection[i]); };
    const auto m = [&](size_t i) { return static_cast<double>(camera.world_to_view[i]); };
    const double ndc_x = (x + 0.5) / extent.width * 2.0 - 1.0, ndc_y = (y + 0.5) / extent.height * 2.0 - 1.0;
    const double w = p(15) - p(11) * depth; // clip w; the fourth row is (0, 0, [11], [15])
    const double view[3] = {(ndc_x * w + p(8) * depth - p(12)) / p(0), (ndc_y * w + p(9) * depth - p(13)) / p(5),
                            -depth};
    double world[3] = {};
    for (size_t axis = 0; axis < 3; ++axis)
        for (size_t row = 0; row < 3; ++row)
            world[axis] += m(axis * 4 + row) * (view[row] - m(12 + row));
    return {world[0], world[1], world[2]};
}

// Where it is in the image, in pixels, by the camera's matrices alone.
Point seen(const Camera& camera, const Point& point, Extent extent) {
    const auto multiply = [](const Matrix4& m, const std::array<double, 4>& v) {
        std::array<double, 4> result{};
        for (size_t row = 0; row < 4; ++row)
            for (size_t column = 0; column < 4; ++column)
                result[row] += static_cast<double>(m[column * 4 + row]) * v[column];
        return result;
    };
    const auto clip = multiply(camera.projection, multiply(camera.world_to_view, {point.x, point.y, point.z, 1.0}));
    return {(clip[0] / clip[3] * 0.5 + 0.5) * extent.width, (clip[1] / clip[3] * 0.5 + 0.5) * extent.height, 0.0};
}

double falloff(Falloff kind, double t) {
    const double square = t * t;
    switch (kind) {
    case Falloff::linear:
        return 1.0 - t;
    case Falloff::quadratic:
        return 1.0 - square;
    case Falloff::sao:
        return std::pow(1.0 - square, 3.0);
    case Falloff::contact:
        return (1.0 - t) * (1.0 - t);
    case Falloff::wide:
        return 1.0 - square * square;
    case Falloff::hard:
        break;
    }
    return 1.0;
}

// Occlusion by an endless wall at right angles, at `distance` in units of the radius: a ray with the component u
// towards the wall meets it after distance / u. Seen on the unit disc below the hemisphere, on which cosine-weighted
// directions are even, that is the chord 2 √(1 - u²) at u.
double wall_occlusion(Falloff kind, double distance) {
    if (distance >= 1.0)
        return 0.0;
    constexpr int steps = 4000;
    double sum = 0.0;
    for (int i = 0; i < steps; ++i) {
        // u = sin a keeps the integrand smooth at u = 1.
        const double low = std::asin(distance), step = (std::numbers::pi / 2.0 - low) / steps;
        const double a = low + (i + 0.5) * step;
        sum += falloff(kind, distance / std::sin(a)) * std::cos(a) * std::cos(a) * step;
    }
    return sum * 2.0 / std::numbers::pi;
}

struct Errors {
    double mean = 0.0, most = 0.0, bias = 0.0;
    size_t pixels = 0;
};

// Of the corner's floor and wall.
Errors corner_errors(const Truth& truth, const Scene& scene, const OcclusionTruth& occlusion) {
    const Extent extent = truth.depth.extent;
    const Camera view = camera(scene, 0, extent);
    Errors errors;
    for (uint32_t y = 0; y < extent.height; ++y)
        for (uint32_t x = 0; x < extent.width; ++x) {
            const Point p = point_at(view, x, y, static_cast<double>(*truth.depth.at(x, y)), extent);
            const double distance = std::abs(std::max(std::abs(p.y), std::abs(p.z))); // the other one is 0
            const double expected = 1.0 - wall_occlusion(occlusion.falloff, distance / occlusion.radius);
            const double error = static_cast<double>(*truth.visibility.at(x, y)) - expected;
            errors.mean += std::abs(error);
            errors.bias += error;
            errors.most = std::max(errors.most, std::abs(error));
            ++errors.pixels;
        }
    errors.mean /= static_cast<double>(errors.pixels);
    errors.bias /= static_cast<double>(errors.pixels);
    return errors;
}

TEST(OcclusionReference, agrees_with_the_segment_of_a_circle) {
    for (const double c : {0.0, 0.2, 0.7})
        EXPECT_NEAR(wall_occlusion(Falloff::hard, c), (std::acos(c) - c * std::sqrt(1 - c * c)) / std::numbers::pi,
                    1e-6);
    EXPECT_NEAR(wall_occlusion(Falloff::hard, 0.0), 0.5, 1e-9);
}

TEST_F(OcclusionTruthTest, a_plane_is_open_at_every_tilt_and_distance) {
    for (const double height : {0.02, 1.0, 300.0})
        for (const double slope : {0.02, 0.3, 5.0}) {
            Scene scene = bare_scene({floor_plane});
            scene.camera = {.eye = {0.2, height, 0}, .target = {0, height - slope, -1}};
            for (const Falloff kind : {Falloff::hard, Falloff::contact, Falloff::sao}) {
                const Truth truth = trace(scene, {48, 27}, {height, kind, 32, 0});
                for (uint32_t i = 0; i < 48 * 27; ++i) {
                    ASSERT_EQ(truth.visibility.values[i], 1.0f) << height << " " << slope;
                    if (truth.depth.values[i] >= sky_depth)
                        continue;
                    float cosine = 0.0f;
                    for (size_t c = 0; c < 3; ++c)
                        cosine += truth.bent_normal.values[4 * i + c] * truth.normal.values[4 * i + c];
                    EXPECT_GT(cosine, 0.98f);
                }
            }
        }
}

TEST_F(OcclusionTruthTest, the_sky_is_open_and_has_no_direction) {
    const Truth truth = trace(bare_scene({}), {9, 5}, {});
    for (uint32_t i = 0; i < 9 * 5; ++i) {
        EXPECT_EQ(truth.visibility.values[i], 1.0f);
        EXPECT_EQ(truth.bent_normal.values[4 * i] + truth.bent_normal.values[4 * i + 1], 0.0f);
        EXPECT_EQ(truth.bent_normal.values[4 * i + 3], 1.0f);
    }
}

TEST_F(OcclusionTruthTest, a_wall_on_a_floor_is_analytic_with_every_falloff) {
    const Scene scene = corner();
    for (size_t i = 0; i < falloff_names().size(); ++i) {
        SCOPED_TRACE(falloff_names()[i]);
        const OcclusionTruth occlusion = {1.5, static_cast<Falloff>(i), 512, 0};
        const Errors errors = corner_errors(trace(scene, {96, 54}, occlusion), scene, occlusion);
        EXPECT_LT(errors.mean, 0.003);
        EXPECT_LT(errors.most, 0.02);
        EXPECT_LT(std::abs(errors.bias), 3e-4);
    }
}

TEST_F(OcclusionTruthTest, the_open_direction_leans_away_from_the_wall) {
    Scene scene = corner();
    scene.camera = {.eye = {0, 2.0, 0.5}, .target = {0, 0, 0.49}}; // down: the image's top is towards the wall
    const Truth truth = trace(scene, {33, 33}, {1.5, Falloff::hard, 256, 0});
    const float* bent = truth.bent_normal.at(16, 16);
    EXPECT_LT(bent[1], -0.2f);
    EXPECT_NEAR(bent[0], 0.0f, 0.02f);
    EXPECT_GT(bent[2], 0.5f);
    EXPECT_NEAR(std::hypot(bent[0], bent[1], bent[2]), 1.0f, 1e-5f);
    EXPECT_EQ(bent[3], *truth.visibility.at(16, 16));
}

// Where no ray gets out there is still a direction.
TEST_F(OcclusionTruthTest, a_closed_gap_is_dark) {
    Primitive ceiling = floor_plane;
    ceiling.motion.pivot = {0, 0.1, 0};
    Scene scene = bare_scene({floor_plane, ceiling});
    scene.camera = {.eye = {0, 0.05, 0}, .target = {0, 0.03, -1}};
    const Truth truth = trace(scene, {16, 9}, {1e5, Falloff::hard, 64, 0});
    for (uint32_t i = 0; i < 16 * 9; ++i) {
        const float* bent = &truth.bent_normal.values[4 * i];
        EXPECT_EQ(truth.visibility.values[i], 0.0f);
        EXPECT_NEAR(std::hypot(bent[0], bent[1], bent[2]), 1.0f, 1e-5f);
    }
}

// A sphere over a plane hides R² cos / d² of the cosine-weighted hemisphere: (R / h)² right below.
std::vector<double> sphere_errors(const Truth& truth, const Scene& scene, double radius, double height) {
    const Extent extent = truth.depth.extent;
    const Camera view = camera(scene, 0, extent);
    std::vector<double> errors;
    for (uint32_t y = 0; y < extent.height; ++y)
        for (uint32_t x = 0; x < extent.width; ++x) {
            const double depth = static_cast<double>(*truth.depth.at(x, y));
            if (depth >= static_cast<double>(sky_depth))
                continue;
            const Point p = point_at(view, x, y, depth, extent);
            if (std::abs(p.y) > 1e-3)
                continue;
            const double d = std::hypot(p.x, height, p.z);
            const double expected = 1.0 - radius * radius * height / (d * d * d);
            errors.push_back(static_cast<double>(*truth.visibility.at(x, y)) - expected);
        }
    return errors;
}

double rms(const std::vector<double>& values) {
    double sum = 0.0;
    for (const double value : values)
        sum += value * value;
    return std::sqrt(sum / static_cast<double>(values.size()));
}

TEST_F(OcclusionTruthTest, a_sphere_over_a_floor_is_its_form_factor_and_converges) {
    const double radius = 0.6, height = 1.1;
    Scene scene = bare_scene({floor_plane, {Shape::sphere, {radius, 0, 0}, 0, {.pivot = {0, height, 0}}, true}});
    scene.camera = {.eye = {0, 0.4, 3.0}, .target = {0, 0.1, 0}};
    const Extent extent{65, 37};
    std::vector<double> rms_of;
    for (const int rays : {16, 64, 256, 1024}) {
        const auto errors = sphere_errors(trace(scene, extent, {100.0, Falloff::hard, rays, 1}), scene, radius, height);
        ASSERT_GT(errors.size(), 800u);
        rms_of.push_back(rms(errors));
    }
    for (size_t i = 1; i < rms_of.size(); ++i) // four times the rays: at most half the error, and less by even rays
        EXPECT_LT(rms_of[i], 0.5 * rms_of[i - 1]) << rms_of[i - 1];
    EXPECT_LT(rms_of.back(), 0.004);
    // The pixel in the middle looks at the point right below.
    Scene below = scene;
    below.camera = {.eye = {0, 0.3, 1.5}, .target = {0, 0, 0}};
    const Truth truth = trace(below, {33, 33}, {100.0, Falloff::hard, 4096, 0});
    EXPECT_NEAR(static_cast<double>(*truth.visibility.at(16, 16)), 1.0 - std::pow(radius / height, 2.0), 2e-3);
}

TEST_F(OcclusionTruthTest, falloffs_differ_and_are_ordered) {
    const Scene& scene = *find_scene("columns");
    const Extent extent{64, 36};
    const auto visibility = [&](Falloff kind) {
        return trace(scene, extent, {1.0, kind, 32, 0}, scene.info.key_frame).visibility.values;
    };
    const auto contact = visibility(Falloff::contact), linear = visibility(Falloff::linear);
    const auto quadratic = visibility(Falloff::quadratic), sao = visibility(Falloff::sao);
    const auto wide = visibility(Falloff::wide), hard = visibility(Falloff::hard);
    double differences[5] = {};
    for (size_t i = 0; i < hard.size(); ++i) {
        const float steps[5] = {contact[i] - linear[i], linear[i] - quadratic[i], quadratic[i] - wide[i],
                                wide[i] - hard[i], sao[i] - quadratic[i]};
        for (size_t k = 0; k < 5; ++k) { // the rays are the same
            EXPECT_GE(steps[k], -1e-6f) << k;
            differences[k] += static_cast<double>(steps[k]) / static_cast<double>(hard.size());
        }
    }
    for (const double difference : differences)
        EXPECT_GT(difference, 0.005);
}

TEST_F(OcclusionTruthTest, two_runs_give_the_same_bits_and_seeds_do_not) {
    const Scene& scene = *find_scene("contact");
    const Extent extent{61, 35};
    for (const int rays : {1, 7, 64, 65, 200}) { // up to four passes
        const OcclusionTruth occlusion = {1.5, Falloff::quadratic, rays, 0};
        const Truth a = trace(scene, extent, occlusion, 3.5), b = trace(scene, extent, occlusion, 3.5);
        EXPECT_EQ(test::first_difference(a.visibility, b.visibility), "");
        EXPECT_EQ(test::first_difference(a.bent_normal, b.bent_normal), "");
        EXPECT_TRUE(test::all_finite(a.visibility) && test::all_finite(a.bent_normal));
        const Truth other = trace(scene, extent, {1.5, Falloff::quadratic, rays, 1}, 3.5);
        EXPECT_NE(test::first_difference(a.visibility, other.visibility), "");
    }
}

TEST_F(OcclusionTruthTest, moves_with_the_scene) {
    const Scene& scene = *find_scene("contact");
    const Truth a = trace(scene, {64, 36}, {0.5, Falloff::hard, 16, 0}, 4);
    const Truth b = trace(scene, {64, 36}, {0.5, Falloff::hard, 16, 0}, 12);
    EXPECT_NE(test::first_difference(a.visibility, b.visibility), "");
}

TEST_F(OcclusionTruthTest, every_lens_sees_the_same_corner) {
    for (const double orthographic_height : {0.0, 2.5})
        for (const double shift : {0.0, 0.2}) {
            SCOPED_TRACE(orthographic_height);
            Scene scene = corner();
            scene.camera.lens.orthographic_height = orthographic_height;
            scene.camera.lens.shift_x = shift;
            scene.camera.lens.shift_y = -shift / 2.0;
            const OcclusionTruth occlusion = {0.8, Falloff::linear, 256, 0};
            const Errors errors = corner_errors(trace(scene, {64, 36}, occlusion), scene, occlusion);
            EXPECT_LT(errors.mean, 0.004);
            EXPECT_LT(errors.most, 0.03);
        }
}

TEST_F(OcclusionTruthTest, units_do_not_matter) {
    for (const char* name : {"crevices", "contact", "grazing-floor"}) {
        const Scene& metres = *find_scene(name);
        const Scene centimetres = in_units(metres, 100.0);
        const double key = metres.info.key_frame;
        const Truth a = trace(metres, {64, 36}, {1.5, Falloff::linear, 64, 0}, key);
        const Truth b = trace(centimetres, {64, 36}, {150.0, Falloff::linear, 64, 0}, key);
        double difference = 0.0;
        for (size_t i = 0; i < a.visibility.values.size(); ++i) {
            difference += static_cast<double>(std::abs(a.visibility.values[i] - b.visibility.values[i]));
            const float factor = a.depth.values[i] < sky_depth ? 100.0f : 1.0f;
            EXPECT_NEAR(b.depth.values[i] / a.depth.values[i] / factor, 1.0f, 2e-4f) << name;
        }
        EXPECT_LT(difference / 64 / 36, 5e-4) << name;
    }
}

// The other images of a lens: depth as the matrix makes it, velocity as the matrices move the points.
TEST_F(OcclusionTruthTest, depth_images_follow_the_projection) {
    const Extent extent{64, 36};
    for (const double height : {0.0, 6.0})
        for (const DepthRange range : {DepthRange::standard, DepthRange::reversed, DepthRange::reversed_infinite}) {
            Scene scene = *find_scene("grazing-floor");
            const double key = scene.info.key_frame;
            scene.camera.lens = {.orthographic_height = height, .range = range, .near_plane = 0.1, .far_plane = 60.0};
            const Truth linear = trace(scene, extent, {1.5, Falloff::hard, 1, 0}, key);
            scene.camera.lens.depth_kind = DepthKind::device;
            EXPECT_EQ(frame_facts(scene, 3, extent).depth_kind, DepthKind::device);
            const Truth device = trace(scene, extent, {1.5, Falloff::hard, 1, 0}, key);
            EXPECT_EQ(test::first_difference(linear.visibility, device.visibility), "");
            const Camera view = camera(scene, key, extent);
            const auto p = [&](size_t i) { return static_cast<double>(view.projection[i]); };
            size_t sky = 0;
            for (size_t i = 0; i < linear.depth.values.size(); ++i) {
                const double t = static_cast<double>(linear.depth.values[i]);
                const double expected = t >= static_cast<double>(sky_depth)
                                            ? (range == DepthRange::standard ? 1.0 : 0.0)
                                            : (p(14) - p(10) * t) / (p(15) - p(11) * t);
                EXPECT_NEAR(static_cast<double>(device.depth.values[i]), std::clamp(expected, 0.0, 1.0), 1e-5);
                sky += linear.depth.values[i] >= sky_depth;
            }
            EXPECT_GT(sky, 0u);
            EXPECT_LT(sky, linear.depth.values.size());
        }
}

TEST_F(OcclusionTruthTest, velocities_are_those_of_every_lens) {
    const Extent extent{64, 36};
    for (const double height : {0.0, 5.0}) {
        Scene scene = *find_scene("columns"); // nothing moves but the camera
        scene.camera.pan = 1.5;
        scene.camera.lens = {.orthographic_height = height, .shift_x = 0.15, .shift_y = -0.1};
        const double key = scene.info.key_frame;
        const apps::HostImage depth = make(VK_FORMAT_R32_SFLOAT, extent);
        const apps::HostImage velocity = make(VK_FORMAT_R32G32_SFLOAT, extent);
        SceneImages images;
        images.depth = depth.image();
        images.velocity = velocity.image();
        render(scene, images, {}, key);
        const FloatImage depths = test::read_back(depth), velocities = test::read_back(velocity);
        const Camera now = camera(scene, key, extent), before = camera(scene, key - 1, extent);
        double most = 0.0;
        for (uint32_t y = 0; y < extent.height; ++y)
            for (uint32_t x = 0; x < extent.width; ++x) {
                if (*depths.at(x, y) > 50.0f)
                    continue;
                const Point p = point_at(now, x, y, static_cast<double>(*depths.at(x, y)), extent);
                const Point old = seen(before, p, extent);
                const double dx = x + 0.5 - old.x, dy = y + 0.5 - old.y;
                EXPECT_NEAR(static_cast<double>(velocities.at(x, y)[0]), dx, 2e-3);
                EXPECT_NEAR(static_cast<double>(velocities.at(x, y)[1]), dy, 2e-3);
                most = std::max(most, std::abs(dx));
            }
        EXPECT_GT(most, 0.5);
    }
}

TEST(OcclusionTruth, refuses_nonsense_with_a_sentence) {
    Scene scene = corner();
    Image image;
    image.format = VK_FORMAT_R32_SFLOAT;
    image.extent = {16, 9};
    SceneImages images;
    images.true_visibility = image;
    const auto message = [&](const OcclusionTruth& occlusion) {
        RenderOptions options;
        options.occlusion = occlusion;
        const auto plan = plan_scene(scene, 0.0, options, images);
        return plan ? check_plan(*plan) : plan.error().message;
    };
    EXPECT_EQ(message({}), "");
    EXPECT_EQ(message({1.5, Falloff::hard, 65536, 0}), "");
    EXPECT_NE(message({1.5, Falloff::hard, 0, 0}).find("rays"), std::string::npos);
    EXPECT_NE(message({1.5, Falloff::hard, 65537, 0}).find("rays"), std::string::npos);
    EXPECT_NE(message({0.0, Falloff::hard, 1, 0}), "");
    EXPECT_NE(message({std::nan(""), Falloff::hard, 1, 0}), "");
    scene.camera.lens.far_plane = 0.01;
    EXPECT_NE(message({}).find("far plane"), std::string::npos);
    EXPECT_EQ(find_falloff("sao"), Falloff::sao);
    EXPECT_FALSE(find_falloff("cubic"));
}

} // namespace
} // namespace sfumato::scene
