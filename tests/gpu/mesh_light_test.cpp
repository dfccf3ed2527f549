// Light, shadows, cut-outs, truth and odd requests of drawn meshes.
#include "tests/gpu/mesh_support.h"

#include "scene/vec3.h"

#include <algorithm>
#include <cmath>

namespace sfumato::scene {
namespace {

using test::FloatImage;

class MeshLight : public test::GpuTest {};

GltfOptions bare() {
    GltfOptions options;
    options.ground = false;
    return options;
}

// The pixel in the middle.
const float* middle(const FloatImage& image) {
    return image.at(image.extent.width / 2, image.extent.height / 2);
}

ModelMaterial double_sided(ModelMaterial material) {
    material.double_sided = true;
    return material;
}

// A sun that shines along -z onto the square, as a node of the file.
void add_light(Model& model, const ModelLight& light, std::array<double, 3> place = {0, 0, 0}) {
    Node node;
    node.light = static_cast<uint32_t>(model.lights.size());
    node.translation = place;
    model.lights.push_back(light);
    model.nodes.push_back(node);
}

constexpr Extent small = {33, 21};
const CameraPath from_front = looking({0, 0.5, 3}, {0, 0.5, 0});
const CameraPath from_behind = looking({0, 0.5, -3}, {0, 0.5, 0});

// Lambert's law with the built-in sun, and the hemisphere of ambient light, on a face of known normal.
TEST_F(MeshLight, a_matt_face_is_as_bright_as_the_cosine_says) {
    MeshRig rig(square_model(matt(0.8f, 0.5f, 0.2f)), bare());
    rig.source().set_camera(from_front);
    const MeshImages images = rig.render(0, small);
    const Light light;
    const double cosine = rig.source().to_sun().z;
    EXPECT_NEAR(cosine, normalised(light.to_sun).z, 1e-9);
    const float colours[] = {0.8f, 0.5f, 0.2f};
    const double sun[] = {light.sun.x, light.sun.y, light.sun.z};
    const double up[] = {light.ambient_up.x, light.ambient_up.y, light.ambient_up.z};
    const double down[] = {light.ambient_down.x, light.ambient_down.y, light.ambient_down.z};
    for (size_t c = 0; c < 3; ++c) {
        const auto albedo = static_cast<double>(colours[c]);
        const double direct = albedo * sun[c] * cosine;
        // Four hundredths are mirrored, spread over the hemisphere.
        EXPECT_NEAR(static_cast<double>(middle(images.direct)[c]), direct, 0.03 * sun[c] * cosine);
        EXPECT_NEAR(static_cast<double>(middle(images.ambient)[c]), albedo * 0.5 * (up[c] + down[c]), 1e-5);
        EXPECT_FLOAT_EQ(middle(images.colour)[c], middle(images.direct)[c] + middle(images.ambient)[c]);
    }
    EXPECT_EQ(middle(images.colour)[3], 1.0f);
    EXPECT_EQ(middle(images.shadow)[0], 1.0f);
}

TEST_F(MeshLight, materials) {
    const auto render = [](const ModelMaterial& material) {
        MeshRig rig(square_model(material), bare());
        rig.source().set_camera(from_front);
        return rig.render(0, small);
    };
    ModelMaterial unlit = matt(0.3f, 0.6f, 0.9f);
    unlit.unlit = true;
    EXPECT_EQ(middle(render(unlit).direct)[2], 0.9f);
    EXPECT_EQ(middle(render(unlit).ambient)[2], 0.0f);
    ModelMaterial glowing = matt(0.5f, 0.5f, 0.5f);
    glowing.emission = {2.0f, 0, 0};
    const MeshImages glow = render(glowing), dark = render(matt(0.5f, 0.5f, 0.5f));
    EXPECT_NEAR(middle(glow.direct)[0] - middle(dark.direct)[0], 2.0f, 1e-5f);
    // A mirror that the sun does not hit straight is dark in direct light.
    ModelMaterial metal = matt(1, 1, 1);
    metal.metallic = 1.0f;
    metal.roughness = 0.1f;
    EXPECT_LT(middle(render(metal).direct)[0], 0.02f);
    EXPECT_GT(middle(render(metal).ambient)[0], 0.1f);
}

TEST_F(MeshLight, single_sided_surfaces_are_not_seen_from_behind) {
    MeshRig single(square_model(matt()), bare());
    single.source().set_camera(from_behind);
    EXPECT_EQ(middle(single.render(0, small).depth)[0], sky_depth);
    MeshRig twofold(square_model(double_sided(matt())), bare());
    twofold.source().set_camera(from_behind);
    const MeshImages images = twofold.render(0, small);
    EXPECT_NEAR(middle(images.depth)[0], 3.0f, 1e-4f);
    EXPECT_NEAR(middle(images.normal)[2], 1.0f, 1e-4f); // towards the camera
    // The sun is on the other side.
    EXPECT_EQ(middle(images.shadow)[0], 0.0f);
    EXPECT_EQ(middle(images.direct)[0], 0.0f);
}

// The left half of the texture is transparent.
Model cut_out(AlphaMode mode) {
    ModelMaterial material = double_sided(matt());
    material.alpha_mode = mode;
    material.base_colour_texture = 0;
    Model model = square_model(material);
    model.textures.push_back({2, 1, {255, 255, 255, 0, 255, 255, 255, 255}, false, false, false, true});
    return model;
}

TEST_F(MeshLight, holes_show_what_is_behind_and_let_light_through) {
    for (const AlphaMode mode : {AlphaMode::mask, AlphaMode::blend, AlphaMode::opaque}) {
        Model model = cut_out(mode);
        // A wall behind, lit from the front.
        ModelMaterial wall = matt();
        Model behind = square_model(wall);
        behind.meshes[0].parts[0].material = 1;
        model.materials.push_back(wall);
        model.meshes.push_back(behind.meshes[0]);
        Node node;
        node.mesh = 1;
        node.scale = {2, 2, 2};
        node.translation = {0, -0.5, -1};
        model.nodes.push_back(node);
        add_light(model, {});
        MeshRig rig(std::move(model), bare());
        rig.source().set_camera(looking({0, 0.5, 6}, {0, 0.5, -1}, 20));
        const Extent extent = {64, 64};
        const MeshImages images = rig.render(0, extent);
        // The square spans about 28 pixels about the middle.
        EXPECT_NEAR(*images.depth.at(25, 32), mode == AlphaMode::opaque ? 6.0f : 7.0f, 0.05f);
        EXPECT_NEAR(*images.depth.at(39, 32), 6.0f, 0.05f);
        EXPECT_EQ(*images.shadow.at(25, 32), 1.0f);
        // From aside, the shadow on the wall.
        rig.source().set_camera(looking({4, 0.5, 1.5}, {0, 0.5, -1}, 30));
        const MeshImages aside = rig.render(0, extent);
        const Camera camera = rig.source().camera(0, extent);
        const auto shadow_at = [&](Vec3 place) {
            const auto pixel = pixel_of(camera, extent, place);
            return *aside.shadow.at(static_cast<uint32_t>(pixel[0]), static_cast<uint32_t>(pixel[1]));
        };
        EXPECT_EQ(shadow_at({-0.25, 0.5, -1}), mode == AlphaMode::opaque ? 0.0f : 1.0f);
        EXPECT_EQ(shadow_at({0.25, 0.3, -1}), 0.0f);
        EXPECT_EQ(shadow_at({-0.8, 0.5, -1}), 1.0f);
    }
}

// Samples of a pixel share its opacity out among them.
TEST_F(MeshLight, blended_surfaces_are_as_transparent_as_their_alpha) {
    ModelMaterial material = matt(1.0f, 0.0f, 0.0f);
    material.unlit = true;
    material.alpha_mode = AlphaMode::blend;
    material.base_colour[3] = 0.25f;
    MeshRig glass(square_model(material), bare());
    MeshRig nothing(square_model(matt()), bare());
    glass.source().set_camera(from_front);
    nothing.source().set_camera(from_behind); // single-sided: the sky alone
    const float sky = middle(nothing.colour(0, small, quick(4)))[1];
    EXPECT_NEAR(middle(glass.colour(0, small, quick(4)))[1], 0.75f * sky, 0.02f);
    EXPECT_EQ(middle(glass.render(0, small).depth)[0], sky_depth);
}

// Against rays from the ground towards the sun, away from the shadow's soft edge.
TEST_F(MeshLight, the_shadow_lies_where_the_sun_is_hidden) {
    Model model = box_model(matt());
    const TriangleMesh mesh = pose_triangles(model, pose_model(model, none, 0));
    GltfOptions options;
    options.ground = true;
    MeshRig rig(std::move(model), options);
    const Vec3 eye = {-3, 2.5, 0.5};
    rig.source().set_camera(looking(eye, {0, -0.5, 0}, 50));
    const Extent extent = {96, 64};
    const MeshImages images = rig.render(0, extent);
    const Camera camera = rig.source().camera(0, extent);
    // The shadow as seen by the sun: a camera far away that looks along its rays.
    View sun;
    sun.forward = rig.source().to_sun() * -1.0;
    size_t dark = 0, bright = 0;
    for (uint32_t y = 0; y < extent.height; ++y)
        for (uint32_t x = 0; x < extent.width; ++x) {
            const TriangleHit own = cast(mesh, camera, extent, x, y);
            const auto depth = static_cast<double>(*images.depth.at(x, y));
            if (own.triangle != none || own.margin < 0.02 || depth >= static_cast<double>(sky_depth))
                continue;
            // The place on the ground, from its depth.
            const Vec3 ray = {((x + 0.5) / extent.width * 2.0 - 1.0) / static_cast<double>(camera.projection[0]),
                              ((y + 0.5) / extent.height * 2.0 - 1.0) / static_cast<double>(camera.projection[5]), -1};
            const auto axis = [&](size_t i) {
                const auto& m = camera.world_to_view;
                return Vec3{static_cast<double>(m[i]), static_cast<double>(m[4 + i]), static_cast<double>(m[8 + i])};
            };
            const Vec3 place = eye + (axis(0) * ray.x + axis(1) * ray.y + axis(2) * ray.z) * depth;
            ASSERT_NEAR(place.y, -0.5, 1e-3);
            sun.eye = place + rig.source().to_sun() * 10.0;
            const Camera seen = camera_of(sun, {.orthographic_height = 1e-6}, {1, 1});
            const TriangleHit hit = cast(mesh, seen, {1, 1}, 0, 0);
            if (hit.margin < 0.02)
                continue;
            ASSERT_EQ(*images.shadow.at(x, y), hit.triangle == none ? 1.0f : 0.0f) << x << ", " << y;
            (hit.triangle == none ? bright : dark) += 1;
        }
    EXPECT_GT(dark, 100u);
    EXPECT_GT(bright, 1000u);
}

// Lit faces have no shadow on themselves.
TEST_F(MeshLight, no_acne) {
    MeshRig rig(box_model(matt()));
    rig.source().set_camera(looking({2, 2.4, 3}, {0, 0, 0}, 25));
    const MeshImages images = rig.render(0, {64, 64});
    for (size_t i = 0; i < images.shadow.values.size(); ++i)
        // All three faces that are seen look to the sun.
        if (images.depth.values[i] < 5.0f && std::abs(images.normal.values[4 * i]) > 0.0f &&
            images.normal.values[4 * i + 1] < 0.85f) {
            ASSERT_EQ(images.shadow.values[i], 1.0f) << i;
        }
}

TEST_F(MeshLight, lights_of_the_file) {
    const auto brightness = [](const ModelLight& light, std::array<double, 3> place) {
        Model model = square_model(matt());
        add_light(model, light, place);
        MeshRig rig(std::move(model), bare());
        rig.source().set_camera(from_front);
        return rig.render(0, small).direct;
    };
    // The brightest is exposed like the sun.
    for (const float intensity : {3.0f, 100000.0f})
        EXPECT_NEAR(middle(brightness({LightKind::directional, {1, 1, 1}, intensity}, {}))[0],
                    static_cast<float>(Light{}.sun.x), 0.04f);
    const FloatImage point = brightness({LightKind::point, {1, 0.5f, 0}, 40.0f}, {0, 0.5, 2});
    EXPECT_NEAR(middle(point)[1] / middle(point)[0], 0.5f, 0.03f);
    EXPECT_LT(*point.at(12, 10), middle(point)[0]);
    const FloatImage spot = brightness({LightKind::spot, {1, 1, 1}, 40.0f, 0.0f, 0.05f, 0.1f}, {0, 0.5, 2});
    EXPECT_NEAR(middle(spot)[0], middle(point)[0], 0.05f);
    EXPECT_EQ(*spot.at(12, 10), 0.0f);
    EXPECT_GT(*point.at(12, 10), 0.0f);
}

// x to the right of the texture, y up, also where the texture is mirrored.
TEST_F(MeshLight, normal_maps_tilt_the_light_and_on_demand_the_normals) {
    ModelMaterial material = matt();
    material.normal_texture = 0;
    const auto render = [&](uint8_t x, uint8_t y, bool is_mirrored, bool has_detail) {
        Model model = square_model(material);
        // Leans by 45 degrees.
        model.textures.push_back({1, 1, {x, y, 218, 255}});
        for (Vertex& vertex : model.meshes[0].parts[0].vertices)
            vertex.texcoord[0] = is_mirrored ? -vertex.texcoord[0] : vertex.texcoord[0];
        GltfOptions options = bare();
        options.normals_have_detail = has_detail;
        MeshRig rig(std::move(model), options);
        rig.source().set_camera(from_front);
        return rig.render(0, small);
    };
    EXPECT_NEAR(middle(render(218, 128, false, false).normal)[0], 0.0f, 1e-5f);
    const MeshImages right = render(218, 128, false, true);
    const float lean = std::sqrt(0.5f);
    EXPECT_NEAR(middle(right.normal)[0], lean, 0.01f);
    EXPECT_NEAR(middle(right.normal)[1], 0.0f, 0.01f);
    EXPECT_NEAR(middle(render(128, 218, false, true).normal)[1], lean, 0.01f);
    EXPECT_NEAR(middle(render(218, 128, true, true).normal)[0], -lean, 0.01f);
    EXPECT_NEAR(middle(render(128, 218, true, true).normal)[1], lean, 0.01f);
    const Vec3 sun = normalised(Light{}.to_sun);
    EXPECT_NEAR(static_cast<double>(middle(right.direct)[0]), Light{}.sun.x * (sun.x + sun.z) * std::sqrt(0.5), 0.05);
}

TEST_F(MeshLight, truth_is_the_mean_of_sharp_frames) {
    MeshRig rig(ribbon_model());
    rig.source().set_camera(looking({0.7, 1.2, 4}, {0.1, 1, 0}, 35, {0.03, 0.05, -0.06}));
    RenderOptions options = quick(2, 4);
    const FloatImage truth = rig.truth(7, small, options);
    std::vector<double> sum(truth.values.size());
    for (int i = 0; i < 4; ++i) {
        const FloatImage sharp = rig.colour(7.0 + 0.5 * ((i + 0.5) / 4.0 - 0.5), small, options);
        for (size_t k = 0; k < sum.size(); ++k)
            sum[k] += static_cast<double>(sharp.values[k]) / 4.0;
    }
    for (size_t k = 0; k < sum.size(); ++k)
        ASSERT_NEAR(static_cast<double>(truth.values[k]), sum[k], 1e-5);
    // Where nothing moves, the same bits.
    MeshRig still(box_model(matt()));
    EXPECT_EQ(test::first_difference(still.truth(3, small, quick(2, 5)), still.colour(3, small, quick(2))), "");
}

// More samples come nearer to many samples, edges included.
TEST_F(MeshLight, samples_smooth_edges) {
    MeshRig rig(box_model(matt()), bare());
    const auto difference = [&](int samples) {
        const FloatImage best = rig.colour(0, small, quick(8)), other = rig.colour(0, small, quick(samples));
        double sum = 0.0;
        for (size_t i = 0; i < best.values.size(); ++i)
            sum += std::abs(static_cast<double>(best.values[i] - other.values[i]));
        return sum;
    };
    EXPECT_LT(difference(2), 0.5 * difference(1));
    EXPECT_LT(difference(4), 0.6 * difference(2));
}

TEST_F(MeshLight, the_same_bits_again_and_every_pixel_written) {
    const auto frames = [] {
        MeshRig rig(ribbon_model());
        std::vector<MeshImages> all;
        all.push_back(rig.render(3, {37, 23}, quick(2, 3), true));
        all.push_back(rig.render(3, {37, 23}, quick(2, 3), true)); // a second time
        all.push_back(rig.render(4, {1, 1}, quick(1, 2), true));
        all.push_back(rig.render(5, {2, 65}, quick(1, 2), true));
        all.push_back(rig.render(3, {37, 23}, quick(2, 3), true)); // after other sizes
        return all;
    };
    const std::vector<MeshImages> first = frames(), second = frames();
    const auto images = [](const MeshImages& m) {
        return std::array{&m.colour,   &m.direct,        &m.ambient, &m.depth, &m.normal,
                          &m.velocity, &m.next_velocity, &m.shadow,  &m.truth};
    };
    for (size_t i = 0; i < first.size(); ++i)
        for (size_t k = 0; k < 9; ++k) {
            EXPECT_EQ(test::first_difference(*images(first[i])[k], *images(second[i])[k]), "") << i << " " << k;
            EXPECT_TRUE(test::all_finite(*images(first[i])[k])) << i << " " << k;
            if (i == 1 || i == 4) {
                EXPECT_EQ(test::first_difference(*images(first[i])[k], *images(first[0])[k]), "") << i << " " << k;
            }
        }
}

TEST_F(MeshLight, traced_occlusion_reaches_the_images) {
    MeshRig rig(box_model(matt()));
    rig.source().set_camera(looking({2, 1.5, 3}, {0, -0.3, 0}, 40));
    const auto visibility = test::expect_value(test::device().create_image(VK_FORMAT_R32_SFLOAT, small), "image");
    const auto bent = test::expect_value(test::device().create_image(VK_FORMAT_R16G16B16A16_SFLOAT, small), "image");
    SceneImages images;
    images.true_visibility = visibility.image();
    images.true_bent_normal = bent.image();
    RenderOptions options = quick();
    options.occlusion.rays = 16;
    test::run_commands([&](VkCommandBuffer commands) {
        test::expect_done(rig.source().record(commands, 0, options, images, 99), "record");
    });
    const FloatImage open = test::read_back(visibility), directions = test::read_back(bent);
    const FloatImage depth = rig.render(0, small).depth;
    EXPECT_LT(std::ranges::min(open.values), 0.8f); // the box's foot
    for (size_t i = 0; i < open.values.size(); ++i) {
        ASSERT_NEAR(directions.values[4 * i + 3], open.values[i], 1e-3f);
        if (depth.values[i] == sky_depth) {
            ASSERT_EQ(open.values[i], 1.0f);
        }
    }
}

TEST_F(MeshLight, requests_that_cannot_be_met) {
    const auto context = test::make_context();
    const ContextInfo info = test::device().context_info();
    const auto compute_only = make_source(*context, info, VK_QUEUE_COMPUTE_BIT, box_model());
    ASSERT_FALSE(compute_only);
    EXPECT_EQ(compute_only.error().code, ErrorCode::unsupported);
    EXPECT_NE(compute_only.error().message.find("graphics"), std::string::npos);
    GltfOptions options;
    options.camera = "Hero";
    const auto no_camera = gltf_facts(box_model(), options);
    ASSERT_FALSE(no_camera);
    EXPECT_NE(no_camera.error().message.find("no camera is called 'Hero'"), std::string::npos);
    Model empty = box_model();
    empty.meshes[0].parts[0].indices.clear();
    empty.meshes[0].parts[0].vertices.clear();
    EXPECT_FALSE(gltf_facts(empty));
    const auto animation = find_animation(ribbon_model(), "bent");
    ASSERT_FALSE(animation);
    EXPECT_NE(animation.error().message.find("did you mean 'bend'?"), std::string::npos);
    EXPECT_EQ(*find_animation(ribbon_model(), "0"), 0u);

    const auto source =
        test::expect_value(make_source(*context, info, test::device().queue_flags(), box_model()), "make_source");
    const auto image = test::expect_value(test::device().create_image(VK_FORMAT_R32_SFLOAT, small), "image");
    SceneImages images;
    const VkCommandBuffer commands = test::expect_value(test::device().begin(), "begin");
    EXPECT_FALSE(source->record(commands, 0, quick(), images, 0));
    images.depth = image.image();
    EXPECT_FALSE(source->record(commands, 0, quick(9), images, 0));
    EXPECT_FALSE(source->record(commands, std::nan(""), quick(), images, 0));
    test::expect_done(test::device().submit_and_wait(), "submit");
}

// A camera of the file: place, angle and kind of projection, and no ground.
TEST_F(MeshLight, cameras_of_the_file) {
    Model model = box_model(matt());
    model.cameras.push_back({"wide", 70.0});
    model.cameras.push_back({"flat", 40.0, 2.5});
    for (const uint32_t camera : {0u, 1u}) {
        Node node;
        node.camera = camera;
        node.translation = {0, 0.25, 4.0 + camera};
        model.nodes.push_back(node);
    }
    const GltfFacts facts = test::expect_value(gltf_facts(model), "facts");
    EXPECT_FALSE(facts.has_ground);
    MeshRig wide(model);
    EXPECT_EQ(wide.source().view(0).view_angle, 70.0);
    EXPECT_NEAR(middle(wide.render(0, small).depth)[0], 3.5f, 1e-4f);
    GltfOptions options;
    options.camera = "flat";
    MeshRig flat(model, options);
    EXPECT_EQ(flat.source().lens().orthographic_height, 2.5);
    EXPECT_NEAR(middle(flat.render(0, small).depth)[0], 4.5f, 1e-4f);
    options.use_file_camera = false;
    EXPECT_TRUE(test::expect_value(gltf_facts(model, options), "facts").has_ground);
}

} // namespace
} // namespace sfumato::scene
