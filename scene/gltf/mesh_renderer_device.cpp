// Loading of functions, memory, buffers and images.
#include "scene/gltf/mesh_renderer_device.h"

#include <string>

namespace sfumato::scene {

Error MeshDevice::failed(const char* call, VkResult result) {
    const std::string message = std::string("drawing meshes: ") + call + " failed: ";
    if (result == VK_ERROR_OUT_OF_HOST_MEMORY || result == VK_ERROR_OUT_OF_DEVICE_MEMORY)
        return {ErrorCode::out_of_memory, message + "out of memory"};
    return {ErrorCode::vulkan, message + "VkResult " + std::to_string(result)};
}

Result<std::unique_ptr<MeshDevice>> MeshDevice::create(const ContextInfo& info) {
    std::unique_ptr<MeshDevice> made(new MeshDevice);
    made->device_ = info.device;
    made->physical_device_ = info.physical_device;
    const char* missing = nullptr;
#define X(name)                                                                                                        \
    made->functions_.name = reinterpret_cast<PFN_vk##name>(info.get_device_proc_addr(info.device, "vk" #name));        \
    if (made->functions_.name == nullptr)                                                                              \
        missing = "vk" #name;
    SFUMATO_MESH_DEVICE_FUNCTIONS(X)
#undef X
    const auto instance_function = [&](const char* name) {
        const auto found = info.get_instance_proc_addr(info.instance, name);
        missing = found == nullptr ? name : missing;
        return found;
    };
    const auto memory = reinterpret_cast<PFN_vkGetPhysicalDeviceMemoryProperties>(
        instance_function("vkGetPhysicalDeviceMemoryProperties"));
    const auto properties =
        reinterpret_cast<PFN_vkGetPhysicalDeviceProperties>(instance_function("vkGetPhysicalDeviceProperties"));
    made->format_properties_ = reinterpret_cast<PFN_vkGetPhysicalDeviceFormatProperties>(
        instance_function("vkGetPhysicalDeviceFormatProperties"));
    if (missing)
        return Error{ErrorCode::unsupported, std::string("drawing meshes: the driver has no ") + missing};
    memory(info.physical_device, &made->memory_);
    VkPhysicalDeviceProperties all{};
    properties(info.physical_device, &all);
    made->limits_ = all.limits;
    return made;
}

bool MeshDevice::has_features(VkFormat format, VkFormatFeatureFlags features) const {
    VkFormatProperties properties{};
    format_properties_(physical_device_, format, &properties);
    return (properties.optimalTilingFeatures & features) == features;
}

Result<MeshObject<VkDeviceMemory>> MeshDevice::allocate(const VkMemoryRequirements& needs,
                                                        VkMemoryPropertyFlags required, const char* what) const {
    for (uint32_t type = 0; type < memory_.memoryTypeCount; ++type) {
        if (!(needs.memoryTypeBits >> type & 1u) || (memory_.memoryTypes[type].propertyFlags & required) != required)
            continue;
        // Known before asking: a driver need not answer such a request sanely.
        if (needs.size > memory_.memoryHeaps[memory_.memoryTypes[type].heapIndex].size)
            continue;
        VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
        info.allocationSize = needs.size;
        info.memoryTypeIndex = type;
        return make(functions_.AllocateMemory, functions_.FreeMemory, info, "vkAllocateMemory");
    }
    return Error{ErrorCode::out_of_memory,
                 std::string("drawing meshes: no memory for ") + std::to_string(needs.size >> 20) + " MiB of " + what};
}

Result<MeshBuffer> MeshDevice::create_buffer(size_t bytes, VkBufferUsageFlags usage) const {
    VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
    info.size = bytes;
    info.usage = usage;
    auto buffer = make(functions_.CreateBuffer, functions_.DestroyBuffer, info, "vkCreateBuffer");
    if (!buffer)
        return buffer.error();
    VkMemoryRequirements needs{};
    functions_.GetBufferMemoryRequirements(device_, *buffer, &needs);
    auto memory = allocate(needs, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT,
                           "vertices and textures");
    if (!memory)
        return memory.error();
    MeshBuffer made{std::move(*memory), std::move(*buffer), nullptr, bytes};
    if (const VkResult result = functions_.BindBufferMemory(device_, made.buffer, made.memory, 0); result != VK_SUCCESS)
        return failed("vkBindBufferMemory", result);
    void* mapped = nullptr;
    if (const VkResult result = functions_.MapMemory(device_, made.memory, 0, VK_WHOLE_SIZE, 0, &mapped);
        result != VK_SUCCESS)
        return failed("vkMapMemory", result);
    made.mapped = static_cast<std::byte*>(mapped);
    return made;
}

Result<MeshImage> MeshDevice::create_image(VkFormat format, Extent extent, uint32_t levels,
                                           VkImageUsageFlags usage) const {
    if (extent.width > limits_.maxImageDimension2D || extent.height > limits_.maxImageDimension2D)
        return Error{ErrorCode::unsupported, "drawing meshes: an image of " + std::to_string(extent.width) + "×" +
                                                 std::to_string(extent.height) + " pixels, this device has at most " +
                                                 std::to_string(limits_.maxImageDimension2D) + " a side"};
    VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
    info.imageType = VK_IMAGE_TYPE_2D;
    info.format = format;
    info.extent = {extent.width, extent.height, 1};
    info.mipLevels = levels;
    info.arrayLayers = 1;
    info.samples = VK_SAMPLE_COUNT_1_BIT;
    info.tiling = VK_IMAGE_TILING_OPTIMAL;
    info.usage = usage;
    MeshImage made;
    auto image = make(functions_.CreateImage, functions_.DestroyImage, info, "vkCreateImage");
    if (!image)
        return image.error();
    made.image = std::move(*image);
    VkMemoryRequirements needs{};
    functions_.GetImageMemoryRequirements(device_, made.image, &needs);
    auto memory = allocate(needs, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, "images");
    if (!memory)
        return memory.error();
    made.memory = std::move(*memory);
    if (const VkResult result = functions_.BindImageMemory(device_, made.image, made.memory, 0); result != VK_SUCCESS)
        return failed("vkBindImageMemory", result);
    VkImageViewCreateInfo view_info{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
    view_info.image = made.image;
    view_info.viewType = VK_IMAGE_VIEW_TYPE_2D;
    view_info.format = format;
    const bool is_depth = (usage & VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT) != 0;
    const VkImageAspectFlags aspect = is_depth ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;
    view_info.subresourceRange = {aspect, 0, levels, 0, 1};
    auto view = make(functions_.CreateImageView, functions_.DestroyImageView, view_info, "vkCreateImageView");
    if (!view)
        return view.error();
    made.view = std::move(*view);
    made.format = format;
    made.extent = extent;
    made.levels = levels;
    return made;
}

} // namespace sfumato::scene
