// A SPIR-V reader of just what the executor needs: descriptor bindings and the local size.
// Opcodes and operand order: SPIR-V specification 1.3, sections 2.3 and 3.32.
#include "gpu/spirv.h"

#include <string>

namespace sfumato {

namespace {

enum Op : uint32_t {
    op_execution_mode = 16,
    op_type_int = 21,
    op_type_image = 25,
    op_type_sampled_image = 27,
    op_type_struct = 30,
    op_type_pointer = 32,
    op_variable = 59,
    op_decorate = 71,
};
constexpr uint32_t magic = 0x07230203;
constexpr uint32_t mode_local_size = 17;
constexpr uint32_t decoration_buffer_block = 3, decoration_binding = 33, decoration_descriptor_set = 34;
constexpr uint32_t storage_uniform_constant = 0, storage_uniform = 2, storage_storage_buffer = 12;

struct Id {
    uint32_t op = 0;
    uint32_t sampled = 0; // of an image type: 1 with sampler, 2 storage
    uint32_t type = 0;    // pointee of a pointer, type of a variable, of an image's texels, of a sampled image
    uint32_t storage = 0;
    uint32_t set = 0, binding = 0;
    bool is_bound = false, is_buffer_block = false;
};

void decorate(Id& id, std::span<const uint32_t> words) {
    if (words[2] == decoration_buffer_block)
        id.is_buffer_block = true;
    if (words.size() > 3 && words[2] == decoration_binding) {
        id.binding = words[3];
        id.is_bound = true;
    }
    if (words.size() > 3 && words[2] == decoration_descriptor_set)
        id.set = words[3];
}

void read_instruction(std::span<const uint32_t> words, std::vector<Id>& ids, ShaderInterface& shader) {
    const uint32_t op = words[0] & 0xffff;
    const auto id = [&](size_t word) -> Id& { return ids[words[word] < ids.size() ? words[word] : 0]; };
    if (op == op_execution_mode && words.size() >= 6 && words[2] == mode_local_size)
        shader.local_size = {words[3], words[4], words[5]};
    else if (op == op_decorate && words.size() >= 3)
        decorate(id(1), words);
    else if (op == op_type_image && words.size() >= 8) {
        id(1).op = op;
        id(1).type = words[2];
        id(1).sampled = words[7];
    } else if (op == op_type_sampled_image && words.size() >= 3) {
        id(1).op = op;
        id(1).type = words[2];
    } else if ((op == op_type_int || op == op_type_struct) && words.size() >= 2)
        id(1).op = op;
    else if (op == op_type_pointer && words.size() >= 4) {
        id(1).storage = words[2];
        id(1).type = words[3];
    } else if (op == op_variable && words.size() >= 4) {
        id(2).op = op;
        id(2).type = words[1];
        id(2).storage = words[3];
    }
}

bool descriptor_type(const std::vector<Id>& ids, const Id& variable, VkDescriptorType& type) {
    const Id& pointee = ids[ids[variable.type].type];
    if (variable.storage == storage_storage_buffer || (variable.storage == storage_uniform && pointee.is_buffer_block))
        type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    else if (variable.storage == storage_uniform)
        type = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC;
    else if (variable.storage == storage_uniform_constant && pointee.op == op_type_sampled_image)
        type = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    else if (variable.storage == storage_uniform_constant && pointee.op == op_type_image && pointee.sampled == 2)
        type = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
    else
        return false;
    return true;
}

} // namespace

Result<ShaderInterface> reflect_shader(const Shader& shader) {
    const auto broken = [&](const char* what) {
        return Error{ErrorCode::internal, std::string("shader ") + shader.name + ": " + what};
    };
    const std::span<const uint32_t> code = shader.code;
    if (code.size() < 5 || code[0] != magic || code[3] > 1u << 22)
        return broken("not SPIR-V");
    ShaderInterface result;
    std::vector<Id> ids(code[3] + 1);
    for (size_t at = 5; at < code.size();) {
        const size_t count = code[at] >> 16;
        if (count == 0 || at + count > code.size())
            return broken("truncated SPIR-V");
        read_instruction(code.subspan(at, count), ids, result);
        at += count;
    }
    for (const Id& id : ids) {
        if (id.op != op_variable || !id.is_bound)
            continue;
        ShaderBinding binding{id.set, id.binding, {}, false};
        if (!descriptor_type(ids, id, binding.type))
            return broken("a binding is neither an image nor a buffer");
        if (binding.type == VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER)
            binding.is_integer = ids[ids[ids[ids[id.type].type].type].type].op == op_type_int;
        result.bindings.push_back(binding);
    }
    return result;
}

} // namespace sfumato
