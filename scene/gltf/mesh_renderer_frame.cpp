// Memory and targets of a frame.
#include "scene/gltf/mesh_renderer_frame.h"

#include <algorithm>

namespace sfumato::scene {
namespace {

constexpr size_t chunk_bytes = 1 << 20;
constexpr size_t alignment = 256; // no device asks for more, neither for constants nor for copies

} // namespace

Result<MeshArena::Chunk> MeshArena::make_chunk(size_t bytes) const {
    constexpr VkBufferUsageFlags usage =
        VK_BUFFER_USAGE_VERTEX_BUFFER_BIT | VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
    auto buffer = device_->create_buffer(std::max(bytes, chunk_bytes), usage);
    if (!buffer)
        return buffer.error();
    Chunk chunk{std::move(*buffer), 0, {}, VK_NULL_HANDLE};
    const MeshFunctions& vk = device_->functions();
    const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC, 1},
                                          {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1}};
    VkDescriptorPoolCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
    info.maxSets = 1;
    info.poolSizeCount = 2;
    info.pPoolSizes = sizes;
    auto pool = device_->make(vk.CreateDescriptorPool, vk.DestroyDescriptorPool, info, "vkCreateDescriptorPool");
    if (!pool)
        return pool.error();
    chunk.pool = std::move(*pool);
    const VkDescriptorSetLayout layout = pipelines_->lights;
    const VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO, nullptr, chunk.pool, 1,
                                               &layout};
    if (const VkResult result = vk.AllocateDescriptorSets(device_->handle(), &allocate, &chunk.lights);
        result != VK_SUCCESS)
        return MeshDevice::failed("vkAllocateDescriptorSets", result);
    const VkDescriptorBufferInfo range{chunk.buffer.buffer, 0, sizeof(shared::MeshLights)};
    const VkWriteDescriptorSet writes[] = {{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET, nullptr, chunk.lights, 0, 0, 1,
                                            VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC, nullptr, &range, nullptr},
                                           {VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET, nullptr, chunk.lights, 1, 0, 1,
                                            VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, &shadow_map_, nullptr, nullptr}};
    vk.UpdateDescriptorSets(device_->handle(), 2, writes, 0, nullptr);
    return chunk;
}

Result<MeshSlice> MeshArena::take(size_t bytes) {
    // Lights are read through a window of their size, which must lie within the buffer wherever it begins.
    const size_t needed = std::max(bytes, sizeof(shared::MeshLights));
    const auto fits = [&](const Chunk& chunk) { return chunk.buffer.size - chunk.used >= needed; };
    auto found = std::ranges::find_if(chunks_, fits);
    if (found == chunks_.end()) {
        auto made = make_chunk(needed);
        if (!made)
            return made.error();
        chunks_.push_back(std::move(*made));
        found = chunks_.end() - 1;
    }
    const MeshSlice slice{found->buffer.buffer, found->used, found->buffer.mapped + found->used, found->lights};
    found->used = std::min((found->used + needed + alignment - 1) / alignment * alignment, found->buffer.size);
    return slice;
}

void MeshArena::reset() {
    for (Chunk& chunk : chunks_)
        chunk.used = 0;
    kept_.clear();
    kept_framebuffers_.clear();
    kept_images_.clear();
}

Result<MeshTarget> make_mesh_target(const MeshDevice& device, const MeshPipelines& pipelines, MeshPass pass,
                                    Extent extent) {
    MeshTarget target;
    target.extent = extent;
    std::vector<VkImageView> views;
    const uint32_t count = mesh_target_count(pass);
    for (uint32_t i = 0; i <= count; ++i) {
        const bool is_depth = i == count;
        const bool is_read = !is_depth || pass == MeshPass::shadow;
        const VkImageUsageFlags usage =
            (is_depth ? VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT : VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT) |
            (is_read ? VkImageUsageFlags{VK_IMAGE_USAGE_SAMPLED_BIT} : 0u);
        auto image = device.create_image(is_depth ? mesh_depth_format : mesh_target_format, extent, 1, usage);
        if (!image)
            return image.error();
        views.push_back(image->view);
        target.images.push_back(std::move(*image));
    }
    VkFramebufferCreateInfo info{VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO};
    info.renderPass = pipelines.render_pass(pass);
    info.attachmentCount = static_cast<uint32_t>(views.size());
    info.pAttachments = views.data();
    info.width = extent.width;
    info.height = extent.height;
    info.layers = 1;
    const MeshFunctions& vk = device.functions();
    auto framebuffer = device.make(vk.CreateFramebuffer, vk.DestroyFramebuffer, info, "vkCreateFramebuffer");
    if (!framebuffer)
        return framebuffer.error();
    target.framebuffer = std::move(*framebuffer);
    return target;
}

} // namespace sfumato::scene
