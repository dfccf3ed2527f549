// Draws what Dear ImGui asks for onto the canvas.
#pragma once

#include "apps/common/device.h"
#include "apps/viewer/vulkan.h"

#include <memory>

struct ImDrawData;

namespace sfumato::viewer {

inline constexpr VkFormat canvas_format = VK_FORMAT_R8G8B8A8_UNORM;

class UiRenderer {
  public:
    // Uploads the font atlas of the current ImGui context. The device must be able to draw.
    static Result<std::unique_ptr<UiRenderer>> create(apps::Device& device);
    ~UiRenderer();

    // Over what is on the canvas, an image of canvas_format in GENERAL that can be a colour attachment. Earlier compute
    // writes of the queue to it are waited for, and later transfers from it see the result. The previous call's
    // commands have finished.
    Result<void> record(VkCommandBuffer commands, const ImDrawData& data, const Image& canvas);

    // Before the canvas goes.
    void forget_canvas();

  private:
    explicit UiRenderer(apps::Device& device) : device_(device), vk_(load_drawing_functions(device)) {}
    Result<void> make_font();
    Result<void> make_pass();
    Result<void> make_pipeline();
    Result<void> make_framebuffer(const Image& canvas);
    Result<void> upload(const ImDrawData& data);
    void draw(VkCommandBuffer commands, const ImDrawData& data, Extent extent) const;

    apps::Device& device_;
    DrawingFunctions vk_;
    apps::HostImage font_;
    apps::HostBuffer vertices_, indices_;
    VkSampler sampler_ = VK_NULL_HANDLE;
    VkDescriptorSetLayout set_layout_ = VK_NULL_HANDLE;
    VkDescriptorPool pool_ = VK_NULL_HANDLE;
    VkDescriptorSet set_ = VK_NULL_HANDLE;
    VkPipelineLayout layout_ = VK_NULL_HANDLE;
    VkRenderPass pass_ = VK_NULL_HANDLE;
    VkPipeline pipeline_ = VK_NULL_HANDLE;
    VkFramebuffer framebuffer_ = VK_NULL_HANDLE;
    VkImageView framebuffer_view_ = VK_NULL_HANDLE;
};

} // namespace sfumato::viewer
