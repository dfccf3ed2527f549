// What the host gets: visibility, softened shadow, colour with the visibility applied. Part of whichever pass is last.

layout(constant_id = 20) const uint application = 0; // none, ambient, everything
layout(constant_id = 21) const bool has_output = false;
layout(constant_id = 22) const bool has_soft_shadow = false;
layout(constant_id = 23) const bool shows_shadow = false; // a debug view travels there

layout(set = 0, binding = 8) uniform sampler2D colour_image;
layout(set = 0, binding = 9) uniform sampler2D ambient_image;
layout(set = 0, binding = 10) uniform writeonly image2D visibility_image;
layout(set = 0, binding = 11) uniform writeonly image2D soft_shadow_image;
layout(set = 0, binding = 12) uniform writeonly image2D output_image;

void finish(ivec2 pixel, float raw_visibility, float shadow) {
    const float clamped = clamp(shows_shadow ? shadow : raw_visibility, 0.0, 1.0);
    const float visibility = constants.power == 1.0 ? clamped : pow(clamped, constants.power);
    imageStore(visibility_image, pixel, vec4(visibility, 0, 0, 1));
    if (has_soft_shadow)
        imageStore(soft_shadow_image, pixel, vec4(shadow, 0, 0, 1));
    if (has_output) {
        vec4 colour = sane(texelFetch(colour_image, scaled(pixel, constants.colour_ratio), 0));
        if (application == 1) {
            const vec4 ambient = sane(texelFetch(ambient_image, scaled(pixel, constants.ambient_ratio), 0));
            colour.rgb -= (1.0 - visibility) * ambient.rgb;
        } else if (application == 2) {
            colour.rgb *= visibility;
        }
        imageStore(output_image, pixel, colour);
    }
}
