// Sums the layers of each texel from the light on; each layer then holds itself and all before it.

layout(local_size_x = 256) in;

layout(constant_id = 0) const uint light_count = 1u;

layout(set = 0, binding = 0) buffer Volume { uint data[]; } volume;

void main() {
    const uint texel = gl_GlobalInvocationID.x;
    const uint area = constants.side * constants.side;
    if (texel >= area * light_count)
        return;
    const uint start = texel / area * constants.layers * area + texel % area;
    uint sum = 0u;
    for (uint layer = 0u; layer < constants.layers; ++layer) {
        const uint at = start + layer * area;
        sum += volume.data[at];
        volume.data[at] = sum;
    }
}
