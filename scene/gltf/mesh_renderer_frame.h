// What one frame of drawing needs of the device: memory for vertices and constants that the host writes anew in every
// frame, and the images that are drawn into.
#pragma once

#include "scene/gltf/mesh_renderer_pipelines.h"
#include "scene/gltf/mesh_shared.h"

#include <optional>
#include <vector>

namespace sfumato::scene {

// A piece of a buffer that the host has written.
struct MeshSlice {
    VkBuffer buffer = VK_NULL_HANDLE;
    VkDeviceSize offset = 0;
    std::byte* mapped = nullptr;
    VkDescriptorSet lights = VK_NULL_HANDLE; // set 0 over this buffer, for a dynamic offset
};

// Given out piece by piece, taken back all at once when the frame has finished on the device.
class MeshArena {
  public:
    // The shadow map stands in every descriptor set for lights.
    MeshArena(const MeshDevice& device, const MeshPipelines& pipelines, const VkDescriptorImageInfo& shadow_map)
        : device_(&device), pipelines_(&pipelines), shadow_map_(shadow_map) {}

    Result<MeshSlice> take(size_t bytes);
    void keep(MeshBuffer buffer) { kept_.push_back(std::move(buffer)); } // until the frame has finished
    void keep(MeshImage image) { kept_images_.push_back(std::move(image)); }
    void keep(MeshObject<VkFramebuffer> framebuffer) { kept_framebuffers_.push_back(std::move(framebuffer)); }
    void reset();

  private:
    struct Chunk {
        MeshBuffer buffer;
        size_t used = 0;
        MeshObject<VkDescriptorPool> pool;
        VkDescriptorSet lights = VK_NULL_HANDLE;
    };
    Result<Chunk> make_chunk(size_t bytes) const;

    const MeshDevice* device_;
    const MeshPipelines* pipelines_;
    VkDescriptorImageInfo shadow_map_;
    std::vector<Chunk> chunks_;
    std::vector<MeshBuffer> kept_;
    std::vector<MeshImage> kept_images_;
    std::vector<MeshObject<VkFramebuffer>> kept_framebuffers_;
};

// A framebuffer with its images, the depth last.
struct MeshTarget {
    std::vector<MeshImage> images;
    MeshObject<VkFramebuffer> framebuffer;
    Extent extent;
};

Result<MeshTarget> make_mesh_target(const MeshDevice& device, const MeshPipelines& pipelines, MeshPass pass,
                                    Extent extent);

} // namespace sfumato::scene
