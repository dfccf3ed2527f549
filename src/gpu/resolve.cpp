// From a plan's resources to device objects: transients from the pool, histories, descriptor sets and constants.
// Everything that can fail happens here, before the first command is recorded.
#include "gpu/executor_state.h"

#include <algorithm>
#include <cstring>

namespace sfumato {

namespace {
constexpr uint64_t chunk_bytes = 64 * 1024;
constexpr uint64_t largest_constants = 16 * 1024; // the least maxUniformBufferRange of Vulkan
constexpr uint32_t sets_per_pool = 32;
} // namespace

// What the plan takes of the host's must have been passed, and what it makes must be within the device's reach.
Result<void> ExecutorState::check_host(const Plan& plan, std::span<const Image> images,
                                       std::span<const Buffer> buffers) const {
    const auto missing = [](const Resource& resource, const char* what, size_t count) {
        return Error{ErrorCode::invalid_argument, std::string("the plan takes ") + what + " " +
                                                      std::to_string(resource.index) + " ('" + resource.name +
                                                      "'), but only " + std::to_string(count) + " were passed"};
    };
    for (const Resource& resource : plan.resources) {
        if (resource.bytes > context->largest_buffer)
            return Error{ErrorCode::unsupported,
                         "buffer '" + resource.name + "' would be " + std::to_string(resource.bytes) +
                             " bytes long; shaders of this device reach " + std::to_string(context->largest_buffer)};
        if (resource.kind == ResourceKind::host && resource.index >= images.size())
            return missing(resource, "image", images.size());
        if (resource.kind != ResourceKind::host_buffer)
            continue;
        if (resource.index >= buffers.size())
            return missing(resource, "buffer", buffers.size());
        const Buffer& buffer = buffers[resource.index];
        if (buffer.handle == VK_NULL_HANDLE || buffer.bytes < resource.bytes)
            return Error{
                ErrorCode::invalid_argument,
                "buffer '" + resource.name + "' is " +
                    (buffer.handle == VK_NULL_HANDLE ? "a null handle" : std::to_string(buffer.bytes) + " bytes long") +
                    "; the plan takes " + std::to_string(resource.bytes) + " bytes of it"};
    }
    return {};
}

Result<ResolvedPlan> ExecutorState::resolve(const Plan& plan, std::span<const Image> images,
                                            std::span<const Buffer> buffers, bool reset) {
    ResolvedPlan resolved;
    resolved.images.resize(plan.resources.size(), nullptr);
    resolved.buffers.resize(plan.resources.size(), nullptr);
    resolved.passes.resize(plan.passes.size());
    const auto fail = [&](const Error& error) {
        release(resolved);
        return Error{error.code, plan.effect + ": " + error.message};
    };
    if (auto passed = check_host(plan, images, buffers); !passed)
        return fail(passed.error());
    for (const Resource& resource : plan.resources) {
        const auto number = static_cast<size_t>(&resource - plan.resources.data());
        if (resource.kind == ResourceKind::state) {
            if (auto state = resolve_state(resource, reset, resolved); !state)
                return fail(state.error());
            resolved.buffers[number] = states[resource.index].buffer.get();
        }
        if (resource.kind == ResourceKind::previous || resource.kind == ResourceKind::current) {
            // Either comes first in a plan: both sides must have the new extent before one is taken.
            if (auto history = resolve_history(resource, reset, resolved); !history)
                return fail(history.error());
            HistoryImages& history = histories[resource.index];
            const uint32_t side = resource.kind == ResourceKind::current ? history.current : 1 - history.current;
            resolved.images[number] = history.images[side].get();
        }
    }
    for (size_t i = 0; i < plan.passes.size(); ++i) {
        auto pipeline = context->pipeline(plan, plan.passes[i]);
        if (!pipeline)
            return fail(pipeline.error());
        resolved.passes[i].pipeline = *pipeline;
        resolved.passes[i].barrier = plan.passes[i].barrier;
        if (auto size = dispatch_size(plan, plan.passes[i], resolved.passes[i]); !size)
            return fail(size.error());
    }
    if (auto transients = resolve_transients(plan, resolved); !transients)
        return fail(transients.error());
    for (size_t i = 0; i < plan.passes.size(); ++i) {
        if (auto set = write_set(plan, plan.passes[i], images, buffers, resolved, resolved.passes[i]); !set)
            return fail(set.error());
        if (i > 0 && plan.passes[i].constants == plan.passes[i - 1].constants) {
            // One copy for passes in a row, which the device finds in its caches.
            resolved.passes[i].constants_set = resolved.passes[i - 1].constants_set;
            resolved.passes[i].constants_offset = resolved.passes[i - 1].constants_offset;
        } else if (auto constants = write_constants(plan.passes[i], resolved.passes[i]); !constants)
            return fail(constants.error());
    }
    return resolved;
}

Result<void> ExecutorState::resolve_history(const Resource& resource, bool reset, ResolvedPlan& resolved) {
    if (histories.size() <= resource.index)
        histories.resize(resource.index + 1);
    HistoryImages& history = histories[resource.index];
    for (int side = 0; side < 2; ++side) {
        auto& image = history.images[side];
        if (image && image->format == resource.format && image->extent == resource.extent)
            continue;
        if (image) {
            context->history_bytes -= image->bytes;
            context->retired.push_back(std::move(image));
        }
        auto created = context->create_image(resource.name.c_str(), resource.format, resource.extent, 1);
        if (!created)
            return created.error();
        image = std::move(*created);
        context->history_bytes += image->bytes;
        history.has_layout[side] = false;
        history.clear_previous = true;
    }
    if (reset)
        history.clear_previous = true;
    for (auto& image : history.images)
        image->last_use = use();
    const auto& cleared = resolved.cleared_histories;
    if (history.clear_previous && std::find(cleared.begin(), cleared.end(), resource.index) == cleared.end())
        resolved.cleared_histories.push_back(resource.index);
    return {};
}

Result<void> ExecutorState::resolve_state(const Resource& resource, bool reset, ResolvedPlan& resolved) {
    if (states.size() <= resource.index)
        states.resize(resource.index + 1);
    StateBuffer& state = states[resource.index];
    if (!state.buffer || state.buffer->bytes != resource.bytes) {
        if (state.buffer) {
            context->history_bytes -= state.buffer->bytes;
            context->retired_buffers.push_back(std::move(state.buffer));
        }
        auto created = context->create_buffer(
            resource.bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT, false);
        if (!created)
            return Error{created.error().code, "state '" + resource.name + "': " + created.error().message};
        state.buffer = std::move(*created);
        context->history_bytes += state.buffer->bytes;
        state.clear = true;
    }
    state.clear = state.clear || reset;
    state.buffer->last_use = use();
    if (state.clear)
        resolved.cleared_states.push_back(resource.index);
    return {};
}

Result<DeviceImage*> ExecutorState::acquire_image(const Resource& resource) {
    for (auto& image : context->transients)
        if (!image->acquired && image->format == resource.format && image->extent == resource.extent &&
            image->mips == resource.mips) {
            image->acquired = true;
            image->last_use = use();
            return image.get();
        }
    auto created = context->create_image(resource.name.c_str(), resource.format, resource.extent, resource.mips);
    if (!created)
        return created.error();
    (*created)->acquired = true;
    (*created)->last_use = use();
    context->transients.push_back(std::move(*created));
    return context->transients.back().get();
}

Result<DeviceBuffer*> ExecutorState::acquire_buffer(const Resource& resource) {
    for (auto& buffer : context->buffers)
        if (!buffer->acquired && buffer->bytes == resource.bytes) {
            buffer->acquired = true;
            buffer->last_use = use();
            return buffer.get();
        }
    auto created = context->create_buffer(resource.bytes,
                                          VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT |
                                              VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                                          false);
    if (!created)
        return Error{created.error().code, "buffer '" + resource.name + "': " + created.error().message};
    (*created)->acquired = true;
    (*created)->last_use = use();
    context->buffers.push_back(std::move(*created));
    return context->buffers.back().get();
}

// Each transient takes an image at its first use and gives it back after its last, so that a later one may have it.
// Where two transients of one plan share an image, the planner knows no hazard between them: a barrier is added unless
// one stands in between already.
Result<void> ExecutorState::resolve_transients(const Plan& plan, ResolvedPlan& resolved) {
    std::vector<size_t> last_pass(plan.resources.size(), 0);
    for (size_t i = 0; i < plan.passes.size(); ++i)
        for (const Access& access : plan.passes[i].accesses)
            if (access.resource != no_resource)
                last_pass[access.resource] = i;
    std::map<const DeviceImage*, size_t> given_back; // image, the pass of its last use
    size_t last_barrier = 0;
    for (size_t i = 0; i < plan.passes.size(); ++i) {
        if (resolved.passes[i].barrier != Barrier::none)
            last_barrier = i;
        for (const Access& access : plan.passes[i].accesses) {
            if (access.resource == no_resource)
                continue;
            const Resource& resource = plan.resources[access.resource];
            if (resource.kind == ResourceKind::buffer && !resolved.buffers[access.resource]) {
                auto buffer = acquire_buffer(resource);
                if (!buffer)
                    return buffer.error();
                resolved.buffers[access.resource] = *buffer;
            }
            if (resource.kind != ResourceKind::transient || resolved.images[access.resource])
                continue;
            auto image = acquire_image(resource);
            if (!image)
                return image.error();
            resolved.images[access.resource] = *image;
            const auto earlier = given_back.find(*image);
            if (earlier != given_back.end() && last_barrier <= earlier->second) {
                if (resolved.passes[i].barrier == Barrier::none)
                    resolved.passes[i].barrier = Barrier::memory;
                last_barrier = i;
            }
        }
        for (const Access& access : plan.passes[i].accesses)
            if (access.resource != no_resource && last_pass[access.resource] == i &&
                plan.resources[access.resource].kind == ResourceKind::transient) {
                resolved.images[access.resource]->acquired = false;
                given_back[resolved.images[access.resource]] = i;
            }
    }
    return {};
}

void ExecutorState::release(const ResolvedPlan& resolved) {
    for (DeviceImage* image : resolved.images)
        if (image)
            image->acquired = false;
    for (DeviceBuffer* buffer : resolved.buffers)
        if (buffer)
            buffer->acquired = false;
}

Result<void> ExecutorState::dispatch_size(const Plan& plan, const Pass& pass, ResolvedPass& out) const {
    if (pass.dispatch.kind == DispatchKind::indirect)
        return {};
    const Resource& target = plan.resources[pass.dispatch.target];
    const uint32_t width = std::max(1u, target.extent.width >> pass.dispatch.mip);
    const uint32_t height = std::max(1u, target.extent.height >> pass.dispatch.mip);
    const auto& local = out.pipeline->local_size;
    const Extent block = pass.dispatch.block;
    if (pass.dispatch.kind == DispatchKind::groups)
        out.groups = {(width + block.width - 1) / block.width, (height + block.height - 1) / block.height, 1};
    else
        out.groups = {(width + local[0] - 1) / local[0], (height + local[1] - 1) / local[1], 1};
    if (out.groups[0] > 65535 || out.groups[1] > 65535)
        return Error{ErrorCode::unsupported, pass.name + " would dispatch " + std::to_string(out.groups[0]) + "×" +
                                                 std::to_string(out.groups[1]) +
                                                 " workgroups; 65535 a side are "
                                                 "guaranteed"};
    return {};
}

Result<VkDescriptorSet> ExecutorState::allocate_set(VkDescriptorSetLayout layout) {
    FrameSlot& frame = slot();
    for (;; ++frame.pool) {
        const bool is_new = frame.pool == frame.pools.size();
        if (is_new) {
            const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 12 * sets_per_pool},
                                                  {VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 6 * sets_per_pool},
                                                  {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 8 * sets_per_pool}};
            VkDescriptorPoolCreateInfo create{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
            create.maxSets = sets_per_pool;
            create.poolSizeCount = 3;
            create.pPoolSizes = sizes;
            VkDescriptorPool pool = VK_NULL_HANDLE;
            if (VkResult r = context->vk.vkCreateDescriptorPool(context->info.device, &create, nullptr, &pool);
                r != VK_SUCCESS)
                return vulkan_error("vkCreateDescriptorPool", r);
            frame.pools.push_back(pool);
        }
        VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO, nullptr,
                                             frame.pools[frame.pool], 1, &layout};
        VkDescriptorSet set = VK_NULL_HANDLE;
        const VkResult r = context->vk.vkAllocateDescriptorSets(context->info.device, &allocate, &set);
        if (r == VK_SUCCESS)
            return set;
        // A full pool is followed by a new one; a new one that is full already will never do.
        const bool is_full = r == VK_ERROR_OUT_OF_POOL_MEMORY || r == VK_ERROR_FRAGMENTED_POOL;
        if (!is_full || is_new)
            return vulkan_error("vkAllocateDescriptorSets", r);
    }
}

Result<void> ExecutorState::write_set(const Plan& plan, const Pass& pass, std::span<const Image> images,
                                      std::span<const Buffer> buffers, const ResolvedPlan& resolved,
                                      ResolvedPass& out) {
    auto set = allocate_set(out.pipeline->set_layout);
    if (!set)
        return set.error();
    out.set = *set;
    const size_t count = pass.accesses.size();
    std::vector<VkDescriptorImageInfo> image_infos(count);
    std::vector<VkDescriptorBufferInfo> buffer_infos(count);
    std::vector<VkWriteDescriptorSet> writes(count);
    for (size_t i = 0; i < count; ++i) {
        const Access& access = pass.accesses[i];
        VkDescriptorImageInfo& image = image_infos[i];
        const Resource* resource = access.resource == no_resource ? nullptr : &plan.resources[access.resource];
        // Some devices cannot filter 32-bit floats: there the nearest texel stands in.
        const bool filters = access.kind == AccessKind::filter && resource &&
                             (context->features(resource->format) & VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT);
        image.sampler = filters ? context->linear : context->nearest;
        image.imageLayout = VK_IMAGE_LAYOUT_GENERAL;
        if (access.kind == AccessKind::write && resource &&
            !(context->features(resource->format) & VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT))
            return Error{ErrorCode::unsupported, "image '" + resource->name + "' has VkFormat " +
                                                     std::to_string(resource->format) +
                                                     ", which shaders of this device cannot write"};
        if (!resource) {
            image.imageView = context->zeros[out.pipeline->integer_samplers >> i & 1]->view;
        } else if (resource->kind == ResourceKind::host) {
            image.imageView = images[resource->index].view;
            image.imageLayout = images[resource->index].layout;
        } else if (resource->kind == ResourceKind::host_buffer) {
            const Buffer& buffer = buffers[resource->index];
            buffer_infos[i] = {buffer.handle, buffer.offset, buffer.bytes};
        } else if (resource->kind == ResourceKind::buffer || resource->kind == ResourceKind::state) {
            buffer_infos[i] = {resolved.buffers[access.resource]->buffer, 0, VK_WHOLE_SIZE};
        } else {
            const DeviceImage& device_image = *resolved.images[access.resource];
            image.imageView = access.mip == all_mips ? device_image.view : device_image.mip_views[access.mip];
        }
        writes[i] = {VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                     nullptr,
                     out.set,
                     static_cast<uint32_t>(i),
                     0,
                     1,
                     descriptor_type(access.kind),
                     &image_infos[i],
                     &buffer_infos[i],
                     nullptr};
    }
    context->vk.vkUpdateDescriptorSets(context->info.device, static_cast<uint32_t>(count), writes.data(), 0, nullptr);
    return {};
}

Result<void> ExecutorState::add_chunk(FrameSlot& frame) {
    if (!frame.chunk_pool) {
        const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC, 64};
        VkDescriptorPoolCreateInfo create{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
        create.maxSets = 64;
        create.poolSizeCount = 1;
        create.pPoolSizes = &size;
        if (VkResult r = context->vk.vkCreateDescriptorPool(context->info.device, &create, nullptr, &frame.chunk_pool);
            r != VK_SUCCESS)
            return vulkan_error("vkCreateDescriptorPool", r);
    }
    ConstantsChunk chunk;
    // The last constants of a chunk may start at its end: the descriptor's range reaches past them.
    auto buffer = context->create_buffer(chunk_bytes + largest_constants, VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, true);
    if (!buffer)
        return buffer.error();
    chunk.buffer = std::move(*buffer);
    // The set comes last: it could not be given back if the buffer failed.
    VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO, nullptr, frame.chunk_pool, 1,
                                         &context->constants_layout};
    if (VkResult r = context->vk.vkAllocateDescriptorSets(context->info.device, &allocate, &chunk.set);
        r != VK_SUCCESS) {
        context->destroy(*chunk.buffer);
        return vulkan_error("vkAllocateDescriptorSets", r);
    }
    context->constant_bytes += chunk.buffer->bytes;
    const VkDescriptorBufferInfo info{chunk.buffer->buffer, 0, largest_constants};
    const VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,    nullptr, chunk.set, 0,      0, 1,
                                     VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC, nullptr, &info,     nullptr};
    context->vk.vkUpdateDescriptorSets(context->info.device, 1, &write, 0, nullptr);
    frame.chunks.push_back(std::move(chunk));
    return {};
}

Result<void> ExecutorState::write_constants(const Pass& pass, ResolvedPass& out) {
    if (pass.constants.empty())
        return {};
    if (pass.constants.size() > largest_constants)
        return Error{ErrorCode::internal, pass.name + " has " + std::to_string(pass.constants.size()) +
                                              " bytes of constants; at most 16384 are allowed"};
    FrameSlot& frame = slot();
    if (frame.chunk < frame.chunks.size() && frame.chunks[frame.chunk].used + pass.constants.size() > chunk_bytes)
        ++frame.chunk;
    if (frame.chunk == frame.chunks.size())
        if (auto added = add_chunk(frame); !added)
            return added.error();
    ConstantsChunk& chunk = frame.chunks[frame.chunk];
    std::memcpy(static_cast<std::byte*>(chunk.buffer->mapped) + chunk.used, pass.constants.data(),
                pass.constants.size());
    out.constants_set = chunk.set;
    out.constants_offset = static_cast<uint32_t>(chunk.used);
    const uint64_t alignment = context->uniform_alignment;
    chunk.used += (pass.constants.size() + alignment - 1) / alignment * alignment;
    return {};
}

} // namespace sfumato
