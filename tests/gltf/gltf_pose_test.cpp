// Poses of glTF models against values worked out by hand.
#include "tests/gltf/gltf_builder.h"

#include <cmath>
#include <numbers>

namespace sfumato::scene {
namespace {

using Point = std::array<double, 3>;

Point moved(const Transform& m, const Point& p) {
    Point result{};
    for (size_t row = 0; row < 3; ++row)
        result[row] = m[row] * p[0] + m[4 + row] * p[1] + m[8 + row] * p[2] + m[12 + row];
    return result;
}

void expect_near(const Point& a, const Point& b, double tolerance = 1e-12) {
    for (size_t k = 0; k < 3; ++k)
        EXPECT_NEAR(a[k], b[k], tolerance) << k;
}

template <class T>
void expect_near_float(const T& a, const Point& b, double tolerance = 1e-6) {
    expect_near({static_cast<double>(a[0]), static_cast<double>(a[1]), static_cast<double>(a[2])}, b, tolerance);
}

// One triangle (0,0,0) (1,0,0) (0,1,0) at one node.
Model triangle_model() {
    Model model;
    model.materials = {{}};
    model.nodes = {{.mesh = 0}};
    MeshPart part;
    for (const auto& p : {std::array<float, 3>{0, 0, 0}, {1, 0, 0}, {0, 1, 0}})
        part.vertices.push_back({.position = p, .normal = {0, 0, 1}});
    part.indices = {0, 1, 2};
    model.meshes = {{.parts = {part}}};
    return model;
}

Model with_channel(AnimatedProperty property, Interpolation interpolation, std::vector<float> times,
                   std::vector<float> values, uint32_t components) {
    Model model = triangle_model();
    const double duration = static_cast<double>(times.back());
    model.animations = {
        {"", duration, {{0, property, interpolation, std::move(times), std::move(values), components}}}};
    return model;
}

TEST(GltfPose, nodes_stand_on_their_parents) {
    Model model = triangle_model();
    const double root = std::sqrt(0.5);
    model.nodes = {{.translation = {1, 2, 3}, .rotation = {0, 0, root, root}, .scale = {2, 2, 2}},
                   {.parent = 0, .translation = {1, 0, 0}, .scale = {1, 3, 1}, .mesh = 0},
                   {.parent = 1, .matrix = Transform{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 1, 0, 1}}};
    const ModelPose pose = pose_model(model, none, 5.0);
    // (1, 1, 1), scaled to (1, 3, 1), shifted to (2, 3, 1), doubled, turned by 90 degrees about z, shifted.
    expect_near(moved(pose.nodes[1], {1, 1, 1}), {1 - 6, 2 + 4, 3 + 2});
    expect_near(moved(pose.nodes[2], {1, 0, 1}), {1 - 6, 2 + 4, 3 + 2});
    const TriangleMesh mesh = pose_triangles(model, pose);
    expect_near_float(mesh.positions[1], {1, 2 + 4, 3});
    ASSERT_EQ(mesh.sources.size(), 1u);
    EXPECT_EQ(mesh.sources[0].node, 1u);
}

TEST(GltfPose, steps_lines_and_wrapping) {
    const std::vector<float> times = {1, 2, 4}, values = {0, 0, 0, 10, 0, 0, 30, 4, 0};
    const Model linear = with_channel(AnimatedProperty::translation, Interpolation::linear, times, values, 3);
    const Model step = with_channel(AnimatedProperty::translation, Interpolation::step, times, values, 3);
    const auto x = [](const Model& model, double seconds) { return pose_model(model, 0, seconds).nodes[0][12]; };
    EXPECT_EQ(x(linear, 0.5), 0.0); // before the first key
    EXPECT_NEAR(x(linear, 1.25), 2.5, 1e-12);
    EXPECT_NEAR(x(linear, 3.0), 20.0, 1e-12);
    EXPECT_NEAR(x(linear, 3.0 + 4.0), 20.0, 1e-12);
    EXPECT_NEAR(x(linear, 3.0 - 8.0), 20.0, 1e-12);
    EXPECT_EQ(x(linear, 4.0), 0.0);
    EXPECT_EQ(x(step, 1.999), 0.0);
    EXPECT_EQ(x(step, 2.0), 10.0);
    EXPECT_EQ(x(step, 3.999), 10.0);
    EXPECT_EQ(pose_model(linear, none, 3.0).nodes[0][12], 0.0);
    EXPECT_TRUE(std::isfinite(x(linear, std::nan(""))));
    EXPECT_TRUE(std::isfinite(x(linear, 1e300)));
    // Two keys at one time, and one key alone.
    EXPECT_EQ(
        x(with_channel(AnimatedProperty::translation, Interpolation::linear, {1, 1, 2}, {5, 0, 0, 7, 0, 0, 9, 0, 0}, 3),
          1.0),
        7.0);
    EXPECT_EQ(x(with_channel(AnimatedProperty::translation, Interpolation::linear, {0}, {5, 0, 0}, 3), 1.0), 5.0);
}

TEST(GltfPose, rotations_take_the_shorter_way_at_even_speed) {
    const float root = std::sqrt(0.5f);
    for (const float sign : {1.0f, -1.0f}) { // the same turn
        const Model model = with_channel(AnimatedProperty::rotation, Interpolation::linear, {0, 3},
                                         {0, 0, 0, 1, 0, 0, sign * root, sign * root}, 4);
        for (const double seconds : {0.0, 1.0, 2.0, 2.999}) {
            const double angle = seconds / 3.0 * std::numbers::pi / 2.0;
            expect_near(moved(pose_model(model, 0, seconds).nodes[0], {1, 0, 0}), {std::cos(angle), std::sin(angle), 0},
                        1e-7);
        }
    }
    // Keys that hardly differ, and zero ones.
    const Model still =
        with_channel(AnimatedProperty::rotation, Interpolation::linear, {0, 1}, {0, 0, 0, 1, 0, 0, 1e-9f, 1}, 4);
    expect_near(moved(pose_model(still, 0, 0.5).nodes[0], {1, 0, 0}), {1, 0, 0}, 1e-8);
    const Model zero =
        with_channel(AnimatedProperty::rotation, Interpolation::linear, {0, 1}, {0, 0, 0, 0, 0, 0, 0, 0}, 4);
    expect_near(moved(pose_model(zero, 0, 0.5).nodes[0], {1, 0, 0}), {1, 0, 0});
}

TEST(GltfPose, cubic_splines_have_their_values_and_tangents) {
    // Values 1 and 5, tangents 3 away from the first and -2 into the second, 2 s between: Hermite.
    const Model model = with_channel(AnimatedProperty::scale, Interpolation::cubic, {0, 2},
                                     {9, 9, 9, 1, 1, 1, 3, 3, 3, -2, -2, -2, 5, 5, 5, 9, 9, 9}, 3);
    const auto size = [&](double seconds) { return pose_model(model, 0, seconds).nodes[0][0]; };
    EXPECT_NEAR(size(0.0), 1.0, 1e-12);
    EXPECT_NEAR(size(1.0), 3.0 + 2.0 * (3.0 + 2.0) / 8.0, 1e-12);
    EXPECT_NEAR(size(2.0 - 1e-9), 5.0, 1e-7);
    const double h = 1e-5;
    EXPECT_NEAR((size(h) - size(0.0)) / h, 3.0, 1e-3);
    EXPECT_NEAR((size(2.0 - h) - size(2.0 - 2.0 * h)) / h, -2.0, 1e-3);
}

TEST(GltfPose, morph_targets_add_up) {
    Model model = triangle_model();
    MeshPart& part = model.meshes[0].parts[0];
    part.targets = {{{{0, 0, 1}, {0, 0, 2}, {0, 0, 3}}, {}}, {{{1, 0, 0}, {0, 0, 0}, {0, 0, 0}}, {{1, 0, 0}, {}, {}}}};
    model.meshes[0].weights = {0.5f, 0.0f};
    const auto position = [&](uint32_t animation, double seconds, size_t vertex) {
        return pose_triangles(model, pose_model(model, animation, seconds)).positions[vertex];
    };
    expect_near_float(position(none, 0, 2), {0, 1, 1.5});
    model.nodes[0].weights = {1.0f, 2.0f}; // in place of the mesh's
    expect_near_float(position(none, 0, 0), {2, 0, 1});
    model.animations = {{"", 1.0, {{0, AnimatedProperty::weights, Interpolation::linear, {0, 1}, {0, 0, 1, 1}, 2}}}};
    expect_near_float(position(0, 0.25, 0), {0.25, 0, 0.25});
    const auto mesh = pose_triangles(model, pose_model(model, 0, 0.5));
    expect_near_float(mesh.normals[0], {0.5 / std::sqrt(1.25), 0, 1 / std::sqrt(1.25)});
}

TEST(GltfPose, normals_keep_upright_under_uneven_scale_and_mirrors) {
    Model model = triangle_model();
    const float root = std::sqrt(0.5f);
    for (Vertex& vertex : model.meshes[0].parts[0].vertices)
        vertex.normal = {root, root, 0};
    model.nodes[0].scale = {2, 1, 1}; // a slope of 45 degrees becomes flatter: its normal steeper
    auto mesh = pose_triangles(model, pose_model(model, none, 0));
    expect_near_float(mesh.normals[0], {1 / std::sqrt(5.0), 2 / std::sqrt(5.0), 0});
    EXPECT_EQ(mesh.indices, (std::vector<uint32_t>{0, 1, 2}));
    model.nodes[0].scale = {-2, 1, 1};
    mesh = pose_triangles(model, pose_model(model, none, 0));
    expect_near_float(mesh.normals[0], {-1 / std::sqrt(5.0), 2 / std::sqrt(5.0), 0});
    EXPECT_EQ(mesh.indices, (std::vector<uint32_t>{0, 2, 1})); // still counter-clockwise in front
    model.nodes[0].scale = {1, 0, 1};                          // flattened: the normal is that of the plane
    mesh = pose_triangles(model, pose_model(model, none, 0));
    expect_near_float(mesh.normals[0], {0, 1, 0});
    model.nodes[0].scale = {0, 0, 0};
    expect_near_float(pose_triangles(model, pose_model(model, none, 0)).normals[0], {0, 0, 0});
}

TEST(GltfPose, skins_blend_their_joints) {
    Model model = triangle_model();
    model.nodes = {{.translation = {50, 0, 0}, .mesh = 0, .skin = 0}, // the node's own place does not count
                   {.translation = {0, 4, 0}},
                   {.parent = 1, .translation = {0, 0, 2}, .scale = {2, 2, 2}}};
    // The second joint was bound at (0, 0, 1).
    model.skins = {
        {{1, 2},
         {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -1, 1}}}};
    auto& vertices = model.meshes[0].parts[0].vertices;
    vertices[0].weights = {1, 0, 0, 0};
    vertices[1].joints = {1, 0, 0, 0};
    vertices[1].weights = {1, 0, 0, 0};
    vertices[2].joints = {0, 1, 0, 0};
    vertices[2].weights = {0.25f, 0.75f, 0, 0};
    const TriangleMesh mesh = pose_triangles(model, pose_model(model, none, 0));
    expect_near_float(mesh.positions[0], {0, 4, 0});
    expect_near_float(mesh.positions[1], {2, 4, 0});
    expect_near_float(mesh.positions[2], {0, 0.25 * 5 + 0.75 * 6, 0});
    expect_near_float(mesh.normals[2], {0, 0, 1});
}

// Between keys a vertex moves smoothly: what it does from t - h to t and from t to t + h agrees to the second order,
// and the order of vertices never changes. The skeleton is the fox's.
TEST(GltfPose, a_running_fox_moves_smoothly) {
    const auto path = test::sample_model("Fox.glb");
    if (path.empty())
        GTEST_SKIP() << "there is no ../shared/data/gltf/Fox.glb beside this checkout";
    const auto model = load_model(path);
    ASSERT_TRUE(model);
    const double t = 0.43, h = 2e-4;
    const auto at = [&](double seconds) { return pose_triangles(*model, pose_model(*model, 2, seconds)); };
    const TriangleMesh before = at(t - h), now = at(t), after = at(t + h), half = at(t + h / 2);
    double fastest = 0.0;
    for (size_t i = 0; i < now.positions.size(); ++i) {
        double bend = 0.0, speed = 0.0, error = 0.0;
        for (size_t k = 0; k < 3; ++k) {
            const auto x = [&](const TriangleMesh& mesh) { return static_cast<double>(mesh.positions[i][k]); };
            bend += std::pow(x(after) - 2.0 * x(now) + x(before), 2.0);
            speed += std::pow((x(after) - x(before)) / (2.0 * h), 2.0);
            error += std::pow((x(half) - x(now)) * 2.0 - (x(after) - x(now)), 2.0);
        }
        EXPECT_LT(std::sqrt(bend), 2e-4) << i; // float positions of up to 90 units
        EXPECT_LT(std::sqrt(error), 2e-4) << i;
        fastest = std::max(fastest, std::sqrt(speed));
    }
    EXPECT_EQ(now.indices, after.indices);
    EXPECT_GT(fastest, 100.0); // units a second, of a fox of 80
    EXPECT_LT(fastest, 3000.0);
    // The animation closes: its end is its start.
    const TriangleMesh start = at(0.0), end = at(model->animations[2].duration - 1e-6);
    for (size_t i = 0; i < start.positions.size(); ++i)
        for (size_t k = 0; k < 3; ++k)
            EXPECT_NEAR(start.positions[i][k], end.positions[i][k], 2.0f);
}

} // namespace
} // namespace sfumato::scene
