// Neighbour maximum: of every tile, the longest vector of the tiles around whose blur can reach it; the tile's class;
// and the lists of tiles by class, from which the gather is dispatched.

layout(local_size_x = 8, local_size_y = 8) in;

layout(constant_id = 0) const int tile_size = 32;
layout(constant_id = 1) const int rings = 1;
layout(constant_id = 2) const uint dilation = 1; // box, selective, line
layout(constant_id = 3) const bool test_edge_neighbours = false;
layout(constant_id = 4) const bool classify = true;
layout(constant_id = 5) const uint blocks_per_tile = 16; // workgroups of the gather

layout(set = 0, binding = 0) uniform sampler2D tile_image;
layout(set = 0, binding = 1) uniform sampler2D spread_image;
layout(set = 0, binding = 2) uniform writeonly image2D neighbour_image; // longest (xy), widest beside it (zw)
layout(set = 0, binding = 3) uniform writeonly image2D class_image;
// Three VkDispatchIndirectCommands (still, uniform, full), three words of padding, then a list of tiles for each.
layout(set = 0, binding = 4) buffer TileLists { uint words[]; } lists;

// A tile swept along the segment from -reach to +reach meets the tile in the middle exactly if that segment meets a
// square of twice the tile's size around the middle. The square is widened by what the tile's other vectors reach to the
// side of the longest, so that none of its pixels is missed. `selective` takes the segment's whole line, `line`
// its true length. Symmetric in the sign of the vector, since the blur reaches both ways.
bool reaches(vec4 tile, ivec2 offset) {
    if (dilation == 0 || offset == ivec2(0))
        return true;
    const bool diagonal = offset.x != 0 && offset.y != 0;
    if (dilation == 1 && !diagonal && !test_edge_neighbours)
        return true;
    const vec2 v = tile.xy;
    const float l = length(v);
    const float half_size = float(tile_size) + (l > 0.0 ? abs(cross_product(tile.zw, v)) / l : 0.0);
    const float limit = dilation == 2 ? 1.0 + abs(constants.centre) : 1e30;
    float low = -limit, high = limit;
    const vec2 middle = vec2(-offset * tile_size);
    for (int axis = 0; axis < 2; ++axis) {
        if (v[axis] == 0.0) {
            if (abs(middle[axis]) >= half_size)
                return false;
            continue;
        }
        const float a = (middle[axis] - half_size) / v[axis];
        const float b = (middle[axis] + half_size) / v[axis];
        low = max(low, min(a, b));
        high = min(high, max(a, b));
    }
    return low < high;
}

void main() {
    const ivec2 tile = ivec2(gl_GlobalInvocationID.xy);
    const ivec2 tiles = textureSize(tile_image, 0);
    if (any(greaterThanEqual(tile, tiles)))
        return;
    const ivec2 first = max(tile - rings, ivec2(0));
    const ivec2 last = min(tile + rings, tiles - 1);
    vec2 longest = vec2(0);
    for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; ++x) {
            const vec4 t = texelFetch(tile_image, ivec2(x, y), 0);
            if (longer(t.xy, longest) && reaches(t, ivec2(x, y) - tile))
                longest = t.xy;
        }
    float spread = 0.0;
    vec2 widest = vec2(0);
    for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; ++x) {
            const vec4 t = texelFetch(tile_image, ivec2(x, y), 0);
            spread = max(spread, length(t.xy - longest) + texelFetch(spread_image, ivec2(x, y), 0).x);
            const bool is_wider = wider(t.xy, widest, longest) || wider(t.zw, widest, longest);
            if (is_wider && reaches(t, ivec2(x, y) - tile))
                widest = wider(t.zw, t.xy, longest) ? t.zw : t.xy;
        }
    const float l = length(longest);
    uint class_index = 2u;
    if (l < still_length)
        class_index = 0u;
    else if (classify && spread <= max(constants.uniform_tolerance * l, constants.uniform_pixels))
        class_index = 1u;
    imageStore(neighbour_image, tile, vec4(longest, widest));
    imageStore(class_image, tile, vec4(float(class_index)));

    const uint slot = atomicAdd(lists.words[class_index * 3u + 1u], 1u);
    if (slot == 0u) {
        lists.words[class_index * 3u] = blocks_per_tile;
        lists.words[class_index * 3u + 2u] = 1u;
    }
    const uint tile_count = uint(tiles.x * tiles.y);
    lists.words[12u + class_index * tile_count + slot] = uint(tile.y * tiles.x + tile.x);
}
