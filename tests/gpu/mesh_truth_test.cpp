// The meshes' ray-traced truth against the analytic one: the same scenes, their primitives cut into triangles.
#include "scene/gltf/mesh_truth.h"
#include "scene/vec3.h"
#include "tests/gpu/gpu_test.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sfumato::scene {
namespace {

using test::FloatImage;
using test::GpuTest;

// A model of one opaque material, and its triangles, grown primitive by primitive.
struct Tessellation {
    Model model;
    TriangleMesh mesh;
    Pose pose = {};

    Tessellation() {
        model.materials = {{.double_sided = true}};
        model.nodes = {{.mesh = 0}};
        model.meshes = {{.parts = {{}}}};
    }

    uint32_t add(Vec3 p, Vec3 n) {
        const auto turned = [&](Vec3 v, double shift) {
            std::array<float, 3> result;
            for (size_t row = 0; row < 3; ++row)
                result[row] = static_cast<float>(pose[row * 4] * v.x + pose[row * 4 + 1] * v.y +
                                                 pose[row * 4 + 2] * v.z + shift * pose[row * 4 + 3]);
            return result;
        };
        mesh.positions.push_back(turned(p, 1.0));
        mesh.normals.push_back(turned(n, 0.0));
        mesh.texcoords.push_back({});
        mesh.opacities.push_back(1.0f);
        return static_cast<uint32_t>(mesh.positions.size() - 1);
    }

    void triangle(uint32_t a, uint32_t b, uint32_t c) {
        mesh.sources.push_back({0, 0, static_cast<uint32_t>(mesh.sources.size())});
        mesh.indices.insert(mesh.indices.end(), {a, b, c});
    }

    // A grid of (columns + 1) × (rows + 1) vertices.
    template <class Surface>
    void grid(uint32_t columns, uint32_t rows, Surface surface) {
        const auto first = static_cast<uint32_t>(mesh.positions.size());
        for (uint32_t j = 0; j <= rows; ++j)
            for (uint32_t i = 0; i <= columns; ++i) {
                const auto [p, n] = surface(static_cast<double>(i) / columns, static_cast<double>(j) / rows);
                add(p, n);
            }
        for (uint32_t j = 0; j < rows; ++j)
            for (uint32_t i = 0; i < columns; ++i) {
                const uint32_t a = first + j * (columns + 1) + i, c = a + columns + 1;
                triangle(a, a + 1, c);
                triangle(a + 1, c + 1, c);
            }
    }

    void disc(double radius, double height, double up) {
        grid(96, 1, [&](double i, double j) {
            const double angle = 2.0 * std::numbers::pi * i;
            return std::pair{Vec3{radius * j * std::cos(angle), height, radius * j * std::sin(angle)}, Vec3{0, up, 0}};
        });
    }

    void add(const Primitive& primitive, double time) {
        pose = pose_at(primitive.motion, time);
        const Vec3 s = primitive.size;
        switch (primitive.shape) {
        case Shape::sphere:
            return grid(128, 64, [&](double i, double j) {
                const double around = 2.0 * std::numbers::pi * i, down = std::numbers::pi * j;
                const Vec3 n = {std::sin(down) * std::cos(around), std::cos(down), std::sin(down) * std::sin(around)};
                return std::pair{n * s.x, n};
            });
        case Shape::box:
            for (int face = 0; face < 6; ++face)
                grid(1, 1, [&](double i, double j) {
                    const double side = face < 3 ? 1.0 : -1.0, a = 2.0 * i - 1.0, b = 2.0 * j - 1.0;
                    const Vec3 p = face % 3 == 0   ? Vec3{side, a, b}
                                   : face % 3 == 1 ? Vec3{a, side, b}
                                                   : Vec3{a, b, side};
                    const Vec3 n = {face % 3 == 0 ? side : 0.0, face % 3 == 1 ? side : 0.0, face % 3 == 2 ? side : 0.0};
                    return std::pair{Vec3{p.x * s.x, p.y * s.y, p.z * s.z}, n};
                });
            return;
        case Shape::cylinder:
            grid(96, 1, [&](double i, double j) {
                const double angle = 2.0 * std::numbers::pi * i;
                const Vec3 n = {std::cos(angle), 0.0, std::sin(angle)};
                return std::pair{n * s.x + Vec3{0, s.y * (2.0 * j - 1.0), 0}, n};
            });
            disc(s.x, s.y, 1.0);
            return disc(s.x, -s.y, -1.0);
        case Shape::plane:
            return grid(40, 40, [](double i, double j) {
                return std::pair{Vec3{200.0 * i - 100.0, 0.0, 200.0 * j - 100.0}, Vec3{0, 1, 0}};
            });
        case Shape::disc:
            return disc(s.x, 0.0, 1.0);
        }
    }
};

struct Analytic {
    FloatImage visibility, bent_normal, depth, normal;
};

class MeshTruthTest : public GpuTest {
  protected:
    void SetUp() override {
        GpuTest::SetUp();
        context_ = test::make_context(0x7a);
        renderer_ = test::expect_value(SceneRenderer::create(*context_), "renderer");
    }

    Analytic trace(const Scene& scene, Extent extent, const OcclusionTruth& occlusion) {
        const auto make = [&](VkFormat format) {
            return test::expect_value(test::device().create_image(format, extent), "image");
        };
        const apps::HostImage visibility = make(VK_FORMAT_R32_SFLOAT), depth = make(VK_FORMAT_R32_SFLOAT);
        const apps::HostImage bent = make(VK_FORMAT_R32G32B32A32_SFLOAT), normal = make(VK_FORMAT_R32G32B32A32_SFLOAT);
        SceneImages images;
        images.depth = depth.image();
        images.normal = normal.image();
        images.true_visibility = visibility.image();
        images.true_bent_normal = bent.image();
        RenderOptions options;
        options.occlusion = occlusion;
        test::run_commands([&](VkCommandBuffer commands) {
            test::expect_done(renderer_->record(commands, scene, scene.info.key_frame, options, images, index_++),
                              "record");
        });
        return {test::read_back(visibility), test::read_back(bent), test::read_back(depth), test::read_back(normal)};
    }

  private:
    std::unique_ptr<Context> context_;
    std::unique_ptr<SceneRenderer> renderer_;
    uint64_t index_ = 0;
};

double at(const FloatImage& image, size_t index) {
    return static_cast<double>(image.values[index]);
}

// Pixels at which both see the same surface; outlines and edges may fall to either side.
std::vector<size_t> same_surface(const Analytic& analytic, const MeshTruth& mesh) {
    std::vector<size_t> result;
    for (size_t i = 0; i < mesh.depth.size(); ++i) {
        const double depth = at(analytic.depth, i), other = static_cast<double>(mesh.depth[i]);
        double cosine = 0.0;
        for (size_t k = 0; k < 3; ++k)
            cosine += at(analytic.normal, i * 4 + k) * static_cast<double>(mesh.normal[i][k]);
        if (depth < 50.0 && std::abs(depth - other) < 0.002 * depth && cosine > 0.999)
            result.push_back(i);
    }
    return result;
}

double rms(const Analytic& analytic, const MeshTruth& mesh, const std::vector<size_t>& pixels) {
    double sum = 0.0;
    for (const size_t i : pixels)
        sum += std::pow(at(analytic.visibility, i) - static_cast<double>(mesh.visibility[i]), 2.0);
    return std::sqrt(sum / static_cast<double>(pixels.size()));
}

double bias(const Analytic& analytic, const MeshTruth& mesh, const std::vector<size_t>& pixels) {
    double sum = 0.0;
    for (const size_t i : pixels)
        sum += static_cast<double>(mesh.visibility[i]) - at(analytic.visibility, i);
    return sum / static_cast<double>(pixels.size());
}

TEST_F(MeshTruthTest, is_the_analytic_truth_of_tessellated_scenes) {
    const Extent extent{96, 54};
    for (const char* name : {"contact", "columns"})
        for (const Falloff kind : {Falloff::hard, Falloff::quadratic})
            for (const double orthographic_height : {0.0, 3.0}) {
                SCOPED_TRACE(std::string(name) + " " + falloff_names()[static_cast<size_t>(kind)]);
                Scene scene = *find_scene(name);
                scene.camera.lens.orthographic_height = orthographic_height;
                scene.camera.lens.shift_x = 0.1;
                Tessellation parts;
                for (const Primitive& primitive : scene.primitives)
                    parts.add(primitive, 0.0);
                const OcclusionTruth options = {1.2, kind, 64, 3}, other_seed = {1.2, kind, 64, 4};
                const Camera view = camera(scene, scene.info.key_frame, extent);
                const Analytic analytic = trace(scene, extent, options);
                const MeshTruth same =
                    test::expect_value(trace_occlusion(parts.model, parts.mesh, view, extent, options), "mesh truth");
                const MeshTruth other = test::expect_value(
                    trace_occlusion(parts.model, parts.mesh, view, extent, other_seed), "mesh truth");
                const Analytic noise = trace(scene, extent, other_seed);
                const auto pixels = same_surface(analytic, same);
                size_t solid = 0;
                for (const float depth : analytic.depth.values)
                    solid += depth < 50.0f;
                EXPECT_GT(pixels.size(), solid * 97 / 100);
                // With other rays as far apart as two analytic truths with other rays; with the same rays much closer.
                MeshTruth noisy = same;
                noisy.visibility = noise.visibility.values;
                const double expected = rms(analytic, noisy, pixels);
                EXPECT_NEAR(rms(analytic, other, pixels), expected, 0.1 * expected);
                EXPECT_LT(rms(analytic, same, pixels), 0.3 * expected);
                EXPECT_LT(std::abs(bias(analytic, same, pixels)), 0.001);
                double bent = 0.0;
                for (const size_t i : pixels)
                    for (size_t k = 0; k < 3; ++k)
                        bent +=
                            std::abs(at(analytic.bent_normal, i * 4 + k) - static_cast<double>(same.bent_normal[i][k]));
                EXPECT_LT(bent / 3.0 / static_cast<double>(pixels.size()), 0.005);
            }
}

// A square of 2 m above a floor. Its material lets rays through or does not.
struct Awning {
    Tessellation parts;

    explicit Awning(const ModelMaterial& material) {
        parts.add({Shape::plane, {1, 1, 1}, 0, {}, true}, 0.0);
        parts.model.materials.push_back(material);
        parts.model.meshes[0].parts.push_back({.material = 1});
        const auto first = static_cast<uint32_t>(parts.mesh.sources.size());
        parts.pose = pose_at({}, 0.0);
        parts.grid(1, 1, [](double i, double j) {
            return std::pair{Vec3{2.0 * i - 1.0, 0.5, 2.0 * j - 1.0}, Vec3{0, 1, 0}};
        });
        for (uint32_t i = first; i < parts.mesh.sources.size(); ++i)
            parts.mesh.sources[i] = {0, 1, i - first};
        for (size_t i = parts.mesh.texcoords.size() - 4; i < parts.mesh.texcoords.size(); ++i) {
            const auto& position = parts.mesh.positions[i];
            parts.mesh.texcoords[i] = {position[0] * 0.5f + 0.5f, position[2] * 0.5f + 0.5f};
            parts.mesh.opacities[i] = material.base_colour[3];
        }
    }

    MeshTruth trace(const View& view, int rays = 256) {
        return test::expect_value(trace_occlusion(parts.model, parts.mesh, camera_of(view, {}, {9, 9}), {9, 9},
                                                  {2.0, Falloff::hard, rays, 0}),
                                  "mesh truth");
    }
};

constexpr size_t middle = 40;
const View from_below = {{0, 0.25, 0}, {0, -1, 0}, {0, 0, -1}, 20.0};
const View from_above = {{0, 3, 0}, {0, -1, 0}, {0, 0, -1}, 20.0};

TEST(MeshTruth, masks_let_rays_and_the_camera_through) {
    Texture left_half{4, 1, {0, 0, 0, 255, 0, 0, 0, 255, 0, 0, 0, 0, 0, 0, 0, 0}};
    left_half.repeats_u = left_half.repeats_v = false;
    const ModelMaterial opaque = {.double_sided = true};
    ModelMaterial clear = opaque, half = opaque;
    clear.alpha_mode = half.alpha_mode = AlphaMode::mask;
    clear.base_colour[3] = 0.4f; // below the cutoff of 0.5
    half.base_colour_texture = 0;
    const float blocked = Awning(opaque).trace(from_below).visibility[middle];
    EXPECT_LT(blocked, 0.35f);
    EXPECT_EQ(Awning(clear).trace(from_below).visibility[middle], 1.0f);
    clear.base_colour[3] = 0.6f;
    EXPECT_EQ(Awning(clear).trace(from_below).visibility[middle], blocked);
    Awning halved(half);
    halved.parts.model.textures.push_back(left_half);
    EXPECT_NEAR(halved.trace(from_below).visibility[middle], (1.0f + blocked) / 2.0f, 0.02f);
    // From above the camera sees the awning on the left and the floor on the right.
    const MeshTruth above = halved.trace(from_above);
    EXPECT_NEAR(above.depth[middle - 2], 2.5f, 1e-4f);
    EXPECT_NEAR(above.depth[middle + 2], 3.0f, 1e-4f);
}

TEST(MeshTruth, the_camera_does_not_see_backs_but_rays_meet_them) {
    ModelMaterial single; // its triangles face down or up, the camera stands on the other side once
    Awning awning(single);
    const View up = {{0, 0.25, 0}, {0, 1, 0}, {0, 0, -1}, 20.0};
    const bool seen_above = awning.trace(from_above).depth[middle] < 2.9f;
    const bool seen_below = awning.trace(up).depth[middle] < 1.0f;
    EXPECT_NE(seen_above, seen_below);
    EXPECT_LT(awning.trace(from_below).visibility[middle], 0.35f);
}

TEST(MeshTruth, same_arguments_same_bits_and_nonsense_refused) {
    Awning awning({.double_sided = true});
    const MeshTruth a = awning.trace(from_below, 33), b = awning.trace(from_below, 33);
    EXPECT_EQ(a.visibility, b.visibility);
    EXPECT_EQ(a.bent_normal, b.bent_normal);
    const Camera view = camera_of(from_below, {}, {9, 9});
    const auto message = [&](const Camera& camera, Extent extent, const OcclusionTruth& options) {
        const auto truth = trace_occlusion(awning.parts.model, awning.parts.mesh, camera, extent, options);
        return truth ? "" : truth.error().message;
    };
    EXPECT_NE(message(view, {0, 9}, {}), "");
    EXPECT_NE(message(view, {9, 9}, {1.5, Falloff::hard, 0, 0}), "");
    EXPECT_NE(message(view, {9, 9}, {-1.0, Falloff::hard, 1, 0}), "");
    Camera broken = view;
    broken.projection[0] = 0.0f;
    EXPECT_NE(message(broken, {9, 9}, {}), "");
    broken.projection[0] = std::nanf("");
    EXPECT_NE(message(broken, {9, 9}, {}), "");
    awning.parts.mesh = {};
    const MeshTruth nothing = awning.trace(from_below, 1);
    EXPECT_EQ(nothing.depth[middle], sky_depth);
    EXPECT_EQ(nothing.visibility[middle], 1.0f);
}

} // namespace
} // namespace sfumato::scene
