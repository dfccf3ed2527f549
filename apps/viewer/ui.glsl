// passes: vertex fragment
// Dear ImGui's triangles: positions in pixels, one texture, colours as a display takes them.
#version 450

#ifdef PASS_vertex
#pragma shader_stage(vertex)
layout(location = 0) in vec2 position;
layout(location = 1) in vec2 texture_place;
layout(location = 2) in vec4 colour;
layout(push_constant) uniform Transform { vec2 scale; vec2 offset; };
layout(location = 0) out vec4 shade;
layout(location = 1) out vec2 place;

void main() {
    shade = colour;
    place = texture_place;
    gl_Position = vec4(position * scale + offset, 0.0, 1.0);
}
#endif

#ifdef PASS_fragment
#pragma shader_stage(fragment)
layout(set = 0, binding = 0) uniform sampler2D font;
layout(location = 0) in vec4 shade;
layout(location = 1) in vec2 place;
layout(location = 0) out vec4 result;

void main() {
    result = shade * texture(font, place);
}
#endif
