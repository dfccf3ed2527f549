// Linear depth, the choice of depths at half resolution and all mips in one dispatch: a workgroup takes 32×32 texels of
// the finest level, and each of the five coarser levels picks from those.

layout(local_size_x = 16, local_size_y = 16) in;

layout(constant_id = 3) const bool device_depth = false;
layout(constant_id = 4) const uint half_choice = 0; // checkerboard, nearest, farthest
layout(constant_id = 5) const uint mip_mode = 1;    // none, rotated, farthest, centre

layout(set = 0, binding = 0) uniform sampler2D depth_image;
layout(set = 0, binding = 1) uniform writeonly image2D mip_0;
layout(set = 0, binding = 2) uniform writeonly image2D mip_1;
layout(set = 0, binding = 3) uniform writeonly image2D mip_2;
layout(set = 0, binding = 4) uniform writeonly image2D mip_3;
layout(set = 0, binding = 5) uniform writeonly image2D mip_4;
layout(set = 0, binding = 6) uniform writeonly image2D mip_5;

const int side = 32;
shared float tile[side][side + 1];

float read_depth(ivec2 pixel) {
    const float value = texelFetch(depth_image, clamp(pixel, ivec2(0), ivec2(constants.size) - 1), 0).x;
    return usable_depth(device_depth ? view_depth_of(value, constants.projection) : value);
}

float base_depth(ivec2 p) {
    if (!half_resolution)
        return read_depth(p);
    // One gather has all four; off the image it repeats the last row and column.
    const vec4 gathered = textureGather(depth_image, (2.0 * vec2(p) + 1.0) / constants.size, 0).wzxy;
    const bool nearest = half_choice == 1 || (half_choice == 0 && ((p.x ^ p.y) & 1) == 0);
    float chosen = 0.0;
    int choice = 0;
    [[unroll]] for (int i = 0; i < 4; ++i) {
        const float z = usable_depth(device_depth ? view_depth_of(gathered[i], constants.projection) : gathered[i]);
        // Odd sizes: the last texel has fewer than four pixels, which must not be taken for others.
        const bool exists = all(lessThan(2 * p + ivec2(i & 1, i >> 1), ivec2(constants.size)));
        if (i == 0 || (exists && (nearest ? z < chosen : z > chosen))) {
            chosen = z;
            choice = i;
        }
    }
    return with_choice(chosen, choice);
}

// An average that leans to the farthest: depths nearer by three quarters of the radius or more have no weight.
float farthest_mean(vec4 z) {
    const float top = max(max(z.x, z.y), max(z.z, z.w));
    const float solid = max(max(is_pyramid_sky(z.x) ? 0.0 : z.x, is_pyramid_sky(z.y) ? 0.0 : z.y),
                            max(is_pyramid_sky(z.z) ? 0.0 : z.z, is_pyramid_sky(z.w) ? 0.0 : z.w));
    if (solid == 0.0)
        return top;
    vec4 weights = max(vec4(0), 1.0 - (solid - z) / (0.75 * constants.radius));
    weights = mix(weights, vec4(0), greaterThanEqual(z, vec4(sky_depth)));
    return dot(mix(z, vec4(0), greaterThanEqual(z, vec4(sky_depth))), weights) / dot(weights, vec4(1));
}

// The texel of the finest level that texel q of level m is.
ivec2 picked_base(ivec2 q, int m) { return mip_mode == 1 ? rotated_base(q, m) : (q << m) + (1 << m >> 1); }

void write_mip(int m, ivec2 q, float z) {
    if (m == 1)
        imageStore(mip_1, q, vec4(z));
    else if (m == 2)
        imageStore(mip_2, q, vec4(z));
    else if (m == 3)
        imageStore(mip_3, q, vec4(z));
    else if (m == 4)
        imageStore(mip_4, q, vec4(z));
    else
        imageStore(mip_5, q, vec4(z));
}

void main() {
    const ivec2 origin = ivec2(gl_WorkGroupID.xy) * side;
    const ivec2 thread = ivec2(gl_LocalInvocationID.xy);
    for (int i = 0; i < 4; ++i) {
        const ivec2 local = thread + 16 * ivec2(i & 1, i >> 1);
        const float z = base_depth(origin + local);
        tile[local.y][local.x] = z;
        imageStore(mip_0, origin + local, vec4(z));
    }
    if (mip_mode == 0)
        return;
    barrier();
    if (mip_mode != 2) {
        // 256 + 64 + 16 + 4 + 1 texels: the first level has a thread for each, the others share the threads.
        const int index = int(gl_LocalInvocationIndex);
        ivec2 base = picked_base(origin / 2 + thread, 1) - origin;
        imageStore(mip_1, origin / 2 + thread, vec4(tile[base.y][base.x]));
        const int m = index < 64 ? 2 : index < 80 ? 3 : index < 84 ? 4 : 5;
        const int first = index < 64 ? 0 : index < 80 ? 64 : index < 84 ? 80 : 84;
        if (index < 85) {
            const int bits = 5 - m; // of a side's texel number
            const int n = index - first;
            const ivec2 q = (origin >> m) + ivec2(n & ((1 << bits) - 1), n >> bits);
            base = picked_base(q, m) - origin;
            write_mip(m, q, tile[base.y][base.x]);
        }
        return;
    }
    for (int m = 1; m <= last_mip; ++m) {
        const int count = side >> m;
        const bool active_thread = all(lessThan(thread, ivec2(count)));
        float z = 0.0;
        if (active_thread) {
            const ivec2 p = 2 * thread;
            z = farthest_mean(vec4(tile[p.y][p.x], tile[p.y][p.x + 1], tile[p.y + 1][p.x], tile[p.y + 1][p.x + 1]));
        }
        barrier();
        if (active_thread) {
            tile[thread.y][thread.x] = z;
            write_mip(m, (origin >> m) + thread, z);
        }
        barrier();
    }
}
