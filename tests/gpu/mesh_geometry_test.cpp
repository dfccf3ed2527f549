// Drawn meshes against rays cast at the same triangles: depth, normals, and velocities against the places of points in
// the previous and the next frame.
#include "tests/gpu/mesh_support.h"

#include "scene/vec3.h"

#include <cmath>

namespace sfumato::scene {
namespace {

class MeshGeometry : public test::GpuTest {};

struct Case {
    const char* name;
    Model model;
    CameraPath path;
    std::optional<Lens> lens;
    bool ground = false;
};

GltfOptions options_of(const Case& one) {
    GltfOptions options;
    options.ground = one.ground;
    options.lens = one.lens;
    return options;
}

double expected_depth(const Lens& lens, const Camera& camera, double depth) {
    if (lens.depth_kind == DepthKind::linear)
        return depth;
    const auto& p = camera.projection;
    const double z = static_cast<double>(p[14]) - static_cast<double>(p[10]) * depth;
    return p[15] != 0.0f ? z : z / depth;
}

// The source's own triangles but for the ground, which lies below them all.
TriangleMesh at_frame(const Model& model, double frame) {
    return pose_triangles(model, pose_model(model, 0, frame / 24.0));
}

void check(const Case& one, double frame, Extent extent) {
    SCOPED_TRACE(one.name);
    MeshRig rig(one.model, options_of(one));
    rig.source().set_camera(one.path);
    const MeshImages images = rig.render(frame, extent);
    const Camera now = rig.source().camera(frame, extent), before = rig.source().camera(frame - 1.0, extent),
                 after = rig.source().camera(frame + 1.0, extent);
    const TriangleMesh mesh = at_frame(one.model, frame), past = at_frame(one.model, frame - 1.0),
                       future = at_frame(one.model, frame + 1.0);
    size_t hits = 0, skies = 0;
    double fastest = 0.0;
    for (uint32_t y = 0; y < extent.height; ++y)
        for (uint32_t x = 0; x < extent.width; ++x) {
            const TriangleHit hit = cast(mesh, now, extent, x, y);
            if (hit.margin < 1e-3)
                continue; // on an edge
            SCOPED_TRACE(testing::Message() << "pixel " << x << ", " << y);
            const double depth = static_cast<double>(*images.depth.at(x, y));
            if (hit.triangle == none) {
                if (!one.ground) {
                    ASSERT_EQ(depth, rig.source().lens().depth_kind == DepthKind::linear
                                         ? static_cast<double>(sky_depth)
                                     : rig.source().lens().range == DepthRange::standard ? 1.0
                                                                                         : 0.0);
                    ASSERT_EQ(images.normal.at(x, y)[2], 0.0f);
                }
                ++skies;
                continue;
            }
            ++hits;
            const double wanted = expected_depth(rig.source().lens(), now, hit.depth);
            ASSERT_NEAR(depth, wanted, 2e-5 * wanted);
            Vec3 normal;
            for (size_t k = 0; k < 3; ++k) {
                const auto& n = mesh.normals[mesh.indices[3 * hit.triangle + k]];
                normal =
                    normal + Vec3{static_cast<double>(n[0]), static_cast<double>(n[1]), static_cast<double>(n[2])} *
                                 hit.weights[k];
            }
            const Vec3 seen = normalised(to_view(now, normal, 0.0));
            const float* n = images.normal.at(x, y);
            const Vec3 drawn = {static_cast<double>(n[0]), static_cast<double>(n[1]), static_cast<double>(n[2])};
            // Double-sided surfaces turn towards the camera.
            ASSERT_GT(std::abs(dot(seen, drawn)), 1.0 - 1e-4);
            const Vec3 ray = now.projection[15] != 0.0f ? Vec3{0, 0, -1} : to_view(now, point_of(mesh, hit), 1.0);
            ASSERT_LT(dot(drawn, ray), 1e-4);
            const auto here = pixel_of(now, extent, point_of(mesh, hit));
            const auto was = pixel_of(before, extent, point_of(past, hit));
            const auto will = pixel_of(after, extent, point_of(future, hit));
            for (size_t c = 0; c < 2; ++c) {
                ASSERT_NEAR(static_cast<double>(images.velocity.at(x, y)[c]), here[c] - was[c], 2e-3);
                ASSERT_NEAR(static_cast<double>(images.next_velocity.at(x, y)[c]), will[c] - here[c], 2e-3);
                fastest = std::max(fastest, std::abs(here[c] - was[c]));
            }
        }
    EXPECT_GT(hits, extent.width * extent.height / 20u);
    EXPECT_GT(skies, 0u);
    EXPECT_GT(fastest, 0.2) << "nothing moved";
}

Lens orthographic(DepthRange range, DepthKind kind) {
    Lens lens;
    lens.orthographic_height = 3.0;
    lens.range = range;
    lens.depth_kind = kind;
    lens.near_plane = 0.1;
    lens.far_plane = 20.0;
    return lens;
}

constexpr Extent small = {61, 37};

TEST_F(MeshGeometry, a_box_seen_by_a_moving_camera) {
    check({"box", box_model(matt()), looking({1.4, 1.1, 2.2}, {0, 0, 0}, 40, {0.08, 0, 0.05}), {}}, 3.0, small);
}

TEST_F(MeshGeometry, a_skinned_and_morphed_ribbon) {
    check({"still camera", ribbon_model(), looking({0.7, 1.2, 4}, {0.1, 1, 0}), {}}, 7.0, small);
    check({"moving camera", ribbon_model(), looking({0.7, 1.2, 4}, {0.1, 1, 0}, 35, {0.03, 0.05, -0.06}), {}}, 15.5,
          small);
    check({"from behind", ribbon_model(), looking({-0.7, 1.2, -4}, {0.1, 1, 0}), {}}, 7.0, small);
}

TEST_F(MeshGeometry, orthographic_and_device_depth) {
    const CameraPath path = looking({1.0, 1.4, 4}, {0.1, 1, 0}, 35, {0.06, 0, 0.02});
    check({"linear", ribbon_model(), path, orthographic(DepthRange::standard, DepthKind::linear)}, 7.0, small);
    check({"standard", ribbon_model(), path, orthographic(DepthRange::standard, DepthKind::device)}, 7.0, small);
    check({"reversed", ribbon_model(), path, orthographic(DepthRange::reversed, DepthKind::device)}, 7.0, small);
    Lens lens;
    lens.depth_kind = DepthKind::device;
    lens.shift_x = 0.1;
    lens.shift_y = -0.05;
    check({"reversed infinite, off-centre", ribbon_model(), path, lens}, 7.0, small);
    lens.range = DepthRange::standard;
    check({"standard perspective", ribbon_model(), path, lens}, 7.0, small);
}

TEST_F(MeshGeometry, mirrored_nodes_keep_their_outside) {
    Model model = box_model(matt());
    model.nodes[0].scale = {-1, 1.2, 0.8};
    check({"mirrored", model, looking({1.4, 1.1, 2.2}, {0, 0, 0}, 40, {0.08, 0, 0.05}), {}}, 3.0, small);
}

// What lies beyond the far plane is sky, as in the analytic scenes.
TEST_F(MeshGeometry, far_plane) {
    GltfOptions options;
    options.lens = Lens{};
    options.lens->range = DepthRange::reversed;
    options.lens->far_plane = 2.0;
    options.ground = false;
    MeshRig rig(square_model(matt()), options);
    rig.source().set_camera(looking({0, 0.5, 3}, {0, 0.5, 0}));
    EXPECT_EQ(*rig.render(0, {9, 9}).depth.at(4, 4), sky_depth);
    options.lens->far_plane = 4.0;
    MeshRig other(square_model(matt()), options);
    other.source().set_camera(looking({0, 0.5, 3}, {0, 0.5, 0}));
    EXPECT_NEAR(*other.render(0, {9, 9}).depth.at(4, 4), 3.0f, 1e-5f);
}

TEST_F(MeshGeometry, what_stands_still_has_no_velocity_at_all) {
    GltfOptions options;
    options.ground = true;
    MeshRig rig(box_model(matt()), options);
    const MeshImages images = rig.render(5.0, small);
    for (const float v : images.velocity.values)
        ASSERT_EQ(v, 0.0f);
    for (const float v : images.next_velocity.values)
        ASSERT_EQ(v, 0.0f);
}

// The sky is that of the analytic scenes, velocities included: the same camera, no primitives.
TEST_F(MeshGeometry, the_sky_is_that_of_the_analytic_scenes) {
    const CameraPath path = [](double frame) {
        View view = looking({0, 1, 6}, {0, 1.2, 0})(frame);
        view.forward.x += 0.05 * frame;
        return view;
    };
    GltfOptions options;
    options.ground = false;
    MeshRig rig(box_model(matt()), options);
    rig.source().set_camera(path);
    const MeshImages drawn = rig.render(2.0, small);
    Scene empty;
    empty.info.name = "empty";
    empty.camera_path = path;
    empty.camera.lens = rig.source().lens();
    const auto context = test::make_context();
    const auto other = test::expect_value(make_source(*context, empty), "make_source");
    const auto colour = test::expect_value(test::device().create_image(VK_FORMAT_R32G32B32A32_SFLOAT, small), "image");
    const auto velocity = test::expect_value(test::device().create_image(VK_FORMAT_R32G32_SFLOAT, small), "image");
    SceneImages images;
    images.colour = colour.image();
    images.velocity = velocity.image();
    test::run_commands([&](VkCommandBuffer commands) {
        test::expect_done(other->record(commands, 2.0, quick(), images, 0), "record");
    });
    const test::FloatImage sky = test::read_back(colour), motion = test::read_back(velocity);
    size_t compared = 0;
    for (uint32_t y = 0; y < small.height; ++y)
        for (uint32_t x = 0; x < small.width; ++x) {
            if (*drawn.depth.at(x, y) != sky_depth)
                continue;
            ++compared;
            for (size_t c = 0; c < 3; ++c)
                ASSERT_EQ(drawn.colour.at(x, y)[c], sky.at(x, y)[c]);
            ASSERT_EQ(drawn.velocity.at(x, y)[0], motion.at(x, y)[0]);
            ASSERT_GT(std::abs(motion.at(x, y)[0]), 0.1f);
        }
    EXPECT_GT(compared, 100u);
}

} // namespace
} // namespace sfumato::scene
