// The programs' own Vulkan device: instance, validation messages, device and command buffers.
#include "apps/common/device.h"

#include "apps/common/device_choice.h"

#include <algorithm>
#include <cstring>
#include <mutex>

namespace sfumato::apps {
namespace {

constexpr const char* validation_layer = "VK_LAYER_KHRONOS_validation";
constexpr size_t most_messages = 256;

template <class Function>
Function instance_function(const VulkanFunctions& functions, VkInstance instance, const char* name) {
    return reinterpret_cast<Function>(functions.GetInstanceProcAddr(instance, name));
}

bool has_layer(const VulkanFunctions& functions, const char* wanted) {
    const auto enumerate = instance_function<PFN_vkEnumerateInstanceLayerProperties>(
        functions, VK_NULL_HANDLE, "vkEnumerateInstanceLayerProperties");
    uint32_t count = 0;
    enumerate(&count, nullptr);
    std::vector<VkLayerProperties> layers(count);
    enumerate(&count, layers.data());
    return std::ranges::any_of(layers, [&](const auto& layer) { return std::strcmp(layer.layerName, wanted) == 0; });
}

bool has_instance_extension(const VulkanFunctions& functions, const char* layer, const char* wanted) {
    const auto enumerate = instance_function<PFN_vkEnumerateInstanceExtensionProperties>(
        functions, VK_NULL_HANDLE, "vkEnumerateInstanceExtensionProperties");
    uint32_t count = 0;
    enumerate(layer, &count, nullptr);
    std::vector<VkExtensionProperties> extensions(count);
    enumerate(layer, &count, extensions.data());
    return std::ranges::any_of(extensions,
                               [&](const auto& item) { return std::strcmp(item.extensionName, wanted) == 0; });
}

bool has_device_extension(const VulkanFunctions& functions, VkPhysicalDevice device, const std::string& wanted) {
    uint32_t count = 0;
    functions.EnumerateDeviceExtensionProperties(device, nullptr, &count, nullptr);
    std::vector<VkExtensionProperties> extensions(count);
    functions.EnumerateDeviceExtensionProperties(device, nullptr, &count, extensions.data());
    return std::ranges::any_of(extensions, [&](const auto& item) { return wanted == item.extensionName; });
}

} // namespace

struct Device::Messages {
    mutable std::mutex mutex; // drivers may call from any thread
    std::vector<std::string> texts;
};

VKAPI_ATTR VkBool32 VKAPI_CALL Device::on_message(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                                  VkDebugUtilsMessageTypeFlagsEXT types,
                                                  const VkDebugUtilsMessengerCallbackDataEXT* data, void* user) {
    const std::string_view text = data->pMessage ? data->pMessage : "";
    // GENERAL is the library's choice for every image it writes and samples.
    const bool only_performance = types == VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT;
    if (only_performance && text.find("GENERAL") != std::string_view::npos)
        return VK_FALSE;
    auto& messages = *static_cast<Messages*>(user);
    const std::lock_guard lock(messages.mutex);
    if (messages.texts.size() < most_messages)
        messages.texts.emplace_back(text);
    return VK_FALSE; // never aborts the call
}

Device::Device() : messages_(std::make_unique<Messages>()) {}

Device::~Device() {
    if (device_) {
        functions_.DeviceWaitIdle(device_);
        one_shot_ = {};
        staging_ = {};
        functions_.DestroyDevice(device_, nullptr);
    }
    if (messenger_) {
        const auto destroy = instance_function<PFN_vkDestroyDebugUtilsMessengerEXT>(functions_, instance_,
                                                                                    "vkDestroyDebugUtilsMessengerEXT");
        destroy(instance_, messenger_, nullptr);
    }
    if (instance_)
        functions_.DestroyInstance(instance_, nullptr);
}

Result<std::unique_ptr<Device>> Device::create(const DeviceOptions& options) {
    std::unique_ptr<Device> device(new Device);
    if (auto made = device->create_instance(options); !made)
        return made.error();
    if (auto chosen = device->choose_device(options); !chosen)
        return chosen.error();
    if (auto made = device->create_device(options); !made)
        return made.error();
    auto commands = device->create_commands();
    if (!commands)
        return commands.error();
    device->one_shot_ = std::move(*commands);
    return device;
}

VkDebugUtilsMessengerCreateInfoEXT Device::messenger_info() const {
    VkDebugUtilsMessengerCreateInfoEXT messenger{};
    messenger.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT;
    messenger.messageSeverity =
        VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    messenger.messageType =
        VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT;
    messenger.pfnUserCallback = &Device::on_message;
    messenger.pUserData = messages_.get();
    return messenger;
}

Result<void> Device::create_instance(const DeviceOptions& options) {
    auto loader = open_loader();
    if (!loader)
        return loader.error();
    functions_ = *loader;
    std::vector<const char*> layers, extensions;
    const bool debug_utils =
        has_instance_extension(functions_, nullptr, VK_EXT_DEBUG_UTILS_EXTENSION_NAME) ||
        (options.validation && has_instance_extension(functions_, validation_layer, VK_EXT_DEBUG_UTILS_EXTENSION_NAME));
    if (options.validation) {
        if (!has_layer(functions_, validation_layer) || !debug_utils)
            return Error{ErrorCode::unsupported, "validation is asked for, but VK_LAYER_KHRONOS_validation with "
                                                 "VK_EXT_debug_utils is not installed"};
        layers.push_back(validation_layer);
        extensions.push_back(VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME);
    }
    for (const std::string& extension : options.instance_extensions) {
        if (!has_instance_extension(functions_, nullptr, extension.c_str()))
            return Error{ErrorCode::unsupported, "this machine's Vulkan lacks the instance extension " + extension};
        extensions.push_back(extension.c_str());
    }
    labels_ = options.labels && debug_utils;
    if (labels_ || options.validation)
        extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);

    VkApplicationInfo application{};
    application.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO;
    application.pApplicationName = "sfumato";
    application.apiVersion = requirements().api_version;
    const VkDebugUtilsMessengerCreateInfoEXT messenger = messenger_info();
    const VkValidationFeatureEnableEXT enabled[] = {VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT};
    VkValidationFeaturesEXT features{};
    features.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT;
    features.pNext = &messenger;
    features.enabledValidationFeatureCount = 1;
    features.pEnabledValidationFeatures = enabled;
    VkInstanceCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO;
    info.pNext = options.validation ? &features : nullptr;
    info.pApplicationInfo = &application;
    info.enabledLayerCount = static_cast<uint32_t>(layers.size());
    info.ppEnabledLayerNames = layers.data();
    info.enabledExtensionCount = static_cast<uint32_t>(extensions.size());
    info.ppEnabledExtensionNames = extensions.data();
    const auto create = instance_function<PFN_vkCreateInstance>(functions_, VK_NULL_HANDLE, "vkCreateInstance");
    if (const VkResult result = create(&info, nullptr, &instance_); result != VK_SUCCESS)
        return instance_error(result);
    if (auto loaded = load_instance_functions(functions_, instance_); !loaded)
        return loaded;
    if (options.validation) {
        const auto create_messenger = instance_function<PFN_vkCreateDebugUtilsMessengerEXT>(
            functions_, instance_, "vkCreateDebugUtilsMessengerEXT");
        const VkResult result = create_messenger(instance_, &messenger, nullptr, &messenger_);
        if (result != VK_SUCCESS)
            return vulkan_error(result, "vkCreateDebugUtilsMessengerEXT");
    }
    return {};
}

Result<void> Device::choose_device(const DeviceOptions& options) {
    auto all = candidates(functions_, instance_, options.graphics ? VK_QUEUE_GRAPHICS_BIT : 0);
    if (!all)
        return all.error();
    auto chosen = choose(*all, options.device);
    if (!chosen)
        return chosen.error();
    physical_device_ = chosen->handle;
    queue_family_ = chosen->queue_family;
    description_ = chosen->description;
    return {};
}

Result<void> Device::create_device(const DeviceOptions& options) {
    const Requirements needs = requirements();
    std::vector<const char*> extensions = needs.extensions;
    for (const std::string& extension : options.device_extensions) {
        if (!has_device_extension(functions_, physical_device_, extension))
            return Error{ErrorCode::unsupported, description_.name + " lacks the device extension " + extension};
        extensions.push_back(extension.c_str());
    }
    const float priority = 1.0f;
    VkDeviceQueueCreateInfo queue{};
    queue.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO;
    queue.queueFamilyIndex = queue_family_;
    queue.queueCount = 1;
    queue.pQueuePriorities = &priority;
    VkDeviceCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO;
    info.queueCreateInfoCount = 1;
    info.pQueueCreateInfos = &queue;
    info.enabledExtensionCount = static_cast<uint32_t>(extensions.size());
    info.ppEnabledExtensionNames = extensions.data();
    info.pEnabledFeatures = &needs.features;
    VkDevice made = VK_NULL_HANDLE;
    if (const VkResult result = functions_.CreateDevice(physical_device_, &info, nullptr, &made); result != VK_SUCCESS)
        return vulkan_error(result, "vkCreateDevice on " + description_.name);
    const char* missing = nullptr;
#define X(name)                                                                                                        \
    functions_.name = reinterpret_cast<PFN_vk##name>(functions_.GetDeviceProcAddr(made, "vk" #name));                  \
    if (functions_.name == nullptr)                                                                                    \
        missing = "vk" #name;
    SFUMATO_APPS_DEVICE_FUNCTIONS(X)
#undef X
    if (missing) {
        if (functions_.DestroyDevice)
            functions_.DestroyDevice(made, nullptr);
        return Error{ErrorCode::unsupported, "the driver of " + description_.name + " has no " + missing};
    }
    device_ = made;
    functions_.GetDeviceQueue(device_, queue_family_, 0, &queue_);
    functions_.GetPhysicalDeviceMemoryProperties(physical_device_, &memory_);
    return {};
}

ContextInfo Device::context_info() const {
    ContextInfo info;
    info.instance = instance_;
    info.physical_device = physical_device_;
    info.device = device_;
    info.get_instance_proc_addr = functions_.GetInstanceProcAddr;
    info.get_device_proc_addr = functions_.GetDeviceProcAddr;
    info.labels = labels_;
    return info;
}

VkQueueFlags Device::queue_flags() const {
    return VK_QUEUE_COMPUTE_BIT | (description_.graphics ? VkQueueFlags{VK_QUEUE_GRAPHICS_BIT} : 0u);
}

std::vector<std::string> Device::validation_messages() const {
    const std::lock_guard lock(messages_->mutex);
    return messages_->texts;
}

void Device::clear_validation_messages() {
    const std::lock_guard lock(messages_->mutex);
    messages_->texts.clear();
}

Commands::~Commands() {
    if (device_ == nullptr)
        return;
    const VulkanFunctions& vk = device_->functions();
    if (pending_)
        vk.WaitForFences(device_->handle(), 1, &fence_, VK_TRUE, UINT64_MAX);
    vk.DestroyFence(device_->handle(), fence_, nullptr);
    vk.DestroyCommandPool(device_->handle(), pool_, nullptr);
}

void Commands::swap(Commands& other) noexcept {
    std::swap(device_, other.device_);
    std::swap(pool_, other.pool_);
    std::swap(buffer_, other.buffer_);
    std::swap(fence_, other.fence_);
    std::swap(pending_, other.pending_);
}

Result<Commands> Device::create_commands() const {
    Commands made;
    made.device_ = this;
    VkCommandPoolCreateInfo pool{};
    pool.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
    pool.queueFamilyIndex = queue_family_;
    if (const VkResult result = functions_.CreateCommandPool(device_, &pool, nullptr, &made.pool_);
        result != VK_SUCCESS)
        return vulkan_error(result, "vkCreateCommandPool");
    VkCommandBufferAllocateInfo buffer{};
    buffer.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
    buffer.commandPool = made.pool_;
    buffer.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
    buffer.commandBufferCount = 1;
    if (const VkResult result = functions_.AllocateCommandBuffers(device_, &buffer, &made.buffer_);
        result != VK_SUCCESS)
        return vulkan_error(result, "vkAllocateCommandBuffers");
    VkFenceCreateInfo fence{};
    fence.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO;
    if (const VkResult result = functions_.CreateFence(device_, &fence, nullptr, &made.fence_); result != VK_SUCCESS)
        return vulkan_error(result, "vkCreateFence");
    return made;
}

Result<void> Device::begin(Commands& commands) const {
    if (auto waited = wait(commands); !waited)
        return waited;
    if (const VkResult result = functions_.ResetCommandPool(device_, commands.pool_, 0); result != VK_SUCCESS)
        return vulkan_error(result, "vkResetCommandPool");
    VkCommandBufferBeginInfo info{};
    info.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
    info.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    if (const VkResult result = functions_.BeginCommandBuffer(commands.buffer_, &info); result != VK_SUCCESS)
        return vulkan_error(result, "vkBeginCommandBuffer");
    return {};
}

Result<void> Device::submit(Commands& commands, VkSemaphore wait_for, VkPipelineStageFlags stage,
                            VkSemaphore signal) const {
    if (const VkResult result = functions_.EndCommandBuffer(commands.buffer_); result != VK_SUCCESS)
        return vulkan_error(result, "vkEndCommandBuffer");
    if (const VkResult result = functions_.ResetFences(device_, 1, &commands.fence_); result != VK_SUCCESS)
        return vulkan_error(result, "vkResetFences");
    VkSubmitInfo info{};
    info.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
    info.commandBufferCount = 1;
    info.pCommandBuffers = &commands.buffer_;
    info.waitSemaphoreCount = wait_for ? 1 : 0;
    info.pWaitSemaphores = &wait_for;
    info.pWaitDstStageMask = &stage;
    info.signalSemaphoreCount = signal ? 1 : 0;
    info.pSignalSemaphores = &signal;
    if (const VkResult result = functions_.QueueSubmit(queue_, 1, &info, commands.fence_); result != VK_SUCCESS)
        return vulkan_error(result, "vkQueueSubmit");
    commands.pending_ = true;
    return {};
}

Result<void> Device::wait(Commands& commands) const {
    if (!commands.pending_)
        return {};
    const VkResult result = functions_.WaitForFences(device_, 1, &commands.fence_, VK_TRUE, UINT64_MAX);
    commands.pending_ = false;
    if (result != VK_SUCCESS)
        return vulkan_error(result, "waiting for the device");
    return {};
}

Result<VkCommandBuffer> Device::begin() {
    if (auto begun = begin(one_shot_); !begun)
        return begun.error();
    return one_shot_.buffer();
}

Result<void> Device::submit_and_wait() {
    if (auto submitted = submit(one_shot_); !submitted)
        return submitted;
    return wait(one_shot_);
}

Result<void> Device::wait_idle() const {
    if (const VkResult result = functions_.DeviceWaitIdle(device_); result != VK_SUCCESS)
        return vulkan_error(result, "vkDeviceWaitIdle");
    return {};
}

} // namespace sfumato::apps
