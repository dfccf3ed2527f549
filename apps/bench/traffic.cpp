// Counts what the passes of a plan move.
#include "apps/bench/traffic.h"

#include <algorithm>
#include <set>
#include <utility>

namespace sfumato::bench {
namespace {

uint64_t mip_bytes(const Resource& resource, uint32_t mip) {
    const uint64_t width = std::max(resource.extent.width >> mip, 1u);
    const uint64_t height = std::max(resource.extent.height >> mip, 1u);
    return width * height * texel_bytes(resource.format);
}

uint64_t access_bytes(const Resource& resource, const Access& access) {
    if (resource.bytes != 0)
        return resource.bytes;
    if (access.mip != all_mips)
        return mip_bytes(resource, access.mip);
    uint64_t bytes = 0;
    for (uint32_t mip = 0; mip < resource.mips; ++mip)
        bytes += mip_bytes(resource, mip);
    return bytes;
}

uint64_t pass_bytes(const Plan& plan, const Pass& pass) {
    uint64_t bytes = 0;
    std::set<std::pair<ResourceId, uint32_t>> seen;
    for (const Access& access : pass.accesses)
        if (access.resource != no_resource && seen.insert({access.resource, access.mip}).second)
            bytes += access_bytes(plan.resources[access.resource], access);
    return bytes;
}

// The image that an indirect pass fills in together with its neighbours.
ResourceId shared_target(const Pass& pass) {
    if (pass.dispatch.kind == DispatchKind::indirect)
        for (const Access& access : pass.accesses)
            if (access.kind == AccessKind::write && access.disjoint)
                return access.resource;
    return no_resource;
}

} // namespace

uint64_t texel_bytes(VkFormat format) {
    switch (format) {
    case VK_FORMAT_R8_UNORM:
    case VK_FORMAT_R8_UINT:
        return 1;
    case VK_FORMAT_R8G8_UNORM:
    case VK_FORMAT_R8G8_SNORM:
    case VK_FORMAT_R16_UNORM:
    case VK_FORMAT_R16_SFLOAT:
    case VK_FORMAT_R16_UINT:
    case VK_FORMAT_D16_UNORM:
        return 2;
    case VK_FORMAT_R16G16B16A16_UNORM:
    case VK_FORMAT_R16G16B16A16_SNORM:
    case VK_FORMAT_R16G16B16A16_SFLOAT:
    case VK_FORMAT_R16G16B16A16_UINT:
    case VK_FORMAT_R32G32_SFLOAT:
    case VK_FORMAT_R32G32_UINT:
        return 8;
    case VK_FORMAT_R32G32B32A32_SFLOAT:
    case VK_FORMAT_R32G32B32A32_UINT:
        return 16;
    case VK_FORMAT_UNDEFINED:
        return 0;
    default: // the rest that effects use is packed into 32 bits
        return 4;
    }
}

PlanTraffic traffic_of(const Plan& plan) {
    PlanTraffic traffic;
    ResourceId last_target = no_resource;
    int groups = 0;
    for (const Pass& pass : plan.passes) {
        PassTraffic entry{pass.name, pass_bytes(plan, pass), pass.dispatch.kind == DispatchKind::indirect, -1};
        const ResourceId target = shared_target(pass);
        if (target == no_resource) {
            traffic.bytes += entry.bytes;
        } else {
            const bool continues = target == last_target;
            groups += continues ? 0 : 1;
            traffic.bytes += continues ? 0 : entry.bytes;
            entry.group = groups - 1;
        }
        last_target = target;
        traffic.passes.push_back(std::move(entry));
    }
    std::set<ResourceId> hosts;
    for (const Pass& pass : plan.passes)
        for (const Access& access : pass.accesses)
            if (access.resource != no_resource && plan.resources[access.resource].kind == ResourceKind::host)
                hosts.insert(access.resource);
    std::set<uint32_t> images;
    for (const ResourceId id : hosts)
        if (images.insert(plan.resources[id].index).second)
            traffic.minimum += mip_bytes(plan.resources[id], 0);
    return traffic;
}

} // namespace sfumato::bench
