// What was drawn, for the host.

layout(local_size_x = 32) in;

layout(set = 0, binding = 0) readonly buffer Facts { uint data[]; } facts;
layout(set = 0, binding = 1) readonly buffer Pairs { uint data[]; } pairs;
layout(set = 0, binding = 2) writeonly buffer Statistics { uint data[]; } statistics;

void main() {
    if (gl_GlobalInvocationID.xy != uvec2(0))
        return;
    statistics.data[0] = facts.data[fact_alive];
    statistics.data[1] = facts.data[fact_drawn];
    statistics.data[2] = pairs.data[0];
    statistics.data[3] = pairs.data[1];
    statistics.data[4] = (pairs.data[1] > pairs.data[0] ? 1u : 0u) | (facts.data[fact_clamped] != 0u ? 2u : 0u);
    statistics.data[5] = 0u;
    statistics.data[6] = 0u;
    statistics.data[7] = 0u;
}
