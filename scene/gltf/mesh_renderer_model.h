// A glTF model on the device: what does not change from frame to frame.
#pragma once

#include "scene/gltf/mesh_renderer_pipelines.h"
#include "scene/gltf/model.h"

#include <map>
#include <vector>

namespace sfumato::scene {

// A run of triangles with one material.
struct MeshDraw {
    uint32_t first_index = 0, count = 0;
    uint32_t node = 0, material = 0;
};

class MeshModel {
  public:
    // `mesh`: the model at any moment. Errors: out of memory, textures beyond what the device can hold.
    static Result<std::unique_ptr<MeshModel>> create(const MeshDevice& device, const MeshPipelines& pipelines,
                                                     const Model& model, const TriangleMesh& mesh);

    // Textures and their mip levels, once. What comes back must stay until the commands have run.
    std::vector<MeshBuffer> record_uploads(VkCommandBuffer commands);

    std::span<const MeshDraw> draws() const { return draws_; }
    VkDescriptorSet material(uint32_t index) const { return sets_[index]; }
    VkBuffer vertices() const { return vertices_.buffer; }
    VkBuffer indices() const { return indices_.buffer; }
    size_t vertex_count() const { return vertex_count_; }

  private:
    explicit MeshModel(const MeshDevice& device) : device_(&device) {}
    Result<void> add_geometry(const Model& model, const TriangleMesh& mesh);
    Result<void> add_texture(const Texture& texture);
    Result<VkSampler> sampler(const Texture& texture);
    Result<void> add_materials(const MeshPipelines& pipelines, const Model& model);
    void record_upload(VkCommandBuffer commands, const MeshImage& image, const MeshBuffer& pixels) const;
    void barrier(VkCommandBuffer commands, const MeshImage& image, uint32_t level, uint32_t count, VkImageLayout before,
                 VkImageLayout after) const;

    const MeshDevice* device_;
    std::vector<MeshDraw> draws_;
    size_t vertex_count_ = 0;
    MeshBuffer vertices_, indices_, materials_;
    std::vector<MeshImage> textures_; // the model's, then white
    std::vector<MeshBuffer> pixels_;  // of each, until they are uploaded
    std::map<uint32_t, MeshObject<VkSampler>> samplers_;
    MeshObject<VkDescriptorPool> pool_;
    std::vector<VkDescriptorSet> sets_;
};

} // namespace sfumato::scene
