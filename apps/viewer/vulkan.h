// The Vulkan functions that drawing and presenting take beyond those of every program, looked up at run time.
#pragma once

#include "apps/common/device.h"

namespace sfumato::viewer {

#define SFUMATO_VIEWER_FUNCTIONS(X)                                                                                    \
    X(CreateRenderPass)                                                                                                \
    X(DestroyRenderPass)                                                                                               \
    X(CreateFramebuffer)                                                                                               \
    X(DestroyFramebuffer)                                                                                              \
    X(CreateShaderModule)                                                                                              \
    X(DestroyShaderModule)                                                                                             \
    X(CreatePipelineLayout)                                                                                            \
    X(DestroyPipelineLayout)                                                                                           \
    X(CreateGraphicsPipelines)                                                                                         \
    X(DestroyPipeline)                                                                                                 \
    X(CreateSampler)                                                                                                   \
    X(DestroySampler)                                                                                                  \
    X(CreateDescriptorSetLayout)                                                                                       \
    X(DestroyDescriptorSetLayout)                                                                                      \
    X(CreateDescriptorPool)                                                                                            \
    X(DestroyDescriptorPool)                                                                                           \
    X(AllocateDescriptorSets)                                                                                          \
    X(UpdateDescriptorSets)                                                                                            \
    X(CmdBeginRenderPass)                                                                                              \
    X(CmdEndRenderPass)                                                                                                \
    X(CmdBindPipeline)                                                                                                 \
    X(CmdBindDescriptorSets)                                                                                           \
    X(CmdBindVertexBuffers)                                                                                            \
    X(CmdBindIndexBuffer)                                                                                              \
    X(CmdPushConstants)                                                                                                \
    X(CmdSetViewport)                                                                                                  \
    X(CmdSetScissor)                                                                                                   \
    X(CmdDrawIndexed)                                                                                                  \
    X(CmdBlitImage)                                                                                                    \
    X(CreateSemaphore)                                                                                                 \
    X(DestroySemaphore)                                                                                                \
    X(CreateSwapchainKHR)                                                                                              \
    X(DestroySwapchainKHR)                                                                                             \
    X(GetSwapchainImagesKHR)                                                                                           \
    X(AcquireNextImageKHR)                                                                                             \
    X(QueuePresentKHR)                                                                                                 \
    X(DestroySurfaceKHR)                                                                                               \
    X(GetPhysicalDeviceSurfaceSupportKHR)                                                                              \
    X(GetPhysicalDeviceSurfaceCapabilitiesKHR)                                                                         \
    X(GetPhysicalDeviceSurfaceFormatsKHR)

// What a device without a window has not is null.
struct DrawingFunctions {
#define X(name) PFN_vk##name name = nullptr;
    SFUMATO_VIEWER_FUNCTIONS(X)
#undef X
};

inline DrawingFunctions load_drawing_functions(const apps::Device& device) {
    DrawingFunctions functions;
    const auto find = [&](const char* name) {
        const PFN_vkVoidFunction found = device.functions().GetDeviceProcAddr(device.handle(), name);
        return found ? found : device.functions().GetInstanceProcAddr(device.instance(), name);
    };
#define X(name) functions.name = reinterpret_cast<PFN_vk##name>(find("vk" #name));
    SFUMATO_VIEWER_FUNCTIONS(X)
#undef X
    return functions;
}

} // namespace sfumato::viewer
