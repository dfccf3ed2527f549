// Models in code and ray casting for the tests of drawn meshes.
#include "tests/gpu/mesh_support.h"

#include "scene/vec3.h"

#include <cmath>
#include <limits>

namespace sfumato::scene {
namespace {

using Float3 = std::array<float, 3>;

void add_quad(MeshPart& part, Float3 corner, Float3 right, Float3 up, Float3 normal) {
    const auto first = static_cast<uint32_t>(part.vertices.size());
    for (const auto& [u, v] : {std::pair{0.0f, 0.0f}, {1.0f, 0.0f}, {1.0f, 1.0f}, {0.0f, 1.0f}}) {
        Vertex vertex;
        for (size_t i = 0; i < 3; ++i)
            vertex.position[i] = corner[i] + u * right[i] + v * up[i];
        vertex.normal = normal;
        vertex.texcoord = {u, 1.0f - v};
        part.vertices.push_back(vertex);
    }
    for (const uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u})
        part.indices.push_back(first + i);
}

Model model_of(MeshPart part, const ModelMaterial& material, const char* name) {
    Model model;
    model.name = name;
    model.materials = {material};
    model.meshes.push_back({name, {std::move(part)}, {}});
    Node node;
    node.mesh = 0;
    model.nodes.push_back(node);
    return model;
}

} // namespace

ModelMaterial matt(float r, float g, float b) {
    ModelMaterial material;
    material.base_colour = {r, g, b, 1.0f};
    material.metallic = 0.0f;
    material.roughness = 1.0f;
    return material;
}

Model box_model(const ModelMaterial& material) {
    constexpr float h = 0.5f;
    MeshPart part;
    add_quad(part, {-h, -h, h}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1});
    add_quad(part, {h, -h, -h}, {-1, 0, 0}, {0, 1, 0}, {0, 0, -1});
    add_quad(part, {h, -h, h}, {0, 0, -1}, {0, 1, 0}, {1, 0, 0});
    add_quad(part, {-h, -h, -h}, {0, 0, 1}, {0, 1, 0}, {-1, 0, 0});
    add_quad(part, {-h, h, h}, {1, 0, 0}, {0, 0, -1}, {0, 1, 0});
    add_quad(part, {-h, -h, -h}, {1, 0, 0}, {0, 0, 1}, {0, -1, 0});
    return model_of(std::move(part), material, "box");
}

Model square_model(const ModelMaterial& material) {
    MeshPart part;
    add_quad(part, {-0.5f, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1});
    return model_of(std::move(part), material, "square");
}

Model ribbon_model() {
    constexpr int rows = 9;
    MeshPart part;
    MorphTarget target;
    for (int row = 0; row < rows; ++row)
        for (int side = 0; side < 2; ++side) {
            const float y = 0.25f * static_cast<float>(row);
            Vertex vertex;
            vertex.position = {side == 0 ? -0.3f : 0.3f, y, 0.05f * y * y};
            vertex.normal = {0, 0, 1};
            const float bent = std::min(std::max(y - 0.5f, 0.0f), 1.0f);
            vertex.joints = {0, 1, 0, 0};
            vertex.weights = {1.0f - bent, bent, 0, 0};
            part.vertices.push_back(vertex);
            target.positions.push_back({row > 5 ? 0.25f : 0.0f, 0, row > 5 ? 0.2f : 0.0f});
        }
    for (uint32_t row = 0; row + 1 < rows; ++row)
        for (const uint32_t i : {0u, 1u, 3u, 0u, 3u, 2u})
            part.indices.push_back(2 * row + i);
    part.targets.push_back(target);
    ModelMaterial material = matt();
    material.double_sided = true;
    Model model = model_of(std::move(part), material, "ribbon");
    model.meshes[0].weights = {0.0f};
    model.nodes[0].skin = 0;
    Node root, tip;
    tip.parent = 1;
    tip.translation = {0, 1, 0};
    model.nodes.push_back(root);
    model.nodes.push_back(tip);
    Transform identity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    Transform down = identity;
    down[13] = -1.0;
    model.skins.push_back({{1, 2}, {identity, down}});
    const float s = std::sin(0.35f), c = std::cos(0.35f);
    Channel turn{2, AnimatedProperty::rotation, Interpolation::linear, {0, 1}, {0, 0, -s, c, 0, 0, s, c}, 4};
    Channel morph{0, AnimatedProperty::weights, Interpolation::linear, {0, 1}, {0, 1}, 1};
    model.animations.push_back({"bend", 1.0, {turn, morph}});
    return model;
}

RenderOptions quick(int samples, int sub_frames) {
    RenderOptions options;
    options.samples = samples;
    options.shutter.sub_frames = sub_frames;
    return options;
}

MeshRig::MeshRig(Model model, const GltfOptions& options) {
    ContextInfo info = test::device().context_info();
    info.poison = 0x7a;
    context_ = test::expect_value(Context::create(info), "Context::create");
    source_ = test::expect_value(make_source(*context_, info, test::device().queue_flags(), std::move(model), options),
                                 "make_source");
}

void MeshRig::run(double frame, const RenderOptions& options, const SceneImages& images) {
    test::run_commands([&](VkCommandBuffer commands) {
        test::expect_done(source_->record(commands, frame, options, images, index_++), "record");
    });
}

MeshImages MeshRig::render(double frame, Extent extent, const RenderOptions& options, bool with_truth) {
    const auto make = [&](VkFormat format) {
        return test::expect_value(test::device().create_image(format, extent), "image");
    };
    constexpr auto four = VK_FORMAT_R32G32B32A32_SFLOAT, two = VK_FORMAT_R32G32_SFLOAT, one = VK_FORMAT_R32_SFLOAT;
    const apps::HostImage colour = make(four), direct = make(four), ambient = make(four), depth = make(one),
                          normal = make(four), velocity = make(two), next = make(two), shadow = make(one),
                          truth_image = with_truth ? make(four) : apps::HostImage{};
    run(frame, options,
        {colour.image(), direct.image(), ambient.image(), depth.image(), normal.image(), velocity.image(), next.image(),
         shadow.image(), truth_image.image()});
    return {test::read_back(colour),
            test::read_back(direct),
            test::read_back(ambient),
            test::read_back(depth),
            test::read_back(normal),
            test::read_back(velocity),
            test::read_back(next),
            test::read_back(shadow),
            with_truth ? test::read_back(truth_image) : test::FloatImage{}};
}

test::FloatImage MeshRig::truth(double frame, Extent extent, const RenderOptions& options) {
    const auto image = test::expect_value(test::device().create_image(VK_FORMAT_R32G32B32A32_SFLOAT, extent), "image");
    SceneImages images;
    images.truth = image.image();
    run(frame, options, images);
    return test::read_back(image);
}

test::FloatImage MeshRig::colour(double frame, Extent extent, const RenderOptions& options) {
    const auto image = test::expect_value(test::device().create_image(VK_FORMAT_R32G32B32A32_SFLOAT, extent), "image");
    SceneImages images;
    images.colour = image.image();
    run(frame, options, images);
    return test::read_back(image);
}

namespace {

Vec3 vec3_of(const Float3& v) {
    return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
}

double element(const Matrix4& m, size_t row, size_t column) {
    return static_cast<double>(m[column * 4 + row]);
}

} // namespace

Vec3 to_view(const Camera& camera, Vec3 v, double w) {
    const auto row = [&](size_t r) {
        return element(camera.world_to_view, r, 0) * v.x + element(camera.world_to_view, r, 1) * v.y +
               element(camera.world_to_view, r, 2) * v.z + element(camera.world_to_view, r, 3) * w;
    };
    return {row(0), row(1), row(2)};
}

std::array<double, 2> pixel_of(const Camera& camera, Extent extent, Vec3 world) {
    const Vec3 v = to_view(camera, world, 1.0);
    const Matrix4& p = camera.projection;
    const double w = element(p, 3, 2) * v.z + element(p, 3, 3);
    const double x = (element(p, 0, 0) * v.x + element(p, 0, 2) * v.z + element(p, 0, 3)) / w;
    const double y = (element(p, 1, 1) * v.y + element(p, 1, 2) * v.z + element(p, 1, 3)) / w;
    return {(x + 1.0) * 0.5 * extent.width, (y + 1.0) * 0.5 * extent.height};
}

TriangleHit cast(const TriangleMesh& mesh, const Camera& camera, Extent extent, uint32_t x, uint32_t y) {
    const Matrix4& p = camera.projection;
    const double px = (x + 0.5) / extent.width * 2.0 - 1.0, py = (y + 0.5) / extent.height * 2.0 - 1.0;
    const bool orthographic = p[15] != 0.0f;
    // In view space: through the eye, or along -Z.
    Vec3 origin = {}, direction = {0, 0, -1};
    if (orthographic) {
        origin = {(px - element(p, 0, 3)) / element(p, 0, 0), (py - element(p, 1, 3)) / element(p, 1, 1), 0};
    } else {
        direction = {(px + element(p, 0, 2)) / element(p, 0, 0), (py + element(p, 1, 2)) / element(p, 1, 1), -1};
    }
    TriangleHit best;
    best.depth = std::numeric_limits<double>::max();
    double margin = 1.0;
    for (uint32_t t = 0; 3 * t < mesh.indices.size(); ++t) {
        Vec3 corners[3];
        for (size_t k = 0; k < 3; ++k)
            corners[k] = to_view(camera, vec3_of(mesh.positions[mesh.indices[3 * t + k]]), 1.0);
        const Vec3 a = corners[1] - corners[0], b = corners[2] - corners[0], q = cross(direction, b);
        const double determinant = dot(a, q);
        if (std::abs(determinant) < 1e-12)
            continue;
        const Vec3 s = origin - corners[0], r = cross(s, a);
        const double u = dot(s, q) / determinant, v = dot(direction, r) / determinant;
        const double depth = dot(b, r) / determinant;
        const double inside = std::min({u, v, 1.0 - u - v});
        if (depth > 1e-3)
            margin = std::min(margin, std::abs(inside));
        if (inside >= 0.0 && depth > 1e-3 && depth < best.depth)
            best = {t, depth, {1.0 - u - v, u, v}, 1.0};
    }
    best.margin = margin;
    return best;
}

Vec3 point_of(const TriangleMesh& mesh, const TriangleHit& hit) {
    Vec3 point;
    for (size_t k = 0; k < 3; ++k)
        point = point + vec3_of(mesh.positions[mesh.indices[3 * hit.triangle + k]]) * hit.weights[k];
    return point;
}

CameraPath looking(Vec3 eye, Vec3 target, double view_angle, Vec3 eye_velocity) {
    return [=](double frame) {
        View view;
        view.eye = eye + eye_velocity * frame;
        view.forward = target - view.eye;
        view.view_angle = view_angle;
        return view;
    };
}

} // namespace sfumato::scene
