// Building and checking plans: pure data, no Vulkan call.
#include "sfumato/plan.h"

#include <algorithm>
#include <utility>

namespace sfumato {

namespace {

bool is_write(AccessKind kind) { return kind == AccessKind::write || kind == AccessKind::buffer_write; }
bool is_buffer(AccessKind kind) { return kind == AccessKind::buffer_read || kind == AccessKind::buffer_write; }

// A storage buffer that is written may be read by the same pass: atomics and append lists do.
bool overlap(const Access& a, const Access& b) {
    return a.resource == b.resource && (a.mip == b.mip || a.mip == all_mips || b.mip == all_mips);
}

} // namespace

Planner::Planner(std::string effect) { plan_.effect = std::move(effect); }

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

ResourceId Planner::buffer(std::string name, uint64_t bytes) {
    plan_.resources.push_back({std::move(name), ResourceKind::buffer, 0, VK_FORMAT_UNDEFINED, {}, 1, bytes});
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

void place_barriers(Plan& plan) {
    std::vector<Access> pending; // since the last barrier
    for (Pass& pass : plan.passes) {
        pass.barrier = Barrier::none;
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
        if (pass.dispatch.kind == DispatchKind::indirect) {
            const bool written = std::any_of(pending.begin(), pending.end(), [&](const Access& earlier) {
                return earlier.resource == pass.dispatch.target && is_write(earlier.kind);
            });
            if (written)
                pass.barrier = Barrier::memory_and_indirect;
        }
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

std::string check_access(const Plan& plan, const Access& access, std::vector<bool>& written) {
    if (access.resource == no_resource)
        return is_write(access.kind) || is_buffer(access.kind) ? "binds nothing for writing" : "";
    if (access.resource >= plan.resources.size())
        return "names a resource that does not exist";
    const Resource& resource = plan.resources[access.resource];
    if ((resource.kind == ResourceKind::buffer) != is_buffer(access.kind))
        return "takes " + resource.name + " for the wrong kind of resource";
    if (access.mip != all_mips && access.mip >= resource.mips)
        return "uses a mip of " + resource.name + " that does not exist";
    if (is_write(access.kind)) {
        if (resource.kind == ResourceKind::previous)
            return "writes the history " + resource.name;
        if (access.mip == all_mips)
            return "writes all mips of " + resource.name + " at once";
        written[access.resource] = true;
    } else if (resource.kind == ResourceKind::transient || resource.kind == ResourceKind::current ||
               resource.kind == ResourceKind::buffer) {
        if (!written[access.resource])
            return "reads " + resource.name + " before anything wrote it";
    }
    return "";
}

std::string check_dispatch(const Plan& plan, const Pass& pass) {
    const Dispatch& dispatch = pass.dispatch;
    if (dispatch.target >= plan.resources.size())
        return "dispatches over no resource";
    const Resource& target = plan.resources[dispatch.target];
    if (dispatch.kind == DispatchKind::indirect)
        return target.kind == ResourceKind::buffer && dispatch.offset % 4 == 0 && dispatch.offset + 12 <= target.bytes
                   ? ""
                   : "dispatches from " + target.name + ", which holds no command there";
    return target.extent ? "" : "dispatches over " + target.name + ", which has no texels";
}

} // namespace

std::string check_plan(const Plan& plan) {
    std::vector<bool> written(plan.resources.size(), false);
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
        if (const std::string defect = check_dispatch(plan, pass); !defect.empty())
            return where + defect;
    }
    return "";
}

std::string extent_text(Extent extent) {
    return std::to_string(extent.width) + "×" + std::to_string(extent.height);
}

} // namespace sfumato
