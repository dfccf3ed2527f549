// What the images of a frame hold of a point: its place in pixels and its depth. Expects the uniform block `scene` and
// view.glsl.

// Pixels from where the camera's axis meets the image, of a view-space point before the camera. Behind it there is no
// such place: a point that was or will be there moves along its line of sight to just before the camera.
vec2 project(vec3 view_position, float depth_now) {
    float depth = is_orthographic() ? 1.0 : max(-view_position.z, 0.02 * depth_now);
    return vec2(view_position.x, -view_position.y) / (depth * scene.lens.xy) * scene.lens.zw * 0.5;
}

vec3 view_position(mat4 view, vec3 world, float w) {
    return (view * vec4(world, w)).xyz;
}

// Linear, or what the projection's matrix makes of it.
float depth_value(float t) {
    if ((scene.flags & SCENE_DEVICE_DEPTH) == 0u)
        return t;
    if (t >= SCENE_SKY_DEPTH)
        return scene.depth_range.z;
    float z = scene.depth_range.y - scene.depth_range.x * t;
    return clamp(is_orthographic() ? z : scene.depth_range.y / t - scene.depth_range.x, 0.0, 1.0);
}
