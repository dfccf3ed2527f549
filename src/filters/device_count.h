// How many elements a building block works on, known on the device alone.
#pragma once

#include "sfumato/plan.h"

#include <algorithm>

namespace sfumato {

// The uint32 at `offset` bytes (a multiple of 4) of `buffer`, at most `capacity`; `capacity` itself where there is no
// buffer. Capacity is at least 1 and bounds every dispatch and every scratch buffer.
struct DeviceCount {
    ResourceId buffer = no_resource;
    uint64_t offset = 0;
    uint32_t capacity = 1;
};

inline Access read_buffer(ResourceId buffer) {
    return {buffer, AccessKind::buffer_read, 0, false};
}
inline Access write_buffer(ResourceId buffer) {
    return {buffer, AccessKind::buffer_write, 0, false};
}

// Binds the count; where there is none, `other` (read by the pass already) stands in its binding.
inline Access count_access(const DeviceCount& count, ResourceId other) {
    return read_buffer(count.buffer == no_resource ? other : count.buffer);
}

// Where the shader finds the count: the number of a 32-bit word, or all ones for "it is the capacity".
inline uint32_t count_word(const DeviceCount& count) {
    return count.buffer == no_resource ? ~0u : static_cast<uint32_t>(count.offset / 4);
}

inline uint32_t blocks_of(uint32_t elements, uint32_t block) {
    return std::max(1u, elements / block + (elements % block != 0 ? 1u : 0u));
}

// A dispatch of so many workgroups. Plans take the size of a dispatch from a resource: this one is touched by no pass,
// so no memory is ever made for it.
inline Dispatch dispatch_groups(Planner& planner, uint32_t groups) {
    const ResourceId shape = planner.transient("workgroups", VK_FORMAT_R8G8B8A8_UNORM, {groups, 1});
    return {DispatchKind::groups, shape, 0, 0};
}

} // namespace sfumato
