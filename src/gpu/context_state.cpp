// Device objects of a Context: images, buffers, samplers, and when they may be destroyed.
#include "gpu/context_state.h"

#include <algorithm>

namespace sfumato {

ContextState::~ContextState() {
    for (auto& [key, pipeline] : pipelines) {
        vk.vkDestroyPipeline(info.device, pipeline.pipeline, nullptr);
        vk.vkDestroyPipelineLayout(info.device, pipeline.layout, nullptr);
        vk.vkDestroyDescriptorSetLayout(info.device, pipeline.set_layout, nullptr);
    }
    for (auto& image : transients)
        destroy(*image);
    for (auto& image : retired)
        destroy(*image);
    for (auto& buffer : buffers)
        destroy(*buffer);
    for (auto& zero : zeros)
        if (zero)
            destroy(*zero);
    if (vk.vkDestroySampler) {
        vk.vkDestroySampler(info.device, nearest, nullptr);
        vk.vkDestroySampler(info.device, linear, nullptr);
        vk.vkDestroyDescriptorSetLayout(info.device, constants_layout, nullptr);
    }
}

Result<void> ContextState::create() {
    if (auto created = create_samplers(); !created)
        return created.error();
    const VkDescriptorSetLayoutBinding binding{0, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC, 1,
                                               VK_SHADER_STAGE_COMPUTE_BIT, nullptr};
    VkDescriptorSetLayoutCreateInfo layout{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, nullptr, 0, 1,
                                           &binding};
    if (VkResult r = vk.vkCreateDescriptorSetLayout(info.device, &layout, nullptr, &constants_layout); r != VK_SUCCESS)
        return vulkan_error("vkCreateDescriptorSetLayout", r);
    constexpr VkFormat formats[] = {VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_R32G32_UINT};
    for (size_t i = 0; i < 2; ++i) {
        auto image = create_image("sfumato zero", formats[i], {1, 1}, 1);
        if (!image)
            return image.error();
        zeros[i] = std::move(*image);
    }
    return {};
}

Result<void> ContextState::create_samplers() {
    for (VkSampler* sampler : {&nearest, &linear}) {
        VkSamplerCreateInfo create{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
        create.magFilter = create.minFilter = sampler == &linear ? VK_FILTER_LINEAR : VK_FILTER_NEAREST;
        create.mipmapMode = sampler == &linear ? VK_SAMPLER_MIPMAP_MODE_LINEAR : VK_SAMPLER_MIPMAP_MODE_NEAREST;
        create.addressModeU = create.addressModeV = create.addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
        create.maxLod = VK_LOD_CLAMP_NONE;
        if (VkResult r = vk.vkCreateSampler(info.device, &create, nullptr, sampler); r != VK_SUCCESS)
            return vulkan_error("vkCreateSampler", r);
    }
    return {};
}

Result<VkDeviceMemory> ContextState::allocate(const VkMemoryRequirements& needs, VkMemoryPropertyFlags preferred,
                                              VkMemoryPropertyFlags required) {
    VkResult result = VK_ERROR_OUT_OF_DEVICE_MEMORY;
    for (const VkMemoryPropertyFlags flags : {required | preferred, required}) {
        for (uint32_t type = 0; type < memory.memoryTypeCount; ++type) {
            if (!(needs.memoryTypeBits >> type & 1) || (memory.memoryTypes[type].propertyFlags & flags) != flags)
                continue;
            VkMemoryAllocateInfo allocate_info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, nullptr, needs.size, type};
            VkDeviceMemory allocation = VK_NULL_HANDLE;
            result = vk.vkAllocateMemory(info.device, &allocate_info, nullptr, &allocation);
            if (result == VK_SUCCESS)
                return allocation;
        }
    }
    return vulkan_error("vkAllocateMemory", result);
}

Result<void> ContextState::create_views(DeviceImage& image) {
    VkImageViewCreateInfo create{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
    create.image = image.image;
    create.viewType = VK_IMAGE_VIEW_TYPE_2D;
    create.format = image.format;
    create.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, image.mips, 0, 1};
    if (VkResult r = vk.vkCreateImageView(info.device, &create, nullptr, &image.view); r != VK_SUCCESS)
        return vulkan_error("vkCreateImageView", r);
    for (uint32_t mip = 0; mip < image.mips; ++mip) {
        create.subresourceRange.baseMipLevel = mip;
        create.subresourceRange.levelCount = 1;
        VkImageView view = VK_NULL_HANDLE;
        if (VkResult r = vk.vkCreateImageView(info.device, &create, nullptr, &view); r != VK_SUCCESS)
            return vulkan_error("vkCreateImageView", r);
        image.mip_views.push_back(view);
    }
    return {};
}

Result<std::unique_ptr<DeviceImage>> ContextState::create_image(const char* name, VkFormat format, Extent extent,
                                                                uint32_t mips) {
    if (extent.width > max_side || extent.height > max_side)
        return Error{ErrorCode::unsupported, std::string("image '") + name + "' would be " + extent_text(extent) +
                                                 "; the device allows sides of " + std::to_string(max_side)};
    auto image = std::make_unique<DeviceImage>();
    image->format = format;
    image->extent = extent;
    image->mips = mips;
    const auto fail = [&](const Error& error) {
        destroy(*image);
        return Error{error.code, std::string("image '") + name + "', " + extent_text(extent) + ": " + error.message};
    };
    VkImageCreateInfo create{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
    create.imageType = VK_IMAGE_TYPE_2D;
    create.format = format;
    create.extent = {extent.width, extent.height, 1};
    create.mipLevels = mips;
    create.arrayLayers = 1;
    create.samples = VK_SAMPLE_COUNT_1_BIT;
    create.usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
    if (VkResult r = vk.vkCreateImage(info.device, &create, nullptr, &image->image); r != VK_SUCCESS)
        return fail(vulkan_error("vkCreateImage", r));
    VkMemoryRequirements needs{};
    vk.vkGetImageMemoryRequirements(info.device, image->image, &needs);
    auto allocation = allocate(needs, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, 0);
    if (!allocation)
        return fail(allocation.error());
    image->memory = *allocation;
    image->bytes = needs.size;
    if (VkResult r = vk.vkBindImageMemory(info.device, image->image, image->memory, 0); r != VK_SUCCESS)
        return fail(vulkan_error("vkBindImageMemory", r));
    if (auto views = create_views(*image); !views)
        return fail(views.error());
    name_object(VK_OBJECT_TYPE_IMAGE, reinterpret_cast<uint64_t>(image->image), name);
    return image;
}

void ContextState::destroy(DeviceImage& image) {
    for (VkImageView view : image.mip_views)
        vk.vkDestroyImageView(info.device, view, nullptr);
    vk.vkDestroyImageView(info.device, image.view, nullptr);
    vk.vkDestroyImage(info.device, image.image, nullptr);
    vk.vkFreeMemory(info.device, image.memory, nullptr);
    image = {};
}

Result<std::unique_ptr<DeviceBuffer>> ContextState::create_buffer(uint64_t bytes, VkBufferUsageFlags usage,
                                                                  bool host_visible) {
    auto buffer = std::make_unique<DeviceBuffer>();
    buffer->bytes = bytes;
    const auto fail = [&](const Error& error) {
        destroy(*buffer);
        return error;
    };
    VkBufferCreateInfo create{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
    create.size = bytes;
    create.usage = usage;
    if (VkResult r = vk.vkCreateBuffer(info.device, &create, nullptr, &buffer->buffer); r != VK_SUCCESS)
        return fail(vulkan_error("vkCreateBuffer", r));
    VkMemoryRequirements needs{};
    vk.vkGetBufferMemoryRequirements(info.device, buffer->buffer, &needs);
    const VkMemoryPropertyFlags required =
        host_visible ? VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT : 0;
    auto allocation = allocate(needs, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, required);
    if (!allocation)
        return fail(allocation.error());
    buffer->memory = *allocation;
    if (VkResult r = vk.vkBindBufferMemory(info.device, buffer->buffer, buffer->memory, 0); r != VK_SUCCESS)
        return fail(vulkan_error("vkBindBufferMemory", r));
    if (host_visible)
        if (VkResult r = vk.vkMapMemory(info.device, buffer->memory, 0, VK_WHOLE_SIZE, 0, &buffer->mapped);
            r != VK_SUCCESS)
            return fail(vulkan_error("vkMapMemory", r));
    return buffer;
}

void ContextState::destroy(DeviceBuffer& buffer) {
    vk.vkDestroyBuffer(info.device, buffer.buffer, nullptr);
    vk.vkFreeMemory(info.device, buffer.memory, nullptr);
    buffer = {};
}

VkFormatFeatureFlags ContextState::features(VkFormat format) {
    const auto [entry, is_new] = format_features.try_emplace(format, 0);
    if (is_new) {
        VkFormatProperties properties{};
        vk.vkGetPhysicalDeviceFormatProperties(info.physical_device, format, &properties);
        entry->second = properties.optimalTilingFeatures;
    }
    return entry->second;
}

bool ContextState::is_idle(const LastUse& use) const {
    const auto executor = executors.find(use.executor);
    // An executor is destroyed only after its work has finished.
    return executor == executors.end() || executor->second >= use.serial + info.frames_in_flight;
}

void ContextState::evict(uint64_t patience) {
    const auto expired = [&](const auto& object, uint64_t extra) {
        if (object->acquired || !is_idle(object->last_use))
            return false;
        const auto executor = executors.find(object->last_use.executor);
        return executor == executors.end() ||
               executor->second >= object->last_use.serial + info.frames_in_flight + extra;
    };
    const auto sweep = [&](auto& pool, uint64_t extra) {
        std::erase_if(pool, [&](auto& object) {
            const bool gone = expired(object, extra);
            if (gone)
                destroy(*object);
            return gone;
        });
    };
    sweep(transients, patience);
    sweep(buffers, patience);
    sweep(retired, 0);
    sweep(retired_buffers, 0);
}

void ContextState::name_object(VkObjectType type, uint64_t handle, const std::string& name) const {
    if (!vk.vkSetDebugUtilsObjectNameEXT)
        return;
    const VkDebugUtilsObjectNameInfoEXT name_info{VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT, nullptr, type,
                                                  handle, name.c_str()};
    vk.vkSetDebugUtilsObjectNameEXT(info.device, &name_info);
}

} // namespace sfumato
