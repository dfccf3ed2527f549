// Loading the function table, and errors of Vulkan calls as sentences.
#include "gpu/functions.h"

namespace sfumato {

Result<Functions> load_functions(const ContextInfo& info) {
    Functions functions;
    const char* missing = nullptr;
#define SFUMATO_LOAD(name)                                                                                             \
    functions.name = reinterpret_cast<PFN_##name>(info.get_instance_proc_addr(info.instance, #name));                  \
    if (!functions.name && !missing)                                                                                   \
        missing = #name;
    SFUMATO_INSTANCE_FUNCTIONS(SFUMATO_LOAD)
#undef SFUMATO_LOAD
#define SFUMATO_LOAD(name)                                                                                             \
    functions.name = reinterpret_cast<PFN_##name>(info.get_device_proc_addr(info.device, #name));                      \
    if (!functions.name && !missing)                                                                                   \
        missing = #name;
    SFUMATO_DEVICE_FUNCTIONS(SFUMATO_LOAD)
#undef SFUMATO_LOAD
    if (info.labels) {
#define SFUMATO_LOAD(name) functions.name = reinterpret_cast<PFN_##name>(info.get_device_proc_addr(info.device, #name));
        SFUMATO_OPTIONAL_FUNCTIONS(SFUMATO_LOAD)
#undef SFUMATO_LOAD
    }
    if (missing)
        return Error{ErrorCode::unsupported, std::string("the device has no ") + missing +
                                                 "; Sfumato needs Vulkan 1.1, reached through the given "
                                                 "get_instance_proc_addr and get_device_proc_addr"};
    return functions;
}

Error vulkan_error(const char* call, VkResult result) {
    const auto named = [&](ErrorCode code, const char* name) {
        return Error{code, std::string(call) + " failed: " + name};
    };
    switch (result) {
    case VK_ERROR_OUT_OF_HOST_MEMORY:
        return named(ErrorCode::out_of_memory, "out of host memory");
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
        return named(ErrorCode::out_of_memory, "out of device memory");
    case VK_ERROR_OUT_OF_POOL_MEMORY:
    case VK_ERROR_FRAGMENTED_POOL:
        return named(ErrorCode::out_of_memory, "out of descriptor pool memory");
    case VK_ERROR_DEVICE_LOST:
        return named(ErrorCode::device_lost, "the device is lost");
    default:
        return {ErrorCode::vulkan, std::string(call) + " failed with VkResult " + std::to_string(result)};
    }
}

} // namespace sfumato
