// The velocity of the air: wind, and curl noise after Bridson, Hourihan, Nordenstam, Curl-Noise for Procedural Fluid Flow
// (SIGGRAPH 2007), with the curl taken as the cross product of two gradients (DeWolf, Divergence-Free Noise, 2005): its
// divergence is zero everywhere, and no third potential is needed.

layout(constant_id = 4) const uint curl_octaves = 2;

// Makes the root mean square speed 1.
const float curl_normalisation = 1.663;

uint lattice_hash(ivec3 cell, uint salt) {
    return mix_bits(uint(cell.x) * 0x9e3779b1u ^ uint(cell.y) * 0x85ebca77u ^ uint(cell.z) * 0xc2b2ae3du ^ salt);
}

// Ten bits a component, -1…1.
vec3 lattice_gradient(uint h) {
    return vec3(h & 1023u, h >> 10 & 1023u, h >> 20 & 1023u) * (2.0 / 1023.0) - 1.0;
}

// Two gradient noises on one lattice, whose gradients turn with time at two speeds, so that the field never repeats; the
// cross product of their exact derivatives. `turns`: cosines and sines.
vec3 curl_noise(vec3 p, vec4 turns, uint salt) {
    const vec3 floored = floor(p);
    const ivec3 cell = ivec3(floored);
    const vec3 f = p - floored;
    const vec3 fade = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    const vec3 slope = 30.0 * f * f * (f * (f - 2.0) + 1.0);
    vec3 first = vec3(0), second = vec3(0);
    for (int i = 0; i < 8; ++i) {
        const ivec3 corner = ivec3(i & 1, i >> 1 & 1, i >> 2);
        const vec3 from = f - vec3(corner);
        const vec3 w = mix(1.0 - fade, fade, vec3(corner));
        const vec3 dw = slope * vec3(2 * corner - 1);
        const vec3 weight_slope = vec3(dw.x * w.y * w.z, w.x * dw.y * w.z, w.x * w.y * dw.z);
        const float weight = w.x * w.y * w.z;
        const uint h = lattice_hash(cell + corner, salt);
        const vec3 a = turns.x * lattice_gradient(h) + turns.y * lattice_gradient(h * 0x2c1b3c6du + 1u);
        const vec3 b =
            turns.z * lattice_gradient(h * 0x297a2d39u + 3u) + turns.w * lattice_gradient(h * 0x4f1bbcdbu + 7u);
        first += weight * a + weight_slope * dot(a, from);
        second += weight * b + weight_slope * dot(b, from);
    }
    return cross(first, second);
}

// `time` in seconds, whole ones and the rest.
vec3 air_velocity(vec3 position, vec2 time) {
    vec3 velocity = constants.air.xyz;
    if (constants.curl_strength == 0.0)
        return velocity;
    float frequency = constants.curl_frequency, strength = constants.curl_strength * curl_normalisation;
    float rate = constants.curl_speed;
    for (uint octave = 0u; octave < curl_octaves; ++octave) {
        // Precise after hours too: whole turns are dropped before the parts are added.
        const vec2 rates = rate * vec2(0.5, 0.3090170);
        const vec2 angle = 6.2831853 * fract(fract(rates * time.x) + rates * time.y);
        const vec4 turns = vec4(cos(angle.x), sin(angle.x), cos(angle.y), sin(angle.y));
        velocity += strength * curl_noise(position * frequency, turns, constants.seed * 31u + octave);
        frequency *= 2.0;
        strength *= 0.7;
        rate *= 1.6;
    }
    return velocity;
}
