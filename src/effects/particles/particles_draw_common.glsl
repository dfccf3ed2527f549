// What the passes of shadowing and drawing share: sprites, the measured facts of all particles, and depth as whole
// numbers that sort.

layout(set = 1, binding = 0) uniform Constants { ParticleDrawConstants constants; };

struct Sprite {
    vec3 position;
    float radius;
    vec3 velocity;
    float extinction;
    vec3 albedo;
    float emission;
};

// Three vec4 a sprite.
Sprite unpack_sprite(vec4 a, vec4 b, vec4 c) { return Sprite(a.xyz, a.w, b.xyz, b.w, c.xyz, c.w); }

bool all_finite(vec4 v) {
    return !any(equal(floatBitsToUint(v) & 0x7f800000u, uvec4(0x7f800000u)));
}

// Dead, empty or broken particles are left out of everything. Lengths beyond 1e15 would overflow when squared.
bool is_alive(vec4 a, vec4 b, vec4 c) {
    return all_finite(a) && all_finite(b) && all_finite(c) && a.w > 0.0 && a.w < 1e15 && b.w > 0.0 &&
           all(lessThan(abs(a.xyz), vec3(1e15)));
}

// Order of floats as order of unsigned integers, for atomic minimum and maximum.
uint ordered(float x) {
    const uint bits = floatBitsToUint(x);
    return bits ^ ((bits >> 31) != 0u ? 0xffffffffu : 0x80000000u);
}
float from_ordered(uint key) { return uintBitsToFloat(key ^ ((key >> 31) != 0u ? 0x80000000u : 0xffffffffu)); }

mat4 light_of(uint light) {
    return light == 0u   ? constants.light_0
           : light == 1u ? constants.light_1
           : light == 2u ? constants.light_2
                         : constants.light_3;
}

// Across the light's rays, and the distance along them: smaller is nearer the light.
vec3 light_space(mat4 light, vec3 position) {
    return vec3(dot(light[0].xyz, position), dot(light[1].xyz, position), -dot(light[2].xyz, position));
}

// The words of the buffer of facts. First the extremes, as ordered integers.
const uint fact_key_low = 0u;
const uint fact_key_high = 1u;
const uint fact_optical = 2u;    // sum of the particles' greatest optical depths, sixteenths
const uint fact_clamped = 3u;    // particles whose optical depth was cut
const uint fact_light = 4u;      // of each light six: low x y z, high x y z
const uint fact_light_words = 6u;
// Then what follows from them, as floats.
const uint fact_key_offset = 28u;
const uint fact_key_scale = 29u;
const uint fact_unit = 30u;      // optical depth of one unit of the shadow buffer
const uint fact_space = 32u;     // of each light eight: corner x y, texel, first depth, depth of a layer, shift of rows
const uint fact_space_words = 8u;
// And counts.
const uint fact_alive = 64u;
const uint fact_drawn = 65u; // in view
const uint fact_words = 96u;
// With a profile, of each place in its table: what the profile there holds over what a sphere's chords hold.
const uint fact_profile = 96u;

// The deepest optical depth that one particle adds: e^-16 is no light at all.
const float deepest = 16.0;

struct LightSpace {
    vec2 corner;
    float texel;   // metres
    float first;   // depth where the first layer begins
    float spacing; // depth of a layer
    float shift;   // how much nearer the light the layers of every second row of texels begin, in layers
};

const float pi = 3.14159265;

// A sphere's optical depth along a ray that passes its middle at `distance` radii, over that through the middle.
float chord(float distance_squared) { return sqrt(max(0.0, 1.0 - distance_squared)); }

// Footprints are at least a grid cell in radius, and small ones are weighted so that the cells together hold what the
// sphere holds: 2/3 pi r^2 times the optical depth through the middle. The sum of the chords over the grid's cells
// stands in for that integral where a sphere covers few of them.
const float exact_radius = 3.0;
