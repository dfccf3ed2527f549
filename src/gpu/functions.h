// The Vulkan entry points that the library calls, from the host's own vkGet*ProcAddr: no link to a loader, no globals,
// so two contexts on two devices do not meet, and tests can hand in a driver that fails.
#pragma once

#include "sfumato/context.h"

namespace sfumato {

#define SFUMATO_INSTANCE_FUNCTIONS(X)                                                                                  \
    X(vkGetPhysicalDeviceProperties)                                                                                   \
    X(vkGetPhysicalDeviceProperties2)                                                                                  \
    X(vkGetPhysicalDeviceMemoryProperties)                                                                             \
    X(vkGetPhysicalDeviceFormatProperties)

#define SFUMATO_DEVICE_FUNCTIONS(X)                                                                                    \
    X(vkAllocateMemory)                                                                                                \
    X(vkFreeMemory)                                                                                                    \
    X(vkMapMemory)                                                                                                     \
    X(vkBindBufferMemory)                                                                                              \
    X(vkBindImageMemory)                                                                                               \
    X(vkGetBufferMemoryRequirements)                                                                                   \
    X(vkGetImageMemoryRequirements)                                                                                    \
    X(vkCreateBuffer)                                                                                                  \
    X(vkDestroyBuffer)                                                                                                 \
    X(vkCreateImage)                                                                                                   \
    X(vkDestroyImage)                                                                                                  \
    X(vkCreateImageView)                                                                                               \
    X(vkDestroyImageView)                                                                                              \
    X(vkCreateSampler)                                                                                                 \
    X(vkDestroySampler)                                                                                                \
    X(vkCreateShaderModule)                                                                                            \
    X(vkDestroyShaderModule)                                                                                           \
    X(vkCreatePipelineLayout)                                                                                          \
    X(vkDestroyPipelineLayout)                                                                                         \
    X(vkCreateComputePipelines)                                                                                        \
    X(vkDestroyPipeline)                                                                                               \
    X(vkCreateDescriptorSetLayout)                                                                                     \
    X(vkDestroyDescriptorSetLayout)                                                                                    \
    X(vkCreateDescriptorPool)                                                                                          \
    X(vkDestroyDescriptorPool)                                                                                         \
    X(vkResetDescriptorPool)                                                                                           \
    X(vkAllocateDescriptorSets)                                                                                        \
    X(vkUpdateDescriptorSets)                                                                                          \
    X(vkCreateQueryPool)                                                                                               \
    X(vkDestroyQueryPool)                                                                                              \
    X(vkGetQueryPoolResults)                                                                                           \
    X(vkCmdBindPipeline)                                                                                               \
    X(vkCmdBindDescriptorSets)                                                                                         \
    X(vkCmdDispatch)                                                                                                   \
    X(vkCmdDispatchIndirect)                                                                                           \
    X(vkCmdPipelineBarrier)                                                                                            \
    X(vkCmdClearColorImage)                                                                                            \
    X(vkCmdFillBuffer)                                                                                                 \
    X(vkCmdResetQueryPool)                                                                                             \
    X(vkCmdWriteTimestamp)

// May be null: without them nothing but names in a debugger is lost.
#define SFUMATO_OPTIONAL_FUNCTIONS(X)                                                                                  \
    X(vkCmdBeginDebugUtilsLabelEXT)                                                                                    \
    X(vkCmdEndDebugUtilsLabelEXT)                                                                                      \
    X(vkSetDebugUtilsObjectNameEXT)

struct Functions {
#define SFUMATO_MEMBER(name) PFN_##name name = nullptr;
    SFUMATO_INSTANCE_FUNCTIONS(SFUMATO_MEMBER)
    SFUMATO_DEVICE_FUNCTIONS(SFUMATO_MEMBER)
    SFUMATO_OPTIONAL_FUNCTIONS(SFUMATO_MEMBER)
#undef SFUMATO_MEMBER
};

// Errors: `unsupported`, naming the first function that the host's driver does not have.
Result<Functions> load_functions(const ContextInfo& info);

// A sentence for a failed Vulkan call: "vkCreateImage failed: VK_ERROR_OUT_OF_DEVICE_MEMORY".
Error vulkan_error(const char* call, VkResult result);

} // namespace sfumato
