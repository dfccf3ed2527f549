// Opening the Vulkan loader, describing the devices and choosing one.
#include "apps/common/device_choice.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <dlfcn.h>

namespace sfumato::apps {
namespace {

const char* type_text(VkPhysicalDeviceType type) {
    switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
        return "discrete";
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
        return "integrated";
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
        return "virtual";
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
        return "cpu";
    default:
        return "other";
    }
}

int rank(VkPhysicalDeviceType type) {
    switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
        return 0;
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
        return 1;
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
        return 2;
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
        return 3;
    default:
        return 4;
    }
}

std::string version_text(uint32_t version) {
    return std::to_string(VK_API_VERSION_MAJOR(version)) + "." + std::to_string(VK_API_VERSION_MINOR(version)) + "." +
           std::to_string(VK_API_VERSION_PATCH(version));
}

std::string lower(std::string text) {
    std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return text;
}

// Driver name and version: core since Vulkan 1.2, an empty text on older devices.
std::string driver_text(const VulkanFunctions& functions, VkPhysicalDevice device, uint32_t api_version) {
    if (api_version < VK_API_VERSION_1_2)
        return {};
    VkPhysicalDeviceDriverProperties driver{};
    driver.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES;
    VkPhysicalDeviceProperties2 properties{};
    properties.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2;
    properties.pNext = &driver;
    functions.GetPhysicalDeviceProperties2(device, &properties);
    const std::string info = driver.driverInfo;
    return info.empty() ? driver.driverName : std::string(driver.driverName) + " " + info;
}

// All members of VkPhysicalDeviceFeatures are VkBool32.
bool has_features(const VkPhysicalDeviceFeatures& present, const VkPhysicalDeviceFeatures& needed) {
    const auto* have = reinterpret_cast<const VkBool32*>(&present);
    const auto* need = reinterpret_cast<const VkBool32*>(&needed);
    for (size_t i = 0; i < sizeof(VkPhysicalDeviceFeatures) / sizeof(VkBool32); ++i)
        if (need[i] && !have[i])
            return false;
    return true;
}

// The queue family to use: the first with the flags needed, one that can draw before one that cannot, one that can
// measure time before one that cannot.
std::optional<uint32_t> choose_queue_family(const VulkanFunctions& functions, VkPhysicalDevice device,
                                            VkQueueFlags flags, DeviceDescription& description) {
    uint32_t count = 0;
    functions.GetPhysicalDeviceQueueFamilyProperties(device, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    functions.GetPhysicalDeviceQueueFamilyProperties(device, &count, families.data());
    std::optional<uint32_t> found;
    int best = -1;
    for (uint32_t i = 0; i < count; ++i) {
        if ((families[i].queueFlags & flags) != flags)
            continue;
        const bool draws = (families[i].queueFlags & VK_QUEUE_GRAPHICS_BIT) != 0;
        const bool measures = families[i].timestampValidBits > 0;
        const int value = 2 * draws + measures;
        if (value <= best)
            continue;
        best = value;
        found = i;
        description.graphics = draws;
        description.timestamps = measures;
    }
    return found;
}

Candidate describe(const VulkanFunctions& functions, VkPhysicalDevice handle, uint32_t index, VkQueueFlags more_flags) {
    VkPhysicalDeviceProperties properties{};
    functions.GetPhysicalDeviceProperties(handle, &properties);
    VkPhysicalDeviceMemoryProperties memory{};
    functions.GetPhysicalDeviceMemoryProperties(handle, &memory);
    VkPhysicalDeviceFeatures features{};
    functions.GetPhysicalDeviceFeatures(handle, &features);

    Candidate candidate;
    candidate.handle = handle;
    candidate.type = properties.deviceType;
    DeviceDescription& description = candidate.description;
    description.index = index;
    description.name = properties.deviceName;
    description.type = type_text(properties.deviceType);
    description.api_version = version_text(properties.apiVersion);
    description.driver = driver_text(functions, handle, properties.apiVersion);
    for (uint32_t heap = 0; heap < memory.memoryHeapCount; ++heap)
        if (memory.memoryHeaps[heap].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT)
            description.memory_bytes += memory.memoryHeaps[heap].size;

    const Requirements needs = requirements();
    const auto family = choose_queue_family(functions, handle, needs.queue_flags | more_flags, description);
    candidate.queue_family = family.value_or(0);
    description.timestamps = description.timestamps && properties.limits.timestampPeriod > 0.0f;
    if (properties.apiVersion < needs.api_version)
        description.why_not_usable = "it has Vulkan " + description.api_version + ", Sfumato needs " +
                                     version_text(needs.api_version) + " or newer";
    else if (!has_features(features, needs.features))
        description.why_not_usable = features.shaderStorageImageWriteWithoutFormat
                                         ? "it lacks a device feature that Sfumato needs"
                                         : "it lacks the feature shaderStorageImageWriteWithoutFormat";
    else if (!family)
        description.why_not_usable =
            more_flags ? "it has no queue that both computes and draws" : "it has no compute queue";
    return candidate;
}

bool matches(const Candidate& candidate, const std::string& wanted) {
    if (wanted.empty())
        return true;
    uint32_t index = 0;
    const auto [end, error] = std::from_chars(wanted.data(), wanted.data() + wanted.size(), index);
    if (error == std::errc{} && end == wanted.data() + wanted.size())
        return candidate.description.index == index;
    return lower(candidate.description.name).find(lower(wanted)) != std::string::npos;
}

} // namespace

Result<VulkanFunctions> open_loader() {
    void* library = dlopen("libvulkan.so.1", RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr) {
        const char* reason = dlerror();
        return Error{ErrorCode::unsupported,
                     std::string("no Vulkan loader: ") + (reason ? reason : "libvulkan.so.1 cannot be opened")};
    }
    VulkanFunctions functions;
    functions.GetInstanceProcAddr =
        reinterpret_cast<PFN_vkGetInstanceProcAddr>(dlsym(library, "vkGetInstanceProcAddr"));
    if (functions.GetInstanceProcAddr == nullptr)
        return Error{ErrorCode::unsupported, "no Vulkan loader: libvulkan.so.1 has no vkGetInstanceProcAddr"};
    return functions;
}

Error vulkan_error(VkResult result, std::string_view what) {
    const std::string message = std::string(what) + " failed: ";
    switch (result) {
    case VK_ERROR_OUT_OF_HOST_MEMORY:
        return {ErrorCode::out_of_memory, message + "out of host memory"};
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
        return {ErrorCode::out_of_memory, message + "out of device memory"};
    case VK_ERROR_DEVICE_LOST:
        return {ErrorCode::device_lost, message + "the device is lost"};
    default:
        return {ErrorCode::vulkan, message + "VkResult " + std::to_string(result)};
    }
}

Error instance_error(VkResult result) {
    if (result == VK_ERROR_INCOMPATIBLE_DRIVER || result == VK_ERROR_INITIALIZATION_FAILED)
        return {ErrorCode::unsupported, "no Vulkan device: the loader found no working driver"};
    return vulkan_error(result, "vkCreateInstance");
}

Result<void> load_instance_functions(VulkanFunctions& functions, VkInstance instance) {
    const char* missing = nullptr;
#define X(name)                                                                                                        \
    functions.name = reinterpret_cast<PFN_vk##name>(functions.GetInstanceProcAddr(instance, "vk" #name));              \
    if (functions.name == nullptr)                                                                                     \
        missing = "vk" #name;
    SFUMATO_APPS_INSTANCE_FUNCTIONS(X)
#undef X
    if (missing)
        return Error{ErrorCode::unsupported, std::string("the Vulkan loader has no ") + missing};
    return {};
}

Result<std::vector<Candidate>> candidates(const VulkanFunctions& functions, VkInstance instance,
                                          VkQueueFlags more_flags) {
    uint32_t count = 0;
    VkResult result = functions.EnumeratePhysicalDevices(instance, &count, nullptr);
    std::vector<VkPhysicalDevice> handles(count);
    if (result == VK_SUCCESS && count > 0)
        result = functions.EnumeratePhysicalDevices(instance, &count, handles.data());
    if (result == VK_ERROR_INITIALIZATION_FAILED || (result == VK_SUCCESS && count == 0))
        return Error{ErrorCode::unsupported, "no Vulkan device: no driver reports one"};
    if (result != VK_SUCCESS && result != VK_INCOMPLETE)
        return vulkan_error(result, "vkEnumeratePhysicalDevices");
    std::vector<Candidate> all;
    for (uint32_t i = 0; i < count; ++i)
        all.push_back(describe(functions, handles[i], i, more_flags));
    return all;
}

Result<Candidate> choose(const std::vector<Candidate>& all, const std::string& wanted) {
    const Candidate* best = nullptr;
    const Candidate* unusable = nullptr;
    std::string names;
    for (const Candidate& candidate : all) {
        const DeviceDescription& description = candidate.description;
        names += (names.empty() ? "" : ", ") + std::to_string(description.index) + " " + description.name;
        if (!matches(candidate, wanted))
            continue;
        if (!description.why_not_usable.empty())
            unusable = unusable ? unusable : &candidate;
        else if (best == nullptr || rank(candidate.type) < rank(best->type))
            best = &candidate;
    }
    if (best)
        return *best;
    if (unusable)
        return Error{ErrorCode::unsupported, "no Vulkan device: " + unusable->description.name + " cannot be used, " +
                                                 unusable->description.why_not_usable};
    return Error{ErrorCode::unsupported, "no Vulkan device: none matches \"" + wanted + "\"; there are: " + names};
}

Result<std::vector<DeviceDescription>> list_devices() {
    auto loader = open_loader();
    if (!loader)
        return loader.error();
    VulkanFunctions& functions = *loader;
    const auto create =
        reinterpret_cast<PFN_vkCreateInstance>(functions.GetInstanceProcAddr(nullptr, "vkCreateInstance"));
    VkApplicationInfo application{};
    application.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO;
    application.apiVersion = VK_API_VERSION_1_1;
    VkInstanceCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO;
    info.pApplicationInfo = &application;
    VkInstance instance = VK_NULL_HANDLE;
    if (const VkResult result = create(&info, nullptr, &instance); result != VK_SUCCESS)
        return instance_error(result);
    if (auto loaded = load_instance_functions(functions, instance); !loaded)
        return loaded.error();
    auto all = candidates(functions, instance);
    functions.DestroyInstance(instance, nullptr);
    if (!all)
        return all.error();
    std::vector<DeviceDescription> descriptions;
    for (Candidate& candidate : *all)
        descriptions.push_back(std::move(candidate.description));
    return descriptions;
}

} // namespace sfumato::apps
