// Sums the layers of each texel from the light on; each layer then holds itself and all before it.

layout(local_size_x = 256) in;

layout(constant_id = 0) const uint light_count = 1u;
layout(constant_id = 1) const uint layers = 16u;
layout(constant_id = 2) const uint side = 256u;

layout(set = 0, binding = 0) buffer Volume { uint data[]; } volume;

void main() {
    const uint texel = gl_GlobalInvocationID.x;
    const uint area = side * side;
    if (texel >= area * light_count)
        return;
    const uint start = texel / area * layers * area + texel % area;
    uint sum = 0u;
    for (uint layer = 0u; layer < layers; ++layer) {
        const uint at = start + layer * area;
        sum += volume.data[at];
        volume.data[at] = sum;
    }
}
