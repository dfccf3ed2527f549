// What a model is shown with: its camera or a view of its bounds, a floor, animation by frames, truth by ray tracing.
#include "scene/gltf/gltf_source.h"

#include "scene/gltf/mesh_renderer.h"
#include "scene/gltf/mesh_truth.h"
#include "scene/scene_request.h"
#include "scene/vec3.h"
#include "sfumato/parameters.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace sfumato::scene {
namespace {

constexpr double own_view_angle = 30.0, own_elevation = 15.0, own_turn = 35.0; // degrees

Error invalid(const Model& model, const std::string& what) {
    return {ErrorCode::invalid_argument, model.name + ": " + what};
}

std::string hint(const std::string& name, const std::vector<std::string>& known) {
    std::string all;
    for (const std::string& one : known)
        all += (all.empty() ? "'" : ", '") + one + "'";
    const std::string near = nearest_name(name, known);
    return near.empty() ? "; there " + (known.empty() ? std::string("is none") : "are " + all)
                        : "; did you mean '" + near + "'?";
}

ModelPose pose_at_frame(const Model& model, const GltfOptions& options, double frame) {
    return pose_model(model, options.animation, frame / options.frames_per_second);
}

double duration_of(const Model& model, uint32_t animation) {
    return animation < model.animations.size() ? model.animations[animation].duration : 0.0;
}

// About the middle of the box that holds every vertex at sixteen moments of the animation, a little wide where it
// moves, since they are not all moments.
Result<Bounds> bounds_of(const Model& model, const GltfOptions& options) {
    const double duration = duration_of(model, options.animation);
    std::vector<std::vector<std::array<float, 3>>> places;
    const int moments = duration > 0.0 ? 16 : 1;
    for (int i = 0; i < moments; ++i)
        places.push_back(pose_triangles(model, pose_model(model, options.animation, duration * i / moments)).positions);
    if (places.front().empty())
        return invalid(model, "has no triangles");
    constexpr double huge = std::numeric_limits<double>::max();
    Vec3 low = {huge, huge, huge}, high = low * -1.0;
    const auto each = [&](const auto& use) {
        for (const auto& list : places)
            for (const auto& p : list)
                use(Vec3{static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])});
    };
    each([&](Vec3 p) {
        low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    });
    Bounds bounds{(low + high) * 0.5, 0.0};
    each([&](Vec3 p) { bounds.radius = std::max(bounds.radius, dot(p - bounds.centre, p - bounds.centre)); });
    bounds.radius = std::max(std::sqrt(bounds.radius) * (moments > 1 ? 1.02 : 1.0), 1e-6);
    return bounds;
}

double lowest(const Model& model, const GltfOptions& options) {
    const double duration = duration_of(model, options.animation);
    double y = std::numeric_limits<double>::max();
    for (int i = 0; i < 16; ++i)
        for (const auto& p : pose_triangles(model, pose_model(model, options.animation, duration * i / 16)).positions)
            y = std::min(y, static_cast<double>(p[1]));
    return y;
}

// Stone tiles, two a side, grey enough to leave the eye to the model.
Texture tiles() {
    constexpr uint32_t side = 256, tile = side / 2;
    Texture texture{side, side, std::vector<uint8_t>(side * side * 4, 255)};
    texture.is_srgb = true;
    for (uint32_t y = 0; y < side; ++y)
        for (uint32_t x = 0; x < side; ++x) {
            const bool is_joint = x % tile < 3 || y % tile < 3;
            const bool is_dark = (x / tile + y / tile) % 2 == 1;
            const auto tone = static_cast<uint8_t>(is_joint ? 128 : is_dark ? 168 : 178);
            std::fill_n(texture.rgba.begin() + (y * side + x) * 4, 3, tone);
        }
    return texture;
}

constexpr double ground_reach = 60.0; // radii of the model: to the horizon, nearly

// A disc of rings, finer towards the middle, where interpolation must be exact. Appended to the model as a node of its
// own, so that everything that knows models knows the ground. The node's index.
uint32_t add_ground(Model& model, const Bounds& bounds, double height) {
    constexpr double rings[] = {1.5, 3.0, 6.0, 12.0, 25.0, ground_reach};
    constexpr uint32_t sectors = 96;
    MeshPart part;
    const auto add = [&](double x, double z) {
        Vertex vertex;
        vertex.position = {static_cast<float>(bounds.centre.x + x * bounds.radius), static_cast<float>(height),
                           static_cast<float>(bounds.centre.z + z * bounds.radius)};
        vertex.normal = {0, 1, 0};
        vertex.texcoord = {static_cast<float>(x), static_cast<float>(z)};
        part.vertices.push_back(vertex);
    };
    add(0, 0);
    for (const double radius : rings)
        for (uint32_t i = 0; i < sectors; ++i) {
            const double turn = 2.0 * std::numbers::pi * i / sectors;
            add(radius * std::sin(turn), radius * std::cos(turn));
        }
    for (uint32_t i = 0; i < sectors; ++i) {
        const uint32_t next = (i + 1) % sectors;
        part.indices.insert(part.indices.end(), {0, 1 + i, 1 + next});
        for (uint32_t ring = 1; ring < std::size(rings); ++ring) {
            const uint32_t inner = 1 + (ring - 1) * sectors, outer = inner + sectors;
            part.indices.insert(part.indices.end(), {inner + i, outer + i, outer + next});
            part.indices.insert(part.indices.end(), {inner + i, outer + next, inner + next});
        }
    }
    ModelMaterial material;
    material.name = "ground";
    material.metallic = 0.0f;
    material.roughness = 1.0f;
    material.double_sided = true;
    material.base_colour_texture = static_cast<uint32_t>(model.textures.size());
    part.material = static_cast<uint32_t>(model.materials.size());
    Node node;
    node.name = "ground";
    node.mesh = static_cast<uint32_t>(model.meshes.size());
    model.textures.push_back(tiles());
    model.materials.push_back(material);
    model.meshes.push_back({"ground", {std::move(part)}, {}});
    model.nodes.push_back(node);
    return static_cast<uint32_t>(model.nodes.size() - 1);
}

// From the front, a little to the right and above, as far away as the bounds ask for.
View own_view(const Bounds& bounds) {
    return turntable(bounds, own_view_angle, 360.0, own_elevation)(own_turn);
}

Lens lens_of(const Model& model, uint32_t camera_node, const Bounds& bounds) {
    Lens lens;
    lens.near_plane = 0.01 * bounds.radius;
    lens.far_plane = 1000.0 * bounds.radius;
    if (camera_node == none)
        return lens;
    const ModelCamera& camera = model.cameras[model.nodes[camera_node].camera];
    lens.orthographic_height = camera.orthographic_height;
    // Orthographic cameras of glTF may begin at 0.
    if (camera.near_plane > 0.0 && camera.far_plane > camera.near_plane && std::isfinite(camera.far_plane)) {
        lens.near_plane = camera.near_plane;
        lens.far_plane = camera.far_plane;
    }
    return lens;
}

View view_of(const Transform& place, const ModelCamera& camera) {
    View view;
    view.eye = {place[12], place[13], place[14]};
    view.forward = Vec3{-place[8], -place[9], -place[10]};
    view.up = {place[4], place[5], place[6]};
    view.view_angle = camera.view_angle;
    return view;
}

class GltfSource final : public SceneSource {
  public:
    GltfSource(Model model, const GltfOptions& options, const GltfFacts& facts, double ground_height)
        : options_(options), facts_(facts) {
        scene_.model = std::move(model);
        scene_.is_still = options.animation >= scene_.model.animations.size();
        scene_.casters = facts.bounds;
        scene_.reach = facts.bounds.radius * (facts.has_ground ? ground_reach + 1.0 : 1.0);
        if (facts.has_ground)
            scene_.ground = add_ground(scene_.model, facts.bounds, ground_height);
        scene_.normals_have_detail = options.normals_have_detail;
        scene_.view.info = facts.info;
        scene_.view.camera.lens = options.lens.value_or(lens_of(scene_.model, facts.camera_node, facts.bounds));
        scene_.pose = [this](double frame) { return pose_at_frame(scene_.model, options_, frame); };
        GltfSource::set_camera({});
    }

    Result<void> open(Context& context, const ContextInfo& info, VkQueueFlags queue_flags) {
        auto made = MeshRenderer::create(context, info, queue_flags, scene_);
        if (!made)
            return made.error();
        renderer_ = std::move(*made);
        return {};
    }

    const SceneInfo& info() const override { return scene_.view.info; }
    Bounds bounds() const override { return scene_.casters; }
    const Lens& lens() const override { return scene_.view.camera.lens; }
    Vec3 to_sun() const override { return renderer_->to_sun(); }
    View view(double frame) const override { return view_at(scene_.view, frame); }
    std::vector<PassTime> times() override { return renderer_->times(); }

    void set_camera(CameraPath path) override {
        scene_.view.camera_path = path ? std::move(path) : [this](double frame) { return file_view(frame); };
    }

    Result<void> record(VkCommandBuffer commands, double frame, const RenderOptions& options, const SceneImages& images,
                        uint64_t index) override {
        SceneImages drawn = images, traced;
        traced.true_visibility = std::exchange(drawn.true_visibility, {});
        traced.true_bent_normal = std::exchange(drawn.true_bent_normal, {});
        const bool traces = traced.true_visibility || traced.true_bent_normal;
        if (auto checked = check_request(info(), lens(), frame, options); !checked)
            return checked;
        const auto extent = common_extent(images);
        if (!extent)
            return extent.error();
        const auto others = host_images(drawn);
        const bool draws = std::ranges::any_of(others, [](const Image& image) { return static_cast<bool>(image); });
        if (draws)
            if (auto done = renderer_->record(commands, frame, options, drawn, index); !done)
                return done;
        if (!traces)
            return {};
        const TriangleMesh mesh = pose_triangles(scene_.model, scene_.pose(frame));
        const auto truth = trace_occlusion(scene_.model, mesh, camera(frame, *extent), *extent, options.occlusion);
        if (!truth)
            return truth.error();
        return renderer_->record_traced(commands, truth->bent_normal, traced, index);
    }

  private:
    View file_view(double frame) const {
        if (facts_.camera_node == none)
            return own_view(scene_.casters);
        const Model& model = scene_.model;
        const ModelPose pose = scene_.pose(frame);
        return view_of(pose.nodes[facts_.camera_node], model.cameras[model.nodes[facts_.camera_node].camera]);
    }

    GltfOptions options_;
    GltfFacts facts_;
    MeshScene scene_;
    std::unique_ptr<MeshRenderer> renderer_;
};

Result<uint32_t> find_camera(const Model& model, const std::string& name) {
    std::vector<std::string> names;
    for (uint32_t i = 0; i < model.nodes.size(); ++i) {
        const Node& node = model.nodes[i];
        if (node.camera == none)
            continue;
        // Files name the camera or the node that carries it.
        if (name.empty() || node.name == name || model.cameras[node.camera].name == name)
            return i;
        names.push_back(node.name.empty() ? model.cameras[node.camera].name : node.name);
    }
    if (name.empty())
        return none;
    return invalid(model, "no camera is called '" + name + "'" + hint(name, names));
}

// What is drawn otherwise than the file says.
void add_warnings(const Model& model, std::vector<std::string>& warnings) {
    const auto blends = [](const ModelMaterial& material) { return material.alpha_mode == AlphaMode::blend; };
    if (std::ranges::any_of(model.materials, blends))
        warnings.push_back(
            "Blended materials have depth, motion and shadow where they are at least half opaque, and none elsewhere.");
    size_t lights = 0;
    bool has_lamps = false;
    for (const Node& node : model.nodes) {
        lights += node.light != none;
        has_lamps = has_lamps || (node.light != none && model.lights[node.light].kind != LightKind::directional);
    }
    if (lights > MESH_MOST_LIGHTS)
        warnings.push_back("Of " + std::to_string(lights) + " lights the first 8 are shown.");
    if (has_lamps)
        warnings.push_back("Point and spot lights cast no shadows.");
}

} // namespace

Result<uint32_t> find_animation(const Model& model, const std::string& text) {
    std::vector<std::string> names;
    for (uint32_t i = 0; i < model.animations.size(); ++i) {
        names.push_back(model.animations[i].name);
        if (names.back() == text || std::to_string(i) == text)
            return i;
    }
    return invalid(model, "no animation is called '" + text + "'" + hint(text, names));
}

Result<GltfFacts> gltf_facts(const Model& model, const GltfOptions& options) {
    if (!(options.frames_per_second > 0.0 && std::isfinite(options.frames_per_second)))
        return invalid(model, std::to_string(options.frames_per_second) + " frames a second, above 0 is possible");
    auto bounds = bounds_of(model, options);
    if (!bounds)
        return bounds.error();
    GltfFacts facts;
    facts.bounds = *bounds;
    if (options.use_file_camera) {
        auto camera = find_camera(model, options.camera);
        if (!camera)
            return camera.error();
        facts.camera_node = *camera;
    }
    facts.has_ground = options.ground.value_or(facts.camera_node == none);
    facts.info.name = model.name;
    facts.info.doc = "A glTF model.";
    facts.info.frames_per_second = options.frames_per_second;
    const double duration = duration_of(model, options.animation);
    // A model that stands still has as many frames as an analytic scene.
    if (duration > 0.0)
        facts.info.frames = static_cast<int>(std::clamp(std::round(duration * options.frames_per_second), 1.0, 1e6));
    facts.info.key_frame = std::max(1, facts.info.frames / 2);
    facts.warnings = model.warnings;
    add_warnings(model, facts.warnings);
    return facts;
}

Result<std::unique_ptr<SceneSource>> make_source(Context& context, const ContextInfo& info, VkQueueFlags queue_flags,
                                                 Model model, const GltfOptions& options) {
    const auto facts = gltf_facts(model, options);
    if (!facts)
        return facts.error();
    const double height = facts->has_ground ? lowest(model, options) : 0.0;
    auto source = std::make_unique<GltfSource>(std::move(model), options, *facts, height);
    if (auto opened = source->open(context, info, queue_flags); !opened)
        return opened.error();
    return std::unique_ptr<SceneSource>(std::move(source));
}

} // namespace sfumato::scene
