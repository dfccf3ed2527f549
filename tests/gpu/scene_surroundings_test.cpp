// What effects are told of a scene besides its images: colliders, the sun, the map of what the sun sees.
#include "scene/scene_source.h"
#include "scene/surroundings.h"
#include "tests/gpu/gpu_test.h"

#include <cmath>

namespace sfumato::test {
namespace {

class SceneSurroundings : public GpuTest {};

const scene::Scene& smoke_columns() {
    return *scene::find_scene("smoke-columns");
}

TEST_F(SceneSurroundings, colliders_are_the_primitives) {
    const scene::Scene& scene = smoke_columns();
    const std::vector<Collider> colliders = scene::colliders_of(scene, 30.0);
    EXPECT_EQ(colliders.size(), scene.primitives.size());
    EXPECT_EQ(colliders[0].shape, ColliderShape::plane);
    size_t moving = 0;
    const std::vector<Collider> later = scene::colliders_of(scene, 31.0);
    for (size_t i = 0; i < colliders.size(); ++i) {
        for (size_t c = 0; c < 3; ++c) // backward differences: the next frame's velocity is the way from here
            EXPECT_NEAR(colliders[i].centre[c] + later[i].velocity[c] / 24.0f, later[i].centre[c], 1e-5f);
        moving += later[i].velocity[0] != 0.0f;
    }
    EXPECT_EQ(moving, 1u) << "the ball";
    // Effects take them, and no more than they may.
    scene::Scene crowded = scene;
    crowded.primitives.resize(64, scene.primitives[1]);
    EXPECT_EQ(scene::colliders_of(crowded, 1.0).size(), most_colliders);
}

// Projected into the sun's map, what the camera sees is lit where nothing stands nearer the sun there.
TEST_F(SceneSurroundings, the_suns_map_gives_the_scenes_own_shadows) {
    constexpr Extent extent{128, 72};
    const auto context = make_context(0);
    const auto source = expect_value(scene::make_source(*context, smoke_columns()), "source");
    const auto make = [](VkFormat format, Extent size) {
        return expect_value(device().create_image(format, size), "image");
    };
    const auto depth = make(VK_FORMAT_R32_SFLOAT, extent), shadow = make(VK_FORMAT_R32_SFLOAT, extent);
    const auto normal = make(VK_FORMAT_R32G32B32A32_SFLOAT, extent);
    const auto map = make(VK_FORMAT_R32_SFLOAT, {512, 512});
    scene::SceneImages images;
    images.depth = depth.image();
    images.shadow = shadow.image();
    images.normal = normal.image();
    ASSERT_TRUE(source->has_sun_map());
    run_commands([&](VkCommandBuffer commands) {
        expect_done(source->record(commands, 24.0, {}, images, 0), "record");
        expect_done(source->record_sun_map(commands, 24.0, map.image(), 0), "record_sun_map");
    });
    const Frame frame = source->frame_facts(24.0, extent);
    ASSERT_EQ(frame.lights.size(), 1u);
    EXPECT_EQ(frame.colliders.size(), smoke_columns().primitives.size());
    const FloatImage depths = read_back(depth), shadows = read_back(shadow), seen = read_back(map);
    const FloatImage normals = read_back(normal);
    const auto transform = [](const Matrix4& m, std::array<double, 4> v) {
        std::array<double, 4> r{};
        for (size_t row = 0; row < 4; ++row)
            for (size_t column = 0; column < 4; ++column)
                r[row] += double{m[column * 4 + row]} * v[column];
        return r;
    };
    const Camera& camera = *frame.camera;
    size_t agree = 0, compared = 0, lit = 0;
    for (uint32_t y = 0; y < extent.height; ++y)
        for (uint32_t x = 0; x < extent.width; ++x) {
            const double z = double{*depths.at(x, y)};
            if (z > 12.0)
                continue;
            // Back to the world; the rotation's transpose.
            const double px = ((x + 0.5) / extent.width * 2.0 - 1.0) * z / double{camera.projection[0]};
            const double py = ((y + 0.5) / extent.height * 2.0 - 1.0) * z / double{camera.projection[5]};
            const Matrix4& v = camera.world_to_view;
            const std::array<double, 3> p = {px - double{v[12]}, py - double{v[13]}, -z - double{v[14]}};
            std::array<double, 4> world = {0, 0, 0, 1}, facing = {0, 0, 0, 0};
            for (size_t c = 0; c < 3; ++c)
                for (size_t r = 0; r < 3; ++r) {
                    world[c] += double{v[c * 4 + r]} * p[r];
                    facing[c] += double{v[c * 4 + r]} * double{normals.at(x, y)[r]};
                }
            double cosine = 0.0;
            for (size_t c = 0; c < 3; ++c)
                cosine += facing[c] * double{frame.lights[0].to_light[c]};
            const auto place = transform(frame.lights[0].world_to_shadow, world);
            const double u = place[0] * 0.5 + 0.5, w = place[1] * 0.5 + 0.5;
            if (u < 0.0 || u >= 1.0 || w < 0.0 || w >= 1.0 || cosine < 0.1)
                continue;
            const float nearest = *seen.at(static_cast<uint32_t>(u * 512), static_cast<uint32_t>(w * 512));
            const bool is_lit = place[2] < double{nearest} + 0.003;
            ++compared;
            lit += is_lit;
            agree += is_lit == (*shadows.at(x, y) > 0.5f);
        }
    EXPECT_GT(compared, 2000u);
    EXPECT_TRUE(lit > compared / 10 && lit < compared * 95 / 100) << lit << " of " << compared;
    EXPECT_GT(agree, compared * 97 / 100) << "of " << compared;
}

} // namespace
} // namespace sfumato::test
