// Which passes ambient occlusion has, in which order, with which constants. The maths is in ambient_occlusion.comp.
#include "shaders/ambient_occlusion.h"
#include "core/formats.h"
#include "core/matrix.h"
#include "effects/ambient_occlusion/ambient_occlusion_plan.h"
#include "effects/ambient_occlusion/ambient_occlusion_shared.h"
#include "effects/plan_parts.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sfumato {

namespace {

using gpu::AmbientOcclusionConstants;
namespace shader = shaders::ambient_occlusion;

constexpr uint32_t pyramid_levels = 6;
constexpr uint32_t pyramid_tile = 32; // texels of the finest level that a workgroup turns into all levels

Access write(ResourceId resource, uint32_t mip = 0) {
    return {resource, AccessKind::write, mip, false};
}

// View x and y = (pixel * xy + zw) times depth, for a perspective projection; without depth for an orthographic one.
gpu::vec4 pixel_to_view(const Matrix4& projection, Extent extent) {
    const bool perspective = projection[11] != 0.0f;
    const float sx = 2.0f / (static_cast<float>(extent.width) * projection[0]);
    const float sy = 2.0f / (static_cast<float>(extent.height) * projection[5]);
    // clip.x = p0 x + p8 z + p12, with z = -depth and clip.w = depth or 1.
    const float ox = perspective ? projection[8] - 1.0f : -1.0f - projection[12];
    const float oy = perspective ? projection[9] - 1.0f : -1.0f - projection[13];
    return {sx, sy, ox / projection[0], oy / projection[5]};
}

// Everything about one frame that several passes need.
struct Setup {
    const Frame& frame;
    const AmbientOcclusionParameters& parameters;
    const AmbientOcclusionImages& images;
    Extent extent;
    Extent working;
    AmbientOcclusionConstants constants{};
    bool is_perspective = true;
    bool is_wide = false;
    History history = {};
    ResourceId depth = no_resource, pyramid = no_resource, signal = no_resource, bent = no_resource;
    ResourceId normal = no_resource, velocity = no_resource, shadow = no_resource;
    ResourceId colour = no_resource, ambient = no_resource;
    ResourceId visibility = no_resource, soft_shadow = no_resource, output = no_resource;

    bool is_half() const { return parameters.resolution == OcclusionResolution::half; }
    bool is_temporal() const { return parameters.temporal && !shows_estimate(); }
    // Without coarser levels the host's depth serves as it is.
    bool is_direct() const { return !is_half() && parameters.depth_mips == DepthMips::none; }
    bool has_shadow() const { return bool(images.shadow); }
    // Views of what comes before any filter.
    bool shows_estimate() const {
        return parameters.debug_view != OcclusionView::none && parameters.debug_view != OcclusionView::history_weight &&
               parameters.debug_view != OcclusionView::filtered;
    }
    uint32_t normal_encoding() const {
        if (!images.normal)
            return 0;
        const FormatInfo& format = *find_format(images.normal.format);
        return (format.components == 2 ? 2u : 1u) | (format.is_signed ? 0u : 4u) |
               (parameters.normal_space == NormalSpace::world ? 8u : 0u);
    }
    std::vector<uint32_t> common() const { return {is_perspective, is_half(), is_wide}; }
};

std::vector<uint32_t> operator+(std::vector<uint32_t> first, std::initializer_list<uint32_t> second) {
    first.insert(first.end(), second);
    return first;
}

void set_cameras(Setup& s) {
    AmbientOcclusionConstants& c = s.constants;
    const Camera& camera = *s.frame.camera;
    const Camera& previous = s.frame.previous_camera ? *s.frame.previous_camera : camera;
    s.is_perspective = camera.projection[11] != 0.0f;
    c.projection.columns = camera.projection;
    c.previous_projection.columns = previous.projection;
    c.previous_view_from_view.columns = multiply(previous.world_to_view, inverse(camera.world_to_view));
    c.view_from_world.columns = camera.world_to_view;
    c.pixel_to_view = pixel_to_view(camera.projection, s.extent);
    c.previous_pixel_to_view = pixel_to_view(previous.projection, s.extent);
    c.pixels = 0.5f * static_cast<float>(s.extent.height) * std::abs(camera.projection[5]);
}

void set_noise(Setup& s) {
    // Patterns repeat after 64 frames: far enough for temporal filters, and sums stay exact.
    const double index = s.parameters.animate_noise ? static_cast<double>(s.frame.index % 64) : 0.0;
    s.constants.noise_shift = static_cast<float>(5.588238 * index);
    s.constants.block_shift = static_cast<float>(index);
}

// Where the taps of obscurance lie: distances in shares of the radius, and the turn from one to the next.
void set_pattern(Setup& s) {
    const AmbientOcclusionParameters& p = s.parameters;
    AmbientOcclusionConstants& c = s.constants;
    constexpr float tau = 2.0f * std::numbers::pi_v<float>;
    const auto count = static_cast<float>(p.pattern == TapPattern::mirrored_spiral ? (p.taps + 1) / 2 : p.taps);
    const auto turns = static_cast<float>(spiral_turns(static_cast<int>(count)));
    float angle = tau * turns / count;
    c.first_angle = 0.5f * angle;
    c.first_tap = 0.5f / count;
    c.tap_spacing = 1.0f / count;
    if (p.pattern == TapPattern::growing_circle) {
        angle = 2.39996323f; // the golden angle
        c.first_angle = 0.0f;
        c.first_tap = 2.0f / (count + 2.0f);
        c.tap_spacing = 1.0f / (count + 2.0f);
    }
    c.turn = {std::cos(angle), std::sin(angle)};
}

// The border that a workgroup loads is at most 8 wide.
int filter_step(const AmbientOcclusionParameters& p) {
    return std::min(p.filter_step, std::max(1, 8 / std::max(1, p.filter_radius)));
}

void set_constants(Setup& s) {
    const AmbientOcclusionParameters& p = s.parameters;
    AmbientOcclusionConstants& c = s.constants;
    set_cameras(s);
    set_noise(s);
    c.size = {static_cast<float>(s.extent.width), static_cast<float>(s.extent.height)};
    c.working_size = {static_cast<float>(s.working.width), static_cast<float>(s.working.height)};
    c.normal_ratio = ratio(s.images.normal, s.extent);
    c.velocity_ratio = ratio(s.images.velocity, s.extent);
    c.shadow_ratio = ratio(s.images.shadow, s.extent);
    c.colour_ratio = ratio(s.images.colour, s.extent);
    c.ambient_ratio = ratio(s.images.ambient, s.extent);
    c.radius = p.radius;
    c.radius_limit = std::max(1.0f, p.radius_limit * c.size.y);
    c.thickness = p.thickness * p.radius;
    c.bias = p.bias;
    c.depth_bias = p.depth_bias;
    c.strength = p.intensity * occlusion_calibration(p);
    c.power = p.power;
    c.step_power = p.step_power;
    c.mip_scale = std::exp2(-p.mip_rate);
    set_pattern(s);
    c.guard_band = static_cast<float>(p.guard_band);
    // Depth in radii, so that signals in half floats reach as far in any unit.
    c.code_scale = s.is_perspective ? p.radius : 1.0f / p.radius;
    const float per_radius = p.filter_comparison == DepthDifference::radius ? 1.0f / p.radius : 1.0f;
    c.filter_scale = per_radius / p.filter_depth;
    const auto bell = [&](int k) {
        const auto offset = static_cast<float>(k * filter_step(p));
        return std::exp(-0.5f * offset * offset / (p.filter_sigma * p.filter_sigma));
    };
    c.bells_near = {bell(1), bell(2), bell(3), bell(4)};
    c.bells_far = {bell(5), bell(6), bell(7), bell(8)};
    c.filter_gaussian = 0.5f / (p.filter_sigma * p.filter_sigma) * std::numbers::log2e_v<float>;
    c.filter_normal = p.filter_normal;
    c.history_position = p.history_position / p.radius;
    c.history_visibility = p.history_visibility;
    c.history_least = std::min(1.0f, p.history_time * s.frame.time_step);
    c.history_length = static_cast<float>(p.history_length);
    c.upsample_scale = (p.upsample == OcclusionUpsample::soma ? 1.0f / p.radius : 1.0f) / p.upsample_depth;
}

void plan_prepare(Planner& planner, Setup& s) {
    const auto padded = [](uint32_t side) { return (side + pyramid_tile - 1) / pyramid_tile * pyramid_tile; };
    // At half resolution the lowest bits tell which of four depths was taken: 16 bits have none to spare.
    const bool narrow = s.parameters.depth_storage == DepthStorage::half && !s.is_half();
    const VkFormat format = narrow ? VK_FORMAT_R16_SFLOAT : VK_FORMAT_R32_SFLOAT;
    s.pyramid =
        planner.transient("depth pyramid", format, {padded(s.working.width), padded(s.working.height)}, pyramid_levels);
    Pass& pass = planner.pass("prepare", shader::prepare);
    pass.specialization = s.common() + std::initializer_list<uint32_t>{s.frame.depth_kind == DepthKind::device,
                                                                       static_cast<uint32_t>(s.parameters.half_depth),
                                                                       static_cast<uint32_t>(s.parameters.depth_mips)};
    pass.accesses = {read(s.depth)};
    for (uint32_t level = 0; level < pyramid_levels; ++level)
        pass.accesses.push_back(write(s.pyramid, level));
    pass.constants = constants_of(s.constants);
    pass.dispatch = {DispatchKind::groups, s.pyramid, pyramid_levels - 1, 0};
}

uint32_t estimator_kind(const AmbientOcclusionParameters& p) {
    return p.estimator == OcclusionEstimator::obscurance ? 0 : static_cast<uint32_t>(p.measure) + 1;
}

void plan_estimate(Planner& planner, Setup& s) {
    const AmbientOcclusionParameters& p = s.parameters;
    const bool derived = p.normals == NormalSource::derived;
    s.signal = planner.transient("estimate", s.is_wide ? VK_FORMAT_R32G32_UINT : VK_FORMAT_R32_UINT, s.working);
    if (s.images.bent_normal)
        s.bent = planner.transient("bent normals", VK_FORMAT_R32G32B32A32_SFLOAT, s.working);
    const bool tests = s.is_temporal() && p.history_occluders;
    const uint32_t view =
        s.shows_estimate() && p.debug_view != OcclusionView::estimate ? static_cast<uint32_t>(p.debug_view) : 0u;
    Pass& pass = planner.pass("estimate", shader::estimate);
    pass.specialization =
        s.common() + std::initializer_list<uint32_t>{estimator_kind(p),
                                                     static_cast<uint32_t>(p.falloff),
                                                     static_cast<uint32_t>(p.pattern),
                                                     static_cast<uint32_t>(p.taps),
                                                     static_cast<uint32_t>(p.slices),
                                                     static_cast<uint32_t>(p.steps),
                                                     static_cast<uint32_t>(p.normalisation),
                                                     static_cast<uint32_t>(p.noise),
                                                     static_cast<uint32_t>(p.iterations),
                                                     static_cast<uint32_t>(p.depth_mips),
                                                     derived ? 0u : s.normal_encoding(),
                                                     p.thickness >= 100.0f,
                                                     s.has_shadow(),
                                                     bool(s.images.bent_normal),
                                                     tests,
                                                     p.step_power == 1.0f,
                                                     p.pattern != TapPattern::spiral,
                                                     view,
                                                     s.is_direct(),
                                                     s.frame.depth_kind == DepthKind::device,
                                                     s.images.normal.extent == s.extent,
                                                     p.animate_noise || p.iterations > 1,
                                                     s.is_half() && p.upsample != OcclusionUpsample::soma};
    pass.accesses = {s.is_direct() ? read(s.depth) : Access{s.pyramid, AccessKind::fetch, all_mips, false},
                     read(derived ? no_resource : s.normal),
                     read(s.shadow),
                     read(tests ? s.history.previous : no_resource),
                     write(s.signal),
                     write(s.bent != no_resource
                               ? s.bent
                               : planner.transient("no bent normals", VK_FORMAT_R32G32B32A32_SFLOAT, {1, 1}))};
    pass.constants = constants_of(s.constants);
    pass.dispatch = {.kind = DispatchKind::groups, .target = s.signal, .block = {32, 16}};
}

// Bindings and constants of what every last pass does.
void add_finish(Planner& planner, const Setup& s, Pass& pass, bool is_last) {
    const AmbientOcclusionImages& i = s.images;
    const auto output = [&](ResourceId image) {
        const bool is_written = is_last && image != no_resource;
        return write(is_written ? image : planner.transient("not written", VK_FORMAT_R32_SFLOAT, {1, 1}));
    };
    const bool has_output = is_last && i.output;
    const bool has_ambient = has_output && s.parameters.application == OcclusionApplication::ambient;
    pass.accesses.push_back(read(has_output ? s.colour : no_resource));
    pass.accesses.push_back(read(has_ambient ? s.ambient : no_resource));
    pass.accesses.push_back(output(s.visibility));
    pass.accesses.push_back(output(s.soft_shadow));
    pass.accesses.push_back(output(s.output));
    pass.specialization.resize(20, 0);
    pass.specialization.push_back(static_cast<uint32_t>(s.parameters.application));
    pass.specialization.push_back(has_output);
    pass.specialization.push_back(bool(i.soft_shadow));
    pass.specialization.push_back(s.parameters.debug_view == OcclusionView::history_weight);
}

struct FilterPass {
    const char* name;
    bool filters;  // or only blends and finishes
    bool temporal; // blends with the history
    bool to_history;
    bool is_last;
    bool enlarged;
};

// The largest tile whose border fits into the 16 KiB of shared memory that every device has: a word for every texel,
// two for wide signals, and one for every averaged row.
Extent filter_tile(uint32_t border, bool is_wide, bool is_small) {
    for (const Extent tile : {Extent{32, 32}, {32, 24}, {32, 16}, {16, 16}, {16, 8}}) {
        if (is_small && tile.width > 16)
            continue;
        const uint32_t rows = tile.height + 2 * border;
        if (((tile.width + 2 * border) | 1) * rows * (is_wide ? 2 : 1) + tile.width * rows <= 4096)
            return tile;
    }
    return {8, 8};
}

void plan_filter(Planner& planner, Setup& s, const FilterPass& f) {
    const AmbientOcclusionParameters& p = s.parameters;
    const int radius = f.filters ? p.filter_radius : 0;
    const int step = filter_step(p);
    const Extent extent = f.enlarged ? s.extent : s.working;
    const VkFormat format = s.is_wide ? VK_FORMAT_R32G32_UINT : VK_FORMAT_R32_UINT;
    const bool keeps = f.to_history || !f.is_last;
    const ResourceId kept =
        f.to_history ? s.history.current : planner.transient("filtered", format, keeps ? extent : Extent{1, 1});
    const bool uses_normals = f.filters && p.filter_normal > 0.0f && s.images.normal;
    const auto border = static_cast<uint32_t>(std::max(1, radius * step));
    // Few texels: many short threads hide more latency than few long ones.
    const bool is_small = uint64_t{extent.width} * extent.height < 800000;
    const Extent tile = filter_tile(border, s.is_wide, is_small);
    Pass& pass = planner.pass(f.name, shader::filter);
    pass.specialization = s.common() + std::initializer_list<uint32_t>{static_cast<uint32_t>(radius),
                                                                       static_cast<uint32_t>(step),
                                                                       static_cast<uint32_t>(p.filter_weight),
                                                                       p.filter_comparison == DepthDifference::relative,
                                                                       p.filter_slope,
                                                                       uses_normals,
                                                                       s.normal_encoding(),
                                                                       f.temporal,
                                                                       f.temporal && s.images.velocity,
                                                                       f.is_last,
                                                                       keeps,
                                                                       f.enlarged,
                                                                       p.debug_view == OcclusionView::history_weight,
                                                                       tile.width,
                                                                       tile.height,
                                                                       s.has_shadow(),
                                                                       is_small ? 1u : 4u};
    pass.accesses = {read(s.signal),
                     read(no_resource),
                     read(f.temporal ? s.history.previous : no_resource),
                     read(f.temporal ? s.velocity : no_resource),
                     read(uses_normals ? s.normal : no_resource),
                     write(kept),
                     read(no_resource),
                     read(no_resource)};
    add_finish(planner, s, pass, f.is_last);
    pass.constants = constants_of(s.constants);
    const ResourceId target = f.is_last && !keeps ? s.visibility : kept;
    pass.dispatch = {.kind = DispatchKind::groups, .target = target, .block = tile};
    s.signal = kept;
}

// Ends in the host's images, or in a signal of full resolution for the filter.
void plan_upsample(Planner& planner, Setup& s, bool is_last) {
    const OcclusionUpsample kind =
        s.parameters.debug_view == OcclusionView::none ? s.parameters.upsample : OcclusionUpsample::nearest;
    const ResourceId kept = planner.transient("enlarged", s.is_wide ? VK_FORMAT_R32G32_UINT : VK_FORMAT_R32_UINT,
                                              is_last ? Extent{1, 1} : s.extent);
    Pass& pass = planner.pass("upsample", shader::upsample);
    pass.specialization = s.common() + std::initializer_list<uint32_t>{s.frame.depth_kind == DepthKind::device,
                                                                       static_cast<uint32_t>(kind), is_last};
    pass.accesses = {read(s.signal),    read(s.depth),     write(kept),       read(no_resource),
                     read(no_resource), read(no_resource), read(no_resource), read(no_resource)};
    add_finish(planner, s, pass, is_last);
    pass.constants = constants_of(s.constants);
    // A workgroup has 32x16 pixels, the first of which lie one off the image.
    pass.dispatch = {.kind = DispatchKind::groups, .target = is_last ? s.visibility : kept, .block = {31, 15}};
    s.signal = kept;
}

void plan_bend(Planner& planner, Setup& s) {
    Pass& pass = planner.pass("bend", shader::bend);
    pass.specialization =
        s.common() + std::initializer_list<uint32_t>{s.frame.depth_kind == DepthKind::device,
                                                     static_cast<uint32_t>(s.parameters.filter_radius)};
    const ResourceId result = planner.host("bent normal", 8, s.images.bent_normal);
    pass.accesses = {read(s.bent), read(s.depth), write(result)};
    pass.constants = constants_of(s.constants);
    pass.dispatch = {DispatchKind::texels, result, 0, 0};
}

// From the estimate to the host's images.
void plan_filters(Planner& planner, Setup& s) {
    const AmbientOcclusionParameters& p = s.parameters;
    const bool filters = p.filter_radius > 0 && !s.shows_estimate();
    const bool temporal = s.is_temporal();
    const bool late = s.is_half() && p.full_resolution_filter && filters && p.debug_view == OcclusionView::none;
    const bool second = temporal && p.second_filter && filters && p.debug_view == OcclusionView::none;
    const bool ends_here = !s.is_half();
    // Full resolution always ends in a filter pass; half resolution in an enlarging one.
    if ((filters && !late) || temporal || ends_here)
        plan_filter(planner, s,
                    {temporal ? "filter and blend" : "filter", filters && !late, temporal, temporal && !second,
                     ends_here && !second, false});
    if (second)
        plan_filter(planner, s, {"second filter", !late, false, true, ends_here, false});
    if (s.is_half())
        plan_upsample(planner, s, !late);
    if (late)
        plan_filter(planner, s, {"filter", true, false, false, true, true});
}

} // namespace

int spiral_turns(int taps) {
    static constexpr int turns[] = {1,  1,  1,  2,  3,  2,  5,  2,  3,  2,  3,  3,  5,  5,  3,  4,  7,  5,  5,  7,
                                    9,  8,  5,  5,  7,  7,  7,  8,  5,  8,  11, 12, 7,  10, 13, 8,  11, 8,  7,  14,
                                    11, 11, 13, 12, 13, 19, 17, 13, 11, 18, 19, 11, 11, 14, 17, 21, 15, 16, 17, 18,
                                    13, 17, 11, 17, 19, 18, 25, 18, 19, 19, 29, 21, 19, 27, 31, 29, 21, 18, 17, 29,
                                    31, 31, 23, 18, 25, 26, 25, 23, 19, 34, 19, 27, 21, 25, 39, 29, 17, 21, 27, 29};
    return turns[std::clamp(taps, 0, 99)];
}

float occlusion_calibration(const AmbientOcclusionParameters& p) {
    if (p.normalisation == OcclusionNormalisation::vicarious_visions)
        return 2.0f;
    if (p.normalisation == OcclusionNormalisation::plain)
        return 1.0f;
    // In the order of the falloffs: hard, linear, quadratic, sao, contact, wide.
    static constexpr float obscurance[] = {2.73f, 4.38f, 3.74f, 2.54f, 5.84f, 3.28f};
    static constexpr float hbao[] = {0.85f, 0.98f, 0.92f, 0.99f, 1.08f, 0.89f};
    const auto falloff = static_cast<size_t>(p.falloff);
    if (p.estimator == OcclusionEstimator::obscurance)
        return obscurance[falloff];
    return p.measure == HorizonMeasure::hbao ? hbao[falloff] : 1.0f;
}

std::string check_ambient_occlusion(const Frame& frame, const AmbientOcclusionParameters& parameters,
                                    const AmbientOcclusionImages& images) {
    const Matrix4& m = frame.camera->projection;
    if (m[0] == 0.0f || m[5] == 0.0f)
        return "frame.camera.projection scales an axis by 0; ambient occlusion reads positions off it";
    if (images.output && !images.colour)
        return "image 'output' is given, but 'colour' is missing: there is nothing to apply the visibility to";
    if (images.output && parameters.application == OcclusionApplication::ambient && !images.ambient)
        return "application is ambient, but image 'ambient' is missing";
    if (images.soft_shadow && !images.shadow)
        return "image 'soft_shadow' is given, but 'shadow' is missing";
    return "";
}

Plan plan_ambient_occlusion(const Frame& frame, const AmbientOcclusionParameters& parameters,
                            const AmbientOcclusionImages& images) {
    const Extent extent = images.depth.extent;
    Planner planner("ambient-occlusion");
    const bool half = parameters.resolution == OcclusionResolution::half;
    Setup s{.frame = frame,
            .parameters = parameters,
            .images = images,
            .extent = extent,
            .working = half ? Extent{(extent.width + 1) / 2, (extent.height + 1) / 2} : extent};
    set_constants(s);
    s.is_wide = s.is_temporal() || s.has_shadow();
    s.depth = planner.host("depth", 0, images.depth);
    s.normal = planner.host("normal", 1, images.normal);
    s.velocity = planner.host("velocity", 2, images.velocity);
    s.shadow = planner.host("shadow", 3, images.shadow);
    s.colour = planner.host("colour", 4, images.colour);
    s.ambient = planner.host("ambient", 5, images.ambient);
    s.visibility = planner.host("visibility", 6, images.visibility);
    s.soft_shadow = planner.host("soft shadow", 7, images.soft_shadow);
    s.output = planner.host("output", 9, images.output);
    if (s.is_temporal())
        s.history = planner.history("occlusion", VK_FORMAT_R32G32_UINT, s.working);
    if (!s.is_direct())
        plan_prepare(planner, s);
    plan_estimate(planner, s);
    plan_filters(planner, s);
    if (images.bent_normal)
        plan_bend(planner, s);
    return std::move(planner).finish();
}

} // namespace sfumato
