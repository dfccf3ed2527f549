// Lights each sorted particle that is in view and packs what tiles need of it; counts the tiles that it touches.

layout(local_size_x = 256) in;

layout(constant_id = 0) const uint light_count = 1u;
layout(constant_id = 1) const bool by_rank = false;
layout(constant_id = 2) const bool has_shadow_map = false;
layout(constant_id = 3) const uint view = 0u; // ParticleView
layout(constant_id = 4) const bool writes_velocity = false;
layout(constant_id = 5) const bool scattering = false; // layers hold blurred light
layout(constant_id = 6) const uint profile = 0u;       // ParticleProfile

layout(set = 0, binding = 0) readonly buffer Sprites { vec4 data[]; } sprites;
layout(set = 0, binding = 1) readonly buffer Facts { uint data[]; } facts;
layout(set = 0, binding = 2) readonly buffer Sorted { uint data[]; } sorted;
layout(set = 0, binding = 3) readonly buffer Count { uint data[]; } count;
layout(set = 0, binding = 4) readonly buffer Volume { uvec4 data[]; } volume;
layout(set = 0, binding = 5) uniform sampler2D shadow_map;
layout(set = 0, binding = 6) writeonly buffer Records { uvec4 data[]; } records; // two a particle
layout(set = 0, binding = 7) writeonly buffer Touched { uint data[]; } touched;  // tiles
layout(set = 0, binding = 8) writeonly buffer Extras { uint data[]; } extras; // velocity, pattern: where there are any

#include "particles_light_volume.glsl"
#include "particles_light_lookup.glsl"
#include "particles_tiles_disc.glsl"
#include "particles_profile.glsl"

// A glow's colour: it goes from red over yellow to white as it gets stronger, the way hot things do.
vec3 glow(float strength) {
    const float heat = strength / (1.0 + strength);
    return strength * vec3(1.0, 0.15 + 0.75 * heat, 0.02 + 0.7 * heat * heat);
}

// Share of the first light that the host's shadow map lets through: four texels, weighted.
float scene_visibility(vec3 position) {
    const vec4 clip = constants.shadow_map_from_world * vec4(position, 1);
    const vec3 at = vec3(clip.xy / clip.w * 0.5 + 0.5, clip.z / clip.w);
    if (clip.w <= 0.0 || any(lessThan(at.xy, vec2(0))) || any(greaterThan(at.xy, vec2(1))))
        return 1.0;
    const vec2 size = vec2(textureSize(shadow_map, 0));
    const vec2 texel = at.xy * size - 0.5;
    const vec2 part = fract(texel);
    const ivec2 first = ivec2(floor(texel));
    vec2 rows;
    [[unroll]] for (int y = 0; y < 2; ++y) {
        vec2 open;
        [[unroll]] for (int x = 0; x < 2; ++x) {
            const ivec2 corner = clamp(first + ivec2(x, y), ivec2(0), ivec2(size) - 1);
            open[x] = at.z <= texelFetch(shadow_map, corner, 0).x + constants.shadow_map_bias ? 1.0 : 0.0;
        }
        rows[y] = mix(open.x, open.y, part.x);
    }
    return mix(rows.x, rows.y, part.y);
}

// Light from one direction that reaches the eye, per unit of albedo: 1 without shadows where scattering is isotropic.
vec3 scattered(vec3 radiance, float optical_depth, float cosine) {
    vec3 sum = vec3(0);
    float share = 1.0, thinner = 1.0, g = constants.phase;
    for (float octave = 0.0; octave < constants.octaves.x; ++octave) {
        const vec3 left = exp(-constants.shadow_colour.rgb * (optical_depth * thinner));
        const float d = 1.0 + g * g - 2.0 * g * cosine;
        sum += share * left * ((1.0 - g * g) / (d * sqrt(d)));
        share *= constants.octaves.y;
        thinner *= constants.octaves.z;
        g *= constants.octaves.w;
    }
    return radiance * sum / (4.0 * pi);
}

// Light varies over a large particle: it is looked up in the middle and at four places of the disc, which together have
// the disc's mean (weighted by its chords) and give its slopes and curves.
const uint taps = 5u;
const float tap_distance = 0.70710678; // radii

struct Lit {
    vec3 colour; // mean
    vec4 shape;  // factor = 1 + shape.x u + shape.y v + shape.z (u² - 1/5) + shape.w (v² - 1/5), u and v in radii
};

vec3 tap_offset(uint tap) {
    const float distance_out = (tap & 1u) != 0u ? tap_distance : -tap_distance;
    // On the picture v goes down.
    return tap == 0u  ? vec3(0)
           : tap < 3u ? constants.world_from_view[0].xyz * distance_out
                      : constants.world_from_view[1].xyz * -distance_out;
}

Lit lit_sprite(Sprite s, uint layer, uint tap_count) {
    const vec3 eye = constants.world_from_view[3].xyz;
    const vec3 to_eye = is_perspective() ? normalize(eye - s.position) : constants.world_from_view[2].xyz;
    vec3 light_sums[taps];
    [[unroll]] for (uint tap = 0u; tap < taps; ++tap)
        light_sums[tap] = constants.ambient.rgb;
    for (uint l = 0u; l < light_count; ++l) {
        const mat4 light = light_of(l);
        const LightSpace space = space_of(l);
        const vec3 place = light_space(light, s.position);
        const Footprint f = footprint_of(space, place.xy, s.radius, 2.0 * s.radius * s.extinction);
        const bool by_layer = !by_rank || l > 0u;
        const float own = by_layer && !scattering ? own_factor(f) : 0.0;
        vec3 radiance = light[3].xyz;
        if (has_shadow_map && l == 0u)
            radiance *= scene_visibility(s.position);
        // Light travels along -towards and leaves along to_eye.
        const float cosine = dot(-light[2].xyz, to_eye);
        [[unroll]] for (uint tap = 0u; tap < taps; ++tap) {
            if (tap >= tap_count)
                break;
            const vec3 offset = tap_offset(tap) * s.radius;
            const vec2 texel =
                f.middle + vec2(dot(light[0].xyz, offset), dot(light[1].xyz, offset)) / space.texel;
            const float depth = by_layer ? depth_before(l, space, f, texel, place.z, own)
                                         : depth_before_layer(l, texel, layer);
            light_sums[tap] += scattered(radiance, depth, cosine);
        }
    }
    const vec3 shine = glow(s.emission);
    Lit lit = Lit(s.albedo * light_sums[0] + shine, vec4(0));
    if (tap_count < taps)
        return lit;
    vec3 sum = vec3(0);
    float bright[taps];
    [[unroll]] for (uint tap = 0u; tap < taps; ++tap) {
        const vec3 colour = s.albedo * light_sums[tap] + shine;
        sum += colour;
        bright[tap] = luminance(colour);
    }
    lit.colour = sum / float(taps);
    const float scale = 1.0 / max(luminance(lit.colour), 1e-9);
    lit.shape = vec4(bright[1] - bright[2], bright[3] - bright[4], bright[1] + bright[2] - 2.0 * bright[0],
                     bright[3] + bright[4] - 2.0 * bright[0]) *
                (scale / vec4(2.0 * tap_distance, 2.0 * tap_distance, 1, 1));
    return lit;
}

// Pixels a frame: where the particle is minus where it was.
vec2 screen_velocity(Sprite s, Disc disc, float time_step) {
    const vec4 clip = constants.previous_clip_from_world * vec4(s.position - s.velocity * time_step, 1);
    if (clip.w <= 0.0)
        return vec2(0);
    const vec2 before = (clip.xy / clip.w * 0.5 + 0.5) * constants.size;
    const vec2 moved = disc.middle / constants.scale - before;
    return is_finite(moved) ? clamp(moved, vec2(-65000.0), vec2(65000.0)) : vec2(0);
}

vec3 hue(float share) { return clamp(abs(fract(share + vec3(0.0, 0.6667, 0.3333)) * 6.0 - 3.0) - 1.0, 0.0, 1.0); }

// As on a light's texels: what so few pixels must be multiplied by to hold what the sphere holds.
float pixel_mass_factor(vec2 middle, float radius) {
    const Footprint f = Footprint(middle, radius, 1.0);
    return mass_factor(f, chord_sum(f));
}

// Which part of the profile's table the particle shows, and what makes its mass that of a sphere. By its slot, which it
// keeps for life: its pattern stays whatever moves before or behind it.
uint pattern_word(uint index) {
    const uint pattern = pattern_of(index);
    const uint place = profile == profile_noise ? place_of(pattern) : 0u;
    const float mass = uintBitsToFloat(facts.data[fact_profile + place]);
    return pattern << 16 | packHalf2x16(vec2(mass > least_mass ? 1.0 / mass : 0.0, 0)); // nothing stays nothing
}

void main() {
    const uint rank = gl_GlobalInvocationID.x;
    if (rank >= constants.capacity)
        return;
    const uint live = count.data[0];
    if (rank >= live) {
        touched.data[rank] = 0u;
        return;
    }
    const uint index = sorted.data[rank];
    const Sprite s = unpack_sprite(sprites.data[3u * index], sprites.data[3u * index + 1u],
                                   sprites.data[3u * index + 2u]);
    Disc disc = project(s.position, s.radius);
    const StandIn stand = stand_in(index, disc.radius, 2.0 * s.radius * s.extinction);
    disc.radius *= stand.radius;
    const float radius = max(disc.radius, 1.0);
    const uint tiles = disc.in_view && stand.depth > 0.0 ? tiles_touched(disc.middle, radius) : 0u;
    touched.data[rank] = tiles;
    if (tiles == 0u)
        return;
    const uint layer = rank / max((live + constants.layers - 1u) / constants.layers, 1u);
    // What covers few pixels needs no more than its middle.
    Lit lit = lit_sprite(s, layer, disc.radius < 1.5 ? 1u : taps);
    if (view == 1u)
        lit = Lit(vec3(float(rank) / float(max(live - 1u, 1u))), vec4(0));
    if (view == 2u) {
        const LightSpace space = space_of(0u);
        const float place = (light_space(constants.light_0, s.position).z - space.first) / space.spacing;
        const uint slice = by_rank ? layer : uint(clamp(place, 0.0, float(constants.layers - 1u)));
        lit = Lit(hue(float(slice) * 0.381966) * ((slice & 1u) == 0u ? 1.0 : 0.6), vec4(0));
    }
    // Optical depth fades in behind the near plane; a disc smaller than a pixel is drawn as large as one, and thinner.
    float depth = stand.depth * s.radius * s.extinction * disc.radius * disc.radius / (radius * radius);
    if (constants.near_range > 0.0)
        depth *= clamp((disc.depth - constants.near_start) / constants.near_range, 0.0, 1.0);
    if (radius < exact_radius)
        depth *= pixel_mass_factor(disc.middle, radius);
    depth = min(depth, 60000.0); // of half the sphere: half floats hold it in whatever unit extinction is
    const vec3 colour = min(lit.colour, vec3(65000.0));
    records.data[2u * rank] = uvec4(floatBitsToUint(disc.middle), floatBitsToUint(vec2(radius, disc.depth)));
    records.data[2u * rank + 1u] = uvec4(packHalf2x16(vec2(depth, colour.r)), packHalf2x16(colour.gb),
                                         packHalf2x16(lit.shape.xy), packHalf2x16(lit.shape.zw));
    const uint words = uint(writes_velocity) + uint(profile != 0u);
    if (writes_velocity)
        extras.data[words * rank] = packHalf2x16(screen_velocity(s, disc, constants.time_step));
    if (profile != 0u)
        extras.data[words * rank + words - 1u] = pattern_word(index);
}
