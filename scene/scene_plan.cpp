// The passes of a scene's frame and of its ground truth.
#include "scene/scene.h"
#include "scene/scene_constants.h"
#include "scene/scene_request.h"
#include "shaders/analytic_scene.h"
#include "shaders/occlusion_truth.h"

#include <algorithm>
#include <optional>
#include <string>

namespace sfumato::scene {
namespace {

using shared::SceneConstants;
namespace code = sfumato::shaders::analytic_scene;
namespace occlusion_code = sfumato::shaders::occlusion_truth;

constexpr uint32_t rays_a_pass = 64;

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
    return check_request(scene.info, scene.camera.lens, frame, options);
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
        if (images_.true_visibility || images_.true_bent_normal)
            occlusion();
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
        ResourceId mean = no_resource;
        const std::vector<Moment> moments = shutter_moments(shutter, frame_);
        for (int i = 0; i < count; ++i) {
            radiance(moments[static_cast<size_t>(i)].frame);
            shared::AccumulateConstants constants{};
            constants.share = moments[static_cast<size_t>(i)].share;
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

    // In many small dispatches: a device that is shared or watched is not held for long.
    void occlusion() {
        const OcclusionTruth& truth = options_.occlusion;
        SceneConstants constants = scene_constants(scene_, frame_, extent_, options_.samples);
        constants.radius = static_cast<float>(truth.radius);
        constants.falloff = static_cast<uint32_t>(truth.falloff);
        constants.all_rays = static_cast<uint32_t>(truth.rays);
        constants.seed = truth.seed;
        ResourceId sums[2] = {no_resource, no_resource};
        ResourceId last = no_resource;
        for (uint32_t first = 0, i = 0; first < constants.all_rays; first += rays_a_pass, ++i) {
            if (i < 2)
                sums[i] = planner_.transient(i == 0 ? "sums a" : "sums b", VK_FORMAT_R32G32B32A32_SFLOAT, extent_);
            constants.first_ray = first;
            constants.ray_count = std::min(rays_a_pass, constants.all_rays - first);
            Pass& pass = planner_.pass("rays", occlusion_code::rays);
            pass.accesses = {{last, AccessKind::fetch}, {sums[i % 2], AccessKind::write}};
            pass.constants = constants_of(constants);
            pass.dispatch.target = sums[i % 2];
            last = sums[i % 2];
        }
        const ResourceId visibility = target("true visibility", 9, images_.true_visibility, VK_FORMAT_R32_SFLOAT);
        const ResourceId bent = target("true bent normal", 10, images_.true_bent_normal, VK_FORMAT_R16G16B16A16_SFLOAT);
        Pass& pass = planner_.pass("average", occlusion_code::average);
        pass.accesses = {{last, AccessKind::fetch}, {visibility, AccessKind::write}, {bent, AccessKind::write}};
        pass.constants = constants_of(constants);
        pass.dispatch.target = visibility;
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

std::array<Image, 11> host_images(const SceneImages& images) {
    return {images.colour, images.direct,          images.ambient,         images.depth,
            images.normal, images.velocity,        images.next_velocity,   images.shadow,
            images.truth,  images.true_visibility, images.true_bent_normal};
}

std::span<const char* const> falloff_names() {
    static constexpr const char* names[] = {"hard", "linear", "quadratic", "sao", "contact", "wide"};
    return names;
}

std::optional<Falloff> find_falloff(std::string_view name) {
    const auto names = falloff_names();
    const auto found = std::ranges::find(names, name, [](const char* known) { return std::string_view(known); });
    return found == names.end() ? std::nullopt : std::optional(static_cast<Falloff>(found - names.begin()));
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
