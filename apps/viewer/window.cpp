// Window, surface, swapchain.
#include "apps/viewer/window.h"

#include "apps/common/device_choice.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <algorithm>

namespace sfumato::viewer {

namespace {

std::string glfw_message(const std::string& otherwise) {
    const char* text = nullptr;
    return glfwGetError(&text) != GLFW_NO_ERROR && text ? text : otherwise;
}

bool must_be_made_anew(VkResult result) {
    return result == VK_ERROR_OUT_OF_DATE_KHR || result == VK_SUBOPTIMAL_KHR || result == VK_ERROR_SURFACE_LOST_KHR;
}

} // namespace

Result<std::unique_ptr<Window>> Window::open(Extent size, const std::string& title) {
    if (glfwInit() != GLFW_TRUE)
        return Error{ErrorCode::unsupported, "no display: " + glfw_message("a window system is needed")};
    std::unique_ptr<Window> made(new Window);
    if (glfwVulkanSupported() != GLFW_TRUE)
        return Error{ErrorCode::unsupported, "no Vulkan for windows: " + glfw_message("the loader finds no driver")};
    glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
    made->window_ =
        glfwCreateWindow(static_cast<int>(size.width), static_cast<int>(size.height), title.c_str(), nullptr, nullptr);
    if (!made->window_)
        return Error{ErrorCode::unsupported, "no window: " + glfw_message("it could not be made")};
    return made;
}

Window::~Window() {
    detach();
    if (window_)
        glfwDestroyWindow(window_);
    glfwTerminate();
}

std::vector<std::string> Window::instance_extensions() {
    uint32_t count = 0;
    const char** names = glfwGetRequiredInstanceExtensions(&count);
    return names ? std::vector<std::string>(names, names + count) : std::vector<std::string>{};
}

float Window::content_scale() const {
    float x = 1.0f, y = 1.0f;
    glfwGetWindowContentScale(window_, &x, &y);
    return std::clamp(x, 1.0f, 4.0f);
}

bool Window::should_close() const {
    return glfwWindowShouldClose(window_) != 0;
}

Extent Window::framebuffer() const {
    int width = 0, height = 0;
    glfwGetFramebufferSize(window_, &width, &height);
    if (glfwGetWindowAttrib(window_, GLFW_ICONIFIED) != 0)
        return {};
    return {static_cast<uint32_t>(std::max(width, 0)), static_cast<uint32_t>(std::max(height, 0))};
}

void Window::poll(double seconds) {
    if (seconds > 0.0)
        glfwWaitEventsTimeout(seconds);
    else
        glfwPollEvents();
}

Result<void> Window::attach(apps::Device& device) {
    device_ = &device;
    vk_ = load_drawing_functions(device);
    auto commands = device.create_commands();
    if (!commands)
        return commands.error();
    commands_ = std::move(*commands);
    VkSemaphoreCreateInfo semaphore{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
    if (const VkResult result = vk_.CreateSemaphore(device.handle(), &semaphore, nullptr, &acquired_);
        result != VK_SUCCESS)
        return apps::vulkan_error(result, "vkCreateSemaphore");
    return make_surface();
}

void Window::detach() {
    if (!device_)
        return;
    static_cast<void>(static_cast<bool>(device_->wait_idle()));
    destroy_swapchain();
    if (surface_)
        vk_.DestroySurfaceKHR(device_->instance(), surface_, nullptr);
    surface_ = VK_NULL_HANDLE;
    vk_.DestroySemaphore(device_->handle(), acquired_, nullptr);
    acquired_ = VK_NULL_HANDLE;
    commands_ = {};
    device_ = nullptr;
}

Result<void> Window::make_surface() {
    destroy_swapchain();
    if (surface_)
        vk_.DestroySurfaceKHR(device_->instance(), surface_, nullptr);
    surface_ = VK_NULL_HANDLE;
    if (const VkResult result = glfwCreateWindowSurface(device_->instance(), window_, nullptr, &surface_);
        result != VK_SUCCESS)
        return apps::vulkan_error(result, "glfwCreateWindowSurface");
    VkBool32 can_present = VK_FALSE;
    vk_.GetPhysicalDeviceSurfaceSupportKHR(device_->physical_device(), device_->queue_family(), surface_, &can_present);
    if (!can_present)
        return Error{ErrorCode::unsupported, device_->name() + " cannot show pictures in this window; another --device "
                                                               "may (list devices)"};
    return {};
}

void Window::destroy_swapchain() {
    for (const Target& target : targets_)
        vk_.DestroySemaphore(device_->handle(), target.finished, nullptr);
    targets_.clear();
    if (swapchain_)
        vk_.DestroySwapchainKHR(device_->handle(), swapchain_, nullptr);
    swapchain_ = VK_NULL_HANDLE;
    extent_ = {};
}

// Leaves no swapchain while the window has no size.
Result<void> Window::make_swapchain() {
    if (auto idle = device_->wait_idle(); !idle)
        return idle;
    VkSurfaceCapabilitiesKHR can{};
    VkResult result = vk_.GetPhysicalDeviceSurfaceCapabilitiesKHR(device_->physical_device(), surface_, &can);
    if (result == VK_ERROR_SURFACE_LOST_KHR)
        return make_surface();
    if (result != VK_SUCCESS)
        return apps::vulkan_error(result, "vkGetPhysicalDeviceSurfaceCapabilitiesKHR");
    Extent extent = framebuffer();
    if (can.currentExtent.width != UINT32_MAX)
        extent = {can.currentExtent.width, can.currentExtent.height};
    extent.width = std::min(extent.width, can.maxImageExtent.width);
    extent.height = std::min(extent.height, can.maxImageExtent.height);
    destroy_swapchain();
    if (!extent)
        return {};
    uint32_t count = 0;
    vk_.GetPhysicalDeviceSurfaceFormatsKHR(device_->physical_device(), surface_, &count, nullptr);
    std::vector<VkSurfaceFormatKHR> formats(count);
    vk_.GetPhysicalDeviceSurfaceFormatsKHR(device_->physical_device(), surface_, &count, formats.data());
    // The canvas holds what the display takes; an sRGB format would encode it again.
    const auto plain = std::ranges::find_if(formats, [](const auto& one) {
        return one.format == VK_FORMAT_B8G8R8A8_UNORM || one.format == VK_FORMAT_R8G8B8A8_UNORM ||
               one.format == VK_FORMAT_A8B8G8R8_UNORM_PACK32;
    });
    if (plain == formats.end() || !(can.supportedUsageFlags & VK_IMAGE_USAGE_TRANSFER_DST_BIT))
        return Error{ErrorCode::unsupported,
                     device_->name() + " has no window format of 8 bits a channel that can be copied to"};
    VkSwapchainCreateInfoKHR info{VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR};
    info.surface = surface_;
    info.minImageCount = std::max(can.minImageCount, 2u);
    if (can.maxImageCount > 0)
        info.minImageCount = std::min(info.minImageCount, can.maxImageCount);
    info.imageFormat = plain->format;
    info.imageColorSpace = plain->colorSpace;
    info.imageExtent = {extent.width, extent.height};
    info.imageArrayLayers = 1;
    info.imageUsage = VK_IMAGE_USAGE_TRANSFER_DST_BIT;
    info.imageSharingMode = VK_SHARING_MODE_EXCLUSIVE;
    info.preTransform = can.currentTransform;
    info.compositeAlpha = can.supportedCompositeAlpha & VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR
                              ? VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR
                              : VK_COMPOSITE_ALPHA_INHERIT_BIT_KHR;
    info.presentMode = VK_PRESENT_MODE_FIFO_KHR; // always there
    info.clipped = VK_TRUE;
    result = vk_.CreateSwapchainKHR(device_->handle(), &info, nullptr, &swapchain_);
    if (must_be_made_anew(result)) {
        swapchain_ = VK_NULL_HANDLE;
        return result == VK_ERROR_SURFACE_LOST_KHR ? make_surface() : Result<void>{};
    }
    if (result != VK_SUCCESS)
        return apps::vulkan_error(result, "vkCreateSwapchainKHR");
    vk_.GetSwapchainImagesKHR(device_->handle(), swapchain_, &count, nullptr);
    std::vector<VkImage> images(count);
    vk_.GetSwapchainImagesKHR(device_->handle(), swapchain_, &count, images.data());
    VkSemaphoreCreateInfo semaphore{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
    for (const VkImage image : images) {
        Target& target = targets_.emplace_back();
        target.image = image;
        if (result = vk_.CreateSemaphore(device_->handle(), &semaphore, nullptr, &target.finished);
            result != VK_SUCCESS)
            return apps::vulkan_error(result, "vkCreateSemaphore");
    }
    extent_ = extent;
    return {};
}

Result<void> Window::copy(const Image& canvas, uint32_t index) {
    if (auto begun = device_->begin(commands_); !begun)
        return begun;
    const VkCommandBuffer commands = commands_.buffer();
    VkImageMemoryBarrier barrier{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER};
    barrier.dstAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
    barrier.oldLayout = VK_IMAGE_LAYOUT_UNDEFINED;
    barrier.newLayout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
    barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.image = targets_[index].image;
    barrier.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    VkMemoryBarrier drawn{VK_STRUCTURE_TYPE_MEMORY_BARRIER};
    drawn.srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT;
    drawn.dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT;
    device_->functions().CmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                                            VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 1, &drawn, 0, nullptr, 1, &barrier);
    VkImageBlit blit{};
    blit.srcSubresource = blit.dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    blit.srcOffsets[1] = {static_cast<int32_t>(canvas.extent.width), static_cast<int32_t>(canvas.extent.height), 1};
    blit.dstOffsets[1] = {static_cast<int32_t>(extent_.width), static_cast<int32_t>(extent_.height), 1};
    vk_.CmdBlitImage(commands, canvas.handle, VK_IMAGE_LAYOUT_GENERAL, targets_[index].image,
                     VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &blit, VK_FILTER_NEAREST);
    barrier.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
    barrier.dstAccessMask = 0;
    barrier.oldLayout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
    barrier.newLayout = VK_IMAGE_LAYOUT_PRESENT_SRC_KHR;
    device_->functions().CmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT,
                                            VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, 0, 0, nullptr, 0, nullptr, 1,
                                            &barrier);
    return device_->submit(commands_, acquired_, VK_PIPELINE_STAGE_TRANSFER_BIT, targets_[index].finished);
}

Result<void> Window::present(const Image& canvas) {
    if (!swapchain_)
        if (auto made = make_swapchain(); !made)
            return made;
    if (!swapchain_)
        return {};
    uint32_t index = 0;
    VkResult result =
        vk_.AcquireNextImageKHR(device_->handle(), swapchain_, UINT64_MAX, acquired_, VK_NULL_HANDLE, &index);
    if (result == VK_ERROR_SURFACE_LOST_KHR)
        return make_surface();
    if (result == VK_ERROR_OUT_OF_DATE_KHR) {
        destroy_swapchain();
        return {};
    }
    if (result != VK_SUCCESS && result != VK_SUBOPTIMAL_KHR)
        return apps::vulkan_error(result, "vkAcquireNextImageKHR");
    if (auto copied = copy(canvas, index); !copied)
        return copied;
    VkPresentInfoKHR info{VK_STRUCTURE_TYPE_PRESENT_INFO_KHR};
    info.waitSemaphoreCount = 1;
    info.pWaitSemaphores = &targets_[index].finished;
    info.swapchainCount = 1;
    info.pSwapchains = &swapchain_;
    info.pImageIndices = &index;
    const VkResult presented = vk_.QueuePresentKHR(device_->queue(), &info);
    if (auto waited = device_->wait(commands_); !waited)
        return waited;
    if (presented != VK_SUCCESS && !must_be_made_anew(presented))
        return apps::vulkan_error(presented, "vkQueuePresentKHR");
    if (presented == VK_ERROR_SURFACE_LOST_KHR)
        return make_surface();
    if (must_be_made_anew(presented) || must_be_made_anew(result)) {
        if (auto idle = device_->wait_idle(); !idle)
            return idle;
        destroy_swapchain();
    }
    return {};
}

} // namespace sfumato::viewer
