// The passes of a scene's frame and of its ground truth.
#include "scene/scene.h"
#include "scene/scene_constants.h"
#include "shaders/analytic_scene.h"
#include "shaders/occlusion_truth.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

namespace sfumato::scene {
namespace {

using shared::SceneConstants;
namespace code = sfumato::shaders::analytic_scene;
namespace occlusion_code = sfumato::shaders::occlusion_truth;

constexpr uint32_t rays_a_pass = 64;

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

template <class Fail>
Result<void> check_occlusion(const OcclusionTruth& occlusion, const Fail& fail) {
    if (occlusion.rays < 1 || occlusion.rays > 65536)
        return fail(std::to_string(occlusion.rays) + " rays a pixel, 1 to 65536 are possible");
    if (!(occlusion.radius > 0.0 && occlusion.radius <= 1e6))
        return fail("rays as long as " + std::to_string(occlusion.radius) + ", above 0 to 1000000 is possible");
    return {};
}

template <class Fail>
Result<void> check_lens(const Lens& lens, const Fail& fail) {
    if (!(lens.near_plane > 0.0 && lens.far_plane > lens.near_plane && std::isfinite(lens.far_plane)))
        return fail("near plane at " + std::to_string(lens.near_plane) + ", far plane at " +
                    std::to_string(lens.far_plane) + ": both must be above 0, the far one beyond the near one");
    if (!std::isfinite(lens.orthographic_height) || !std::isfinite(lens.shift_x) || !std::isfinite(lens.shift_y))
        return fail("the lens has a height or a shift that is not finite");
    return {};
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
    if (auto checked = check_lens(scene.camera.lens, fail); !checked)
        return checked;
    return check_occlusion(options.occlusion, fail);
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
