// Depth is reversed: 1 is near, cleared to 0; in the shadow map it is not.
#include "scene/gltf/mesh_renderer_pipelines.h"

#include "scene/gltf/mesh_shared.h"
#include "shaders/mesh_surface.h"
#include "shaders/mesh_vertex.h"

#include <cstddef>
#include <vector>

namespace sfumato::scene {
namespace {

namespace vertex_code = sfumato::shaders::mesh_vertex;
namespace fragment_code = sfumato::shaders::mesh_surface;

Result<MeshObject<VkDescriptorSetLayout>> make_set_layout(const MeshDevice& device,
                                                          std::span<const VkDescriptorType> types) {
    std::vector<VkDescriptorSetLayoutBinding> bindings;
    for (const VkDescriptorType type : types)
        bindings.push_back({static_cast<uint32_t>(bindings.size()), type, 1, VK_SHADER_STAGE_FRAGMENT_BIT, nullptr});
    VkDescriptorSetLayoutCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
    info.bindingCount = static_cast<uint32_t>(bindings.size());
    info.pBindings = bindings.data();
    const MeshFunctions& vk = device.functions();
    return device.make(vk.CreateDescriptorSetLayout, vk.DestroyDescriptorSetLayout, info,
                       "vkCreateDescriptorSetLayout");
}

Result<MeshObject<VkRenderPass>> make_render_pass(const MeshDevice& device, MeshPass pass) {
    const uint32_t count = mesh_target_count(pass);
    std::vector<VkAttachmentDescription> attachments(count + 1);
    std::vector<VkAttachmentReference> colours;
    for (uint32_t i = 0; i <= count; ++i) {
        const bool is_depth = i == count, is_map = pass == MeshPass::shadow;
        VkAttachmentDescription& target = attachments[i];
        target.format = is_depth ? mesh_depth_format : mesh_target_format;
        target.samples = VK_SAMPLE_COUNT_1_BIT;
        target.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;
        target.storeOp = is_depth && !is_map ? VK_ATTACHMENT_STORE_OP_DONT_CARE : VK_ATTACHMENT_STORE_OP_STORE;
        target.stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
        target.stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
        target.initialLayout = VK_IMAGE_LAYOUT_UNDEFINED;
        target.finalLayout = !is_depth ? VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL
                             : is_map  ? VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL
                                       : VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
        if (!is_depth)
            colours.push_back({i, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL});
    }
    const VkAttachmentReference depth{count, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL};
    VkSubpassDescription subpass{};
    subpass.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS;
    subpass.colorAttachmentCount = count;
    subpass.pColorAttachments = colours.data();
    subpass.pDepthStencilAttachment = &depth;
    // What was drawn is read by shaders; it is drawn again when they have done so.
    constexpr VkPipelineStageFlags readers =
        VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT | VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT;
    constexpr VkPipelineStageFlags writers = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT |
                                             VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT |
                                             VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT;
    constexpr VkAccessFlags writes =
        VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
    constexpr VkAccessFlags reads = VK_ACCESS_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_READ_BIT;
    const VkSubpassDependency dependencies[] = {
        {VK_SUBPASS_EXTERNAL, 0, readers | writers, writers, writes, writes | reads, 0},
        {0, VK_SUBPASS_EXTERNAL, writers, readers, writes, VK_ACCESS_SHADER_READ_BIT, 0}};
    VkRenderPassCreateInfo info{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO};
    info.attachmentCount = count + 1;
    info.pAttachments = attachments.data();
    info.subpassCount = 1;
    info.pSubpasses = &subpass;
    info.dependencyCount = 2;
    info.pDependencies = dependencies;
    const MeshFunctions& vk = device.functions();
    return device.make(vk.CreateRenderPass, vk.DestroyRenderPass, info, "vkCreateRenderPass");
}

struct VertexInput {
    std::vector<VkVertexInputBindingDescription> bindings;
    std::vector<VkVertexInputAttributeDescription> attributes;
};

VertexInput vertex_input(MeshPass pass) {
    constexpr auto vec2 = VK_FORMAT_R32G32_SFLOAT, vec3 = VK_FORMAT_R32G32B32_SFLOAT,
                   vec4 = VK_FORMAT_R32G32B32A32_SFLOAT;
    constexpr uint32_t position = offsetof(MeshPosedVertex, position), normal = offsetof(MeshPosedVertex, normal);
    VertexInput input;
    const auto bind = [&](uint32_t binding, size_t stride) {
        input.bindings.push_back({binding, static_cast<uint32_t>(stride), VK_VERTEX_INPUT_RATE_VERTEX});
    };
    bind(mesh_static, sizeof(MeshStaticVertex));
    bind(mesh_posed, sizeof(MeshPosedVertex));
    input.attributes = {{MESH_TEXCOORD, mesh_static, vec2, offsetof(MeshStaticVertex, texcoord)},
                        {MESH_COLOUR, mesh_static, vec4, offsetof(MeshStaticVertex, colour)},
                        {MESH_POSITION, mesh_posed, vec3, position}};
    if (pass != MeshPass::shadow)
        input.attributes.push_back({MESH_NORMAL, mesh_posed, vec3, normal});
    if (pass == MeshPass::geometry) {
        bind(mesh_previous, sizeof(MeshPosedVertex));
        bind(mesh_next, sizeof(MeshPosedVertex));
        input.attributes.push_back({MESH_PREVIOUS, mesh_previous, vec3, position});
        input.attributes.push_back({MESH_NEXT, mesh_next, vec3, position});
    }
    return input;
}

struct Stages {
    std::array<MeshObject<VkShaderModule>, 2> modules;
    std::array<VkPipelineShaderStageCreateInfo, 2> infos{};
};

Result<Stages> make_stages(const MeshDevice& device, MeshPass pass) {
    constexpr Shader vertices[] = {vertex_code::light, vertex_code::geometry, vertex_code::shadow};
    constexpr Shader fragments[] = {fragment_code::light, fragment_code::geometry, fragment_code::shadow};
    const Shader shaders[] = {vertices[static_cast<size_t>(pass)], fragments[static_cast<size_t>(pass)]};
    const MeshFunctions& vk = device.functions();
    Stages stages;
    for (size_t i = 0; i < 2; ++i) {
        VkShaderModuleCreateInfo info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
        info.codeSize = shaders[i].code.size_bytes();
        info.pCode = shaders[i].code.data();
        auto made = device.make(vk.CreateShaderModule, vk.DestroyShaderModule, info, "vkCreateShaderModule");
        if (!made)
            return made.error();
        stages.modules[i] = std::move(*made);
        stages.infos[i].sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
        stages.infos[i].stage = i == 0 ? VK_SHADER_STAGE_VERTEX_BIT : VK_SHADER_STAGE_FRAGMENT_BIT;
        stages.infos[i].module = stages.modules[i];
        stages.infos[i].pName = "main";
    }
    return stages;
}

Result<MeshObject<VkPipeline>> make_pipeline(const MeshDevice& device, const MeshPipelines& made, MeshPass pass,
                                             VkPipelineCache cache) {
    auto stages = make_stages(device, pass);
    if (!stages)
        return stages.error();
    const VertexInput input = vertex_input(pass);
    VkPipelineVertexInputStateCreateInfo vertices{VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
    vertices.vertexBindingDescriptionCount = static_cast<uint32_t>(input.bindings.size());
    vertices.pVertexBindingDescriptions = input.bindings.data();
    vertices.vertexAttributeDescriptionCount = static_cast<uint32_t>(input.attributes.size());
    vertices.pVertexAttributeDescriptions = input.attributes.data();
    VkPipelineInputAssemblyStateCreateInfo assembly{VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
    assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
    VkPipelineViewportStateCreateInfo viewport{VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO};
    viewport.viewportCount = viewport.scissorCount = 1;
    VkPipelineRasterizationStateCreateInfo raster{VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
    raster.polygonMode = VK_POLYGON_MODE_FILL;
    // Which side is seen is for the shader to judge: it differs from material to material.
    raster.cullMode = VK_CULL_MODE_NONE;
    raster.frontFace = VK_FRONT_FACE_COUNTER_CLOCKWISE;
    raster.lineWidth = 1.0f;
    raster.depthBiasEnable = pass == MeshPass::shadow;
    // The tent of the shadow's filter reaches one and a half texels to each side.
    raster.depthBiasSlopeFactor = 2.0f;
    VkPipelineMultisampleStateCreateInfo samples{VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
    samples.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
    VkPipelineDepthStencilStateCreateInfo depth{VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO};
    depth.depthTestEnable = depth.depthWriteEnable = VK_TRUE;
    depth.depthCompareOp = pass == MeshPass::shadow ? VK_COMPARE_OP_LESS : VK_COMPARE_OP_GREATER;
    VkPipelineColorBlendAttachmentState opaque{};
    opaque.colorWriteMask =
        VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT | VK_COLOR_COMPONENT_B_BIT | VK_COLOR_COMPONENT_A_BIT;
    const std::vector<VkPipelineColorBlendAttachmentState> targets(mesh_target_count(pass), opaque);
    VkPipelineColorBlendStateCreateInfo blend{VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO};
    blend.attachmentCount = static_cast<uint32_t>(targets.size());
    blend.pAttachments = targets.data();
    const VkDynamicState states[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
    VkPipelineDynamicStateCreateInfo dynamic{VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO};
    dynamic.dynamicStateCount = 2;
    dynamic.pDynamicStates = states;
    VkGraphicsPipelineCreateInfo info{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO};
    info.stageCount = 2;
    info.pStages = stages->infos.data();
    info.pVertexInputState = &vertices;
    info.pInputAssemblyState = &assembly;
    info.pViewportState = &viewport;
    info.pRasterizationState = &raster;
    info.pMultisampleState = &samples;
    info.pDepthStencilState = &depth;
    info.pColorBlendState = &blend;
    info.pDynamicState = &dynamic;
    info.layout = made.layout;
    info.renderPass = made.render_pass(pass);
    VkPipeline pipeline = VK_NULL_HANDLE;
    const MeshFunctions& vk = device.functions();
    if (const VkResult result = vk.CreateGraphicsPipelines(device.handle(), cache, 1, &info, nullptr, &pipeline);
        result != VK_SUCCESS)
        return MeshDevice::failed("vkCreateGraphicsPipelines", result);
    return MeshObject<VkPipeline>(device.handle(), pipeline, vk.DestroyPipeline);
}

Result<void> make_layouts(const MeshDevice& device, MeshPipelines& made) {
    constexpr auto image = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    constexpr VkDescriptorType lights[] = {VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC, image};
    constexpr VkDescriptorType material[] = {VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, image, image, image, image};
    auto set_0 = make_set_layout(device, lights);
    auto set_1 = make_set_layout(device, material);
    if (!set_0 || !set_1)
        return set_0 ? set_1.error() : set_0.error();
    made.lights = std::move(*set_0);
    made.material = std::move(*set_1);
    const VkDescriptorSetLayout sets[] = {made.lights, made.material};
    const VkPushConstantRange push{VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0,
                                   sizeof(shared::MeshDraw)};
    static_assert(sizeof(shared::MeshDraw) <= 128, "Vulkan promises no more push constants");
    VkPipelineLayoutCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    info.setLayoutCount = 2;
    info.pSetLayouts = sets;
    info.pushConstantRangeCount = 1;
    info.pPushConstantRanges = &push;
    const MeshFunctions& vk = device.functions();
    auto layout = device.make(vk.CreatePipelineLayout, vk.DestroyPipelineLayout, info, "vkCreatePipelineLayout");
    if (!layout)
        return layout.error();
    made.layout = std::move(*layout);
    return {};
}

} // namespace

Result<MeshPipelines> make_mesh_pipelines(const MeshDevice& device, VkPipelineCache cache) {
    MeshPipelines made;
    if (auto layouts = make_layouts(device, made); !layouts)
        return layouts.error();
    for (const MeshPass pass : {MeshPass::light, MeshPass::geometry, MeshPass::shadow}) {
        auto render_pass = make_render_pass(device, pass);
        if (!render_pass)
            return render_pass.error();
        made.render_passes[static_cast<size_t>(pass)] = std::move(*render_pass);
        auto pipeline = make_pipeline(device, made, pass, cache);
        if (!pipeline)
            return pipeline.error();
        made.pipelines[static_cast<size_t>(pass)] = std::move(*pipeline);
    }
    return made;
}

} // namespace sfumato::scene
