// The tiles of 16×16 pixels that a disc touches, in rows: a count, and each by number. Both must find the same tiles in
// whatever shader they stand, therefore `precise`.

const float tile_side = 16.0;

uvec2 tile_counts() { return uvec2(ceil(constants.working_size / tile_side)); }

// First and last tile of one row; empty if the last is before the first. The nearest line of the row decides.
ivec2 tile_span(vec2 middle, float radius, int row) {
    precise const float nearest = clamp(middle.y, float(row) * tile_side, float(row + 1) * tile_side) - middle.y;
    precise const float half_width = sqrt(max(radius * radius - nearest * nearest, 0.0));
    precise const vec2 ends = floor((middle.x + vec2(-half_width, half_width)) * (1.0 / tile_side));
    // Compared as floats: discs near the eye leave the range of integers.
    const float last = float(tile_counts().x) - 1.0;
    return ivec2(max(ends.x, 0.0), min(ends.y, last));
}

ivec2 tile_rows(vec2 middle, float radius) {
    precise const vec2 ends = floor((middle.y + vec2(-radius, radius)) * (1.0 / tile_side));
    return ivec2(max(ends.x, 0.0), min(ends.y, float(tile_counts().y) - 1.0));
}

uint tiles_touched(vec2 middle, float radius) {
    const ivec2 rows = tile_rows(middle, radius);
    uint sum = 0u;
    for (int row = rows.x; row <= rows.y; ++row) {
        const ivec2 span = tile_span(middle, radius, row);
        sum += uint(max(span.y - span.x + 1, 0));
    }
    return sum;
}

// The tile of that number among those touched, row by row.
uint touched_tile(vec2 middle, float radius, uint number) {
    const ivec2 rows = tile_rows(middle, radius);
    for (int row = rows.x; row <= rows.y; ++row) {
        const ivec2 span = tile_span(middle, radius, row);
        const uint width = uint(max(span.y - span.x + 1, 0));
        if (number < width)
            return uint(row) * tile_counts().x + uint(span.x) + number;
        number -= width;
    }
    return tile_counts().x * uint(rows.x);
}
