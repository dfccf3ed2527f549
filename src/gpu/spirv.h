// What a compute shader binds, read from its SPIR-V, so that a pass that does not fit its shader is an error with a
// name.
#pragma once

#include "sfumato/plan.h"
#include "sfumato/result.h"

#include <array>
#include <vector>

namespace sfumato {

struct ShaderBinding {
    uint32_t set = 0;
    uint32_t binding = 0;
    VkDescriptorType type = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    bool is_integer = false; // a sampler of integers
};

struct ShaderInterface {
    std::array<uint32_t, 3> local_size = {1, 1, 1};
    std::vector<ShaderBinding> bindings;
};

Result<ShaderInterface> reflect_shader(const Shader& shader);

} // namespace sfumato
