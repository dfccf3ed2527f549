// Runs motion blur on the device and in the reference from one description of the input.
#include "tests/gpu/motion_blur_support.h"

#include <cmath>

namespace sfumato::test {

namespace {

// One device for all tests of the process: opening one costs more than most tests. It outlives them on purpose.
struct Rig {
    std::unique_ptr<apps::Device> device;
    std::unique_ptr<Context> context;
    std::unique_ptr<Context> plain; // without subgroup operations
};

Rig* rig() {
    static Rig* const shared = [] {
        auto device = apps::Device::create({.device = "", .validation = true, .labels = true});
        if (!device) {
            ADD_FAILURE() << device.error().message;
            return static_cast<Rig*>(nullptr);
        }
        auto context = Context::create((*device)->context_info());
        if (!context) {
            ADD_FAILURE() << context.error().message;
            return static_cast<Rig*>(nullptr);
        }
        ContextInfo info = (*device)->context_info();
        info.subgroups = false;
        auto plain = Context::create(info);
        if (!plain) {
            ADD_FAILURE() << plain.error().message;
            return static_cast<Rig*>(nullptr);
        }
        return new Rig{std::move(*device), std::move(*context), std::move(*plain)};
    }();
    return shared;
}

template <int N>
apps::HostImage upload(apps::Device& device, const reference::Grid<N>& grid) {
    constexpr VkFormat formats[] = {VK_FORMAT_R32_SFLOAT, VK_FORMAT_R32G32_SFLOAT, VK_FORMAT_UNDEFINED,
                                    VK_FORMAT_R32G32B32A32_SFLOAT};
    if (grid.empty())
        return {};
    auto image =
        device.create_image(formats[N - 1], {static_cast<uint32_t>(grid.width), static_cast<uint32_t>(grid.height)});
    if (!image) {
        ADD_FAILURE() << image.error().message;
        return {};
    }
    std::vector<float> values;
    for (const auto& texel : grid.texels)
        for (const double value : texel)
            values.push_back(static_cast<float>(value));
    if (auto uploaded = device.upload(*image, values, N); !uploaded)
        ADD_FAILURE() << uploaded.error().message;
    return std::move(*image);
}

double texture(double x, double y, int channel) {
    return 0.5 + 0.25 * std::sin(0.55 * x + channel) * std::cos(0.4 * y - channel) +
           0.2 * std::sin(0.13 * x * (channel + 1) + 0.21 * y);
}

} // namespace

reference::Grid<4> blur_on_device(const BlurInput& input, const MotionBlurParameters& parameters, const Frame& frame,
                                  bool subgroups) {
    reference::Grid<4> result(input.colour.width, input.colour.height);
    Rig* r = rig();
    if (!r)
        return result;
    apps::Device& device = *r->device;
    const auto colour = upload(device, input.colour), depth = upload(device, input.depth);
    const auto velocity = upload(device, input.velocity), next = upload(device, input.next_velocity);
    const auto exclusion = upload(device, input.exclusion);
    std::vector<apps::HostImage> layers;
    for (const auto& layer : input.layers) {
        layers.push_back(upload(device, layer.velocity));
        layers.push_back(upload(device, layer.mask));
    }
    layers.resize(4);
    auto output = device.create_image(VK_FORMAT_R32G32B32A32_SFLOAT, colour.extent());
    auto effect = MotionBlur::create(subgroups ? *r->context : *r->plain);
    if (!output || !effect) {
        ADD_FAILURE() << "could not create the effect or its output";
        return result;
    }
    MotionBlurImages images;
    images.colour = colour.image();
    images.depth = depth.image();
    images.velocity = velocity.image();
    images.next_velocity = next.image();
    images.layer_1 = layers[0].image();
    images.layer_1_mask = layers[1].image();
    images.layer_2 = layers[2].image();
    images.layer_2_mask = layers[3].image();
    images.exclusion_mask = exclusion.image();
    images.output = output->image();
    auto commands = device.begin();
    EXPECT_TRUE(commands);
    const auto recorded = (*effect)->record(*commands, frame, parameters, images);
    EXPECT_TRUE(recorded) << recorded.error().message;
    const auto finished = device.submit_and_wait();
    EXPECT_TRUE(finished) << finished.error().message;
    auto pixels = device.readback(*output);
    EXPECT_TRUE(pixels);
    for (size_t i = 0; pixels && i < result.texels.size(); ++i)
        for (size_t c = 0; c < 4; ++c)
            result.texels[i][c] = double{(*pixels)[4 * i + c]};
    for (const std::string& message : device.validation_messages())
        ADD_FAILURE() << message;
    device.clear_validation_messages();
    return result;
}

reference::MotionBlurSettings settings_of(const MotionBlurParameters& p, const Frame& frame) {
    reference::MotionBlurSettings s;
    s.shutter = double{p.shutter};
    s.position = static_cast<reference::ShutterPosition>(p.shutter_position);
    s.curve = static_cast<reference::ShutterCurve>(p.shutter_curve);
    s.radius = double{p.radius};
    s.repair_edges = p.repair_edges;
    s.storage = p.storage == VelocityStorage::packed ? reference::Storage::packed : reference::Storage::half;
    s.tile_size = p.tile;
    s.dilation = static_cast<reference::Dilation>(p.dilation);
    s.test_edge_neighbours = p.test_edge_neighbours;
    s.classify = p.tile_classes;
    s.uniform_tolerance = double{p.uniform_tolerance};
    s.uniform_pixels = double{p.uniform_pixels} / 1080.0; // of the height
    s.weighting = static_cast<reference::Weighting>(p.weighting);
    s.taps = p.taps;
    s.search_taps = p.search_taps;
    s.least_taps = p.least_taps;
    s.second_direction = p.second_direction;
    s.filter_taps = p.filter_taps;
    s.taps_per_pixel = double{p.taps_per_pixel};
    s.alternate = p.alternate;
    s.jitter_amount = double{p.jitter_amount};
    s.tile_jitter = p.tile_jitter;
    s.jitter = static_cast<reference::TapJitter>(p.jitter);
    s.hdr_weighting = p.hdr_weighting;
    s.soft_extent_kind = static_cast<reference::SoftExtent>(p.depth_comparison);
    s.soft_extent = double{p.soft_extent};
    s.background_weight = double{p.weight_background};
    s.foreground_weight = double{p.weight_foreground};
    s.mutual_weight = double{p.weight_mutual};
    s.centre_weight = double{p.weight_centre};
    s.iterations = p.iterations;
    s.is_steady = p.iterations == 1 && !p.animate_jitter;
    s.frame = p.animate_jitter ? static_cast<int>(frame.index % 64) : 0;
    return s;
}

BlurInput disc_scene(int width, int height) {
    BlurInput input;
    input.colour = reference::Grid<4>(width, height);
    input.depth = reference::Grid<1>(width, height);
    input.velocity = reference::Grid<2>(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const bool disc = std::hypot(x - 0.4 * width, y - 0.5 * height) < 0.25 * height;
            const bool pillar = x > 0.75 * width && x < 0.82 * width;
            for (int c = 0; c < 3; ++c)
                input.colour.at(x, y)[static_cast<size_t>(c)] = texture(x, y, c) + (disc ? 0.6 : pillar ? 0.3 : 0.0);
            input.colour.at(x, y)[3] = disc ? 1.0 : 0.5;
            input.depth.at(x, y) = {disc ? 3.0 : pillar ? 5.0 : 10.0};
            input.velocity.at(x, y) = disc     ? std::array{0.2 * height, 0.1 * height + 0.05 * y}
                                      : pillar ? std::array{0.0, 0.0}
                                               : std::array{-0.05 * height, 0.0};
        }
    return input;
}

BlurInput pan_scene(int width, int height, double velocity_x, double velocity_y) {
    BlurInput input;
    input.colour = reference::Grid<4>(width, height);
    input.depth = reference::Grid<1>(width, height);
    input.velocity = reference::Grid<2>(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            for (int c = 0; c < 3; ++c)
                input.colour.at(x, y)[static_cast<size_t>(c)] = texture(x, y, c);
            input.colour.at(x, y)[3] = 1.0;
            input.depth.at(x, y) = {8.0};
            input.velocity.at(x, y) = {velocity_x, velocity_y};
        }
    return input;
}

Difference difference(const reference::Grid<4>& a, const reference::Grid<4>& b, double threshold) {
    Difference result;
    double sum = 0.0;
    size_t above = 0;
    for (size_t i = 0; i < a.texels.size(); ++i) {
        double worst = 0.0;
        for (size_t c = 0; c < 4; ++c) {
            const double d = std::fabs(a.texels[i][c] - b.texels[i][c]);
            // NaN must not pass for equal.
            worst = d <= worst ? worst : d;
            sum += d * d;
        }
        result.largest = worst <= result.largest ? result.largest : worst;
        above += worst <= threshold ? 0 : 1;
    }
    const auto count = static_cast<double>(a.texels.size());
    result.root_mean_square = std::sqrt(sum / (4.0 * count));
    result.share_above = static_cast<double>(above) / count;
    return result;
}

} // namespace sfumato::test
