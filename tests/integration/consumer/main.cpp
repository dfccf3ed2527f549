// Motion blur in a program that has its own Vulkan device. What is Sfumato's stands between the marks; the umbrella
// header's comment shows the same lines.
#include "host.h"

#include <cmath>
#include <cstdio>
#include <sfumato/sfumato.h>

namespace {

int fail(const char* what) {
    std::fprintf(stderr, "%s\n", what);
    return 1;
}

// White left of the middle, black right of it; everything moves 16 pixels a frame to the right.
std::vector<float> edge() {
    std::vector<float> values;
    for (uint32_t i = 0; i < Host::width * Host::height; ++i)
        for (int c = 0; c < 4; ++c)
            values.push_back(c == 3 || i % Host::width < Host::width / 2 ? 1.0f : 0.0f);
    return values;
}

std::vector<float> motion() {
    std::vector<float> values;
    for (uint32_t i = 0; i < Host::width * Host::height; ++i) {
        values.push_back(16.0f);
        values.push_back(0.0f);
    }
    return values;
}

// Shutter 0.5: the edge is seen over 8 pixels around the middle, and untouched away from it.
bool is_blurred_edge(const std::vector<float>& output) {
    const auto at = [&](uint32_t x, uint32_t y) { return output[(y * Host::width + x) * 4]; };
    for (uint32_t y = 0; y < Host::height; ++y) {
        double sum = 0.0;
        for (uint32_t x = 0; x < Host::width; ++x) {
            if (!std::isfinite(at(x, y)))
                return false;
            if ((x < 58 && at(x, y) != 1.0f) || (x >= 70 && at(x, y) != 0.0f))
                return false;
            sum += double{at(x, y)};
        }
        if (std::abs(sum - 64.0) > 2.0 || at(62, y) > 0.95f || at(65, y) < 0.05f)
            return false;
    }
    return true;
}

// Creates the device with what the library asks for, then blurs one frame.
int blur(Host& host, const HostImage& colour, const HostImage& velocity, const HostImage& output) {
    const VkExtent2D size{Host::width, Host::height};
    const auto as_image = [&](const HostImage& image) {
        return sfumato::Image{
            image.image, image.view, image.format, {size.width, size.height}, VK_IMAGE_LAYOUT_GENERAL};
    };
    const VkCommandBuffer commands = host.begin();
    const uint64_t frame_index = 0;
    const float seconds = 1.0f / 60.0f;

    // [sfumato
    // Once, on your device (created with sfumato::requirements().features enabled):
    sfumato::ContextInfo info;
    info.instance = host.instance;
    info.physical_device = host.physical_device;
    info.device = host.device;
    info.get_instance_proc_addr = vkGetInstanceProcAddr;
    info.get_device_proc_addr = vkGetDeviceProcAddr;
    auto context = sfumato::Context::create(info);
    if (!context)
        return fail(context.error().message.c_str());
    auto motion_blur = sfumato::MotionBlur::create(**context);
    if (!motion_blur)
        return fail(motion_blur.error().message.c_str());
    // Every frame, into your command buffer; your images stay in the layout they are in:
    sfumato::Frame frame;
    frame.index = frame_index;
    frame.time_step = seconds;
    sfumato::MotionBlurParameters parameters; // or *sfumato::preset<sfumato::MotionBlurParameters>("low")
    sfumato::MotionBlurImages images;
    images.colour = as_image(colour); // sfumato::Image{image, view, format, {width, height}, layout}
    images.velocity = as_image(velocity);
    images.output = as_image(output);
    if (auto recorded = (*motion_blur)->record(commands, frame, parameters, images); !recorded)
        return fail(recorded.error().message.c_str());
    // sfumato]

    host.submit_and_wait(commands);
    return 0;
}

} // namespace

int main() {
    Host host(sfumato::requirements().features);
    HostImage colour = host.create_image(4, edge());
    HostImage velocity = host.create_image(2, motion());
    HostImage output = host.create_image(4, std::vector<float>(size_t{4} * Host::width * Host::height, NAN));
    int result = blur(host, colour, velocity, output);
    if (result == 0 && !is_blurred_edge(host.read(output)))
        result = fail("the output is not the blurred edge");
    for (HostImage* image : {&colour, &velocity, &output})
        host.destroy(*image);
    return result;
}
