// Building and checking plans: pure data, no Vulkan call.
#include "sfumato/plan.h"

#include <algorithm>
#include <utility>

namespace sfumato {

namespace {

bool is_write(AccessKind kind) {
    return kind == AccessKind::write || kind == AccessKind::buffer_write;
}
bool is_buffer(AccessKind kind) {
    return kind == AccessKind::buffer_read || kind == AccessKind::buffer_write;
}
bool is_buffer(ResourceKind kind) {
    return kind == ResourceKind::buffer || kind == ResourceKind::host_buffer || kind == ResourceKind::state;
}

// A storage buffer that is written may be read by the same pass: atomics and append lists do.
bool overlap(const Access& a, const Access& b) {
    return a.resource == b.resource && (a.mip == b.mip || a.mip == all_mips || b.mip == all_mips);
}

} // namespace

Planner::Planner(std::string effect) {
    plan_.effect = std::move(effect);
}

ResourceId Planner::host(std::string name, uint32_t index, const Image& image) {
    if (!image)
        return no_resource;
    plan_.resources.push_back({std::move(name), ResourceKind::host, index, image.format, image.extent, 1, 0});
    return static_cast<ResourceId>(plan_.resources.size() - 1);
}

ResourceId Planner::transient(std::string name, VkFormat format, Extent extent, uint32_t mips) {
    plan_.resources.push_back({std::move(name), ResourceKind::transient, 0, format, extent, mips, 0});
    return static_cast<ResourceId>(plan_.resources.size() - 1);
}

namespace {
Extent row_of(uint32_t elements) {
    return elements == 0 ? Extent{} : Extent{elements, 1};
}
} // namespace

ResourceId Planner::buffer(std::string name, uint64_t bytes, uint32_t elements) {
    plan_.resources.push_back(
        {std::move(name), ResourceKind::buffer, 0, VK_FORMAT_UNDEFINED, row_of(elements), 1, bytes});
    return static_cast<ResourceId>(plan_.resources.size() - 1);
}

ResourceId Planner::host_buffer(std::string name, uint32_t index, const Buffer& buffer, uint32_t elements) {
    if (!buffer)
        return no_resource;
    plan_.resources.push_back(
        {std::move(name), ResourceKind::host_buffer, index, VK_FORMAT_UNDEFINED, row_of(elements), 1, buffer.bytes});
    return static_cast<ResourceId>(plan_.resources.size() - 1);
}

ResourceId Planner::state(std::string name, uint64_t bytes, uint32_t elements) {
    plan_.resources.push_back(
        {std::move(name), ResourceKind::state, states_++, VK_FORMAT_UNDEFINED, row_of(elements), 1, bytes});
    return static_cast<ResourceId>(plan_.resources.size() - 1);
}

History Planner::history(std::string name, VkFormat format, Extent extent) {
    const uint32_t index = histories_++;
    const auto first = static_cast<ResourceId>(plan_.resources.size());
    plan_.resources.push_back({name + " (previous)", ResourceKind::previous, index, format, extent, 1, 0});
    plan_.resources.push_back({name, ResourceKind::current, index, format, extent, 1, 0});
    return {first, first + 1};
}

Pass& Planner::pass(std::string name, const Shader& shader) {
    Pass& pass = plan_.passes.emplace_back();
    pass.name = std::move(name);
    pass.shader = shader;
    return pass;
}

Plan Planner::finish() && {
    place_barriers(plan_);
    return std::move(plan_);
}

namespace {

// The pass from 0 to `end` that last wrote the buffer, or `end` if none did.
size_t last_writer(const Plan& plan, ResourceId buffer, size_t end) {
    for (size_t i = end; i-- > 0;)
        for (const Access& access : plan.passes[i].accesses)
            if (access.resource == buffer && is_write(access.kind))
                return i;
    return end;
}

// A barrier that stands between the writing of commands and their dispatch is widened to cover reading them; where
// there is none, the dispatching pass gets one.
void guard_commands(Plan& plan, size_t dispatching) {
    const size_t writer = last_writer(plan, plan.passes[dispatching].dispatch.target, dispatching);
    if (writer == dispatching)
        return;
    for (size_t i = dispatching; i > writer; --i)
        if (plan.passes[i].barrier != Barrier::none) {
            plan.passes[i].barrier = Barrier::memory_and_indirect;
            return;
        }
    plan.passes[dispatching].barrier = Barrier::memory_and_indirect;
}

} // namespace

void place_barriers(Plan& plan) {
    std::vector<Access> pending; // since the last barrier
    for (Pass& pass : plan.passes)
        pass.barrier = Barrier::none;
    for (size_t i = 0; i < plan.passes.size(); ++i) {
        Pass& pass = plan.passes[i];
        for (const Access& access : pass.accesses) {
            if (access.resource == no_resource)
                continue;
            for (const Access& earlier : pending) {
                const bool hazard = overlap(access, earlier) && (is_write(access.kind) || is_write(earlier.kind)) &&
                                    !(access.disjoint && earlier.disjoint);
                if (hazard)
                    pass.barrier = Barrier::memory;
            }
        }
        if (pass.dispatch.kind == DispatchKind::indirect)
            guard_commands(plan, i);
        if (pass.barrier != Barrier::none)
            pending.clear();
        for (const Access& access : pass.accesses)
            if (access.resource != no_resource)
                pending.push_back(access);
        // The indirect command is read like a buffer: a later write of it must wait.
        if (pass.dispatch.kind == DispatchKind::indirect)
            pending.push_back({pass.dispatch.target, AccessKind::buffer_read, 0, false});
    }
}

namespace {

// Of every resource, the mips that the passes so far have written, as bits.
using Written = std::vector<uint64_t>;

std::string check_access(const Plan& plan, const Access& access, const Written& written) {
    if (access.resource == no_resource)
        return is_write(access.kind) || is_buffer(access.kind) ? "binds nothing for writing" : "";
    if (access.resource >= plan.resources.size())
        return "names a resource that does not exist";
    const Resource& resource = plan.resources[access.resource];
    if (is_buffer(resource.kind) != is_buffer(access.kind))
        return "takes " + resource.name + " for the wrong kind of resource";
    if (access.mip != all_mips && access.mip >= resource.mips)
        return "uses a mip of " + resource.name + " that does not exist";
    if (is_write(access.kind)) {
        if (resource.kind == ResourceKind::previous)
            return "writes the history " + resource.name;
        if (access.mip == all_mips)
            return "writes all mips of " + resource.name + " at once";
    } else if (resource.kind == ResourceKind::transient || resource.kind == ResourceKind::current ||
               resource.kind == ResourceKind::buffer) {
        const uint64_t needed = access.mip == all_mips ? (uint64_t{1} << resource.mips) - 1 : uint64_t{1} << access.mip;
        if ((written[access.resource] & needed) != needed)
            return "reads " + resource.name + " before anything wrote it";
    }
    return "";
}

std::string check_dispatch(const Plan& plan, const Pass& pass, const Written& written) {
    const Dispatch& dispatch = pass.dispatch;
    if (dispatch.target >= plan.resources.size())
        return "dispatches over no resource";
    const Resource& target = plan.resources[dispatch.target];
    if (!dispatch.block)
        return "dispatches over blocks of no texels";
    if (dispatch.kind != DispatchKind::indirect)
        return target.extent && dispatch.mip < target.mips
                   ? ""
                   : "dispatches over " + target.name + ", which has no texels there";
    // A host's buffer may lack the usage, and a state of the frame before holds no command that this plan knows.
    if (target.kind != ResourceKind::buffer || dispatch.offset % 4 != 0 || dispatch.offset + 12 > target.bytes)
        return "dispatches from " + target.name + ", which holds no command there";
    if (written[dispatch.target] == 0)
        return "dispatches from " + target.name + " before anything wrote it";
    for (const Access& access : pass.accesses)
        if (access.resource == dispatch.target && is_write(access.kind))
            return "writes " + target.name + " while it is dispatched from it";
    return "";
}

// Hazards are tracked by resource: two of them for one image or buffer would hide one.
std::string check_host_resources(const Plan& plan) {
    for (size_t i = 0; i < plan.resources.size(); ++i)
        for (size_t j = 0; j < i; ++j) {
            const Resource &a = plan.resources[j], &b = plan.resources[i];
            const bool is_buffer = a.kind == ResourceKind::host_buffer || a.kind == ResourceKind::state;
            if (a.kind == b.kind && a.index == b.index && (is_buffer || a.kind == ResourceKind::host))
                return plan.effect + " takes " +
                       (a.kind == ResourceKind::state ? "state "
                        : is_buffer                   ? "host buffer "
                                                      : "host image ") +
                       std::to_string(a.index) + " twice, as " + a.name + " and " + b.name;
        }
    return "";
}

} // namespace

std::string check_plan(const Plan& plan) {
    if (const std::string defect = check_host_resources(plan); !defect.empty())
        return defect;
    for (const Resource& resource : plan.resources) {
        if (resource.mips < 1 || resource.mips > 32)
            return plan.effect + ": " + resource.name + " has " + std::to_string(resource.mips) + " mips";
        if (is_buffer(resource.kind) && (resource.bytes == 0 || resource.bytes % 4 != 0))
            return plan.effect + ": " + resource.name + " has " + std::to_string(resource.bytes) +
                   " bytes; a buffer holds whole words";
    }
    Written written(plan.resources.size(), 0);
    for (const Pass& pass : plan.passes) {
        const std::string where = plan.effect + "/" + pass.name + " ";
        for (const Access& access : pass.accesses)
            if (const std::string defect = check_access(plan, access, written); !defect.empty())
                return where + defect;
        for (size_t i = 0; i < pass.accesses.size(); ++i)
            for (size_t j = 0; j < i; ++j) {
                const Access& a = pass.accesses[i];
                const Access& b = pass.accesses[j];
                if (a.resource != no_resource && overlap(a, b) && (is_write(a.kind) || is_write(b.kind)))
                    return where + "binds " + plan.resources[a.resource].name + " twice, once for writing";
            }
        if (const std::string defect = check_dispatch(plan, pass, written); !defect.empty())
            return where + defect;
        for (const Access& access : pass.accesses)
            if (is_write(access.kind))
                written[access.resource] |= uint64_t{1} << access.mip;
    }
    return "";
}

std::string extent_text(Extent extent) {
    return std::to_string(extent.width) + "×" + std::to_string(extent.height);
}

} // namespace sfumato
