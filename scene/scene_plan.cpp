// The passes of a scene's frame and of its ground truth.
#include "scene/scene.h"
#include "scene/scene_shared.h"
#include "scene/vec3.h"
#include "shaders/analytic_scene.h"

#include <algorithm>
#include <optional>
#include <string>

namespace sfumato::scene {
namespace {

using shared::SceneConstants;
namespace code = sfumato::shaders::analytic_scene;

static_assert(sizeof(SceneConstants) <= 16384, "Vulkan promises no larger uniform block");

shared::vec4 vec4_of(Vec3 v, double w = 0.0) {
    return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z), static_cast<float>(w)};
}

void copy_pose(const Pose& pose, shared::vec4 (&rows)[3]) {
    for (size_t row = 0; row < 3; ++row)
        rows[row] = vec4_of({pose[row * 4], pose[row * 4 + 1], pose[row * 4 + 2]}, pose[row * 4 + 3]);
}

shared::mat4 mat4_of(const Matrix4& matrix) {
    shared::mat4 result;
    std::ranges::copy(matrix, result.elements);
    return result;
}

// A little wide, so that rounding never cuts a primitive.
double bounding_radius(const Primitive& primitive) {
    const Vec3 size = primitive.size;
    switch (primitive.shape) {
    case Shape::sphere:
    case Shape::disc:
        return size.x * 1.001;
    case Shape::box:
        return std::sqrt(dot(size, size)) * 1.001;
    case Shape::cylinder:
        return std::sqrt(size.x * size.x + size.y * size.y) * 1.001;
    case Shape::plane:
        break;
    }
    return -1.0;
}

shared::ScenePrimitive primitive_constants(const Primitive& primitive, double time) {
    shared::ScenePrimitive result{};
    result.size = vec4_of(primitive.size, bounding_radius(primitive));
    result.shape = static_cast<uint32_t>(primitive.shape);
    result.material = primitive.material;
    const Pose now = pose_at(primitive.motion, time);
    const Pose previous = pose_at(primitive.motion, time - 1.0);
    const Pose next = pose_at(primitive.motion, time + 1.0);
    copy_pose(now, result.now);
    copy_pose(previous, result.previous);
    copy_pose(next, result.next);
    result.flags = (now == previous ? PRIMITIVE_STILL_PREVIOUS : 0u) | (now == next ? PRIMITIVE_STILL_NEXT : 0u) |
                   (primitive.casts_shadow ? PRIMITIVE_CASTS_SHADOW : 0u);
    return result;
}

// The rotation of a rigid matrix is its first three columns.
bool same_rotation(const Camera& a, const Camera& b) {
    return std::equal(a.world_to_view.begin(), a.world_to_view.begin() + 12, b.world_to_view.begin());
}

void set_camera(SceneConstants& constants, const Scene& scene, double frame, Extent extent) {
    const Camera now = camera(scene, frame, extent);
    const Camera previous = camera(scene, frame - 1.0, extent);
    const Camera next = camera(scene, frame + 1.0, extent);
    constants.view = mat4_of(now.world_to_view);
    constants.previous_view = mat4_of(previous.world_to_view);
    constants.next_view = mat4_of(next.world_to_view);
    const double time = frame - scene.info.key_frame;
    constants.eye = vec4_of(scene.camera.eye + scene.camera.eye_velocity * time);
    constants.lens = {1.0f / now.projection[0], -1.0f / now.projection[5], static_cast<float>(extent.width),
                      static_cast<float>(extent.height)};
    constants.flags = (now.world_to_view == previous.world_to_view ? SCENE_CAMERA_STILL_PREVIOUS : 0u) |
                      (now.world_to_view == next.world_to_view ? SCENE_CAMERA_STILL_NEXT : 0u) |
                      (same_rotation(now, previous) ? SCENE_SKY_STILL_PREVIOUS : 0u) |
                      (same_rotation(now, next) ? SCENE_SKY_STILL_NEXT : 0u);
}

SceneConstants scene_constants(const Scene& scene, double frame, Extent extent, int samples) {
    SceneConstants constants{};
    set_camera(constants, scene, frame, extent);
    const Light& light = scene.light;
    constants.sun = vec4_of(normalised(light.to_sun));
    constants.sun_colour = vec4_of(light.sun, light.clouds);
    constants.sky_zenith = vec4_of(light.zenith);
    constants.sky_horizon = vec4_of(light.horizon);
    constants.ambient_up = vec4_of(light.ambient_up);
    constants.ambient_down = vec4_of(light.ambient_down);
    constants.primitive_count = static_cast<uint32_t>(scene.primitives.size());
    constants.samples = static_cast<uint32_t>(samples);
    for (size_t i = 0; i < scene.materials.size(); ++i) {
        const Material& material = scene.materials[i];
        shared::SceneMaterial& target = constants.materials[i];
        target.colour_a = vec4_of(material.colour_a, material.detail);
        target.colour_b = vec4_of(material.colour_b, material.emission);
        target.pattern = static_cast<uint32_t>(material.pattern);
        target.scale = static_cast<float>(material.scale);
    }
    for (size_t i = 0; i < scene.primitives.size(); ++i)
        constants.primitives[i] = primitive_constants(scene.primitives[i], frame - scene.info.key_frame);
    return constants;
}

// The images' common extent, or an error.
Result<Extent> common_extent(const SceneImages& images) {
    std::optional<Extent> extent;
    for (const Image& image : host_images(images)) {
        if (!image)
            continue;
        if (extent && *extent != image.extent)
            return Error{ErrorCode::invalid_argument, "the scene's images differ in extent: " + extent_text(*extent) +
                                                          " and " + extent_text(image.extent)};
        extent = image.extent;
    }
    if (!extent)
        return Error{ErrorCode::invalid_argument, "none of the scene's images is present"};
    return *extent;
}

Result<void> check(const Scene& scene, double frame, const RenderOptions& options) {
    const auto fail = [&](const std::string& what) {
        return Error{ErrorCode::invalid_argument, "scene " + scene.info.name + ": " + what};
    };
    if (scene.primitives.size() > SCENE_MOST_PRIMITIVES || scene.materials.size() > SCENE_MOST_MATERIALS)
        return fail(std::to_string(scene.primitives.size()) + " primitives and " +
                    std::to_string(scene.materials.size()) + " materials, at most 64 and 16 are possible");
    for (const Primitive& primitive : scene.primitives)
        if (primitive.material >= scene.materials.size())
            return fail("a primitive has material " + std::to_string(primitive.material) + " of " +
                        std::to_string(scene.materials.size()));
    if (!std::isfinite(frame))
        return fail("the frame's time is not finite");
    if (options.samples < 1 || options.samples > 8)
        return fail(std::to_string(options.samples) + " samples a side, 1 to 8 are possible");
    const Shutter& shutter = options.shutter;
    if (shutter.sub_frames < 1 || shutter.sub_frames > 256)
        return fail(std::to_string(shutter.sub_frames) + " sub-frames, 1 to 256 are possible");
    if (!(shutter.open >= 0.0 && shutter.open <= 16.0))
        return fail("the shutter is open for " + std::to_string(shutter.open) + " frames, 0 to 16 are possible");
    return {};
}

// Builds one plan.
class ScenePlanner {
  public:
    ScenePlanner(const Scene& scene, double frame, const RenderOptions& options, const SceneImages& images,
                 Extent extent)
        : scene_(scene), frame_(frame), options_(options), images_(images), extent_(extent), planner_("scene") {}

    Plan plan() {
        if (images_.colour || images_.direct || images_.ambient)
            sharp();
        if (images_.truth)
            truth();
        if (images_.depth || images_.normal || images_.velocity || images_.next_velocity || images_.shadow)
            geometry();
        return std::move(planner_).finish();
    }

  private:
    // The host's image, or one that is written and forgotten.
    ResourceId target(const char* name, uint32_t index, const Image& image, VkFormat otherwise) {
        return image ? planner_.host(name, index, image) : planner_.transient(name, otherwise, extent_);
    }

    // Light of one moment, always by the same pass: the same scene gives the same bits.
    void radiance(double frame) {
        if (direct_ == no_resource) {
            direct_ = planner_.transient("moment direct", VK_FORMAT_R32G32B32A32_SFLOAT, extent_);
            ambient_ = planner_.transient("moment ambient", VK_FORMAT_R32G32B32A32_SFLOAT, extent_);
        }
        Pass& pass = planner_.pass("radiance", code::radiance);
        pass.accesses = {{direct_, AccessKind::write}, {ambient_, AccessKind::write}};
        pass.constants = constants_of(scene_constants(scene_, frame, extent_, options_.samples));
        pass.dispatch.target = direct_;
    }

    void sharp() {
        radiance(frame_);
        const ResourceId colour = target("colour", 0, images_.colour, VK_FORMAT_R16G16B16A16_SFLOAT);
        const ResourceId direct = target("direct", 1, images_.direct, VK_FORMAT_R16G16B16A16_SFLOAT);
        const ResourceId ambient = target("ambient", 2, images_.ambient, VK_FORMAT_R16G16B16A16_SFLOAT);
        Pass& pass = planner_.pass("resolve", code::resolve);
        pass.accesses = {{direct_, AccessKind::fetch},
                         {ambient_, AccessKind::fetch},
                         {colour, AccessKind::write},
                         {direct, AccessKind::write},
                         {ambient, AccessKind::write}};
        pass.dispatch.target = colour;
    }

    void truth() {
        const ResourceId result = planner_.host("truth", 8, images_.truth);
        const Shutter& shutter = options_.shutter;
        const int count = shutter.sub_frames;
        ResourceId means[2] = {no_resource, no_resource};
        for (int i = 0; i < 2 && i < count - 1; ++i)
            means[i] = planner_.transient(i == 0 ? "mean a" : "mean b", VK_FORMAT_R32G32B32A32_SFLOAT, extent_);
        const double first = shutter.position == ShutterPosition::start    ? 0.0
                             : shutter.position == ShutterPosition::centre ? -0.5
                                                                           : -1.0;
        double weights = 0.0;
        ResourceId mean = no_resource;
        for (int i = 0; i < count; ++i) {
            const double place = (i + 0.5) / count;
            const double weight = shutter.curve ? std::max(shutter.curve(place), 0.0) : 1.0;
            weights += weight;
            radiance(frame_ + (first + place) * shutter.open);
            shared::AccumulateConstants constants{};
            // Until there is any weight, the newest moment stands for the mean.
            constants.share = mean == no_resource || weights == 0.0 ? 1.0f : static_cast<float>(weight / weights);
            const ResourceId next = i == count - 1 ? result : means[i % 2];
            Pass& pass = planner_.pass("accumulate", code::accumulate);
            pass.accesses = {{direct_, AccessKind::fetch},
                             {ambient_, AccessKind::fetch},
                             {mean, AccessKind::fetch},
                             {next, AccessKind::write}};
            pass.constants = constants_of(constants);
            pass.dispatch.target = next;
            mean = next;
        }
    }

    void geometry() {
        const ResourceId depth = target("depth", 3, images_.depth, VK_FORMAT_R32_SFLOAT);
        const ResourceId normal = target("normal", 4, images_.normal, VK_FORMAT_R16G16B16A16_SFLOAT);
        const ResourceId velocity = target("velocity", 5, images_.velocity, VK_FORMAT_R16G16_SFLOAT);
        const ResourceId next_velocity = target("next velocity", 6, images_.next_velocity, VK_FORMAT_R16G16_SFLOAT);
        const ResourceId shadow = target("shadow", 7, images_.shadow, VK_FORMAT_R16_SFLOAT);
        Pass& pass = planner_.pass("geometry", code::geometry);
        pass.accesses = {{depth, AccessKind::write},
                         {normal, AccessKind::write},
                         {velocity, AccessKind::write},
                         {next_velocity, AccessKind::write},
                         {shadow, AccessKind::write}};
        pass.constants = constants_of(scene_constants(scene_, frame_, extent_, options_.samples));
        pass.dispatch.target = depth;
    }

    const Scene& scene_;
    double frame_;
    const RenderOptions& options_;
    const SceneImages& images_;
    Extent extent_;
    Planner planner_;
    ResourceId direct_ = no_resource;
    ResourceId ambient_ = no_resource;
};

} // namespace

std::array<Image, 9> host_images(const SceneImages& images) {
    return {images.colour,   images.direct,        images.ambient, images.depth, images.normal,
            images.velocity, images.next_velocity, images.shadow,  images.truth};
}

Result<Plan> plan_scene(const Scene& scene, double frame, const RenderOptions& options, const SceneImages& images) {
    if (auto checked = check(scene, frame, options); !checked)
        return checked.error();
    const auto extent = common_extent(images);
    if (!extent)
        return extent.error();
    return ScenePlanner(scene, frame, options, images, *extent).plan();
}

} // namespace sfumato::scene
