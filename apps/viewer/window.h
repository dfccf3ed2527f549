// The window: GLFW, a surface and a swapchain onto which finished canvases are copied.
#pragma once

#include "apps/common/device.h"
#include "apps/viewer/vulkan.h"

#include <memory>
#include <string>
#include <vector>

struct GLFWwindow;

namespace sfumato::viewer {

class Window {
  public:
    // Needs a display. Error (unsupported): there is none, or one without Vulkan.
    static Result<std::unique_ptr<Window>> open(Extent size, const std::string& title);
    ~Window();
    Window(const Window&) = delete;
    Window& operator=(const Window&) = delete;

    GLFWwindow* handle() const { return window_; }
    static std::vector<std::string> instance_extensions();
    float content_scale() const;

    // Once, with a device that was made with the extensions above and VK_KHR_swapchain; it must outlive the window or
    // be detached first. Error: the device cannot show pictures in this window.
    Result<void> attach(apps::Device& device);
    void detach();

    bool should_close() const;
    Extent framebuffer() const; // 0×0 while minimised

    // Waits for events for so many seconds, not at all for 0.
    void poll(double seconds);

    // Shows the canvas, scaled if the window has just changed its size. What has become of the swapchain or the surface
    // meanwhile is mended now or in the next call. Error: the device is lost, out of memory.
    Result<void> present(const Image& canvas);

  private:
    Window() = default;
    struct Target {
        VkImage image = VK_NULL_HANDLE;
        VkSemaphore finished = VK_NULL_HANDLE; // one an image: presenting may still wait for it in the next frame
    };

    Result<void> make_surface();
    Result<void> make_swapchain();
    void destroy_swapchain();
    Result<void> copy(const Image& canvas, uint32_t index);

    GLFWwindow* window_ = nullptr;
    apps::Device* device_ = nullptr;
    DrawingFunctions vk_;
    VkSurfaceKHR surface_ = VK_NULL_HANDLE;
    VkSwapchainKHR swapchain_ = VK_NULL_HANDLE;
    Extent extent_;
    std::vector<Target> targets_;
    VkSemaphore acquired_ = VK_NULL_HANDLE;
    apps::Commands commands_;
};

} // namespace sfumato::viewer
