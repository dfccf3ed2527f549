// passes: light geometry shadow
// Surfaces of a glTF model.
//   light     direct and ambient light: Lambert and GGX, after the metallic-roughness model of glTF 2.0, appendix B
//   geometry  normal, depth, motion and shadow
//   shadow    depth alone, for the shadow map
#version 450
#extension GL_GOOGLE_include_directive : require
#include "scene_shared.h"
#include "mesh_shared.h"

layout(push_constant) uniform Push {
    MeshDraw draw;
};
layout(set = 0, binding = 0, std140) uniform Lights {
    MeshLights lighting;
};
layout(set = 0, binding = 1) uniform sampler2D shadow_map;
layout(set = 1, binding = 0, std140) uniform Material {
    MeshMaterial material;
};
layout(set = 1, binding = 1) uniform sampler2D base_colour_map;
layout(set = 1, binding = 2) uniform sampler2D metallic_roughness_map;
layout(set = 1, binding = 3) uniform sampler2D normal_map;
layout(set = 1, binding = 4) uniform sampler2D emission_map;

layout(location = MESH_TEXCOORD) in vec2 texcoord;
layout(location = MESH_COLOUR) in vec4 colour;

vec4 base_colour() {
    return texture(base_colour_map, texcoord, draw.bias) * material.base_colour * colour;
}

float cutoff() {
    return (material.flags & MESH_BLENDED) != 0u ? draw.cutoff : material.cutoff;
}

#ifdef PASS_shadow
void main() {
    if (base_colour().a < cutoff())
        discard;
}
#else

layout(location = MESH_POSITION) in vec3 position;
layout(location = MESH_NORMAL) in vec3 normal;

bool is_orthographic() {
    return draw.forward.w != 0.0;
}

float view_depth() {
    return dot(position - draw.eye.xyz, draw.forward.xyz);
}

// Towards the camera, unit.
vec3 view_direction() {
    return is_orthographic() ? -draw.forward.xyz : normalize(draw.eye.xyz - position);
}

// What the camera does not see: the inside of single-sided surfaces, holes, what lies beyond the far plane.
bool is_visible(float alpha) {
    bool side = gl_FrontFacing || (material.flags & MESH_DOUBLE_SIDED) != 0u;
    return side && alpha >= cutoff() && view_depth() <= draw.eye.w;
}

// An interpolated normal may look away at a silhouette: it is bent until it is seen edge-on.
vec3 towards(vec3 n, vec3 to_eye) {
    float away = dot(n, to_eye);
    return away >= 0.0 ? n : normalize(n - (away - 1e-4) * to_eye);
}

// On the side that is seen. Where the model has no normal, the triangle's own.
vec3 smooth_normal() {
    vec3 face = cross(dFdx(position), dFdy(position));
    float size = dot(normal, normal);
    if (size > 1e-8)
        return normal * (inversesqrt(size) * (gl_FrontFacing ? 1.0 : -1.0));
    vec3 to_eye = view_direction();
    float area = dot(face, face);
    if (!(area > 1e-30))
        return to_eye;
    return face * (inversesqrt(area) * (dot(face, to_eye) < 0.0 ? -1.0 : 1.0));
}

vec3 detailed_normal(vec3 n) {
    // The directions in which the texture coordinates grow, from the neighbouring pixels: taken by all of them.
    vec3 dx = dFdx(position), dy = dFdy(position);
    vec2 tx = dFdx(texcoord), ty = dFdy(texcoord);
    vec3 map = texture(normal_map, texcoord, draw.bias).xyz * 2.0 - 1.0;
    if ((material.flags & MESH_NORMAL_MAP) == 0u)
        return n;
    map.xy *= material.emission.w;
    vec3 across_x = cross(dy, n), across_y = cross(n, dx);
    // Pixels are counted downwards, which turns both.
    float side = dot(cross(dx, dy), n) < 0.0 ? -1.0 : 1.0;
    vec3 t = (across_x * tx.x + across_y * ty.x) * side;
    vec3 down = (across_x * tx.y + across_y * ty.y) * side;
    // Texture coordinates grow downwards, normal maps have y up.
    float hand = dot(cross(n, t), down) < 0.0 ? 1.0 : -1.0;
    t -= n * dot(n, t);
    float size = dot(t, t);
    if (!(size > 1e-24))
        return n;
    t *= inversesqrt(size);
    return normalize(map.x * t + map.y * hand * cross(n, t) + map.z * n);
}

// Share of the first light that arrives: a 3×3 texel wide tent over the shadow map.
float shadow(vec3 n) {
    if (lighting.shadow.z == 0.0)
        return 1.0;
    vec4 place = lighting.shadow_from_world * vec4(position + n * (1.5 * lighting.shadow.x), 1.0);
    float side = lighting.shadow.y;
    vec2 texel = (place.xy * 0.5 + 0.5) * side - 0.5;
    // No caster lies outside the map.
    if (any(lessThan(texel, vec2(1.0))) || any(greaterThan(texel, vec2(side - 3.0))))
        return 1.0;
    ivec2 base = ivec2(floor(texel));
    vec2 part = texel - floor(texel);
    vec4 wx = vec4(1.0 - part.x, 1.0, 1.0, part.x);
    vec4 wy = vec4(1.0 - part.y, 1.0, 1.0, part.y);
    float depth = min(place.z, 1.0);
    // Two sums, so that full light and full shadow are exact.
    float lit = 0.0, blocked = 0.0;
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x) {
            bool arrives = depth <= texelFetch(shadow_map, base + ivec2(x - 1, y - 1), 0).r;
            lit += arrives ? wx[x] * wy[y] : 0.0;
            blocked += arrives ? 0.0 : wx[x] * wy[y];
        }
    return lit / (lit + blocked);
}
#endif

#ifdef PASS_light
layout(location = 0) out vec4 direct_out;
layout(location = 1) out vec4 ambient_out;

struct Surface {
    vec3 normal;
    vec3 to_eye;
    vec3 albedo; // of the diffuse part
    vec3 mirror; // reflectance seen straight on
    float alpha; // roughness squared
};

// Radiance for an irradiance of π.
vec3 reflected(Surface s, vec3 to_light) {
    float nl = dot(s.normal, to_light);
    if (nl <= 0.0)
        return vec3(0.0);
    vec3 half_way = normalize(to_light + s.to_eye);
    float nv = max(dot(s.normal, s.to_eye), 1e-4);
    float nh = clamp(dot(s.normal, half_way), 0.0, 1.0);
    float vh = clamp(dot(s.to_eye, half_way), 0.0, 1.0);
    vec3 fresnel = s.mirror + (1.0 - s.mirror) * pow(1.0 - vh, 5.0);
    float square = s.alpha * s.alpha;
    float peak = nh * nh * (square - 1.0) + 1.0;
    float distribution = square / (peak * peak); // times π
    float visibility = 0.5 / (nl * sqrt(nv * nv * (1.0 - square) + square) + nv * sqrt(nl * nl * (1.0 - square) + square));
    return nl * (s.albedo * (1.0 - fresnel) + fresnel * (distribution * visibility));
}

vec3 light_from(MeshLight light, Surface s) {
    if (light.colour.w == float(MESH_DIRECTIONAL))
        return light.colour.rgb * reflected(s, light.direction.xyz);
    vec3 away = light.position.xyz - position;
    float square = max(dot(away, away), 1e-8);
    vec3 to_light = away * inversesqrt(square);
    float edge = square * light.position.w * light.position.w;
    float reach = clamp(1.0 - edge * edge, 0.0, 1.0) / square;
    if (light.colour.w == float(MESH_SPOT)) {
        float cone = clamp(dot(to_light, light.direction.xyz) * light.cone.x + light.cone.y, 0.0, 1.0);
        reach *= cone * cone;
    }
    return light.colour.rgb * reach * reflected(s, to_light);
}

void main() {
    vec4 base = base_colour();
    vec2 rough_metal = texture(metallic_roughness_map, texcoord, draw.bias).gb;
    vec3 emission = texture(emission_map, texcoord, draw.bias).rgb * material.emission.rgb;
    vec3 smooth_one = smooth_normal();
    Surface s;
    s.to_eye = view_direction();
    s.normal = detailed_normal(smooth_one);
    // Normals that change within a pixel spread highlights (Tokuyoshi and Kaplanyan, JCGT 2021).
    vec3 nx = dFdx(s.normal), ny = dFdy(s.normal);
    if (!is_visible(base.a))
        discard;
    s.normal = towards(s.normal, s.to_eye);
    if ((material.flags & MESH_UNLIT) != 0u) {
        direct_out = vec4(base.rgb, 1.0);
        ambient_out = vec4(0.0);
        return;
    }
    float metallic = clamp(rough_metal.y * material.metallic, 0.0, 1.0);
    float roughness = clamp(rough_metal.x * material.roughness, 0.08, 1.0);
    float spread = min(0.25 * (dot(nx, nx) + dot(ny, ny)), 0.18);
    s.alpha = sqrt(min(roughness * roughness * roughness * roughness + spread, 1.0));
    s.albedo = base.rgb * (1.0 - metallic);
    s.mirror = mix(vec3(0.04), base.rgb, metallic);
    vec3 direct = emission;
    uint count = uint(lighting.shadow.w);
    for (uint i = 0u; i < count; ++i)
        direct += light_from(lighting.lights[i], s) * (i == 0u ? shadow(smooth_one) : 1.0);
    vec3 around = mix(lighting.ambient_down.rgb, lighting.ambient_up.rgb, 0.5 + 0.5 * s.normal.y);
    direct_out = vec4(direct, 1.0);
    ambient_out = vec4(base.rgb * around, 0.0);
}
#endif

#ifdef PASS_geometry
layout(location = MESH_PREVIOUS) in vec3 before;
layout(location = MESH_NEXT) in vec3 after;
layout(location = 0) out vec4 normal_out; // xyz: world, towards the camera; w: view depth, 0 where nothing is
layout(location = 1) out vec4 before_out; // xyz: previous minus current place; w: share of the first light
layout(location = 2) out vec4 after_out;  // xyz: next minus current place

void main() {
    float alpha = base_colour().a;
    vec3 n = smooth_normal();
    vec3 detailed = detailed_normal(n);
    if (!is_visible(alpha))
        discard;
    vec3 seen = towards(draw.detail != 0u ? detailed : n, view_direction());
    bool lit = lighting.shadow.z == 0.0 || dot(n, lighting.lights[0].direction.xyz) > 0.0;
    normal_out = vec4(seen, view_depth());
    before_out = vec4(before, lit ? shadow(n) : 0.0);
    after_out = vec4(after, 0.0);
}
#endif
