// What an effect does in one frame, as plain data: passes in order, what each reads and writes, and its constants.
// Sfumato's own Executor turns a plan into Vulkan commands; a host on another API can do so itself.
#pragma once

#include "sfumato/buffer.h"
#include "sfumato/image.h"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace sfumato {

// A compute shader: entry point "main", SPIR-V 1.3. `code` lives as long as the program.
struct Shader {
    const char* name; // "motion_blur/gather"
    std::span<const uint32_t> code;
};

enum class ResourceKind {
    host,        // the host's image number `index`, as passed to the executor
    transient,   // an image that lives from its first write to its last read in this plan
    previous,    // history `index` as the previous frame left it; zero after a reset
    current,     // history `index` as this frame writes it
    buffer,      // a transient storage buffer of `bytes`
    host_buffer, // the host's buffer number `index`, as passed to the executor
    // Storage buffer `index` of `bytes` that the executor keeps from frame to frame: read and written in place. Zero
    // after a reset or a change of size.
    state,
};

struct Resource {
    std::string name;
    ResourceKind kind = ResourceKind::transient;
    uint32_t index = 0;
    VkFormat format = VK_FORMAT_UNDEFINED;
    Extent extent; // of an image in texels; of a buffer its elements, where passes are dispatched over them
    uint32_t mips = 1;
    uint64_t bytes = 0;
};

using ResourceId = uint32_t;
inline constexpr ResourceId no_resource = ~0u;

enum class AccessKind {
    fetch,  // combined image sampler, nearest, clamp to edge
    filter, // combined image sampler, linear, between mips too, clamp to edge
    write,  // storage image, written only
    buffer_read,
    buffer_write, // also read and atomics
};

inline constexpr uint32_t all_mips = ~0u;

// One binding. `no_resource` with fetch or filter binds a 1×1 image of zeros: an input that the shader does not look
// at.
struct Access {
    ResourceId resource = no_resource;
    AccessKind kind = AccessKind::fetch;
    uint32_t mip = 0; // or all_mips for reads
    // This write touches other texels than the other disjoint writes of the resource: they need no barrier in between.
    bool disjoint = false;
};

enum class DispatchKind {
    texels,   // one invocation a texel (or element) of `target`
    groups,   // one workgroup for every `block` texels (or elements) of `target`
    indirect, // VkDispatchIndirectCommand at `offset` bytes into the buffer `target`
};

struct Dispatch {
    DispatchKind kind = DispatchKind::texels;
    ResourceId target = no_resource;
    uint32_t mip = 0;
    uint64_t offset = 0;
    Extent block{1, 1};
};

enum class Barrier { none, memory, memory_and_indirect };

// Bindings of set 0 are numbered by position in `accesses`; constants, where there are any, are the uniform buffer at
// set 1, binding 0. `specialization[i]` is the 32-bit constant with constant_id i.
struct Pass {
    std::string name;
    Shader shader;
    // The same result by subgroup arithmetic and ballots, for devices that have them; may be absent.
    Shader subgroup_shader = {};
    std::vector<uint32_t> specialization;
    std::vector<Access> accesses;
    std::vector<std::byte> constants;
    Dispatch dispatch;
    Barrier barrier = Barrier::none; // needed before this pass; filled in by Planner::finish
};

struct Plan {
    std::string effect;
    std::vector<Resource> resources;
    std::vector<Pass> passes;
};

// What a history is made of, kept by the executor from frame to frame.
struct History {
    ResourceId previous = no_resource;
    ResourceId current = no_resource;
};

// Builds a plan. Mistakes in its use are defects of the effect, found by the plan's tests, never caused by a host.
class Planner {
  public:
    explicit Planner(std::string effect);

    ResourceId host(std::string name, uint32_t index, const Image& image);
    ResourceId transient(std::string name, VkFormat format, Extent extent, uint32_t mips = 1);
    // `elements`: what passes are dispatched over, one row of them. 0 where none is.
    ResourceId buffer(std::string name, uint64_t bytes, uint32_t elements = 0);
    ResourceId host_buffer(std::string name, uint32_t index, const Buffer& buffer, uint32_t elements = 0);
    ResourceId state(std::string name, uint64_t bytes, uint32_t elements = 0);
    History history(std::string name, VkFormat format, Extent extent);

    // Starts a pass; the following calls on the returned reference fill it in.
    Pass& pass(std::string name, const Shader& shader);

    Extent extent(ResourceId resource) const { return plan_.resources[resource].extent; }

    // Fills in the barriers and hands out the plan.
    Plan finish() &&;

  private:
    Plan plan_;
    uint32_t histories_ = 0;
    uint32_t states_ = 0;
};

// Fills in Pass::barrier: a barrier stands only where a pass reads what an earlier pass wrote since the last barrier,
// writes what it read or wrote (unless both writes are disjoint), or dispatches from a buffer it wrote.
void place_barriers(Plan& plan);

// First defect of a plan, or "": reads before writes, reading and writing one mip in a pass, unknown resources,
// dispatches over nothing. Costs microseconds; the executor runs it on every plan.
std::string check_plan(const Plan& plan);

// Copies a constants struct into a pass.
template <class Constants>
std::vector<std::byte> constants_of(const Constants& constants) {
    static_assert(std::is_trivially_copyable_v<Constants> && sizeof(Constants) % 16 == 0);
    std::vector<std::byte> bytes(sizeof(Constants));
    std::memcpy(bytes.data(), &constants, sizeof(Constants));
    return bytes;
}

// "1920×1080"
std::string extent_text(Extent extent);

} // namespace sfumato
