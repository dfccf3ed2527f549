// The camera's rays and the surfaces that they meet. Expects the uniform block `scene` and ray_cast.glsl.

struct Ray {
    vec3 origin; // world
    vec3 direction;
};

bool is_orthographic() {
    return (scene.flags & SCENE_ORTHOGRAPHIC) != 0u;
}

// The ray through a point of the image in pixels. Its direction has length 1 along the camera's axis, so that t along it
// is the view depth.
Ray camera_ray(vec2 place) {
    vec2 ndc = place / scene.lens.zw * 2.0 - 1.0 + scene.frustum.xy;
    vec2 side = vec2(ndc.x * scene.lens.x, -ndc.y * scene.lens.y);
    mat3 to_world = transpose(mat3(scene.view));
    if (is_orthographic())
        return Ray(scene.eye.xyz + to_world * vec3(side, 0.0), to_world * vec3(0.0, 0.0, -1.0));
    return Ray(scene.eye.xyz, to_world * vec3(side, -1.0));
}

// What the camera sees: nothing beyond the far plane of the projection, if it has one.
Hit camera_hit(Ray ray) {
    Hit hit = cast_ray(ray.origin, ray.direction, 1e-3 * scene.frustum.w);
    if (hit.t > scene.frustum.z)
        hit.t = SCENE_SKY_DEPTH;
    return hit;
}

struct Surface {
    uint index;
    float depth;
    vec3 position;       // world
    vec3 local_position; // on the primitive
    vec3 local_normal;
    vec3 normal; // world, towards the camera
};

Surface surface_at(Hit hit, Ray ray) {
    Surface s;
    s.index = hit.index;
    s.depth = hit.t;
    s.position = ray.origin + hit.t * ray.direction;
    s.local_position = to_local_direction(hit.index, s.position - primitive_position(hit.index));
    s.local_normal = local_normal(hit.index, s.local_position);
    s.normal = to_world_direction(hit.index, s.local_normal);
    if (dot(s.normal, ray.direction) > 0.0)
        s.normal = -s.normal;
    return s;
}
