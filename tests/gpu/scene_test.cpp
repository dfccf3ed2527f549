// The analytic scene against what is known without it: planes, projections of moved points, means of sharp frames.
#include "apps/common/device.h"
#include "scene/scene.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <set>

namespace sfumato::scene {
namespace {

using apps::HostImage;

// One rendered frame, read back. Interleaved, the channels of SceneImages.
struct Rendered {
    Extent extent;
    std::vector<float> colour, direct, ambient, depth, normal, velocity, next_velocity, shadow, truth;

    size_t pixels() const { return depth.size(); }
};

class SceneTest : public testing::Test {
  protected:
    void SetUp() override {
        auto device = apps::Device::create({.device = "", .validation = true, .labels = false});
        ASSERT_TRUE(device) << device.error().message;
        device_ = std::move(*device);
        ContextInfo info = device_->context_info();
        info.poison = 0x7a; // what is not written would show
        auto context = Context::create(info);
        ASSERT_TRUE(context) << context.error().message;
        context_ = std::move(*context);
        auto renderer = SceneRenderer::create(*context_);
        ASSERT_TRUE(renderer) << renderer.error().message;
        renderer_ = std::move(*renderer);
    }

    void TearDown() override {
        if (!device_)
            return;
        for (const std::string& message : device_->validation_messages())
            ADD_FAILURE() << message;
        renderer_.reset();
        context_.reset();
    }

    HostImage make(VkFormat format, Extent extent) {
        auto image = device_->create_image(format, extent);
        EXPECT_TRUE(image) << (image ? "" : image.error().message);
        return image ? std::move(*image) : HostImage{};
    }

    std::vector<float> read(const HostImage& image) {
        auto values = device_->readback(image);
        EXPECT_TRUE(values) << (values ? "" : values.error().message);
        return values ? std::move(*values) : std::vector<float>{};
    }

    Rendered render(const Scene& scene, double frame, Extent extent, const RenderOptions& options) {
        const VkFormat half4 = VK_FORMAT_R16G16B16A16_SFLOAT;
        HostImage colour = make(half4, extent), direct = make(half4, extent), ambient = make(half4, extent);
        HostImage depth = make(VK_FORMAT_R32_SFLOAT, extent), normal = make(half4, extent);
        HostImage velocity = make(VK_FORMAT_R32G32_SFLOAT, extent), next = make(VK_FORMAT_R32G32_SFLOAT, extent);
        HostImage shadow = make(VK_FORMAT_R8_UNORM, extent), truth = make(half4, extent);
        run(scene, frame, options,
            {colour.image(), direct.image(), ambient.image(), depth.image(), normal.image(), velocity.image(),
             next.image(), shadow.image(), truth.image()});
        return {extent,       read(colour),   read(direct), read(ambient), read(depth),
                read(normal), read(velocity), read(next),   read(shadow),  read(truth)};
    }

    std::vector<float> render_colour(const Scene& scene, double frame, Extent extent, int samples) {
        HostImage colour = make(VK_FORMAT_R16G16B16A16_SFLOAT, extent);
        SceneImages images;
        images.colour = colour.image();
        run(scene, frame, {.samples = samples, .shutter = {}}, images);
        return read(colour);
    }

    std::vector<float> render_truth(const Scene& scene, double frame, Extent extent, const RenderOptions& options) {
        HostImage truth = make(VK_FORMAT_R16G16B16A16_SFLOAT, extent);
        SceneImages images;
        images.truth = truth.image();
        run(scene, frame, options, images);
        return read(truth);
    }

    void run(const Scene& scene, double frame, const RenderOptions& options, const SceneImages& images) {
        auto commands = device_->begin();
        ASSERT_TRUE(commands) << commands.error().message;
        const auto recorded = renderer_->record(*commands, scene, frame, options, images, index_++);
        EXPECT_TRUE(recorded) << (recorded ? "" : recorded.error().message);
        const auto done = device_->submit_and_wait();
        EXPECT_TRUE(done) << (done ? "" : done.error().message);
    }

    std::unique_ptr<apps::Device> device_;
    std::unique_ptr<Context> context_;
    std::unique_ptr<SceneRenderer> renderer_;
    uint64_t index_ = 0;
};

RenderOptions quick(int sub_frames = 1, int samples = 1) {
    RenderOptions options;
    options.samples = samples;
    options.shutter.sub_frames = sub_frames;
    return options;
}

// A black world without light, to put single things into.
Scene empty_scene() {
    Scene scene;
    scene.info.name = "test";
    scene.info.key_frame = 0;
    scene.light = {
        .to_sun = {0, 1, 0}, .sun = {}, .zenith = {}, .horizon = {}, .clouds = 0, .ambient_up = {}, .ambient_down = {}};
    scene.materials = {{.pattern = Pattern::solid, .colour_a = {1, 1, 1}, .emission = 1.0}};
    return scene;
}

struct View {
    std::array<double, 3> point;
    double x, y; // pixels
};

// A world point as a camera sees it, by its matrices alone.
View seen(const Camera& camera, const std::array<double, 3>& world, double w, Extent extent) {
    View result{};
    const auto& m = camera.world_to_view;
    for (size_t row = 0; row < 3; ++row)
        result.point[row] = static_cast<double>(m[row]) * world[0] + static_cast<double>(m[4 + row]) * world[1] +
                            static_cast<double>(m[8 + row]) * world[2] + static_cast<double>(m[12 + row]) * w;
    const auto& p = camera.projection;
    const double clip_w = static_cast<double>(p[11]) * result.point[2];
    result.x = (static_cast<double>(p[0]) * result.point[0] / clip_w * 0.5 + 0.5) * extent.width;
    result.y = (static_cast<double>(p[5]) * result.point[1] / clip_w * 0.5 + 0.5) * extent.height;
    return result;
}

// The world point (or, with depth 0, the direction) behind the centre of a pixel.
std::array<double, 3> behind_pixel(const Camera& camera, uint32_t x, uint32_t y, double depth, Extent extent) {
    const double scale = depth > 0.0 ? depth : 1.0;
    const double ndc_x = (x + 0.5) / extent.width * 2.0 - 1.0, ndc_y = (y + 0.5) / extent.height * 2.0 - 1.0;
    const auto& m = camera.world_to_view;
    const std::array<double, 3> view = {ndc_x / static_cast<double>(camera.projection[0]) * scale,
                                        ndc_y / static_cast<double>(camera.projection[5]) * scale, -scale};
    std::array<double, 3> world{};
    for (size_t axis = 0; axis < 3; ++axis)
        for (size_t row = 0; row < 3; ++row)
            world[axis] += static_cast<double>(m[axis * 4 + row]) *
                           (view[row] - (depth > 0.0 ? static_cast<double>(m[12 + row]) : 0.0));
    return world;
}

std::array<double, 3> move(const Pose& from, const Pose& to, const std::array<double, 3>& world) {
    std::array<double, 3> local{}, result{};
    for (size_t column = 0; column < 3; ++column)
        for (size_t row = 0; row < 3; ++row)
            local[column] += from[row * 4 + column] * (world[row] - from[row * 4 + 3]);
    for (size_t row = 0; row < 3; ++row)
        result[row] =
            to[row * 4] * local[0] + to[row * 4 + 1] * local[1] + to[row * 4 + 2] * local[2] + to[row * 4 + 3];
    return result;
}

double sum(const std::vector<float>& values, size_t channel, size_t channels) {
    double total = 0.0;
    for (size_t i = channel; i < values.size(); i += channels)
        total += static_cast<double>(values[i]);
    return total;
}

bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

double half_displacement(const Rendered& r, size_t pixel) {
    return 25.0 *
           std::hypot(static_cast<double>(r.velocity[2 * pixel]), static_cast<double>(r.velocity[2 * pixel + 1])) /
           r.extent.height;
}

TEST(Scenes, HaveNamesDocsAndFit) {
    std::set<std::string> names;
    for (const Scene& scene : scenes()) {
        EXPECT_TRUE(names.insert(scene.info.name).second) << scene.info.name;
        EXPECT_EQ(scene.info.name.find_first_not_of("abcdefghijklmnopqrstuvwxyz-"), std::string::npos);
        EXPECT_FALSE(scene.info.doc.empty());
        EXPECT_EQ(find_scene(scene.info.name), &scene);
        EXPECT_GT(scene.info.frames, scene.info.key_frame);
        Image image;
        image.format = VK_FORMAT_R32_SFLOAT;
        image.extent = {16, 9};
        SceneImages images;
        images.depth = image;
        const auto plan = plan_scene(scene, 0.0, quick(), images);
        ASSERT_TRUE(plan) << plan.error().message;
        EXPECT_EQ(check_plan(*plan), "");
    }
    EXPECT_GE(names.size(), 9u);
    EXPECT_EQ(find_scene("no-such-scene"), nullptr);
}

TEST(Scenes, RefuseNonsenseWithASentence) {
    const Scene& scene = scenes()[0];
    Image image;
    image.format = VK_FORMAT_R16G16B16A16_SFLOAT;
    image.extent = {16, 9};
    SceneImages images;
    EXPECT_FALSE(plan_scene(scene, 0.0, quick(), images));
    images.colour = image;
    EXPECT_TRUE(plan_scene(scene, 0.0, quick(), images));
    EXPECT_FALSE(plan_scene(scene, std::nan(""), quick(), images));
    EXPECT_FALSE(plan_scene(scene, 0.0, quick(0), images));
    EXPECT_FALSE(plan_scene(scene, 0.0, quick(257), images));
    EXPECT_FALSE(plan_scene(scene, 0.0, quick(1, 0), images));
    EXPECT_FALSE(plan_scene(scene, 0.0, quick(1, 9), images));
    images.depth = image;
    images.depth.extent = {16, 8};
    const auto differing = plan_scene(scene, 0.0, quick(), images);
    ASSERT_FALSE(differing);
    EXPECT_EQ(differing.error().code, ErrorCode::invalid_argument);
    EXPECT_NE(differing.error().message.find("16×8"), std::string::npos) << differing.error().message;
    Scene crowded = scene;
    crowded.primitives.resize(65);
    images.depth = {};
    EXPECT_FALSE(plan_scene(crowded, 0.0, quick(), images));
}

TEST_F(SceneTest, DepthOfPlanesIsAnalytic) {
    const Extent extent{64, 36};
    Scene scene = empty_scene();
    scene.camera = {.eye = {0.3, 2.0, 5.0}, .target = {0.3, 2.0, 0.0}};
    scene.primitives = {{Shape::plane, {1, 1, 1}, 0, {}, true}};
    const Rendered floor = render(scene, 0, extent, quick());
    const double tangent = std::tan(20.0 * 3.14159265358979 / 180.0);
    for (uint32_t y = 0; y < extent.height; ++y) {
        const double down = ((y + 0.5) / extent.height * 2.0 - 1.0) * tangent;
        const double expected = down > 0.0 ? 2.0 / down : static_cast<double>(sky_depth);
        for (uint32_t x = 0; x < extent.width; ++x)
            EXPECT_NEAR(static_cast<double>(floor.depth[y * extent.width + x]) / expected, 1.0, 1e-5) << x << " " << y;
    }
    scene.primitives[0].motion = {.pivot = {0, 0, -3}, .tilt = {90, 0, 0}};
    const Rendered wall = render(scene, 0, extent, quick());
    for (const float depth : wall.depth)
        EXPECT_NEAR(depth, 8.0f, 1e-5f);
}

TEST_F(SceneTest, NormalsAreUnitAndFaceTheCamera) {
    const Extent extent{96, 54};
    for (const Scene& scene : scenes()) {
        const Rendered r = render(scene, scene.info.key_frame, extent, quick());
        const Camera view = camera(scene, scene.info.key_frame, extent);
        for (size_t i = 0; i < r.pixels(); ++i) {
            const float *n = &r.normal[4 * i], length = std::hypot(n[0], n[1], n[2]);
            if (r.depth[i] >= sky_depth) {
                EXPECT_EQ(length, 0.0f);
                continue;
            }
            EXPECT_NEAR(length, 1.0f, 2e-3f) << scene.info.name;
            const auto x = static_cast<float>(i % extent.width) + 0.5f, y = static_cast<float>(i / extent.width) + 0.5f;
            const float ray_x = (x / static_cast<float>(extent.width) * 2 - 1) / view.projection[0];
            const float ray_y = (y / static_cast<float>(extent.height) * 2 - 1) / view.projection[5];
            EXPECT_LT(n[0] * ray_x + n[1] * ray_y - n[2], 2e-3f) << scene.info.name << " " << x << " " << y;
        }
    }
}

// One primitive at a time with every kind of motion at once, under a camera that travels and pans.
TEST_F(SceneTest, VelocitiesAreThoseOfProjectedPoints) {
    const Extent extent{96, 54};
    for (const Shape shape : {Shape::sphere, Shape::box, Shape::cylinder, Shape::plane, Shape::disc}) {
        Scene scene = empty_scene();
        scene.camera = {.eye = {0.2, 1.1, 5.0},
                        .eye_velocity = {0.1, -0.05, 0.2},
                        .target = {0, 0.2, 0},
                        .target_velocity = {0.05, 0.1, 0},
                        .pan = 2.0};
        const Motion motion = {.pivot = {0.1, -0.2, 0.3},
                               .velocity = {0.2, 0.1, -0.3},
                               .swing = {0.1, 0.2, 0.3},
                               .swing_period = 9,
                               .swing_phase = 0.1,
                               .axis = {0.3, 1, 0.2},
                               .angle = 25,
                               .spin = 14,
                               .rock = 10,
                               .rock_period = 7,
                               .offset = {0.2, 0.1, 0},
                               .tilt = {40, 20, 10}};
        scene.primitives = {{shape, {1.0, 0.7, 0.8}, 0, motion, true}};
        const double time = 1.25;
        const Rendered r = render(scene, time, extent, quick());
        const Camera now = camera(scene, time, extent);
        size_t hits = 0;
        for (uint32_t y = 0; y < extent.height; ++y)
            for (uint32_t x = 0; x < extent.width; ++x) {
                const size_t i = y * extent.width + x;
                const bool sky = r.depth[i] >= sky_depth;
                if (!sky && r.depth[i] > 60.0f)
                    continue; // the plane's horizon: floats end there
                hits += sky ? 0 : 1;
                const auto world = behind_pixel(now, x, y, sky ? 0.0 : static_cast<double>(r.depth[i]), extent);
                const double w = sky ? 0.0 : 1.0;
                for (const double step : {-1.0, 1.0}) {
                    const auto there = sky ? world : move(pose_at(motion, time), pose_at(motion, time + step), world);
                    const View other = seen(camera(scene, time + step, extent), there, w, extent);
                    const auto& velocity = step < 0 ? r.velocity : r.next_velocity;
                    const double sign = step < 0 ? -1.0 : 1.0;
                    EXPECT_NEAR(static_cast<double>(velocity[2 * i]), sign * (other.x - (x + 0.5)), 2e-3);
                    EXPECT_NEAR(static_cast<double>(velocity[2 * i + 1]), sign * (other.y - (y + 0.5)), 2e-3);
                }
            }
        EXPECT_GT(hits, 200u) << static_cast<int>(shape);
    }
}

TEST_F(SceneTest, SpeedsAreTypicalAndSceneStillIsStill) {
    const Extent extent{160, 90};
    for (const Scene& scene : scenes()) {
        if (!is_for(scene.info, "motion-blur"))
            continue;
        const Rendered r = render(scene, scene.info.key_frame, extent, quick(7, 2));
        std::vector<double> moving;
        for (size_t i = 0; i < r.pixels(); ++i)
            if (half_displacement(r, i) > 0.3)
                moving.push_back(half_displacement(r, i));
        std::ranges::sort(moving);
        if (scene.info.name == "still") {
            EXPECT_TRUE(std::ranges::all_of(r.velocity, [](float v) { return v == 0.0f; }));
            EXPECT_TRUE(std::ranges::all_of(r.next_velocity, [](float v) { return v == 0.0f; }));
            EXPECT_TRUE(same_bits(r.truth, r.colour));
            continue;
        }
        ASSERT_FALSE(moving.empty()) << scene.info.name;
        EXPECT_GT(moving[moving.size() * 95 / 100], 1.0) << scene.info.name;
        EXPECT_LT(moving[moving.size() * 95 / 100], 6.0) << scene.info.name;
        EXPECT_FALSE(same_bits(r.truth, r.colour)) << scene.info.name;
    }
}

TEST_F(SceneTest, StillThingsBeforeAMovingWallKeepTheirBits) {
    const Scene& scene = *find_scene("static-foreground");
    const Rendered r = render(scene, scene.info.key_frame, {160, 90}, quick(16, 1));
    size_t still = 0;
    for (size_t i = 0; i < r.pixels(); ++i) {
        if (r.velocity[2 * i] != 0.0f || r.velocity[2 * i + 1] != 0.0f)
            continue;
        ++still;
        EXPECT_EQ(std::memcmp(&r.truth[4 * i], &r.colour[4 * i], 16), 0);
    }
    EXPECT_GT(still, r.pixels() / 4);
    EXPECT_LT(still, r.pixels());
}

TEST_F(SceneTest, TruthOfATravellingThingConservesEnergy) {
    Scene scene = empty_scene();
    scene.camera = {.eye = {0, 0, 5}, .target = {0, 0, 0}};
    scene.materials[0].emission = 3.0;
    scene.primitives = {
        {Shape::box, {0.4, 0.3, 0.1}, 0, {.velocity = {0.6, 0.2, 0}, .axis = {0, 0, 1}, .angle = 20}, false}};
    const Extent extent{128, 72};
    const auto colour = render_colour(scene, 0, extent, 4);
    const auto truth = render_truth(scene, 0, extent, quick(16, 4));
    EXPECT_GT(sum(colour, 0, 4), 100.0);
    EXPECT_NEAR(sum(truth, 0, 4) / sum(colour, 0, 4), 1.0, 0.01);
    EXPECT_FALSE(same_bits(truth, colour));
}

TEST_F(SceneTest, TruthIsTheMeanOfSharpFramesInsideTheShutter) {
    const Extent extent{48, 27};
    for (const char* name : {"fairground", "spinning-disc", "camera-pan"}) {
        const Scene& scene = *find_scene(name);
        const double key = scene.info.key_frame;
        for (const auto& [position, opens] :
             {std::pair{ShutterPosition::start, 0.0}, {ShutterPosition::centre, -0.3}, {ShutterPosition::end, -0.6}}) {
            RenderOptions options = quick(5, 2);
            options.shutter.open = 0.6;
            options.shutter.position = position;
            const auto truth = render_truth(scene, key, extent, options);
            std::vector<double> mean(truth.size(), 0.0);
            for (int i = 0; i < 5; ++i) {
                const auto colour = render_colour(scene, key + opens + 0.6 * (i + 0.5) / 5, extent, 2);
                for (size_t k = 0; k < mean.size(); ++k)
                    mean[k] += static_cast<double>(colour[k]) / 5;
            }
            for (size_t k = 0; k < mean.size(); ++k)
                EXPECT_NEAR(static_cast<double>(truth[k]), mean[k], 1e-3 * (1.0 + mean[k])) << name << " " << k;
        }
    }
}

TEST_F(SceneTest, ShutterCurveWeighsSubFrames) {
    const Scene& scene = *find_scene("two-trains");
    const double key = scene.info.key_frame;
    RenderOptions options = quick(3, 1);
    options.shutter.curve = [](double place) { return place > 0.4 && place < 0.6 ? 2.0 : 0.0; };
    EXPECT_TRUE(same_bits(render_truth(scene, key, {64, 36}, options), render_colour(scene, key, {64, 36}, 1)));
    options.shutter.curve = nullptr;
    EXPECT_FALSE(same_bits(render_truth(scene, key, {64, 36}, options), render_colour(scene, key, {64, 36}, 1)));
}

TEST_F(SceneTest, LooksTheSameAtAnyResolution) {
    for (const char* name : {"fairground", "camera-pan"}) {
        const Scene& scene = *find_scene(name);
        const double key = scene.info.key_frame;
        const Rendered small = render(scene, key, {64, 36}, quick(1, 6));
        const Rendered large = render(scene, key, {192, 108}, quick(1, 2));
        double difference = 0.0, speed_difference = 0.0;
        for (uint32_t y = 0; y < 36; ++y)
            for (uint32_t x = 0; x < 64; ++x) {
                for (size_t c = 0; c < 3; ++c) {
                    double mean = 0.0;
                    for (uint32_t k = 0; k < 9; ++k)
                        mean += static_cast<double>(large.colour[4 * ((3 * y + k / 3) * 192 + 3 * x + k % 3) + c]) / 9;
                    difference += std::abs(mean - static_cast<double>(small.colour[4 * (y * 64 + x) + c]));
                }
                // The middle of three by three pixels is the centre of the one.
                const size_t centre = (3 * y + 1) * 192 + 3 * x + 1;
                speed_difference += std::abs(half_displacement(large, centre) - half_displacement(small, y * 64 + x));
                EXPECT_NEAR(large.depth[centre] / small.depth[y * 64 + x], 1.0f, 1e-3f);
            }
        EXPECT_LT(difference / (64 * 36 * 3), 0.01) << name;
        EXPECT_LT(speed_difference / (64 * 36), 1e-3) << name;
    }
}

TEST_F(SceneTest, ColourIsDirectPlusAmbient) {
    const Scene& scene = scenes()[0];
    const Rendered r = render(scene, scene.info.key_frame, {96, 54}, quick(1, 2));
    size_t lit = 0, shaded = 0;
    for (size_t i = 0; i < r.pixels(); ++i) {
        for (size_t c = 0; c < 3; ++c)
            EXPECT_NEAR(r.colour[4 * i + c], r.direct[4 * i + c] + r.ambient[4 * i + c], 2e-3f);
        EXPECT_EQ(r.colour[4 * i + 3], 1.0f);
        (r.shadow[i] == 1.0f ? lit : shaded) += 1;
        EXPECT_TRUE(r.shadow[i] == 0.0f || r.shadow[i] == 1.0f);
    }
    EXPECT_GT(lit, r.pixels() / 4);
    EXPECT_GT(shaded, r.pixels() / 50);
}

TEST_F(SceneTest, TwoRunsGiveTheSameBits) {
    const Scene& scene = scenes()[0];
    const Rendered a = render(scene, 9.5, {97, 61}, quick(3, 2));
    const Rendered b = render(scene, 9.5, {97, 61}, quick(3, 2));
    EXPECT_TRUE(same_bits(a.colour, b.colour) && same_bits(a.truth, b.truth) && same_bits(a.depth, b.depth) &&
                same_bits(a.normal, b.normal) && same_bits(a.velocity, b.velocity) &&
                same_bits(a.next_velocity, b.next_velocity) && same_bits(a.shadow, b.shadow));
}

TEST_F(SceneTest, OddSizesAreWrittenWhole) {
    for (const Extent extent : {Extent{1, 1}, Extent{7, 3}, Extent{97, 61}})
        for (const Scene& scene : scenes()) {
            const Rendered r = render(scene, 0, extent, quick(2, 1));
            for (const auto* values : {&r.colour, &r.direct, &r.ambient, &r.depth, &r.normal, &r.velocity,
                                       &r.next_velocity, &r.shadow, &r.truth})
                EXPECT_TRUE(std::ranges::all_of(*values, [](float v) { return std::isfinite(v); })) << scene.info.name;
            EXPECT_TRUE(std::ranges::all_of(r.depth, [](float v) { return v > 0.0f; }));
            for (size_t i = 0; i < r.pixels(); ++i) // created as zero: alpha shows that it was written
                EXPECT_TRUE(r.colour[4 * i + 3] == 1.0f && r.truth[4 * i + 3] == 1.0f);
        }
}

} // namespace
} // namespace sfumato::scene
