// Images and buffers of the programs' own device, with upload and read-back.
#include "apps/common/device_choice.h"
#include "apps/common/pixels.h"

#include <cstring>
#include <utility>

namespace sfumato::apps {
namespace {

std::string size_text(Extent extent) {
    return std::to_string(extent.width) + "×" + std::to_string(extent.height);
}

size_t pixel_count(Extent extent) {
    return static_cast<size_t>(extent.width) * extent.height;
}

// A barrier over everything: transfers are rare, and never measured.
void barrier(const VulkanFunctions& vk, VkCommandBuffer commands, VkPipelineStageFlags before, VkAccessFlags written,
             VkPipelineStageFlags after, VkAccessFlags used) {
    VkMemoryBarrier memory{};
    memory.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
    memory.srcAccessMask = written;
    memory.dstAccessMask = used;
    vk.CmdPipelineBarrier(commands, before, after, 0, 1, &memory, 0, nullptr, 0, nullptr);
}

VkBufferImageCopy whole_image(Extent extent) {
    VkBufferImageCopy copy{};
    copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    copy.imageExtent = {extent.width, extent.height, 1};
    return copy;
}

constexpr VkImageSubresourceRange whole_range = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};

Result<const PixelFormat*> known_format(const HostImage& image) {
    if (!image.image())
        return Error{ErrorCode::invalid_argument, "the image to transfer is absent (0×0)"};
    const PixelFormat* format = find_pixel_format(image.format());
    if (format == nullptr)
        return Error{ErrorCode::invalid_argument,
                     "images of VkFormat " + std::to_string(image.format()) + " cannot be uploaded or read back"};
    return format;
}

} // namespace

HostImage::~HostImage() {
    if (device_ == nullptr)
        return;
    const VulkanFunctions& vk = device_->functions();
    vk.DestroyImageView(device_->handle(), image_.view, nullptr);
    vk.DestroyImage(device_->handle(), image_.handle, nullptr);
    vk.FreeMemory(device_->handle(), memory_, nullptr);
}

void HostImage::swap(HostImage& other) noexcept {
    std::swap(device_, other.device_);
    std::swap(image_, other.image_);
    std::swap(memory_, other.memory_);
}

HostBuffer::~HostBuffer() {
    if (device_ == nullptr)
        return;
    const VulkanFunctions& vk = device_->functions();
    vk.DestroyBuffer(device_->handle(), buffer_, nullptr);
    vk.FreeMemory(device_->handle(), memory_, nullptr); // unmaps as well
}

void HostBuffer::swap(HostBuffer& other) noexcept {
    std::swap(device_, other.device_);
    std::swap(buffer_, other.buffer_);
    std::swap(memory_, other.memory_);
    std::swap(mapped_, other.mapped_);
    std::swap(size_, other.size_);
}

bool Device::can_store(VkFormat format) const {
    VkFormatProperties properties{};
    functions_.GetPhysicalDeviceFormatProperties(physical_device_, format, &properties);
    return (properties.optimalTilingFeatures & VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT) != 0;
}

Result<VkDeviceMemory> Device::allocate(const VkMemoryRequirements& needs, VkMemoryPropertyFlags required,
                                        VkMemoryPropertyFlags preferred, std::string_view what) const {
    for (const VkMemoryPropertyFlags flags : {required | preferred, required}) {
        for (uint32_t type = 0; type < memory_.memoryTypeCount; ++type) {
            if (!(needs.memoryTypeBits >> type & 1u) || (memory_.memoryTypes[type].propertyFlags & flags) != flags)
                continue;
            // Known before asking: a driver need not answer such a request sanely.
            if (needs.size > memory_.memoryHeaps[memory_.memoryTypes[type].heapIndex].size)
                return Error{ErrorCode::out_of_memory, std::string(what) + " needs " + std::to_string(needs.size) +
                                                           " bytes, more than the device's memory"};
            VkMemoryAllocateInfo info{};
            info.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
            info.allocationSize = needs.size;
            info.memoryTypeIndex = type;
            VkDeviceMemory memory = VK_NULL_HANDLE;
            const VkResult result = functions_.AllocateMemory(device_, &info, nullptr, &memory);
            if (result == VK_SUCCESS)
                return memory;
            return vulkan_error(result, "allocating " + std::to_string(needs.size) + " bytes for " + std::string(what));
        }
    }
    return Error{ErrorCode::out_of_memory, "no memory type fits " + std::string(what)};
}

Result<HostImage> Device::create_image(VkFormat format, Extent extent, VkImageUsageFlags more_usage) {
    VkPhysicalDeviceProperties properties{};
    functions_.GetPhysicalDeviceProperties(physical_device_, &properties);
    const uint32_t most = properties.limits.maxImageDimension2D;
    if (!extent || extent.width > most || extent.height > most)
        return Error{ErrorCode::invalid_argument, "an image of " + size_text(extent) +
                                                      " pixels cannot be made: each side must be 1 to " +
                                                      std::to_string(most)};
    VkFormatProperties features{};
    functions_.GetPhysicalDeviceFormatProperties(physical_device_, format, &features);
    if (!(features.optimalTilingFeatures & VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT))
        return Error{ErrorCode::unsupported, name() + " cannot sample images of VkFormat " + std::to_string(format)};
    VkImageCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO;
    info.imageType = VK_IMAGE_TYPE_2D;
    info.format = format;
    info.extent = {extent.width, extent.height, 1};
    info.mipLevels = 1;
    info.arrayLayers = 1;
    info.samples = VK_SAMPLE_COUNT_1_BIT;
    info.usage =
        VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT | more_usage;
    if (can_store(format))
        info.usage |= VK_IMAGE_USAGE_STORAGE_BIT;
    HostImage made;
    made.device_ = this;
    made.image_ = {VK_NULL_HANDLE, VK_NULL_HANDLE, format, extent, VK_IMAGE_LAYOUT_GENERAL};
    if (const VkResult result = functions_.CreateImage(device_, &info, nullptr, &made.image_.handle);
        result != VK_SUCCESS) {
        made.image_.handle = VK_NULL_HANDLE;
        return vulkan_error(result, "creating an image of " + size_text(extent) + " pixels");
    }
    if (auto bound = bind_and_view(made); !bound)
        return bound.error();
    if (auto cleared = clear(made); !cleared)
        return cleared.error();
    return made;
}

Result<void> Device::bind_and_view(HostImage& made) {
    VkMemoryRequirements needs{};
    functions_.GetImageMemoryRequirements(device_, made.image_.handle, &needs);
    auto memory =
        allocate(needs, 0, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, "an image of " + size_text(made.extent()) + " pixels");
    if (!memory)
        return memory.error();
    made.memory_ = *memory;
    if (const VkResult result = functions_.BindImageMemory(device_, made.image_.handle, made.memory_, 0);
        result != VK_SUCCESS)
        return vulkan_error(result, "vkBindImageMemory");
    VkImageViewCreateInfo view{};
    view.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO;
    view.image = made.image_.handle;
    view.viewType = VK_IMAGE_VIEW_TYPE_2D;
    view.format = made.format();
    view.subresourceRange = whole_range;
    if (const VkResult result = functions_.CreateImageView(device_, &view, nullptr, &made.image_.view);
        result != VK_SUCCESS) {
        made.image_.view = VK_NULL_HANDLE;
        return vulkan_error(result, "vkCreateImageView");
    }
    return {};
}

// From no layout to GENERAL, all zero: what an image starts with never depends on old memory.
Result<void> Device::clear(const HostImage& image) {
    auto commands = begin();
    if (!commands)
        return commands.error();
    VkImageMemoryBarrier transition{};
    transition.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER;
    transition.dstAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
    transition.oldLayout = VK_IMAGE_LAYOUT_UNDEFINED;
    transition.newLayout = VK_IMAGE_LAYOUT_GENERAL;
    transition.srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    transition.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    transition.image = image.image().handle;
    transition.subresourceRange = whole_range;
    functions_.CmdPipelineBarrier(*commands, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 0,
                                  nullptr, 0, nullptr, 1, &transition);
    const VkClearColorValue zero{};
    functions_.CmdClearColorImage(*commands, image.image().handle, VK_IMAGE_LAYOUT_GENERAL, &zero, 1, &whole_range);
    barrier(functions_, *commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
            VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT);
    return submit_and_wait();
}

Result<HostBuffer> Device::create_buffer(size_t bytes, VkBufferUsageFlags more_usage) {
    HostBuffer made;
    made.device_ = this;
    made.size_ = bytes;
    VkBufferCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
    info.size = bytes;
    info.usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT |
                 VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | more_usage;
    if (const VkResult result = functions_.CreateBuffer(device_, &info, nullptr, &made.buffer_); result != VK_SUCCESS) {
        made.buffer_ = VK_NULL_HANDLE;
        return vulkan_error(result, "creating a buffer of " + std::to_string(bytes) + " bytes");
    }
    VkMemoryRequirements needs{};
    functions_.GetBufferMemoryRequirements(device_, made.buffer_, &needs);
    auto memory = allocate(needs, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT,
                           VK_MEMORY_PROPERTY_HOST_CACHED_BIT, "a buffer in host memory");
    if (!memory)
        return memory.error();
    made.memory_ = *memory;
    if (const VkResult result = functions_.BindBufferMemory(device_, made.buffer_, made.memory_, 0);
        result != VK_SUCCESS)
        return vulkan_error(result, "vkBindBufferMemory");
    void* mapped = nullptr;
    if (const VkResult result = functions_.MapMemory(device_, made.memory_, 0, VK_WHOLE_SIZE, 0, &mapped);
        result != VK_SUCCESS)
        return vulkan_error(result, "vkMapMemory");
    made.mapped_ = static_cast<std::byte*>(mapped);
    return made;
}

Result<void> Device::ensure_staging(size_t bytes) {
    if (staging_.bytes().size() >= bytes)
        return {};
    staging_ = {}; // the old one goes first
    auto made = create_buffer(bytes);
    if (!made)
        return made.error();
    staging_ = std::move(*made);
    return {};
}

void Device::record_upload(VkCommandBuffer commands, const HostBuffer& source, const HostImage& target) const {
    barrier(functions_, commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
            VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT,
            VK_ACCESS_TRANSFER_WRITE_BIT);
    const VkBufferImageCopy copy = whole_image(target.extent());
    functions_.CmdCopyBufferToImage(commands, source.handle(), target.image().handle, VK_IMAGE_LAYOUT_GENERAL, 1,
                                    &copy);
    barrier(functions_, commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
            VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT);
}

void Device::record_readback(VkCommandBuffer commands, const HostImage& source, const HostBuffer& target) const {
    barrier(functions_, commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_ACCESS_MEMORY_WRITE_BIT,
            VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_READ_BIT | VK_ACCESS_TRANSFER_WRITE_BIT);
    const VkBufferImageCopy copy = whole_image(source.extent());
    functions_.CmdCopyImageToBuffer(commands, source.image().handle, VK_IMAGE_LAYOUT_GENERAL, target.handle(), 1,
                                    &copy);
    barrier(functions_, commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
            VK_PIPELINE_STAGE_HOST_BIT | VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
            VK_ACCESS_HOST_READ_BIT | VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT);
}

Result<void> Device::upload(const HostImage& image, std::span<const float> values, uint32_t components) {
    auto format = known_format(image);
    if (!format)
        return format.error();
    const size_t pixels = pixel_count(image.extent());
    if (components < 1 || components > 4 || values.size() != pixels * components)
        return Error{ErrorCode::invalid_argument, "upload of " + std::to_string(values.size()) + " values with " +
                                                      std::to_string(components) + " components does not fit " +
                                                      size_text(image.extent()) + " pixels"};
    const size_t bytes = pixels * (*format)->bytes();
    if (auto ready = ensure_staging(bytes); !ready)
        return ready;
    encode_pixels(**format, values, components, staging_.bytes().first(bytes));
    auto commands = begin();
    if (!commands)
        return commands.error();
    record_upload(*commands, staging_, image);
    return submit_and_wait();
}

Result<void> Device::upload_bytes(const HostImage& image, std::span<const std::byte> bytes) {
    auto format = known_format(image);
    if (!format)
        return format.error();
    const size_t needed = pixel_count(image.extent()) * (*format)->bytes();
    if (bytes.size() != needed)
        return Error{ErrorCode::invalid_argument, "upload of " + std::to_string(bytes.size()) +
                                                      " bytes: " + size_text(image.extent()) + " pixels of " +
                                                      (*format)->name + " are " + std::to_string(needed)};
    if (auto ready = ensure_staging(needed); !ready)
        return ready;
    std::memcpy(staging_.bytes().data(), bytes.data(), needed);
    auto commands = begin();
    if (!commands)
        return commands.error();
    record_upload(*commands, staging_, image);
    return submit_and_wait();
}

Result<std::vector<std::byte>> Device::readback_bytes(const HostImage& image) {
    auto format = known_format(image);
    if (!format)
        return format.error();
    const size_t bytes = pixel_count(image.extent()) * (*format)->bytes();
    if (auto ready = ensure_staging(bytes); !ready)
        return ready.error();
    auto commands = begin();
    if (!commands)
        return commands.error();
    record_readback(*commands, image, staging_);
    if (auto done = submit_and_wait(); !done)
        return done.error();
    const auto mapped = staging_.bytes().first(bytes);
    return std::vector<std::byte>(mapped.begin(), mapped.end());
}

Result<std::vector<float>> Device::readback(const HostImage& image) {
    auto bytes = readback_bytes(image);
    if (!bytes)
        return bytes.error();
    return decode_pixels(*find_pixel_format(image.format()), *bytes);
}

} // namespace sfumato::apps
