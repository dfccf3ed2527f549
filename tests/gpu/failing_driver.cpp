// The wrappers of the failing driver: one for each function that creates, destroys or may fail.
#include "tests/gpu/failing_driver.h"

#include <cstdlib>
#include <iostream>

namespace sfumato::test {
namespace {

FailingDriver* driver = nullptr;
PFN_vkGetDeviceProcAddr real_get = nullptr;

bool must_fail(const char* name) {
    const bool fails = driver->calls++ == driver->fail_at || driver->fail_always == name;
    if (fails) {
        ++driver->failed;
        driver->last_failed = name;
    }
    return fails;
}

// `Name` is a type with `static constexpr const char* text`, so that each function has a wrapper of its own.
template <class Name, class Function>
struct Wrapper;

template <class Name, class... Args>
struct Wrapper<Name, VkResult(VKAPI_PTR*)(Args...)> {
    static inline PFN_vkVoidFunction real = nullptr;
    static VKAPI_ATTR VkResult VKAPI_CALL call(Args... args) {
        if (must_fail(Name::text))
            return driver->result;
        const VkResult result = reinterpret_cast<VkResult(VKAPI_PTR*)(Args...)>(real)(args...);
        if (result == VK_SUCCESS)
            ++driver->alive[Name::text];
        return result;
    }
};

template <class Name, class Handle>
struct Wrapper<Name, void(VKAPI_PTR*)(VkDevice, Handle, const VkAllocationCallbacks*)> {
    static inline PFN_vkVoidFunction real = nullptr;
    static VKAPI_ATTR void VKAPI_CALL call(VkDevice device, Handle handle, const VkAllocationCallbacks* allocator) {
        if (handle)
            --driver->alive[Name::creator];
        reinterpret_cast<void(VKAPI_PTR*)(VkDevice, Handle, const VkAllocationCallbacks*)>(real)(device, handle,
                                                                                                 allocator);
    }
};

// Functions that make something which another one destroys.
#define PAIRS(X)                                                                                                       \
    X(vkAllocateMemory, vkFreeMemory)                                                                                  \
    X(vkCreateBuffer, vkDestroyBuffer)                                                                                 \
    X(vkCreateImage, vkDestroyImage)                                                                                   \
    X(vkCreateImageView, vkDestroyImageView)                                                                           \
    X(vkCreateSampler, vkDestroySampler)                                                                               \
    X(vkCreateShaderModule, vkDestroyShaderModule)                                                                     \
    X(vkCreatePipelineLayout, vkDestroyPipelineLayout)                                                                 \
    X(vkCreateComputePipelines, vkDestroyPipeline)                                                                     \
    X(vkCreateDescriptorSetLayout, vkDestroyDescriptorSetLayout)                                                       \
    X(vkCreateDescriptorPool, vkDestroyDescriptorPool)                                                                 \
    X(vkCreateQueryPool, vkDestroyQueryPool)

// Functions that may fail and make nothing of their own.
#define SINGLES(X)                                                                                                     \
    X(vkMapMemory) X(vkBindBufferMemory) X(vkBindImageMemory) X(vkResetDescriptorPool) X(vkAllocateDescriptorSets)

#define PAIR_NAMES(create, destroy)                                                                                    \
    struct create##_name {                                                                                             \
        static constexpr const char* text = #create;                                                                   \
    };                                                                                                                 \
    struct destroy##_name {                                                                                            \
        static constexpr const char* creator = #create;                                                                \
    };
PAIRS(PAIR_NAMES)
#define SINGLE_NAME(name)                                                                                              \
    struct name##_name {                                                                                               \
        static constexpr const char* text = #name;                                                                     \
    };
SINGLES(SINGLE_NAME)

template <class Name, class Function>
PFN_vkVoidFunction wrap(VkDevice device, const char* name) {
    using Wrapped = Wrapper<Name, Function>;
    Wrapped::real = real_get(device, name);
    return Wrapped::real ? reinterpret_cast<PFN_vkVoidFunction>(&Wrapped::call) : nullptr;
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL get(VkDevice device, const char* name) {
    const std::string wanted = name;
    if (driver->hidden.contains(wanted))
        return nullptr;
#define WRAP_PAIR(create, destroy)                                                                                     \
    if (wanted == #create)                                                                                             \
        return wrap<create##_name, PFN_##create>(device, name);                                                        \
    if (wanted == #destroy)                                                                                            \
        return wrap<destroy##_name, PFN_##destroy>(device, name);
    PAIRS(WRAP_PAIR)
#define WRAP_SINGLE(single)                                                                                            \
    if (wanted == #single)                                                                                             \
        return wrap<single##_name, PFN_##single>(device, name);
    SINGLES(WRAP_SINGLE)
    return real_get(device, name);
}

} // namespace

int FailingDriver::total_alive() const {
    int total = 0;
#define COUNT(create, destroy)                                                                                         \
    if (const auto found = alive.find(#create); found != alive.end())                                                  \
        total += std::abs(found->second);
    PAIRS(COUNT)
    return total;
}

void FailingDriver::install(ContextInfo& info) {
    driver = this;
    if (info.get_device_proc_addr != &get)
        real_get = info.get_device_proc_addr;
    info.get_device_proc_addr = &get;
}

} // namespace sfumato::test
