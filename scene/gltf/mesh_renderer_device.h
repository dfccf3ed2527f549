// Vulkan for drawing meshes: the functions that it takes, and buffers and images that free themselves. The library's
// own part of the work, compute, goes through Executor.
#pragma once

#include "sfumato/context.h"
#include "sfumato/image.h"

#include <memory>
#include <span>

namespace sfumato::scene {

#define SFUMATO_MESH_DEVICE_FUNCTIONS(X)                                                                               \
    X(AllocateMemory)                                                                                                  \
    X(FreeMemory)                                                                                                      \
    X(MapMemory)                                                                                                       \
    X(CreateBuffer)                                                                                                    \
    X(DestroyBuffer)                                                                                                   \
    X(GetBufferMemoryRequirements)                                                                                     \
    X(BindBufferMemory)                                                                                                \
    X(CreateImage)                                                                                                     \
    X(DestroyImage)                                                                                                    \
    X(GetImageMemoryRequirements)                                                                                      \
    X(BindImageMemory)                                                                                                 \
    X(CreateImageView)                                                                                                 \
    X(DestroyImageView)                                                                                                \
    X(CreateSampler)                                                                                                   \
    X(DestroySampler)                                                                                                  \
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
    X(CreateDescriptorSetLayout)                                                                                       \
    X(DestroyDescriptorSetLayout)                                                                                      \
    X(CreateDescriptorPool)                                                                                            \
    X(DestroyDescriptorPool)                                                                                           \
    X(AllocateDescriptorSets)                                                                                          \
    X(UpdateDescriptorSets)                                                                                            \
    X(CmdPipelineBarrier)                                                                                              \
    X(CmdCopyBufferToImage)                                                                                            \
    X(CmdBlitImage)                                                                                                    \
    X(CmdBeginRenderPass)                                                                                              \
    X(CmdEndRenderPass)                                                                                                \
    X(CmdBindPipeline)                                                                                                 \
    X(CmdBindDescriptorSets)                                                                                           \
    X(CmdBindVertexBuffers)                                                                                            \
    X(CmdBindIndexBuffer)                                                                                              \
    X(CmdPushConstants)                                                                                                \
    X(CmdSetViewport)                                                                                                  \
    X(CmdSetScissor)                                                                                                   \
    X(CmdDrawIndexed)

struct MeshFunctions {
#define X(name) PFN_vk##name name = nullptr;
    SFUMATO_MESH_DEVICE_FUNCTIONS(X)
#undef X
};

class MeshDevice;

// Any handle that one function of the device destroys.
template <class Handle>
class MeshObject {
  public:
    using Destroy = void(VKAPI_PTR*)(VkDevice, Handle, const VkAllocationCallbacks*);
    MeshObject() = default;
    MeshObject(VkDevice device, Handle handle, Destroy destroy) : device_(device), handle_(handle), destroy_(destroy) {}
    MeshObject(MeshObject&& other) noexcept { swap(other); }
    MeshObject& operator=(MeshObject&& other) noexcept {
        MeshObject(std::move(other)).swap(*this);
        return *this;
    }
    ~MeshObject() {
        if (handle_ != VK_NULL_HANDLE)
            destroy_(device_, handle_, nullptr);
    }
    operator Handle() const { return handle_; }

  private:
    void swap(MeshObject& other) noexcept {
        std::swap(device_, other.device_);
        std::swap(handle_, other.handle_);
        std::swap(destroy_, other.destroy_);
    }
    VkDevice device_ = VK_NULL_HANDLE;
    Handle handle_ = VK_NULL_HANDLE;
    Destroy destroy_ = nullptr;
};

// In host memory, mapped and coherent.
struct MeshBuffer {
    MeshObject<VkDeviceMemory> memory;
    MeshObject<VkBuffer> buffer; // goes before its memory
    std::byte* mapped = nullptr;
    size_t size = 0;
};

struct MeshImage {
    MeshObject<VkDeviceMemory> memory;
    MeshObject<VkImage> image;
    MeshObject<VkImageView> view; // of all levels
    VkFormat format = VK_FORMAT_UNDEFINED;
    Extent extent;
    uint32_t levels = 1;

    // As the executor takes it.
    Image in(VkImageLayout layout) const { return {image, view, format, extent, layout}; }
};

// Vulkan objects of the host and the functions to use them. Externally synchronised like its context.
class MeshDevice {
  public:
    // Errors (unsupported): a function that the driver lacks.
    static Result<std::unique_ptr<MeshDevice>> create(const ContextInfo& info);

    const MeshFunctions& functions() const { return functions_; }
    VkDevice handle() const { return device_; }
    const VkPhysicalDeviceLimits& limits() const { return limits_; }
    bool has_features(VkFormat format, VkFormatFeatureFlags features) const;

    Result<MeshBuffer> create_buffer(size_t bytes, VkBufferUsageFlags usage) const;
    Result<MeshImage> create_image(VkFormat format, Extent extent, uint32_t levels, VkImageUsageFlags usage) const;

    // Wraps the handle that vkCreate… made, or tells why there is none.
    template <class Handle, class Info>
    Result<MeshObject<Handle>>
    make(VkResult(VKAPI_PTR* creator)(VkDevice, const Info*, const VkAllocationCallbacks*, Handle*),
         typename MeshObject<Handle>::Destroy destroyer, const Info& info, const char* call) const {
        Handle made = VK_NULL_HANDLE;
        if (const VkResult result = creator(device_, &info, nullptr, &made); result != VK_SUCCESS)
            return failed(call, result);
        return MeshObject<Handle>(device_, made, destroyer);
    }

    // "drawing meshes: vkCreateImage failed: …"
    static Error failed(const char* call, VkResult result);

  private:
    MeshDevice() = default;
    Result<MeshObject<VkDeviceMemory>> allocate(const VkMemoryRequirements& needs, VkMemoryPropertyFlags required,
                                                const char* what) const;

    MeshFunctions functions_;
    VkDevice device_ = VK_NULL_HANDLE;
    VkPhysicalDevice physical_device_ = VK_NULL_HANDLE;
    PFN_vkGetPhysicalDeviceFormatProperties format_properties_ = nullptr;
    VkPhysicalDeviceMemoryProperties memory_{};
    VkPhysicalDeviceLimits limits_{};
};

} // namespace sfumato::scene
