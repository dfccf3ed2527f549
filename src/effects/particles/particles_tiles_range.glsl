// Where each tile's pairs begin and end among the sorted ones. Tiles without any keep the zeros they were cleared to.

layout(local_size_x = 256) in;


layout(set = 0, binding = 0) readonly buffer Tiles { uint data[]; } tiles;
layout(set = 0, binding = 1) readonly buffer Pairs { uint data[]; } pairs;
layout(set = 0, binding = 2) buffer Ranges { uvec2 data[]; } ranges;

const uint per_thread = 4u;

void main() {
    const uint live = min(pairs.data[0], constants.room);
    [[unroll]] for (uint i = 0u; i < per_thread; ++i) {
        const uint pair = (gl_WorkGroupID.x * per_thread + i) * 256u + gl_LocalInvocationIndex;
        if (pair >= live)
            return;
        const uint tile = tiles.data[pair];
        if (pair == 0u || tiles.data[pair - 1u] != tile)
            ranges.data[tile].x = pair;
        if (pair + 1u == live || tiles.data[pair + 1u] != tile)
            ranges.data[tile].y = pair + 1u;
    }
}
