// A pipeline for textured triangles. Debian's own back end for Vulkan is linked to the loader; this one finds its
// functions at run time like the rest of the program.
#include "apps/viewer/ui_renderer.h"

#include "apps/common/device_choice.h"
#include "shaders/ui.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <imgui.h>

namespace sfumato::viewer {

namespace {

struct Transform {
    float scale[2];
    float offset[2];
};

Result<void> checked(VkResult result, const char* what) {
    return result == VK_SUCCESS ? Result<void>{} : Result<void>(apps::vulkan_error(result, what));
}

} // namespace

Result<std::unique_ptr<UiRenderer>> UiRenderer::create(apps::Device& device) {
    std::unique_ptr<UiRenderer> made(new UiRenderer(device));
    for (const auto step : {&UiRenderer::make_font, &UiRenderer::make_pass, &UiRenderer::make_pipeline})
        if (auto done = (made.get()->*step)(); !done)
            return done.error();
    return made;
}

UiRenderer::~UiRenderer() {
    static_cast<void>(static_cast<bool>(device_.wait_idle()));
    forget_canvas();
    const VkDevice device = device_.handle();
    vk_.DestroyPipeline(device, pipeline_, nullptr);
    vk_.DestroyRenderPass(device, pass_, nullptr);
    vk_.DestroyPipelineLayout(device, layout_, nullptr);
    vk_.DestroyDescriptorPool(device, pool_, nullptr);
    vk_.DestroyDescriptorSetLayout(device, set_layout_, nullptr);
    vk_.DestroySampler(device, sampler_, nullptr);
}

void UiRenderer::forget_canvas() {
    vk_.DestroyFramebuffer(device_.handle(), framebuffer_, nullptr);
    framebuffer_ = VK_NULL_HANDLE;
    framebuffer_view_ = VK_NULL_HANDLE;
}

Result<void> UiRenderer::make_font() {
    unsigned char* pixels = nullptr;
    int width = 0, height = 0;
    ImGui::GetIO().Fonts->GetTexDataAsRGBA32(&pixels, &width, &height);
    const Extent extent = {static_cast<uint32_t>(width), static_cast<uint32_t>(height)};
    auto image = device_.create_image(VK_FORMAT_R8G8B8A8_UNORM, extent);
    if (!image)
        return image.error();
    font_ = std::move(*image);
    const auto* bytes = reinterpret_cast<const std::byte*>(pixels);
    if (auto uploaded = device_.upload_bytes(font_, {bytes, size_t{extent.width} * extent.height * 4}); !uploaded)
        return uploaded;

    VkSamplerCreateInfo sampler{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
    sampler.magFilter = sampler.minFilter = VK_FILTER_LINEAR;
    sampler.addressModeU = sampler.addressModeV = sampler.addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
    if (auto made = checked(vk_.CreateSampler(device_.handle(), &sampler, nullptr, &sampler_), "vkCreateSampler");
        !made)
        return made;
    VkDescriptorSetLayoutBinding binding{0, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1, VK_SHADER_STAGE_FRAGMENT_BIT,
                                         nullptr};
    VkDescriptorSetLayoutCreateInfo set_layout{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
    set_layout.bindingCount = 1;
    set_layout.pBindings = &binding;
    if (auto made = checked(vk_.CreateDescriptorSetLayout(device_.handle(), &set_layout, nullptr, &set_layout_),
                            "vkCreateDescriptorSetLayout");
        !made)
        return made;
    const VkDescriptorPoolSize size = {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1};
    VkDescriptorPoolCreateInfo pool{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
    pool.maxSets = 1;
    pool.poolSizeCount = 1;
    pool.pPoolSizes = &size;
    if (auto made =
            checked(vk_.CreateDescriptorPool(device_.handle(), &pool, nullptr, &pool_), "vkCreateDescriptorPool");
        !made)
        return made;
    VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
    allocate.descriptorPool = pool_;
    allocate.descriptorSetCount = 1;
    allocate.pSetLayouts = &set_layout_;
    if (auto made = checked(vk_.AllocateDescriptorSets(device_.handle(), &allocate, &set_), "vkAllocateDescriptorSets");
        !made)
        return made;
    const VkDescriptorImageInfo font = {sampler_, font_.image().view, VK_IMAGE_LAYOUT_GENERAL};
    VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
    write.dstSet = set_;
    write.descriptorCount = 1;
    write.descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    write.pImageInfo = &font;
    vk_.UpdateDescriptorSets(device_.handle(), 1, &write, 0, nullptr);
    return {};
}

Result<void> UiRenderer::make_pass() {
    VkAttachmentDescription attachment{};
    attachment.format = canvas_format;
    attachment.samples = VK_SAMPLE_COUNT_1_BIT;
    attachment.loadOp = VK_ATTACHMENT_LOAD_OP_LOAD;
    attachment.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
    attachment.stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
    attachment.stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
    attachment.initialLayout = attachment.finalLayout = VK_IMAGE_LAYOUT_GENERAL;
    const VkAttachmentReference colour = {0, VK_IMAGE_LAYOUT_GENERAL};
    VkSubpassDescription subpass{};
    subpass.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS;
    subpass.colorAttachmentCount = 1;
    subpass.pColorAttachments = &colour;
    VkSubpassDependency dependencies[2] = {};
    dependencies[0].srcSubpass = VK_SUBPASS_EXTERNAL;
    dependencies[0].srcStageMask = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT;
    dependencies[0].srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT;
    dependencies[0].dstStageMask = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT;
    dependencies[0].dstAccessMask = VK_ACCESS_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT;
    dependencies[1].dstSubpass = VK_SUBPASS_EXTERNAL;
    dependencies[1].srcStageMask = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT;
    dependencies[1].srcAccessMask = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT;
    dependencies[1].dstStageMask = VK_PIPELINE_STAGE_TRANSFER_BIT | VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT;
    dependencies[1].dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT;
    VkRenderPassCreateInfo info{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO};
    info.attachmentCount = 1;
    info.pAttachments = &attachment;
    info.subpassCount = 1;
    info.pSubpasses = &subpass;
    info.dependencyCount = 2;
    info.pDependencies = dependencies;
    return checked(vk_.CreateRenderPass(device_.handle(), &info, nullptr, &pass_), "vkCreateRenderPass");
}

Result<void> UiRenderer::make_pipeline() {
    const VkPushConstantRange range = {VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof(Transform)};
    VkPipelineLayoutCreateInfo layout{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    layout.setLayoutCount = 1;
    layout.pSetLayouts = &set_layout_;
    layout.pushConstantRangeCount = 1;
    layout.pPushConstantRanges = &range;
    if (auto made =
            checked(vk_.CreatePipelineLayout(device_.handle(), &layout, nullptr, &layout_), "vkCreatePipelineLayout");
        !made)
        return made;
    VkPipelineShaderStageCreateInfo stages[2] = {};
    const std::pair<VkShaderStageFlagBits, const Shader*> shaders[] = {
        {VK_SHADER_STAGE_VERTEX_BIT, &shaders::ui::vertex}, {VK_SHADER_STAGE_FRAGMENT_BIT, &shaders::ui::fragment}};
    Result<void> result;
    for (size_t i = 0; i < 2 && result; ++i) {
        VkShaderModuleCreateInfo module{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
        module.codeSize = shaders[i].second->code.size_bytes();
        module.pCode = shaders[i].second->code.data();
        stages[i].sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
        stages[i].stage = shaders[i].first;
        stages[i].pName = "main";
        result = checked(vk_.CreateShaderModule(device_.handle(), &module, nullptr, &stages[i].module),
                         "vkCreateShaderModule");
    }
    const VkVertexInputBindingDescription binding = {0, sizeof(ImDrawVert), VK_VERTEX_INPUT_RATE_VERTEX};
    const VkVertexInputAttributeDescription attributes[] = {
        {0, 0, VK_FORMAT_R32G32_SFLOAT, offsetof(ImDrawVert, pos)},
        {1, 0, VK_FORMAT_R32G32_SFLOAT, offsetof(ImDrawVert, uv)},
        {2, 0, VK_FORMAT_R8G8B8A8_UNORM, offsetof(ImDrawVert, col)}};
    VkPipelineVertexInputStateCreateInfo input{VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
    input.vertexBindingDescriptionCount = 1;
    input.pVertexBindingDescriptions = &binding;
    input.vertexAttributeDescriptionCount = 3;
    input.pVertexAttributeDescriptions = attributes;
    VkPipelineInputAssemblyStateCreateInfo assembly{VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
    assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
    VkPipelineViewportStateCreateInfo viewport{VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO};
    viewport.viewportCount = viewport.scissorCount = 1;
    VkPipelineRasterizationStateCreateInfo raster{VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
    raster.lineWidth = 1.0f;
    VkPipelineMultisampleStateCreateInfo multisample{VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
    multisample.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
    VkPipelineColorBlendAttachmentState over{};
    over.blendEnable = VK_TRUE;
    over.srcColorBlendFactor = VK_BLEND_FACTOR_SRC_ALPHA;
    over.dstColorBlendFactor = over.dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA;
    over.srcAlphaBlendFactor = VK_BLEND_FACTOR_ONE;
    over.colorWriteMask = 0xf;
    VkPipelineColorBlendStateCreateInfo blend{VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO};
    blend.attachmentCount = 1;
    blend.pAttachments = &over;
    const VkDynamicState states[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
    VkPipelineDynamicStateCreateInfo dynamic{VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO};
    dynamic.dynamicStateCount = 2;
    dynamic.pDynamicStates = states;
    VkGraphicsPipelineCreateInfo info{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO};
    info.stageCount = 2;
    info.pStages = stages;
    info.pVertexInputState = &input;
    info.pInputAssemblyState = &assembly;
    info.pViewportState = &viewport;
    info.pRasterizationState = &raster;
    info.pMultisampleState = &multisample;
    info.pColorBlendState = &blend;
    info.pDynamicState = &dynamic;
    info.layout = layout_;
    info.renderPass = pass_;
    if (result)
        result = checked(vk_.CreateGraphicsPipelines(device_.handle(), VK_NULL_HANDLE, 1, &info, nullptr, &pipeline_),
                         "vkCreateGraphicsPipelines");
    for (const auto& stage : stages)
        vk_.DestroyShaderModule(device_.handle(), stage.module, nullptr);
    return result;
}

Result<void> UiRenderer::make_framebuffer(const Image& canvas) {
    if (framebuffer_view_ == canvas.view)
        return {};
    forget_canvas();
    VkFramebufferCreateInfo info{VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO};
    info.renderPass = pass_;
    info.attachmentCount = 1;
    info.pAttachments = &canvas.view;
    info.width = canvas.extent.width;
    info.height = canvas.extent.height;
    info.layers = 1;
    if (auto made =
            checked(vk_.CreateFramebuffer(device_.handle(), &info, nullptr, &framebuffer_), "vkCreateFramebuffer");
        !made)
        return made;
    framebuffer_view_ = canvas.view;
    return {};
}

Result<void> UiRenderer::upload(const ImDrawData& data) {
    const auto reserve = [&](apps::HostBuffer& buffer, size_t bytes, VkBufferUsageFlags usage) -> Result<void> {
        if (buffer.bytes().size() >= bytes)
            return {};
        auto made = device_.create_buffer(bytes * 2, usage);
        if (!made)
            return made.error();
        buffer = std::move(*made);
        return {};
    };
    const auto vertices = static_cast<size_t>(data.TotalVtxCount), indices = static_cast<size_t>(data.TotalIdxCount);
    if (auto made = reserve(vertices_, vertices * sizeof(ImDrawVert), VK_BUFFER_USAGE_VERTEX_BUFFER_BIT); !made)
        return made;
    if (auto made = reserve(indices_, indices * sizeof(ImDrawIdx), VK_BUFFER_USAGE_INDEX_BUFFER_BIT); !made)
        return made;
    std::byte* vertex = vertices_.bytes().data();
    std::byte* index = indices_.bytes().data();
    for (int i = 0; i < data.CmdListsCount; ++i) {
        const ImDrawList& list = *data.CmdLists[i];
        std::memcpy(vertex, list.VtxBuffer.Data, static_cast<size_t>(list.VtxBuffer.size_in_bytes()));
        std::memcpy(index, list.IdxBuffer.Data, static_cast<size_t>(list.IdxBuffer.size_in_bytes()));
        vertex += list.VtxBuffer.size_in_bytes();
        index += list.IdxBuffer.size_in_bytes();
    }
    return {};
}

void UiRenderer::draw(VkCommandBuffer commands, const ImDrawData& data, Extent extent) const {
    vk_.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline_);
    vk_.CmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout_, 0, 1, &set_, 0, nullptr);
    const VkBuffer vertices = vertices_.handle();
    const VkDeviceSize start = 0;
    vk_.CmdBindVertexBuffers(commands, 0, 1, &vertices, &start);
    vk_.CmdBindIndexBuffer(commands, indices_.handle(), 0,
                           sizeof(ImDrawIdx) == 2 ? VK_INDEX_TYPE_UINT16 : VK_INDEX_TYPE_UINT32);
    const auto width = static_cast<float>(extent.width), height = static_cast<float>(extent.height);
    const VkViewport viewport = {0.0f, 0.0f, width, height, 0.0f, 1.0f};
    vk_.CmdSetViewport(commands, 0, 1, &viewport);
    const Transform transform = {{2.0f / data.DisplaySize.x, 2.0f / data.DisplaySize.y}, {-1.0f, -1.0f}};
    vk_.CmdPushConstants(commands, layout_, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof transform, &transform);
    const float to_pixels_x = width / data.DisplaySize.x, to_pixels_y = height / data.DisplaySize.y;
    uint32_t first_index = 0;
    int32_t first_vertex = 0;
    for (int i = 0; i < data.CmdListsCount; ++i) {
        const ImDrawList& list = *data.CmdLists[i];
        for (const ImDrawCmd& command : list.CmdBuffer) {
            const float left = std::max(command.ClipRect.x * to_pixels_x, 0.0f);
            const float top = std::max(command.ClipRect.y * to_pixels_y, 0.0f);
            const float right = std::min(command.ClipRect.z * to_pixels_x, width);
            const float bottom = std::min(command.ClipRect.w * to_pixels_y, height);
            if (command.UserCallback || right <= left || bottom <= top)
                continue;
            const VkRect2D scissor = {{static_cast<int32_t>(left), static_cast<int32_t>(top)},
                                      {static_cast<uint32_t>(right - left), static_cast<uint32_t>(bottom - top)}};
            vk_.CmdSetScissor(commands, 0, 1, &scissor);
            vk_.CmdDrawIndexed(commands, command.ElemCount, 1, first_index + command.IdxOffset,
                               first_vertex + static_cast<int32_t>(command.VtxOffset), 0);
        }
        first_index += static_cast<uint32_t>(list.IdxBuffer.Size);
        first_vertex += list.VtxBuffer.Size;
    }
}

Result<void> UiRenderer::record(VkCommandBuffer commands, const ImDrawData& data, const Image& canvas) {
    if (data.TotalVtxCount == 0 || data.DisplaySize.x <= 0.0f || data.DisplaySize.y <= 0.0f)
        return {};
    if (auto made = make_framebuffer(canvas); !made)
        return made;
    if (auto uploaded = upload(data); !uploaded)
        return uploaded;
    VkRenderPassBeginInfo begin{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
    begin.renderPass = pass_;
    begin.framebuffer = framebuffer_;
    begin.renderArea.extent = {canvas.extent.width, canvas.extent.height};
    vk_.CmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
    draw(commands, data, canvas.extent);
    vk_.CmdEndRenderPass(commands);
    return {};
}

} // namespace sfumato::viewer
