// Which passes motion blur has, in which order, with which constants. The maths is in motion_blur.comp.
#include "effects/motion_blur/motion_blur_plan.h"

#include "core/matrix.h"
#include "effects/motion_blur/motion_blur_shared.h"
#include "effects/plan_parts.h"
#include "shaders/motion_blur.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace sfumato {

// The velocity pass keeps a tile in shared memory; larger radii take more rings of tiles.
constexpr uint32_t largest_tile = 32;
// Pixels of a thread of the velocity pass; fewer where it repairs edges, which takes registers.
constexpr uint32_t velocity_pixels = 8, velocity_pixels_with_repair = 4;
// Pixels of a thread of the gather, 1, 2 or 4: their own colours are loaded together.
constexpr uint32_t gather_pixels = 2;

float effective_shutter(const Frame& frame, const MotionBlurParameters& parameters) {
    // A fraction of a frame at the reference rate, as a fraction of this frame.
    const float fixed = parameters.shutter / (parameters.reference_frame_rate * frame.time_step);
    float shutter = parameters.shutter;
    if (parameters.frame_rate_mode == FrameRateMode::fixed)
        shutter = fixed;
    else if (parameters.frame_rate_mode == FrameRateMode::reference)
        shutter = std::min(shutter, fixed);
    return shutter / static_cast<float>(parameters.generated_frames);
}

uint32_t tile_size(const MotionBlurParameters& parameters, Extent extent) {
    const auto radius = static_cast<uint32_t>(std::ceil(parameters.radius * static_cast<float>(extent.height)));
    const uint32_t wanted = parameters.tile > 0 ? static_cast<uint32_t>(parameters.tile) : radius;
    return std::clamp((wanted + 7) / 8 * 8, 8u, largest_tile);
}

namespace {

using gpu::MotionBlurConstants;
namespace shader = shaders::motion_blur;

float centre_of(ShutterPosition position) {
    return position == ShutterPosition::start ? 1.0f : position == ShutterPosition::end ? -1.0f : 0.0f;
}

float fraction(double x) {
    return static_cast<float>(x - std::floor(x));
}

// Everything about one frame that several passes need.
struct Setup {
    const Frame& frame;
    const MotionBlurParameters& parameters;
    const MotionBlurImages& images;
    Extent extent;
    uint32_t tile;
    Extent tiles;
    float radius; // pixels
    MotionBlurConstants constants{};
    ResourceId surface = no_resource, tile_image = no_resource, neighbours = no_resource;
    ResourceId colour = no_resource, output = no_resource;

    bool is_packed() const { return parameters.storage == VelocityStorage::packed; }
    bool has_previous_camera() const { return images.depth && frame.camera && frame.previous_camera; }
    bool same_size() const {
        for (const Image* input : {&images.depth, &images.velocity, &images.next_velocity, &images.layer_1,
                                   &images.layer_1_mask, &images.layer_2, &images.layer_2_mask, &images.exclusion_mask})
            if (*input && input->extent != extent)
                return false;
        return true;
    }
    // A velocity image without its next one knows of things that move, the next camera does not: taking the camera's
    // motion for the second half of the shutter would halve theirs.
    bool has_next_camera() const {
        return images.depth && frame.camera && frame.next_camera && (images.next_velocity || !images.velocity);
    }
};

gpu::vec4 layer_scale(const Image& image, Extent extent, float strength) {
    if (!image)
        return {};
    const gpu::vec2 r = ratio(image, extent);
    return {r.x, r.y, strength / r.x, strength / r.y};
}

void set_cameras(Setup& s) {
    MotionBlurConstants& c = s.constants;
    if (!s.frame.camera)
        return;
    const Matrix4 now = unjittered_projection(*s.frame.camera, s.extent);
    const Matrix4 to_world = inverse(s.frame.camera->world_to_view);
    c.clip_from_view.columns = now;
    const auto from_view = [&](const Camera& other) {
        return multiply(unjittered_projection(other, s.extent), multiply(other.world_to_view, to_world));
    };
    if (s.frame.previous_camera)
        c.previous_clip_from_view.columns = from_view(*s.frame.previous_camera);
    if (s.frame.next_camera)
        c.next_clip_from_view.columns = from_view(*s.frame.next_camera);
}

void set_constants(Setup& s) {
    const MotionBlurParameters& p = s.parameters;
    MotionBlurConstants& c = s.constants;
    const auto height = static_cast<float>(s.extent.height);
    set_cameras(s);
    c.size = {static_cast<float>(s.extent.width), height};
    c.inverse_size = {1.0f / c.size.x, 1.0f / c.size.y};
    c.velocity_ratio = ratio(s.images.velocity, s.extent);
    c.next_velocity_ratio = ratio(s.images.next_velocity, s.extent);
    c.depth_ratio = ratio(s.images.depth, s.extent);
    c.layer_1_mask_ratio = ratio(s.images.layer_1_mask, s.extent);
    c.layer_2_mask_ratio = ratio(s.images.layer_2_mask, s.extent);
    c.exclusion_ratio = ratio(s.images.exclusion_mask, s.extent);
    c.layer_1_scale = layer_scale(s.images.layer_1, s.extent, p.layer_1_strength);
    c.layer_2_scale = layer_scale(s.images.layer_2, s.extent, p.layer_2_strength);
    c.shutter = effective_shutter(s.frame, p);
    c.centre = centre_of(p.shutter_position);
    c.radius = s.radius;
    c.uniform_tolerance = p.uniform_tolerance;
    c.uniform_pixels = p.uniform_pixels * height / 1080.0f;
    c.soft_extent = p.soft_extent;
    c.weight_background = p.weight_background;
    c.weight_foreground = p.weight_foreground;
    c.weight_mutual = p.weight_mutual;
    c.weight_centre = p.weight_centre;
    c.taps_per_pixel = p.taps_per_pixel;
    c.jitter_amount = p.jitter_amount;
    c.debug_scale = s.radius > 0.0f ? 1.0f / s.radius : 0.0f;
}

void set_iteration(Setup& s, int iteration) {
    // Patterns repeat after 64 frames: far enough for temporal filters, and sums stay exact.
    const uint64_t base = s.parameters.animate_jitter ? s.frame.index % 64 : 0;
    const auto index = static_cast<double>(base * static_cast<uint64_t>(s.parameters.iterations)) + iteration;
    s.constants.noise_shift = static_cast<float>(5.588238 * index);
    s.constants.ordered_shift = fraction(0.61803398875 * index);
    s.constants.parity = static_cast<float>(static_cast<uint64_t>(index) % 2);
    s.constants.iteration = static_cast<float>(iteration);
}

Access write(ResourceId resource, bool disjoint = false) {
    return {resource, AccessKind::write, 0, disjoint};
}

void plan_velocity(Planner& planner, Setup& s) {
    const MotionBlurImages& i = s.images;
    const auto input = [&](const char* name, uint32_t index, const Image& image) {
        return read(planner.host(name, index, image));
    };
    s.surface =
        planner.transient("velocity and depth", s.is_packed() ? VK_FORMAT_R32_UINT : VK_FORMAT_R32G32_UINT, s.extent);
    s.tile_image = planner.transient("tile maximum", VK_FORMAT_R32G32B32A32_UINT, s.tiles);
    const auto layer = [](const Image& image, LayerBlend blend) {
        return image ? static_cast<uint32_t>(blend) + 1 : 0;
    };
    Pass& pass = planner.pass("velocity", shader::velocity);
    pass.subgroup_shader = shader::velocity_subgroups;
    pass.specialization = {s.tile,
                           s.is_packed(),
                           bool(i.depth),
                           s.frame.depth_kind == DepthKind::device,
                           bool(i.velocity),
                           bool(i.next_velocity),
                           s.has_previous_camera(),
                           s.has_next_camera(),
                           s.parameters.repair_edges,
                           layer(i.layer_1, s.parameters.layer_1_blend),
                           bool(i.layer_1_mask),
                           layer(i.layer_2, s.parameters.layer_2_blend),
                           bool(i.layer_2_mask),
                           bool(i.exclusion_mask),
                           s.same_size(),
                           s.tile * s.tile /
                               (s.parameters.repair_edges ? velocity_pixels_with_repair : velocity_pixels)};
    pass.accesses = {input("velocity", 2, i.velocity),
                     input("next velocity", 3, i.next_velocity),
                     input("depth", 1, i.depth),
                     input("layer 1", 4, i.layer_1),
                     input("layer 1 mask", 5, i.layer_1_mask),
                     input("layer 2", 6, i.layer_2),
                     input("layer 2 mask", 7, i.layer_2_mask),
                     input("exclusion mask", 8, i.exclusion_mask),
                     write(s.surface),
                     write(s.tile_image)};
    pass.constants = constants_of(s.constants);
    pass.dispatch = {DispatchKind::groups, s.tile_image};
}

void plan_neighbours(Planner& planner, Setup& s) {
    s.neighbours = planner.buffer("neighbour maximum", uint64_t{8} * s.tiles.width * s.tiles.height);
    const float reach = s.radius * (1.0f + std::abs(s.constants.centre));
    const auto rings = std::max(1u, static_cast<uint32_t>(std::ceil(reach / static_cast<float>(s.tile))));
    Pass& pass = planner.pass("neighbours", shader::neighbours);
    pass.subgroup_shader = shader::neighbours_subgroups;
    pass.specialization = {s.tile,
                           s.is_packed(),
                           rings,
                           static_cast<uint32_t>(s.parameters.dilation),
                           s.parameters.test_edge_neighbours,
                           s.parameters.tile_classes};
    pass.accesses = {read(s.tile_image), {s.neighbours, AccessKind::buffer_write, 0, false}};
    pass.constants = constants_of(s.constants);
    pass.dispatch = {DispatchKind::groups, s.tile_image, 0, 0, {4, 1}};
}

void plan_gather(Planner& planner, Setup& s, ResourceId mean, ResourceId target) {
    const MotionBlurParameters& p = s.parameters;
    uint32_t debug = 0;
    if (p.debug_view == MotionBlurView::taps || p.debug_view == MotionBlurView::share)
        debug = p.debug_view == MotionBlurView::taps ? 1 : 2;
    Pass& pass = planner.pass("gather", shader::gather);
    pass.specialization = {s.tile,
                           s.is_packed(),
                           static_cast<uint32_t>(p.weighting),
                           static_cast<uint32_t>(p.taps),
                           p.taps_per_pixel > 0.0f,
                           p.alternate,
                           p.tile_jitter,
                           static_cast<uint32_t>(p.jitter),
                           static_cast<uint32_t>(p.shutter_curve),
                           p.hdr_weighting,
                           p.depth_comparison == DepthComparison::absolute,
                           mean != no_resource,
                           debug,
                           p.filter_taps,
                           static_cast<uint32_t>(p.search_taps),
                           static_cast<uint32_t>(p.least_taps),
                           p.second_direction,
                           256 / gather_pixels,
                           p.iterations == 1 && !p.animate_jitter};
    pass.accesses = {{s.colour, AccessKind::filter, 0, false},
                     read(s.surface),
                     read(mean),
                     {s.neighbours, AccessKind::buffer_read, 0, false},
                     write(target)};
    pass.constants = constants_of(s.constants);
    pass.dispatch = {DispatchKind::groups, target, 0, 0, {16, 16}};
}

void plan_debug(Planner& planner, Setup& s, uint32_t view) {
    Pass& pass = planner.pass("debug", shader::debug);
    pass.specialization = {s.tile, s.is_packed(), view};
    pass.accesses = {read(s.colour),
                     read(s.surface),
                     read(s.tile_image),
                     {s.neighbours, AccessKind::buffer_read, 0, false},
                     write(s.output)};
    pass.constants = constants_of(s.constants);
    pass.dispatch = {DispatchKind::texels, s.output, 0, 0};
}

// At a camera cut velocities lead nowhere: the picture is passed through. The same tile machinery copies it.
float radius_pixels(const Frame& frame, const MotionBlurParameters& parameters, Extent extent) {
    return frame.reset ? 0.0f : parameters.radius * static_cast<float>(extent.height);
}

} // namespace

Plan plan_motion_blur(const Frame& frame, const MotionBlurParameters& parameters, const MotionBlurImages& images) {
    const Extent extent = images.colour.extent;
    const uint32_t tile = tile_size(parameters, extent);
    Planner planner("motion-blur");
    Setup s{.frame = frame,
            .parameters = parameters,
            .images = images,
            .extent = extent,
            .tile = tile,
            .tiles = {(extent.width + tile - 1) / tile, (extent.height + tile - 1) / tile},
            .radius = radius_pixels(frame, parameters, extent)};
    set_constants(s);
    set_iteration(s, 0);
    s.colour = planner.host("colour", 0, images.colour);
    s.output = planner.host("output", 9, images.output);
    plan_velocity(planner, s);
    plan_neighbours(planner, s);
    if (parameters.debug_view >= MotionBlurView::velocity && parameters.debug_view <= MotionBlurView::tile_class) {
        plan_debug(planner, s,
                   static_cast<uint32_t>(parameters.debug_view) - static_cast<uint32_t>(MotionBlurView::velocity));
        return std::move(planner).finish();
    }
    ResourceId mean = no_resource;
    for (int iteration = 0; iteration < parameters.iterations; ++iteration) {
        const bool is_last = iteration + 1 == parameters.iterations;
        // Full precision between iterations: they are for quality, and rounding would bias the mean.
        const ResourceId target = is_last ? s.output : planner.transient("mean", VK_FORMAT_R32G32B32A32_SFLOAT, extent);
        set_iteration(s, iteration);
        plan_gather(planner, s, mean, target);
        mean = target;
    }
    return std::move(planner).finish();
}

} // namespace sfumato
