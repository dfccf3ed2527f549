// The programs' and the tests' own Vulkan device: one instance, one device, one queue, images with upload and
// read-back, command buffers. The loader is opened at run time, so that a program starts without one and says so.
#pragma once

#include "apps/common/vulkan_functions.h"
#include "sfumato/buffer.h"
#include "sfumato/context.h"
#include "sfumato/image.h"
#include "sfumato/result.h"

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sfumato::apps {

struct DeviceOptions {
    std::string device;      // index or part of the name; empty: the best (discrete, integrated, virtual, cpu)
    bool validation = false; // VK_LAYER_KHRONOS_validation with synchronisation validation; see validation_messages()
    bool labels = false;     // VK_EXT_debug_utils, where there is one
    bool graphics = false;   // the queue must be able to draw as well as to compute
    std::vector<std::string> instance_extensions = {}; // needed besides; an error where there is none
    std::vector<std::string> device_extensions = {};
};

struct DeviceDescription {
    uint32_t index = 0; // what DeviceOptions::device accepts
    std::string name;
    std::string type;           // "discrete", "integrated", "virtual", "cpu" or "other"
    std::string api_version;    // "1.3.230"
    std::string driver;         // name and version as the driver tells them, or ""
    uint64_t memory_bytes = 0;  // device-local heaps
    bool timestamps = false;    // the queue can measure passes
    bool graphics = false;      // the queue can draw; compute it can always
    std::string why_not_usable; // "" if Sfumato runs on it
};

// Every Vulkan device of this machine, in the loader's order. Errors (unsupported): no loader, no device.
Result<std::vector<DeviceDescription>> list_devices();

class Device;

// A 2D image in GENERAL layout, cleared to zero. Usages: SAMPLED, TRANSFER and, where the device has it for the format,
// STORAGE. Must be destroyed before its device, when no submitted command uses it any more.
class HostImage {
  public:
    HostImage() = default;
    HostImage(HostImage&& other) noexcept { swap(other); }
    HostImage& operator=(HostImage&& other) noexcept {
        HostImage(std::move(other)).swap(*this);
        return *this;
    }
    ~HostImage();

    const Image& image() const { return image_; } // absent (0×0) if default-constructed
    Extent extent() const { return image_.extent; }
    VkFormat format() const { return image_.format; }

  private:
    friend class Device;
    void swap(HostImage& other) noexcept;
    const Device* device_ = nullptr;
    Image image_;
    VkDeviceMemory memory_ = VK_NULL_HANDLE;
};

// A buffer in host memory, mapped and coherent for as long as it lives. For transfers and as an effect's buffer; never
// empty.
class HostBuffer {
  public:
    HostBuffer() = default;
    HostBuffer(HostBuffer&& other) noexcept { swap(other); }
    HostBuffer& operator=(HostBuffer&& other) noexcept {
        HostBuffer(std::move(other)).swap(*this);
        return *this;
    }
    ~HostBuffer();

    VkBuffer handle() const { return buffer_; }
    std::span<std::byte> bytes() const { return {mapped_, size_}; }
    Buffer buffer() const { return {buffer_, 0, size_}; }

  private:
    friend class Device;
    void swap(HostBuffer& other) noexcept;
    const Device* device_ = nullptr;
    VkBuffer buffer_ = VK_NULL_HANDLE;
    VkDeviceMemory memory_ = VK_NULL_HANDLE;
    std::byte* mapped_ = nullptr;
    size_t size_ = 0;
};

// A command buffer with its fence: one for each frame in flight.
class Commands {
  public:
    Commands() = default;
    Commands(Commands&& other) noexcept { swap(other); }
    Commands& operator=(Commands&& other) noexcept {
        Commands(std::move(other)).swap(*this);
        return *this;
    }
    ~Commands(); // waits for what was submitted

    VkCommandBuffer buffer() const { return buffer_; }
    bool pending() const { return pending_; } // submitted and not yet waited for

  private:
    friend class Device;
    void swap(Commands& other) noexcept;
    const Device* device_ = nullptr;
    VkCommandPool pool_ = VK_NULL_HANDLE;
    VkCommandBuffer buffer_ = VK_NULL_HANDLE;
    VkFence fence_ = VK_NULL_HANDLE;
    bool pending_ = false;
};

// Externally synchronised. Several may live at once, each with its own instance. Destroy everything made from it first.
class Device {
  public:
    // Errors (unsupported): no loader, no device, none that fits `options.device`, a device that lacks what the library
    // needs, no validation layer where one is asked for.
    static Result<std::unique_ptr<Device>> create(const DeviceOptions& options = {});
    ~Device();
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    ContextInfo context_info() const; // timestamps are off: set ContextInfo::timestamps where timestamps() holds
    const DeviceDescription& description() const { return description_; }
    const std::string& name() const { return description_.name; }
    bool timestamps() const { return description_.timestamps; }
    VkQueueFlags queue_flags() const;      // compute and, where the device has it, graphics
    bool can_store(VkFormat format) const; // usable as an effect's output
    VkDevice handle() const { return device_; }
    VkPhysicalDevice physical_device() const { return physical_device_; }
    VkInstance instance() const { return instance_; }
    VkQueue queue() const { return queue_; }
    uint32_t queue_family() const { return queue_family_; }
    const VulkanFunctions& functions() const { return functions_; }

    // `more_usage`: beyond what every HostImage has.
    Result<HostImage> create_image(VkFormat format, Extent extent, VkImageUsageFlags more_usage = 0);
    Result<HostBuffer> create_buffer(size_t bytes, VkBufferUsageFlags more_usage = 0);

    // Copies `values`, width × height pixels of `components` channels, row by row from the top, and waits. Conversion
    // as in encode_pixels. Earlier commands of the queue have finished with the image when it changes.
    Result<void> upload(const HostImage& image, std::span<const float> values, uint32_t components);
    Result<void> upload_bytes(const HostImage& image, std::span<const std::byte> bytes);

    // Waits for the commands submitted so far. Interleaved, with the format's own number of channels.
    Result<std::vector<float>> readback(const HostImage& image);
    Result<std::vector<std::byte>> readback_bytes(const HostImage& image);

    // For pipelines that keep transfers in flight: only the copies, with the barriers before and after that make them
    // safe against any other command of this queue and, for the read-back, visible to the host after wait().
    void record_upload(VkCommandBuffer commands, const HostBuffer& source, const HostImage& target) const;
    void record_readback(VkCommandBuffer commands, const HostImage& source, const HostBuffer& target) const;

    // Commands for the frames in flight: create once, then begin, record, submit, and wait before the next begin.
    Result<Commands> create_commands() const;
    Result<void> begin(Commands& commands) const;
    // `wait_for`, if there is one, is waited for by `stage`; `signal`, if there is one, is signalled at the end.
    Result<void> submit(Commands& commands, VkSemaphore wait_for = VK_NULL_HANDLE,
                        VkPipelineStageFlags stage = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                        VkSemaphore signal = VK_NULL_HANDLE) const;
    Result<void> wait(Commands& commands) const; // nothing to do if it is not pending

    // One-shot commands.
    Result<VkCommandBuffer> begin();
    Result<void> submit_and_wait();

    Result<void> wait_idle() const;

    // Errors and warnings of the validation layer since creation or the last clear, the oldest first (256 at most).
    std::vector<std::string> validation_messages() const;
    void clear_validation_messages();

  private:
    friend class HostImage;
    friend class HostBuffer;
    friend class Commands;
    struct Messages;

    Device();
    VkDebugUtilsMessengerCreateInfoEXT messenger_info() const;
    Result<void> create_instance(const DeviceOptions& options);
    Result<void> choose_device(const DeviceOptions& options);
    Result<void> create_device(const DeviceOptions& options);
    Result<VkDeviceMemory> allocate(const VkMemoryRequirements& needs, VkMemoryPropertyFlags required,
                                    VkMemoryPropertyFlags preferred, std::string_view what) const;
    Result<void> ensure_staging(size_t bytes);
    Result<void> bind_and_view(HostImage& made);
    Result<void> clear(const HostImage& image);
    static VKAPI_ATTR VkBool32 VKAPI_CALL on_message(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                                     VkDebugUtilsMessageTypeFlagsEXT types,
                                                     const VkDebugUtilsMessengerCallbackDataEXT* data, void* user);

    VulkanFunctions functions_;
    std::unique_ptr<Messages> messages_; // the callback's target: outlives the instance
    VkInstance instance_ = VK_NULL_HANDLE;
    VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
    VkPhysicalDevice physical_device_ = VK_NULL_HANDLE;
    VkDevice device_ = VK_NULL_HANDLE;
    VkQueue queue_ = VK_NULL_HANDLE;
    uint32_t queue_family_ = 0;
    VkPhysicalDeviceMemoryProperties memory_{};
    DeviceDescription description_;
    bool labels_ = false;
    Commands one_shot_;
    HostBuffer staging_; // grows, reused by every upload and read-back
};

} // namespace sfumato::apps
