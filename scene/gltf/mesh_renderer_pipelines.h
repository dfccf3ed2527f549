// Render passes, descriptor layouts and pipelines for drawing meshes.
#pragma once

#include "scene/gltf/mesh_renderer_device.h"

#include <array>

namespace sfumato::scene {

// What a pass draws: see mesh_surface.frag.
enum class MeshPass { light, geometry, shadow };
inline constexpr size_t mesh_pass_count = 3;

inline constexpr VkFormat mesh_depth_format = VK_FORMAT_D32_SFLOAT;
inline constexpr VkFormat mesh_target_format = VK_FORMAT_R32G32B32A32_SFLOAT;

// Colour targets of a pass; each has a depth target after them.
constexpr uint32_t mesh_target_count(MeshPass pass) {
    return pass == MeshPass::light ? 2 : pass == MeshPass::geometry ? 3 : 0;
}

// What is bound as vertex buffers, in this order.
struct MeshStaticVertex {
    float texcoord[2];
    float colour[4];
};
struct MeshPosedVertex {
    float position[3];
    float normal[3];
};
enum MeshBinding : uint32_t { mesh_static, mesh_posed, mesh_previous, mesh_next, mesh_binding_count };

struct MeshPipelines {
    MeshObject<VkDescriptorSetLayout> lights;   // set 0: MeshLights (dynamic offset), shadow map
    MeshObject<VkDescriptorSetLayout> material; // set 1: MeshMaterial, four textures
    MeshObject<VkPipelineLayout> layout;
    std::array<MeshObject<VkRenderPass>, mesh_pass_count> render_passes;
    std::array<MeshObject<VkPipeline>, mesh_pass_count> pipelines;

    VkRenderPass render_pass(MeshPass pass) const { return render_passes[static_cast<size_t>(pass)]; }
    VkPipeline pipeline(MeshPass pass) const { return pipelines[static_cast<size_t>(pass)]; }
};

Result<MeshPipelines> make_mesh_pipelines(const MeshDevice& device, VkPipelineCache cache);

} // namespace sfumato::scene
