// Writes the pairs of tile and particle. The threads of a workgroup share the pairs of its particles evenly, however
// large one of them is.

layout(local_size_x = 256) in;

layout(constant_id = 0) const bool backward = false; // far particles first: of too many pairs the first are left out
layout(constant_id = 1) const bool counts_dropped = false;

layout(set = 0, binding = 0) readonly buffer Records { uvec4 data[]; } records;
layout(set = 0, binding = 1) readonly buffer Touched { uint data[]; } touched;
layout(set = 0, binding = 2) readonly buffer Places { uint data[]; } places; // exclusive sums of the touched
layout(set = 0, binding = 3) writeonly buffer Tiles { uint data[]; } tiles;
layout(set = 0, binding = 4) writeonly buffer Ranks { uint data[]; } ranks;
layout(set = 0, binding = 5) writeonly buffer Pairs { uint data[]; } pairs; // count, wanted
layout(set = 0, binding = 6) buffer Dropped { uint data[]; } dropped;       // of each tile

shared uint ends[256];
shared vec3 discs[256]; // middle, radius

void main() {
    const uint rank = gl_GlobalInvocationID.x, thread = gl_LocalInvocationIndex;
    const uint last = constants.capacity - 1u;
    const uint wanted = places.data[last] + touched.data[last];
    if (rank == 0u) {
        pairs.data[0] = min(wanted, constants.room);
        pairs.data[1] = wanted;
    }
    const uint base = places.data[min(gl_WorkGroupID.x * 256u, last)];
    uint end = wanted;
    if (rank < constants.capacity) {
        end = places.data[rank] + touched.data[rank];
        if (touched.data[rank] != 0u) {
            discs[thread] = uintBitsToFloat(records.data[2u * rank].xyz);
        }
    }
    ends[thread] = end - base;
    barrier();
    const uint left_out = backward && wanted > constants.room ? wanted - constants.room : 0u;
    const uint here = ends[255];
    for (uint pair = thread; pair < here; pair += 256u) {
        uint low = 0u, high = 255u; // the first particle whose pairs end after this one
        while (low < high) {
            const uint middle = (low + high) / 2u;
            if (ends[middle] > pair)
                high = middle;
            else
                low = middle + 1u;
        }
        const uint first = low == 0u ? 0u : ends[low - 1u];
        const uint place = base + pair - left_out; // wraps to beyond the room for those left out
        if (place >= constants.room && !counts_dropped)
            continue;
        const uint tile = touched_tile(discs[low].xy, discs[low].z, pair - first);
        if (place >= constants.room) {
            atomicAdd(dropped.data[tile], 1u);
            continue;
        }
        tiles.data[place] = tile;
        ranks.data[place] = gl_WorkGroupID.x * 256u + low;
    }
}
