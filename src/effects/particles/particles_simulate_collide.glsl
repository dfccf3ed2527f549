// Collisions: with planes, spheres and boxes along the way of a step, and with the surfaces that the depth image shows.

layout(constant_id = 0) const bool collides_with_depth = true;
layout(constant_id = 1) const bool collides_with_shapes = true;
layout(constant_id = 2) const bool device_depth = false;

layout(set = 0, binding = 0) uniform sampler2D depth;

// What is kept free between a particle and a surface, so that rounding does not put it behind.
const float clearance = 1e-4;

const uint shape_plane = 0u, shape_sphere = 1u, shape_box = 2u;

struct Mover {
    vec3 position;
    vec3 velocity;
};

// Velocity after touching a surface with the unit `normal` that moves with `surface`.
vec3 bounced(vec3 velocity, vec3 normal, vec3 surface) {
    const vec3 relative = velocity - surface;
    const float approach = dot(relative, normal);
    if (approach >= 0.0)
        return velocity;
    const vec3 along = relative - approach * normal;
    return surface + along * (1.0 - constants.friction) - constants.bounce * approach * normal;
}

struct Solid {
    vec3 centre;
    uint shape;
    vec3 size;
    mat3 axes;
    vec3 velocity;
};

// Whether a solid can be met within `reach` of a position; endless ones always.
bool is_near(uint i, vec3 position, float reach) {
    const vec3 from = position - constants.colliders[5u * i].xyz;
    const float bound = constants.colliders[5u * i + 1u].w;
    return bound < 0.0 || dot(from, from) <= (bound + reach) * (bound + reach);
}

Solid solid_at(uint i) {
    const vec4 a = constants.colliders[5u * i], b = constants.colliders[5u * i + 1u];
    const vec4 x = constants.colliders[5u * i + 2u], y = constants.colliders[5u * i + 3u],
               z = constants.colliders[5u * i + 4u];
    return Solid(a.xyz, uint(a.w), b.xyz, mat3(x.xyz, y.xyz, z.xyz), vec3(x.w, y.w, z.w));
}

// Signed distance in the solid's own space (below 0 inside) and the outward normal there.
float distance_to(Solid solid, vec3 p, out vec3 normal) {
    if (solid.shape == shape_plane) {
        normal = vec3(0, 1, 0);
        return p.y;
    }
    if (solid.shape == shape_sphere) {
        const float r = length(p);
        normal = r > 0.0 ? p / r : vec3(0, 1, 0);
        return r - solid.size.x;
    }
    const vec3 q = abs(p) - solid.size;
    const float face = max(q.x, max(q.y, q.z));
    normal = face == q.x ? vec3(p.x < 0.0 ? -1 : 1, 0, 0)
             : face == q.y ? vec3(0, p.y < 0.0 ? -1 : 1, 0)
                           : vec3(0, 0, p.z < 0.0 ? -1 : 1);
    return face; // right inside, and its sign outside: all that is asked for
}

// The share of the way from a to b (own space) after which the solid is entered from outside, or 2.
float entry(Solid solid, vec3 a, vec3 b, out vec3 normal) {
    const vec3 way = b - a;
    normal = vec3(0, 1, 0);
    if (solid.shape == shape_plane)
        return a.y >= 0.0 && b.y < 0.0 ? a.y / (a.y - b.y) : 2.0;
    if (solid.shape == shape_sphere) {
        const float radius = solid.size.x;
        const float aa = dot(way, way), ab = dot(a, way), outside = dot(a, a) - radius * radius;
        const float root = ab * ab - aa * outside;
        if (outside < 0.0 || ab >= 0.0 || root < 0.0)
            return 2.0;
        const float t = (-ab - sqrt(root)) / aa;
        normal = (a + t * way) / radius;
        return t <= 1.0 ? t : 2.0;
    }
    // Slabs. A way along a face never divides by zero.
    const vec3 safe = mix(way, vec3(1e-20), lessThan(abs(way), vec3(1e-20)));
    const vec3 one = (-solid.size - a) / safe, two = (solid.size - a) / safe;
    const vec3 near = min(one, two), far = max(one, two);
    const float first = max(near.x, max(near.y, near.z)), last = min(far.x, min(far.y, far.z));
    if (first < 0.0 || first > 1.0 || first > last)
        return 2.0;
    normal = first == near.x ? vec3(-sign(safe.x), 0, 0)
             : first == near.y ? vec3(0, -sign(safe.y), 0)
                               : vec3(0, 0, -sign(safe.z));
    return first;
}

// What is met on the way is bounced off, up to three times; what is inside a solid after that is put outside.
Mover collide_with_shapes(Mover before, Mover after, float step) {
    for (uint meeting = 0u; meeting < 3u; ++meeting) {
        float first = 2.0;
        vec3 normal = vec3(0), surface = vec3(0);
        const float way = length(after.position - before.position);
        for (uint i = 0u; i < constants.collider_count; ++i) {
            if (!is_near(i, before.position, way))
                continue;
            const Solid solid = solid_at(i);
            vec3 n;
            const float t = entry(solid, (before.position - solid.centre) * solid.axes,
                                  (after.position - solid.centre) * solid.axes, n);
            if (t < first) {
                first = t;
                normal = solid.axes * n;
                surface = solid.velocity;
            }
        }
        if (first > 1.0)
            break;
        // The velocity where it touches; what the forces add in the rest of the step acts after the bounce.
        const vec3 change = (1.0 - first) * (after.velocity - before.velocity);
        const vec3 touching = bounced(after.velocity - change, normal, surface);
        step *= 1.0 - first;
        before = Mover(mix(before.position, after.position, first) + clearance * normal, touching);
        // A particle between surfaces may rest for a moment.
        after.velocity = touching + change;
        after.position = before.position + (meeting < 2u ? 0.5 * step * (touching + after.velocity) : vec3(0));
    }
    // Twice, for corners between two solids.
    bool is_inside = true;
    for (uint round = 0u; round < 2u && is_inside; ++round) {
        is_inside = false;
        for (uint i = 0u; i < constants.collider_count; ++i) {
            if (!is_near(i, after.position, 0.0))
                continue;
            const Solid solid = solid_at(i);
            vec3 n;
            const float inside = distance_to(solid, (after.position - solid.centre) * solid.axes, n);
            if (inside >= 0.0)
                continue;
            is_inside = true;
            n = solid.axes * n;
            after.position += (clearance - inside) * n;
            after.velocity = bounced(after.velocity, n, solid.velocity);
        }
    }
    return after;
}

float depth_at(ivec2 texel) {
    const float value = texelFetch(depth, clamp(texel, ivec2(0), textureSize(depth, 0) - 1), 0).x;
    return device_depth ? view_depth_of(value, constants.projection) : value;
}

// View space, of a place in the image (-1…1) at a view depth.
vec3 unproject(vec2 place, float view_depth) {
    const mat4 p = constants.projection;
    const float w = p[3][3] - p[2][3] * view_depth;
    return vec3((place.x * w + p[2][0] * view_depth - p[3][0]) / p[0][0],
                (place.y * w + p[2][1] * view_depth - p[3][1]) / p[1][1], -view_depth);
}

vec3 surface_at(ivec2 texel, float view_depth) {
    return unproject((vec2(texel) + 0.5) / vec2(textureSize(depth, 0)) * 2.0 - 1.0, view_depth);
}

// Difference of neighbours along one axis, of the side that is on the same surface; zero where there is none.
vec3 surface_slope(ivec2 texel, ivec2 axis, float here) {
    const float before = depth_at(texel - axis), after = depth_at(texel + axis);
    const bool take_before = is_sky(after) || (!is_sky(before) && abs(before - here) < abs(after - here));
    if (take_before ? is_sky(before) : is_sky(after))
        return vec3(0);
    const vec3 middle = surface_at(texel, here);
    const ivec2 limit = textureSize(depth, 0) - 1;
    return take_before ? middle - surface_at(clamp(texel - axis, ivec2(0), limit), before)
                       : surface_at(clamp(texel + axis, ivec2(0), limit), after) - middle;
}

// Towards the camera.
vec3 surface_normal(ivec2 texel, float here, vec3 place) {
    const bool perspective = constants.projection[2][3] != 0.0;
    const vec3 to_eye = perspective ? -normalize(place) : vec3(0, 0, 1);
    const vec3 n = cross(surface_slope(texel, ivec2(1, 0), here), surface_slope(texel, ivec2(0, 1), here));
    const float size = length(n);
    if (!(size > 0.0 && is_finite(size)))
        return to_eye;
    return dot(n, to_eye) < 0.0 ? -n / size : n / size;
}

// What went behind a visible surface, by no more than its thickness and the way of the step, is put back before it.
Mover collide_with_depth(Mover before, Mover after) {
    const vec3 place = (constants.world_to_view * vec4(after.position, 1)).xyz;
    const vec4 clip = constants.projection * vec4(place, 1);
    if (clip.w <= 0.0 || any(greaterThanEqual(abs(clip.xy), vec2(clip.w))))
        return after;
    const vec2 ndc = clip.xy / clip.w;
    const ivec2 texel = ivec2((ndc * 0.5 + 0.5) * vec2(textureSize(depth, 0)));
    const float here = depth_at(texel);
    if (is_sky(here) || here <= 0.0)
        return after;
    const float behind = -place.z - here;
    const float way = place.z - (constants.world_to_view * vec4(before.position, 1)).z;
    if (behind <= 0.0 || behind >= constants.thickness + max(-way, 0.0))
        return after;
    const vec3 surface = unproject(ndc, here);
    const vec3 normal = surface_normal(texel, here, surface);
    const vec3 out_place = place + normal * (clearance + max(0.0, dot(surface - place, normal)));
    const vec3 world_normal = normalize(mat3(constants.view_to_world) * normal);
    return Mover((constants.view_to_world * vec4(out_place, 1)).xyz, bounced(after.velocity, world_normal, vec3(0)));
}
