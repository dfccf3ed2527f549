// Rays against the primitives of the scene. Expects the uniform block `scene`.

struct Hit {
    float t;    // along the ray; SCENE_SKY_DEPTH for none
    uint index; // of the primitive
};

vec3 primitive_position(uint i) {
    return vec3(scene.primitives[i].now[0].w, scene.primitives[i].now[1].w, scene.primitives[i].now[2].w);
}

// Rotates from world to local space: the rows of the pose are the columns of its inverse.
vec3 to_local_direction(uint i, vec3 v) {
    return v.x * scene.primitives[i].now[0].xyz + v.y * scene.primitives[i].now[1].xyz +
           v.z * scene.primitives[i].now[2].xyz;
}

vec3 to_world_direction(uint i, vec3 v) {
    return vec3(dot(scene.primitives[i].now[0].xyz, v), dot(scene.primitives[i].now[1].xyz, v),
                dot(scene.primitives[i].now[2].xyz, v));
}

// Nearest t in (t_min, t_max) at which the ray enters the sphere, else t_max.
float hit_sphere(float radius, vec3 o, vec3 d, float t_min, float t_max) {
    float a = dot(d, d);
    float b = dot(o, d);
    // The distance of the ray from the centre, without the cancellation of b² - a c.
    vec3 nearest = o - d * (b / a);
    float inside = radius * radius - dot(nearest, nearest);
    if (inside <= 0.0)
        return t_max;
    float t = -b / a - sqrt(inside / a);
    return t > t_min && t < t_max ? t : t_max;
}

float hit_box(vec3 size, vec3 o, vec3 d, float t_min, float t_max) {
    // A component of exactly zero would make 0 × infinity.
    vec3 safe = mix(d, vec3(1e-20), lessThan(abs(d), vec3(1e-20)));
    vec3 a = (-size - o) / safe;
    vec3 b = (size - o) / safe;
    vec3 low = min(a, b);
    vec3 high = max(a, b);
    float enter = max(max(low.x, low.y), low.z);
    float leave = min(min(high.x, high.y), high.z);
    return enter < leave && enter > t_min && enter < t_max ? enter : t_max;
}

float hit_cylinder(vec2 size, vec3 o, vec3 d, float t_min, float t_max) {
    float dy = abs(d.y) < 1e-20 ? 1e-20 : d.y;
    float cap_a = (-size.y - o.y) / dy;
    float cap_b = (size.y - o.y) / dy;
    float enter = min(cap_a, cap_b);
    float leave = max(cap_a, cap_b);
    float a = dot(d.xz, d.xz);
    float b = dot(o.xz, d.xz);
    vec2 nearest = a > 1e-20 ? o.xz - d.xz * (b / a) : o.xz;
    float inside = size.x * size.x - dot(nearest, nearest);
    if (inside <= 0.0)
        return t_max;
    if (a > 1e-20) {
        float half_chord = sqrt(inside / a);
        enter = max(enter, -b / a - half_chord);
        leave = min(leave, -b / a + half_chord);
    }
    return enter < leave && enter > t_min && enter < t_max ? enter : t_max;
}

float hit_flat(float radius, vec3 o, vec3 d, float t_min, float t_max) {
    if (o.y * d.y >= 0.0)
        return t_max;
    float t = -o.y / d.y;
    vec2 place = o.xz + t * d.xz;
    return t > t_min && t < t_max && dot(place, place) <= radius * radius ? t : t_max;
}

// The nearer of t_max and the entry of the ray into primitive i.
float hit_primitive(uint i, vec3 origin, vec3 direction, float t_min, float t_max) {
    vec4 size = scene.primitives[i].size;
    vec3 away = origin - primitive_position(i);
    if (size.w >= 0.0) {
        vec3 nearest = away - direction * (dot(away, direction) / dot(direction, direction));
        if (dot(nearest, nearest) > size.w * size.w)
            return t_max;
    }
    vec3 o = to_local_direction(i, away);
    vec3 d = to_local_direction(i, direction);
    switch (scene.primitives[i].shape) {
    case SHAPE_SPHERE:
        return hit_sphere(size.x, o, d, t_min, t_max);
    case SHAPE_BOX:
        return hit_box(size.xyz, o, d, t_min, t_max);
    case SHAPE_CYLINDER:
        return hit_cylinder(size.xy, o, d, t_min, t_max);
    case SHAPE_PLANE:
        return hit_flat(1e9, o, d, t_min, t_max);
    default:
        return hit_flat(size.x, o, d, t_min, t_max);
    }
}

Hit cast_ray(vec3 origin, vec3 direction, float t_min) {
    Hit hit = Hit(SCENE_SKY_DEPTH, 0u);
    for (uint i = 0u; i < scene.primitive_count; ++i) {
        float t = hit_primitive(i, origin, direction, t_min, hit.t);
        if (t < hit.t)
            hit = Hit(t, i);
    }
    return hit;
}

// 1 if the ray is free, 0 if anything that casts shadows is in its way.
float cast_shadow(vec3 origin, vec3 direction) {
    for (uint i = 0u; i < scene.primitive_count; ++i) {
        if ((scene.primitives[i].flags & PRIMITIVE_CASTS_SHADOW) == 0u)
            continue;
        if (hit_primitive(i, origin, direction, 0.0, 1e9) < 1e9)
            return 0.0;
    }
    return 1.0;
}

// Outward normal of the surface at a point on it, local space: of the face that the point is nearest to.
vec3 local_normal(uint i, vec3 p) {
    vec3 size = scene.primitives[i].size.xyz;
    switch (scene.primitives[i].shape) {
    case SHAPE_SPHERE:
        return normalize(p);
    case SHAPE_BOX: {
        vec3 gap = abs(size - abs(p));
        if (gap.x <= gap.y && gap.x <= gap.z)
            return vec3(p.x < 0.0 ? -1.0 : 1.0, 0.0, 0.0);
        return gap.y <= gap.z ? vec3(0.0, p.y < 0.0 ? -1.0 : 1.0, 0.0) : vec3(0.0, 0.0, p.z < 0.0 ? -1.0 : 1.0);
    }
    case SHAPE_CYLINDER:
        if (abs(size.y - abs(p.y)) < abs(size.x - length(p.xz)))
            return vec3(0.0, p.y < 0.0 ? -1.0 : 1.0, 0.0);
        return normalize(vec3(p.x, 0.0, p.z));
    default:
        return vec3(0.0, 1.0, 0.0);
    }
}
