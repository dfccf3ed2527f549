// Inputs for ambient occlusion and the device's answers to them.
#include "tests/gpu/ambient_occlusion_support.h"

#include "effects/ambient_occlusion/ambient_occlusion_plan.h"

#include <cmath>

namespace sfumato::test {
namespace {

// One context for all tests, so that a pipeline is made once. It outlives them on purpose.
Context& context() {
    static Context* const shared = make_context(1).release();
    return *shared;
}

scene::SceneRenderer& renderer() {
    static scene::SceneRenderer* const shared =
        expect_value(scene::SceneRenderer::create(context()), "renderer").release();
    return *shared;
}

uint64_t next_index() {
    static uint64_t index = 0;
    return index++;
}

apps::HostImage blank(VkFormat format, Extent extent) {
    return expect_value(device().create_image(format, extent), "image");
}

} // namespace

OcclusionInput render_input(const scene::Scene& scene, int frame, Extent extent, int rays, scene::Falloff falloff,
                            double radius) {
    constexpr VkFormat one = VK_FORMAT_R32_SFLOAT, four = VK_FORMAT_R32G32B32A32_SFLOAT;
    const apps::HostImage depth = blank(one, extent), normal = blank(four, extent), shadow = blank(one, extent);
    const apps::HostImage velocity = blank(VK_FORMAT_R32G32_SFLOAT, extent);
    const apps::HostImage colour = blank(four, extent), ambient = blank(four, extent);
    const apps::HostImage truth = blank(one, extent), bent = blank(four, extent);
    scene::SceneImages images;
    images.depth = depth.image();
    images.normal = normal.image();
    images.velocity = velocity.image();
    images.shadow = shadow.image();
    images.colour = colour.image();
    images.ambient = ambient.image();
    if (rays > 0) {
        images.true_visibility = truth.image();
        images.true_bent_normal = bent.image();
    }
    scene::RenderOptions options;
    options.samples = 1;
    options.occlusion = {radius, falloff, std::max(1, rays), 0};
    run_commands([&](VkCommandBuffer commands) {
        expect_done(renderer().record(commands, scene, frame, options, images, next_index()), "scene");
    });
    OcclusionInput input{scene::frame_facts(scene, frame, extent),
                         read_back(depth),
                         read_back(normal),
                         read_back(velocity),
                         read_back(shadow),
                         read_back(colour),
                         read_back(ambient),
                         {},
                         {}};
    if (rays > 0) {
        input.truth = read_back(truth);
        input.true_bent_normal = read_back(bent);
    }
    return input;
}

double device_depth(const Frame& frame, double z) {
    if (frame.depth_kind == DepthKind::linear)
        return z;
    const Matrix4& p = frame.camera->projection;
    return (double{p[14]} - double{p[10]} * z) / (double{p[15]} - double{p[11]} * z);
}

namespace {

// clip.z = a Z + b for the near plane 0.1 and the far plane 1000.
void set_depth_range(Matrix4& p, DepthCode code, bool perspective) {
    const float n = 0.1f, f = 1000.0f;
    if (perspective) {
        p[10] = code == DepthCode::reversed ? n / (f - n) : code == DepthCode::standard ? f / (n - f) : 0.0f;
        p[14] = code == DepthCode::reversed ? f * n / (f - n) : code == DepthCode::standard ? f * n / (n - f) : n;
    } else {
        p[10] = code == DepthCode::standard ? 1.0f / (n - f) : 1.0f / (f - n);
        p[14] = code == DepthCode::standard ? n / (n - f) : f / (f - n);
    }
}

} // namespace

Frame perspective_frame(Extent extent, double focal, double shift, DepthCode code) {
    const double aspect = static_cast<double>(extent.width) / extent.height;
    Camera camera;
    const auto s = static_cast<float>(2.0 * shift);
    camera.projection = {static_cast<float>(2.0 * focal / aspect),
                         0,
                         0,
                         0,
                         0,
                         static_cast<float>(-2.0 * focal),
                         0,
                         0,
                         s,
                         0.5f * s,
                         0,
                         -1,
                         0,
                         0,
                         0,
                         0};
    set_depth_range(camera.projection, code, true);
    Frame frame;
    frame.camera = camera;
    frame.previous_camera = camera;
    frame.depth_kind = code == DepthCode::linear ? DepthKind::linear : DepthKind::device;
    return frame;
}

Frame orthographic_frame(Extent extent, double view_height, double shift, DepthCode code) {
    const double aspect = static_cast<double>(extent.width) / extent.height;
    Camera camera;
    const auto s = static_cast<float>(2.0 * shift);
    camera.projection = {static_cast<float>(2.0 / (view_height * aspect)),
                         0,
                         0,
                         0,
                         0,
                         static_cast<float>(-2.0 / view_height),
                         0,
                         0,
                         0,
                         0,
                         0,
                         0,
                         s,
                         0.5f * s,
                         0,
                         1};
    set_depth_range(camera.projection, code, false);
    Frame frame;
    frame.camera = camera;
    frame.previous_camera = camera;
    frame.depth_kind = code == DepthCode::linear ? DepthKind::linear : DepthKind::device;
    return frame;
}

OcclusionInput plane_input(const Frame& frame, Extent extent, std::array<double, 3> n, double distance) {
    OcclusionInput input;
    input.frame = frame;
    const Matrix4& p = frame.camera->projection;
    const bool perspective = p[11] != 0.0f;
    const double length = std::hypot(n[0], n[1], n[2]);
    for (double& component : n)
        component /= length;
    input.normal = make_image(extent, 3, [&](uint32_t, uint32_t, float* pixel) {
        for (size_t i = 0; i < 3; ++i)
            pixel[i] = static_cast<float>(n[i]);
    });
    input.depth = make_image(extent, 1, [&](uint32_t x, uint32_t y, float* pixel) {
        const double ndc_x = 2.0 * (x + 0.5) / extent.width - 1.0, ndc_y = 2.0 * (y + 0.5) / extent.height - 1.0;
        // A point of the ray: (a + b z, c + d z, -z).
        const double a = perspective ? 0.0 : (ndc_x - double{p[12]}) / double{p[0]};
        const double c = perspective ? 0.0 : (ndc_y - double{p[13]}) / double{p[5]};
        const double b = perspective ? (ndc_x + double{p[8]}) / double{p[0]} : 0.0;
        const double d = perspective ? (ndc_y + double{p[9]}) / double{p[5]} : 0.0;
        const double slope = n[0] * b + n[1] * d - n[2];
        const double z = (-distance - n[0] * a - n[1] * c) / slope;
        const bool seen = z > 0.0 && std::isfinite(z) && z < 1e6;
        *pixel = seen                                    ? static_cast<float>(device_depth(frame, z))
                 : frame.depth_kind == DepthKind::linear ? 1e10f
                                                         : static_cast<float>(device_depth(frame, 1e30));
    });
    return input;
}

OcclusionStream::OcclusionStream() : rig_(context(), AmbientOcclusion::info()) {}

OcclusionOutput OcclusionStream::run(const OcclusionInput& input, const AmbientOcclusionParameters& parameters,
                                     bool optional) {
    const auto give = [&](const char* role, const FloatImage& image, bool wanted) {
        if (wanted && !image.values.empty())
            rig_.set(role, image);
        else
            rig_.remove(role);
    };
    give("depth", input.depth, true);
    give("normal", input.normal, true);
    give("velocity", input.velocity, true);
    give("shadow", input.shadow, optional);
    give("colour", input.colour, optional);
    give("ambient", input.ambient, optional);
    rig_.optional_outputs = optional;
    FloatImage all = rig_.run(input.frame, &parameters);
    const Extent extent = input.extent();
    const size_t size = size_t{extent.width} * extent.height * all.components;
    const auto part = [&](size_t i) {
        if ((i + 1) * size > all.values.size())
            return FloatImage{};
        const auto first = all.values.begin() + static_cast<std::ptrdiff_t>(i * size);
        return FloatImage{extent, all.components, {first, first + static_cast<std::ptrdiff_t>(size)}};
    };
    return {part(0), part(1), part(2), part(3)};
}

OcclusionOutput occlude(const OcclusionInput& input, const AmbientOcclusionParameters& parameters, bool optional) {
    return OcclusionStream().run(input, parameters, optional);
}

AmbientOcclusionParameters plain_parameters() {
    AmbientOcclusionParameters p;
    p.radius = 1.5f;
    p.falloff = OcclusionFalloff::hard;
    p.estimator = OcclusionEstimator::horizon;
    p.measure = HorizonMeasure::bitmask;
    p.slices = 4;
    p.steps = 8;
    p.step_power = 1.0f;
    p.thickness = 0.67f;
    p.taps = 12;
    p.bias = 0.02f;
    p.depth_bias = 0.00005f;
    p.radius_limit = 2.0f;
    p.noise = OcclusionNoise::blocks;
    p.resolution = OcclusionResolution::full;
    p.depth_mips = DepthMips::rotated;
    p.mip_rate = 3.0f;
    p.normals = NormalSource::given;
    p.filter_radius = 0;
    p.filter_step = 1;
    p.filter_sigma = 2.0f;
    p.filter_weight = DepthWeight::gaussian;
    p.filter_comparison = DepthDifference::relative;
    p.filter_depth = 0.02f;
    p.filter_slope = true;
    p.filter_normal = 0.0f;
    p.temporal = false;
    p.upsample = OcclusionUpsample::relative;
    p.upsample_depth = 0.02f;
    return p;
}

Deviation deviation(const OcclusionOutput& a, const OcclusionOutput& b, double tolerance) {
    return deviation(
        a.visibility.extent.width, a.visibility.extent.height, tolerance,
        [&](uint32_t x, uint32_t y) { return a.at(x, y); }, [&](uint32_t x, uint32_t y) { return b.at(x, y); });
}

Deviation error_of(const OcclusionOutput& a, const OcclusionInput& truth) {
    return deviation(
        truth.extent().width, truth.extent().height, 0.1, [&](uint32_t x, uint32_t y) { return a.at(x, y); },
        [&](uint32_t x, uint32_t y) { return double{*truth.truth.at(x, y)}; });
}

reference::Grid<1> depth_grid(const OcclusionInput& input) {
    reference::Grid<1> grid(static_cast<int>(input.extent().width), static_cast<int>(input.extent().height));
    for (size_t i = 0; i < grid.texels.size(); ++i)
        grid.texels[i] = {double{input.depth.values[i]}};
    return grid;
}

reference::Grid<3> normal_grid(const OcclusionInput& input) {
    if (input.normal.values.empty())
        return {};
    reference::Grid<3> grid(static_cast<int>(input.extent().width), static_cast<int>(input.extent().height));
    for (size_t i = 0; i < grid.texels.size(); ++i)
        for (size_t c = 0; c < 3; ++c)
            grid.texels[i][c] = double{input.normal.values[i * input.normal.components + c]};
    return grid;
}

reference::AmbientOcclusionReference reference_of(const OcclusionInput& input,
                                                  const AmbientOcclusionParameters& parameters) {
    const int taps = parameters.pattern == TapPattern::mirrored_spiral ? (parameters.taps + 1) / 2 : parameters.taps;
    return {depth_grid(input), normal_grid(input), input.frame, parameters, double{occlusion_calibration(parameters)},
            spiral_turns(taps)};
}

} // namespace sfumato::test
