// Vertices, indices, textures with mip levels, and a descriptor set a material.
#include "scene/gltf/mesh_renderer_model.h"

#include "scene/gltf/mesh_shared.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <string>

namespace sfumato::scene {
namespace {

constexpr uint32_t texture_slots = 4;

// Triangles in a row that have one node and one part.
std::vector<MeshDraw> runs_of(const Model& model, const TriangleMesh& mesh) {
    std::vector<MeshDraw> draws;
    const auto same = [](const TriangleMesh::Source& a, const TriangleMesh::Source& b) {
        return a.node == b.node && a.part == b.part;
    };
    for (uint32_t i = 0; i < mesh.sources.size(); ++i) {
        const TriangleMesh::Source& source = mesh.sources[i];
        if (i == 0 || !same(source, mesh.sources[i - 1])) {
            const MeshPart& part = model.meshes[model.nodes[source.node].mesh].parts[source.part];
            draws.push_back({3 * i, 0, source.node, part.material});
        }
        draws.back().count += 3;
    }
    return draws;
}

// The colours of a run's vertices, which stand in the mesh in the order that they have in their part.
void copy_colours(const Model& model, const TriangleMesh& mesh, const MeshDraw& draw,
                  std::span<MeshStaticVertex> vertices) {
    const TriangleMesh::Source& source = mesh.sources[draw.first_index / 3];
    const MeshPart& part = model.meshes[model.nodes[source.node].mesh].parts[source.part];
    const auto used = std::span(mesh.indices).subspan(draw.first_index, draw.count);
    const auto own = std::span(part.indices).subspan(3 * size_t{source.triangle}, draw.count);
    const uint32_t first = std::ranges::min(used) - std::ranges::min(own);
    for (const uint32_t index : used)
        std::ranges::copy(part.vertices[index - first].colour, vertices[index].colour);
}

shared::MeshMaterial material_constants(const ModelMaterial& material) {
    shared::MeshMaterial result{};
    const auto& base = material.base_colour;
    const auto& emission = material.emission;
    result.base_colour = {base[0], base[1], base[2], base[3]};
    result.emission = {emission[0], emission[1], emission[2], material.normal_scale};
    result.metallic = material.metallic;
    result.roughness = material.roughness;
    result.cutoff = material.alpha_mode == AlphaMode::mask ? material.alpha_cutoff : -1.0f;
    result.flags = (material.double_sided ? MESH_DOUBLE_SIDED : 0u) | (material.unlit ? MESH_UNLIT : 0u) |
                   (material.normal_texture != none ? MESH_NORMAL_MAP : 0u) |
                   (material.alpha_mode == AlphaMode::blend ? MESH_BLENDED : 0u);
    return result;
}

} // namespace

Result<std::unique_ptr<MeshModel>> MeshModel::create(const MeshDevice& device, const MeshPipelines& pipelines,
                                                     const Model& model, const TriangleMesh& mesh) {
    std::unique_ptr<MeshModel> made(new MeshModel(device));
    if (auto added = made->add_geometry(model, mesh); !added)
        return added.error();
    for (const Texture& texture : model.textures)
        if (auto added = made->add_texture(texture); !added)
            return added.error();
    if (auto added = made->add_texture({1, 1, {255, 255, 255, 255}}); !added)
        return added.error();
    if (auto added = made->add_materials(pipelines, model); !added)
        return added.error();
    return made;
}

Result<void> MeshModel::add_geometry(const Model& model, const TriangleMesh& mesh) {
    if (mesh.indices.empty() || mesh.positions.empty())
        return Error{ErrorCode::invalid_argument, "the model " + model.name + " has no triangles"};
    draws_ = runs_of(model, mesh);
    vertex_count_ = mesh.positions.size();
    auto vertices = device_->create_buffer(vertex_count_ * sizeof(MeshStaticVertex), VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
    auto indices = device_->create_buffer(mesh.indices.size() * 4, VK_BUFFER_USAGE_INDEX_BUFFER_BIT);
    if (!vertices || !indices)
        return vertices ? indices.error() : vertices.error();
    vertices_ = std::move(*vertices);
    indices_ = std::move(*indices);
    std::vector<MeshStaticVertex> all(vertex_count_);
    for (size_t i = 0; i < vertex_count_; ++i)
        all[i] = {{mesh.texcoords[i][0], mesh.texcoords[i][1]}, {1, 1, 1, 1}};
    for (const MeshDraw& draw : draws_)
        copy_colours(model, mesh, draw, all);
    std::memcpy(vertices_.mapped, all.data(), vertices_.size);
    std::memcpy(indices_.mapped, mesh.indices.data(), indices_.size);
    return {};
}

Result<void> MeshModel::add_texture(const Texture& texture) {
    const auto levels = static_cast<uint32_t>(std::bit_width(std::max(texture.width, texture.height)));
    auto image = device_->create_image(
        texture.is_srgb ? VK_FORMAT_R8G8B8A8_SRGB : VK_FORMAT_R8G8B8A8_UNORM, {texture.width, texture.height}, levels,
        VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT);
    if (!image)
        return image.error();
    auto pixels = device_->create_buffer(texture.rgba.size(), VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
    if (!pixels)
        return pixels.error();
    std::memcpy(pixels->mapped, texture.rgba.data(), texture.rgba.size());
    textures_.push_back(std::move(*image));
    pixels_.push_back(std::move(*pixels));
    return {};
}

Result<VkSampler> MeshModel::sampler(const Texture& texture) {
    const uint32_t key = (texture.repeats_u ? 1u : 0u) | (texture.repeats_v ? 2u : 0u) | (texture.is_nearest ? 4u : 0u);
    if (const auto found = samplers_.find(key); found != samplers_.end())
        return VkSampler{found->second};
    VkSamplerCreateInfo info{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
    info.magFilter = texture.is_nearest ? VK_FILTER_NEAREST : VK_FILTER_LINEAR;
    info.minFilter = info.magFilter;
    info.mipmapMode = texture.is_nearest ? VK_SAMPLER_MIPMAP_MODE_NEAREST : VK_SAMPLER_MIPMAP_MODE_LINEAR;
    const auto mode = [](bool repeats) {
        return repeats ? VK_SAMPLER_ADDRESS_MODE_REPEAT : VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
    };
    info.addressModeU = mode(texture.repeats_u);
    info.addressModeV = mode(texture.repeats_v);
    info.addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
    info.maxLod = VK_LOD_CLAMP_NONE;
    const MeshFunctions& vk = device_->functions();
    auto made = device_->make(vk.CreateSampler, vk.DestroySampler, info, "vkCreateSampler");
    if (!made)
        return made.error();
    return VkSampler{samplers_.emplace(key, std::move(*made)).first->second};
}

Result<void> MeshModel::add_materials(const MeshPipelines& pipelines, const Model& model) {
    const auto count = static_cast<uint32_t>(model.materials.size());
    const MeshFunctions& vk = device_->functions();
    const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, count},
                                          {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, count * texture_slots}};
    VkDescriptorPoolCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
    info.maxSets = count;
    info.poolSizeCount = 2;
    info.pPoolSizes = sizes;
    auto pool = device_->make(vk.CreateDescriptorPool, vk.DestroyDescriptorPool, info, "vkCreateDescriptorPool");
    if (!pool)
        return pool.error();
    pool_ = std::move(*pool);
    constexpr size_t stride = 256; // no device asks for a larger alignment
    static_assert(sizeof(shared::MeshMaterial) <= stride);
    auto constants = device_->create_buffer(count * stride, VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT);
    if (!constants)
        return constants.error();
    materials_ = std::move(*constants);
    const Texture white{1, 1, {}};
    for (uint32_t i = 0; i < count; ++i) {
        const ModelMaterial& material = model.materials[i];
        const shared::MeshMaterial values = material_constants(material);
        std::memcpy(materials_.mapped + i * stride, &values, sizeof(values));
        const VkDescriptorSetLayout layout = pipelines.material;
        const VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO, nullptr, pool_, 1,
                                                   &layout};
        VkDescriptorSet set = VK_NULL_HANDLE;
        if (const VkResult result = vk.AllocateDescriptorSets(device_->handle(), &allocate, &set); result != VK_SUCCESS)
            return MeshDevice::failed("vkAllocateDescriptorSets", result);
        const VkDescriptorBufferInfo buffer{materials_.buffer, i * stride, sizeof(values)};
        const uint32_t maps[texture_slots] = {material.base_colour_texture, material.metallic_roughness_texture,
                                              material.normal_texture, material.emission_texture};
        VkDescriptorImageInfo images[texture_slots];
        std::vector<VkWriteDescriptorSet> writes = {{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET, nullptr, set, 0, 0, 1,
                                                     VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, nullptr, &buffer, nullptr}};
        for (uint32_t slot = 0; slot < texture_slots; ++slot) {
            const bool has_map = maps[slot] != none;
            auto used = sampler(has_map ? model.textures[maps[slot]] : white);
            if (!used)
                return used.error();
            const MeshImage& image = has_map ? textures_[maps[slot]] : textures_.back();
            images[slot] = {*used, image.view, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
            writes.push_back({VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET, nullptr, set, slot + 1, 0, 1,
                              VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, &images[slot], nullptr, nullptr});
        }
        vk.UpdateDescriptorSets(device_->handle(), static_cast<uint32_t>(writes.size()), writes.data(), 0, nullptr);
        sets_.push_back(set);
    }
    return {};
}

// Between transfers, and at last to the shaders.
void MeshModel::barrier(VkCommandBuffer commands, const MeshImage& image, uint32_t level, uint32_t count,
                        VkImageLayout before, VkImageLayout after) const {
    const bool is_last = after == VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
    VkImageMemoryBarrier change{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER};
    change.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
    change.dstAccessMask =
        is_last ? VK_ACCESS_SHADER_READ_BIT : VK_ACCESS_TRANSFER_READ_BIT | VK_ACCESS_TRANSFER_WRITE_BIT;
    change.oldLayout = before;
    change.newLayout = after;
    change.srcQueueFamilyIndex = change.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    change.image = image.image;
    change.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, level, count, 0, 1};
    device_->functions().CmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT,
                                            is_last ? VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT
                                                    : VK_PIPELINE_STAGE_TRANSFER_BIT,
                                            0, 0, nullptr, 0, nullptr, 1, &change);
}

void MeshModel::record_upload(VkCommandBuffer commands, const MeshImage& image, const MeshBuffer& pixels) const {
    constexpr auto target = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, source = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
    const MeshFunctions& vk = device_->functions();
    barrier(commands, image, 0, image.levels, VK_IMAGE_LAYOUT_UNDEFINED, target);
    VkBufferImageCopy copy{};
    copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    copy.imageExtent = {image.extent.width, image.extent.height, 1};
    vk.CmdCopyBufferToImage(commands, pixels.buffer, image.image, target, 1, &copy);
    const auto corner = [&](uint32_t level) {
        return VkOffset3D{std::max(1, static_cast<int>(image.extent.width >> level)),
                          std::max(1, static_cast<int>(image.extent.height >> level)), 1};
    };
    // Every level is the one above at half its size; sRGB is averaged as light.
    for (uint32_t level = 1; level < image.levels; ++level) {
        barrier(commands, image, level - 1, 1, target, source);
        VkImageBlit blit{};
        blit.srcSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, level - 1, 0, 1};
        blit.dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, level, 0, 1};
        blit.srcOffsets[1] = corner(level - 1);
        blit.dstOffsets[1] = corner(level);
        vk.CmdBlitImage(commands, image.image, source, image.image, target, 1, &blit, VK_FILTER_LINEAR);
    }
    if (image.levels > 1)
        barrier(commands, image, 0, image.levels - 1, source, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    barrier(commands, image, image.levels - 1, 1, target, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
}

std::vector<MeshBuffer> MeshModel::record_uploads(VkCommandBuffer commands) {
    for (size_t i = 0; i < pixels_.size(); ++i)
        record_upload(commands, textures_[i], pixels_[i]);
    return std::exchange(pixels_, {});
}

} // namespace sfumato::scene
