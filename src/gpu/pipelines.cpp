// Compute pipelines, made when a pass first needs them and checked against the shader's SPIR-V.
#include "gpu/context_state.h"

#include <algorithm>

namespace sfumato {

VkDescriptorType descriptor_type(AccessKind kind) {
    switch (kind) {
    case AccessKind::fetch:
    case AccessKind::filter:
        return VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    case AccessKind::write:
        return VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
    default:
        return VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    }
}

namespace {

const char* type_name(VkDescriptorType type) {
    switch (type) {
    case VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER:
        return "a sampled image";
    case VK_DESCRIPTOR_TYPE_STORAGE_IMAGE:
        return "a storage image";
    case VK_DESCRIPTOR_TYPE_STORAGE_BUFFER:
        return "a storage buffer";
    default:
        return "constants";
    }
}

// Bindings that the optimiser dropped may be bound all the same; every one that is left must fit.
Result<void> check_bindings(const Plan& plan, const Pass& pass, const ShaderInterface& shader) {
    const auto defect = [&](const ShaderBinding& binding, const std::string& what) {
        return Error{ErrorCode::internal, plan.effect + "/" + pass.name + ": " + pass.shader.name + " binding " +
                                              std::to_string(binding.binding) + " of set " +
                                              std::to_string(binding.set) + " " + what};
    };
    for (const ShaderBinding& binding : shader.bindings) {
        if (binding.set == 1) {
            if (binding.type != VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC || pass.constants.empty())
                return defect(binding, "must be the pass's constants");
            continue;
        }
        if (binding.set > 1 || binding.binding >= pass.accesses.size())
            return defect(binding, "is not bound by the pass");
        const VkDescriptorType bound = descriptor_type(pass.accesses[binding.binding].kind);
        if (bound != binding.type)
            return defect(binding,
                          std::string("is ") + type_name(binding.type) + ", but the pass binds " + type_name(bound));
    }
    return {};
}

} // namespace

// Vulkan guarantees four storage buffers and four storage images a shader; some passes bind more, as desktop devices
// allow.
Result<void> ContextState::check_limits(const Pass& pass) const {
    const auto count = [&](VkDescriptorType type) {
        return static_cast<uint32_t>(std::count_if(pass.accesses.begin(), pass.accesses.end(),
                                                   [&](const Access& a) { return descriptor_type(a.kind) == type; }));
    };
    const struct {
        uint32_t wanted, allowed;
        const char* things;
    } needs[] = {
        {count(VK_DESCRIPTOR_TYPE_STORAGE_BUFFER), most_bindings.storage_buffers, "storage buffers"},
        {count(VK_DESCRIPTOR_TYPE_STORAGE_IMAGE), most_bindings.storage_images, "storage images"},
        {count(VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER), most_bindings.sampled_images, "sampled images"},
        {static_cast<uint32_t>(pass.accesses.size()) + (pass.constants.empty() ? 0u : 1u), most_bindings.all,
         "resources"},
    };
    for (const auto& need : needs)
        if (need.wanted > need.allowed)
            return Error{ErrorCode::unsupported, "pass " + pass.name + " binds " + std::to_string(need.wanted) + " " +
                                                     need.things + "; a shader of this device may bind " +
                                                     std::to_string(need.allowed)};
    return {};
}

Result<const Pipeline*> ContextState::pipeline(const Plan& plan, const Pass& pass) {
    std::vector<uint64_t> key = {reinterpret_cast<uint64_t>(shader_of(pass).code.data()), pass.accesses.size(),
                                 pass.constants.empty() ? 0u : 1u};
    for (const Access& access : pass.accesses)
        key.push_back(descriptor_type(access.kind));
    key.insert(key.end(), pass.specialization.begin(), pass.specialization.end());
    if (const auto found = pipelines.find(key); found != pipelines.end())
        return &found->second;
    auto created = create_pipeline(plan, pass);
    if (!created)
        return created.error();
    return &pipelines.emplace(std::move(key), *created).first->second;
}

Result<Pipeline> ContextState::create_pipeline(const Plan& plan, const Pass& pass) {
    const Shader& source = shader_of(pass);
    auto shader = reflect_shader(source);
    if (!shader)
        return shader.error();
    if (auto checked = check_bindings(plan, pass, *shader); !checked)
        return checked.error();
    if (auto checked = check_limits(pass); !checked)
        return checked.error();
    Pipeline result;
    result.local_size = shader->local_size;
    for (const ShaderBinding& binding : shader->bindings)
        if (binding.is_integer && binding.binding < 64)
            result.integer_samplers |= uint64_t{1} << binding.binding;
    VkShaderModule module = VK_NULL_HANDLE;
    const auto fail = [&](const char* call, VkResult code) {
        vk.vkDestroyShaderModule(info.device, module, nullptr);
        vk.vkDestroyPipelineLayout(info.device, result.layout, nullptr);
        vk.vkDestroyDescriptorSetLayout(info.device, result.set_layout, nullptr);
        Error error = vulkan_error(call, code);
        error.message = std::string(source.name) + ": " + error.message;
        return error;
    };
    std::vector<VkDescriptorSetLayoutBinding> bindings;
    for (const Access& access : pass.accesses)
        bindings.push_back({static_cast<uint32_t>(bindings.size()), descriptor_type(access.kind), 1,
                            VK_SHADER_STAGE_COMPUTE_BIT, nullptr});
    VkDescriptorSetLayoutCreateInfo set{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, nullptr, 0,
                                        static_cast<uint32_t>(bindings.size()), bindings.data()};
    if (VkResult r = vk.vkCreateDescriptorSetLayout(info.device, &set, nullptr, &result.set_layout); r != VK_SUCCESS)
        return fail("vkCreateDescriptorSetLayout", r);
    const VkDescriptorSetLayout layouts[] = {result.set_layout, constants_layout};
    VkPipelineLayoutCreateInfo layout{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    layout.setLayoutCount = pass.constants.empty() ? 1 : 2;
    layout.pSetLayouts = layouts;
    if (VkResult r = vk.vkCreatePipelineLayout(info.device, &layout, nullptr, &result.layout); r != VK_SUCCESS)
        return fail("vkCreatePipelineLayout", r);
    VkShaderModuleCreateInfo code{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
    code.codeSize = source.code.size_bytes();
    code.pCode = source.code.data();
    if (VkResult r = vk.vkCreateShaderModule(info.device, &code, nullptr, &module); r != VK_SUCCESS)
        return fail("vkCreateShaderModule", r);
    std::vector<VkSpecializationMapEntry> entries;
    for (uint32_t i = 0; i < pass.specialization.size(); ++i)
        entries.push_back({i, i * 4, 4});
    const VkSpecializationInfo specialization{static_cast<uint32_t>(entries.size()), entries.data(),
                                              pass.specialization.size() * 4, pass.specialization.data()};
    VkComputePipelineCreateInfo create{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
    create.stage = {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                    nullptr,
                    0,
                    VK_SHADER_STAGE_COMPUTE_BIT,
                    module,
                    "main",
                    &specialization};
    create.layout = result.layout;
    if (VkResult r =
            vk.vkCreateComputePipelines(info.device, info.pipeline_cache, 1, &create, nullptr, &result.pipeline);
        r != VK_SUCCESS)
        return fail("vkCreateComputePipelines", r);
    vk.vkDestroyShaderModule(info.device, module, nullptr);
    name_object(VK_OBJECT_TYPE_PIPELINE, reinterpret_cast<uint64_t>(result.pipeline), source.name);
    return result;
}

} // namespace sfumato
