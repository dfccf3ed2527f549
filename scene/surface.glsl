// Procedural patterns and the sky. Patterns live in local space, so they move with their primitive; what is finer than a
// pixel fades to its mean. Expects the uniform block `scene`.

uint hash(uvec3 p) {
    uint h = p.x * 0x8da6b343u + p.y * 0xd8163841u + p.z * 0xcb1ab31fu;
    h ^= h >> 15;
    h *= 0x2c1b3c6du;
    h ^= h >> 12;
    h *= 0x297a2d39u;
    return h ^ (h >> 15);
}

float random_at(ivec3 cell) {
    return float(hash(uvec3(cell)) >> 8) * (1.0 / 16777216.0);
}

// Value noise, 0…1.
float noise(vec3 p) {
    vec3 base = floor(p);
    ivec3 c = ivec3(base);
    vec3 f = p - base;
    f = f * f * (3.0 - 2.0 * f);
    vec4 low = vec4(random_at(c), random_at(c + ivec3(1, 0, 0)), random_at(c + ivec3(0, 1, 0)),
                    random_at(c + ivec3(1, 1, 0)));
    vec4 high = vec4(random_at(c + ivec3(0, 0, 1)), random_at(c + ivec3(1, 0, 1)), random_at(c + ivec3(0, 1, 1)),
                     random_at(c + ivec3(1, 1, 1)));
    vec4 z = mix(low, high, f.z);
    vec2 y = mix(z.xy, z.zw, f.y);
    return mix(y.x, y.y, f.x);
}

float fractal_noise(vec3 p) {
    return (noise(p) * 4.0 + noise(p * 2.03 + 7.1) * 2.0 + noise(p * 4.01 + 3.7)) * (1.0 / 7.0);
}

// How much of a pattern with `cells` cells a metre is left when a pixel spans `footprint` metres.
float contrast(float cells, float footprint) {
    return 1.0 - smoothstep(0.3, 0.9, cells * footprint);
}

// The two coordinates of the face that looks along the normal's largest component.
vec2 face_coordinates(vec3 p, vec3 normal) {
    vec3 n = abs(normal);
    return n.y >= n.x && n.y >= n.z ? p.xz : n.x >= n.z ? p.zy : p.xy;
}

// Distance from the nearest joint in a unit cell, and that cell.
float joint(vec2 uv, out ivec2 cell) {
    vec2 base = floor(uv);
    cell = ivec2(base);
    vec2 gap = min(uv - base, 1.0 - (uv - base));
    return min(gap.x, gap.y);
}

// Share of colour_b (x) and a factor on the colour (y).
vec2 pattern_mix(uint pattern, float cells, vec3 p, vec3 normal) {
    // Off the origin, so that faces at whole cells do not flicker between two of them.
    vec3 q = p * cells + vec3(0.371, 0.417, 0.293);
    switch (pattern) {
    case PATTERN_CHECKER: {
        ivec3 c = ivec3(floor(q));
        return vec2(float((c.x + c.y + c.z) & 1), 1.0);
    }
    case PATTERN_STRIPES:
        return vec2(float(int(floor(q.x)) & 1), 1.0);
    case PATTERN_RINGS:
        return vec2(float(int(floor(q.y)) & 1), 1.0);
    case PATTERN_SECTORS: {
        float turn = atan(p.z, p.x) * 0.15915494 + 0.5;
        float ring = floor(length(p.xz) * 2.5 + 0.1);
        return vec2(float(int(floor(turn * cells * 2.0) + ring) & 1), 1.0);
    }
    case PATTERN_BRICKS: {
        vec2 uv = face_coordinates(q, normal) * vec2(1.0, 2.0);
        uv.x += 0.5 * float(int(floor(uv.y)) & 1);
        ivec2 cell;
        vec2 base = floor(uv);
        vec2 gap = min(uv - base, 1.0 - (uv - base)) * vec2(1.0, 0.5);
        cell = ivec2(base);
        return vec2(1.0 - step(0.035, min(gap.x, gap.y)), 0.75 + 0.5 * random_at(ivec3(cell, 5)));
    }
    case PATTERN_TILES: {
        ivec2 cell;
        float gap = joint(face_coordinates(q, normal), cell);
        float tone = 0.85 + 0.3 * random_at(ivec3(cell, 9));
        return vec2(float((cell.x + cell.y) & 1), gap < 0.02 ? 0.45 : tone);
    }
    case PATTERN_NOISE:
        return vec2(smoothstep(0.3, 0.7, fractal_noise(q)), 1.0);
    default:
        return vec2(0.0, 1.0);
    }
}

// Colour of a material at local point p.
vec3 surface_colour(uint material, vec3 p, vec3 normal, float footprint) {
    vec4 a = scene.materials[material].colour_a;
    vec3 b = scene.materials[material].colour_b.rgb;
    uint pattern = scene.materials[material].pattern;
    float cells = scene.materials[material].scale;
    if (pattern == PATTERN_SOLID && a.w == 0.0)
        return a.rgb;
    vec2 mixing = pattern_mix(pattern, cells, p, normal);
    // Sectors are counted a turn, not a metre: they are wide but at their centre.
    float left = pattern == PATTERN_SECTORS ? 1.0 : contrast(cells, footprint);
    float mean_share = pattern == PATTERN_BRICKS ? 0.1 : pattern == PATTERN_SOLID ? 0.0 : 0.5;
    vec3 colour = mix(a.rgb, b, mix(mean_share, mixing.x, left)) * mix(1.0, mixing.y, left);
    if (a.w > 0.0) {
        // Two octaves of fine grain, each there as long as a pixel can show it.
        float coarse = (noise(p * 9.0 + 11.3) - 0.5) * contrast(9.0, footprint);
        float fine = (noise(p * 31.0 + 4.9) - 0.5) * contrast(31.0, footprint);
        colour *= 1.0 + a.w * (coarse + fine);
    }
    return colour;
}

vec3 sky_colour(vec3 direction) {
    vec3 d = normalize(direction);
    float up = max(d.y, 0.0);
    vec3 colour = mix(scene.sky_horizon.rgb, scene.sky_zenith.rgb, sqrt(up));
    if (d.y < 0.0)
        colour *= 1.0 + 0.5 * max(d.y, -1.0);
    float share = scene.sun_colour.w;
    if (share > 0.0 && d.y > 0.0) {
        vec3 place = vec3(d.xz / (d.y + 0.18), 0.0) * 1.7;
        float cloud = smoothstep(0.62 - 0.3 * share, 0.85 - 0.2 * share, fractal_noise(place + 2.5));
        colour = mix(colour, scene.sky_horizon.rgb * 0.6 + scene.sun_colour.rgb * 0.35, cloud * smoothstep(0.0, 0.15, d.y));
    }
    return colour;
}
