// The host's picture, darkened by the shadow of the particles where it lies behind them for the light, seen through
// them. At reduced resolution each pixel takes its four neighbours by how well their depths fit its own, and of each
// what lies before the pixel's own depth.

layout(local_size_x = 16, local_size_y = 8) in;

layout(constant_id = 0) const bool device_depth = false;
layout(constant_id = 1) const uint factor = 1u;
layout(constant_id = 2) const bool by_rank = false;
layout(constant_id = 3) const bool casts_shadow = true;
layout(constant_id = 4) const bool has_direct = false;
layout(constant_id = 5) const bool has_velocity = false;
layout(constant_id = 6) const bool has_transmittance = false;
layout(constant_id = 7) const uint view = 0u;
layout(constant_id = 8) const bool perspective = true;
layout(constant_id = 9) const bool scattering = false;

layout(set = 0, binding = 0) uniform sampler2D colour_image;
layout(set = 0, binding = 1) uniform sampler2D depth_image;
layout(set = 0, binding = 2) uniform sampler2D direct_image;
layout(set = 0, binding = 3) uniform sampler2D scene_velocity_image;
layout(set = 0, binding = 4) uniform sampler2D block_depths;
layout(set = 0, binding = 5) uniform sampler2D far_image;
layout(set = 0, binding = 6) uniform sampler2D near_image;
layout(set = 0, binding = 7) uniform sampler2D velocity_image;
layout(set = 0, binding = 8) readonly buffer Facts { uint data[]; } facts;
layout(set = 0, binding = 9) readonly buffer Volume { uvec4 data[]; } volume;
layout(set = 0, binding = 10) readonly buffer Ranges { uvec2 data[]; } ranges;
layout(set = 0, binding = 11) readonly buffer Dropped { uint data[]; } dropped;
layout(set = 0, binding = 12) uniform writeonly image2D output_image;
layout(set = 0, binding = 13) uniform writeonly image2D velocity_output;
layout(set = 0, binding = 14) uniform writeonly image2D transmittance_output;

#include "particles_light_volume.glsl"
#include "particles_light_lookup.glsl"

ivec2 scaled(sampler2D image, ivec2 pixel) {
    return ivec2((vec2(pixel) + 0.5) * vec2(textureSize(image, 0)) / constants.size);
}

float scene_depth(ivec2 pixel) {
    const float value = texelFetch(depth_image, scaled(depth_image, pixel), 0).x;
    const float z = device_depth ? view_depth_of(value, constants.projection) : value;
    return is_sky(z) || !(z > 0.0) ? sky_depth : z;
}

struct Seen {
    vec4 particles; // colour, transmittance
    vec2 velocity;
};

// Of one working pixel, what lies before depth z, and how well its depths fit.
vec4 part_before(ivec2 texel, float z, out float fit) {
    const vec2 depths = texelFetch(block_depths, texel, 0).xy;
    fit = 1.0 / (1e-3 + abs(z - clamp(z, depths.x, depths.y)) / (z * constants.depth_tolerance));
    // In inverse depth; what is well behind the nearest surface sees all that is behind it, though the farthest be sky.
    const float part = depths.y > depths.x
                           ? clamp(2.0 * (1.0 / depths.x - 1.0 / z) / (1.0 / depths.x - 1.0 / depths.y), 0.0, 1.0)
                           : 1.0;
    return mix(texelFetch(near_image, texel, 0), texelFetch(far_image, texel, 0), part);
}

Seen particles_before(ivec2 pixel, float z) {
    Seen seen;
    if (factor == 1u) {
        seen.particles = texelFetch(far_image, pixel, 0);
        seen.velocity = has_velocity ? texelFetch(velocity_image, pixel, 0).xy : vec2(0);
        return seen;
    }
    const vec2 at = (vec2(pixel) + 0.5) / float(factor) - 0.5;
    const ivec2 first = ivec2(floor(at)), last = ivec2(constants.working_size) - 1;
    const vec2 part = at - vec2(first);
    seen = Seen(vec4(0), vec2(0));
    float total = 0.0;
    [[unroll]] for (int i = 0; i < 4; ++i) {
        const ivec2 corner = ivec2(i & 1, i >> 1);
        const ivec2 texel = clamp(first + corner, ivec2(0), last);
        const vec2 sides = mix(1.0 - part, part, vec2(corner));
        float fit;
        const vec4 particles = part_before(texel, z, fit);
        const float weight = sides.x * sides.y * fit;
        seen.particles += weight * particles;
        if (has_velocity)
            seen.velocity += weight * texelFetch(velocity_image, texel, 0).xy;
        total += weight;
    }
    seen.particles /= total;
    seen.velocity /= total;
    return seen;
}

vec3 world_position(ivec2 pixel, float z) {
    const vec2 xy = (vec2(pixel) + 0.5) * constants.pixel_to_view.xy + constants.pixel_to_view.zw;
    return (constants.world_from_view * vec4(perspective ? xy * z : xy, -z, 1)).xyz;
}

// Share of the first light that comes through the particles to a place of the scene.
vec3 light_left(vec3 position) {
    const LightSpace space = space_of(0u);
    const vec3 place = light_space(constants.light_0, position);
    const vec2 texel = (place.xy - space.corner) / space.texel;
    if (by_rank) // slices are no layers along the light: as in the document, what is not before them all is behind them all
        return place.z > space.first ? exp(-constants.shadow_colour.rgb * depth_before_layer(0u, texel, constants.layers))
                                     : vec3(1);
    // Half a row up and half a row down take as much of even as of odd rows, whose layers differ: no stripes on surfaces.
    const vec2 half_row = vec2(0, 0.5);
    const float depth = 0.5 * (depth_at(0u, space, texel - half_row, place.z) + depth_at(0u, space, texel + half_row, place.z));
    return exp(-constants.shadow_colour.rgb * depth);
}

vec3 heat(float x) { return clamp(vec3(3.0 * x - 1.0, 2.0 - abs(4.0 * x - 2.0), 1.5 - 3.0 * x), 0.0, 1.0); }

// The inside of the effect; the first light's buffer is laid over the whole picture.
vec3 debug_colour(ivec2 pixel, vec4 particles) {
    const vec2 part = (vec2(pixel) + 0.5) / constants.size;
    const ivec2 tile = ivec2(vec2(pixel) * constants.scale / 16.0);
    const uint tile_number = uint(tile.y) * uint(ceil(constants.working_size.x / 16.0)) + uint(tile.x);
    if (view == 3u) // shadow
        return exp(-constants.shadow_colour.rgb *
                   depth_before_layer(0u, vec2(part.x, 1.0 - part.y) * float(constants.side), constants.layers));
    if (view == 4u) { // layers, in rows from the light on
        const float columns = ceil(sqrt(float(constants.layers)));
        const vec2 cell = part * columns;
        const int layer = int(floor(cell.y) * columns + floor(cell.x));
        const vec2 within = fract(cell);
        return layer >= int(constants.layers) ? vec3(0)
                                    : exp(-constants.shadow_colour.rgb *
                                          depth_before_layer(0u, vec2(within.x, 1.0 - within.y) * float(constants.side), uint(layer) + 1u));
    }
    if (view == 5u) { // tiles: particles in each, a step of colour for every doubling up to 65536
        const uvec2 range = ranges.data[tile_number];
        return range.y > range.x ? heat(log2(float(range.y - range.x) + 1.0) / 16.0) : vec3(0);
    }
    if (view == 6u) // overflow: red where pairs were left out
        return dropped.data[tile_number] != 0u ? vec3(1, 0, 0) : vec3(0.25 * (1.0 - particles.a));
    return particles.rgb; // order, slices: colours of the particles themselves
}

void main() {
    const ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(vec2(pixel), constants.size)))
        return;
    const vec4 colour = sane(texelFetch(colour_image, pixel, 0));
    const float z = scene_depth(pixel);
    const Seen seen = particles_before(pixel, z);
    vec3 scene = colour.rgb;
    if (casts_shadow && z < sky_depth) {
        const vec3 lost = constants.shadow_colour.w * (1.0 - light_left(world_position(pixel, z)));
        scene -= lost * (has_direct ? min(sane(texelFetch(direct_image, scaled(direct_image, pixel), 0)).rgb, scene)
                                    : scene);
    }
    vec4 result = vec4(scene * seen.particles.a + seen.particles.rgb,
                       colour.a * seen.particles.a + 1.0 - seen.particles.a);
    if (view != 0u)
        result = vec4(debug_colour(pixel, seen.particles), 1);
    imageStore(output_image, pixel, result);
    if (has_transmittance)
        imageStore(transmittance_output, pixel, vec4(seen.particles.a, 0, 0, 0));
    if (has_velocity) {
        const vec2 behind = sane(texelFetch(scene_velocity_image, scaled(scene_velocity_image, pixel), 0)).xy;
        imageStore(velocity_output, pixel, vec4(behind * seen.particles.a + seen.velocity, 0, 0));
    }
}
