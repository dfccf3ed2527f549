// The facts before any particle was looked at.

layout(local_size_x = 128) in;

layout(set = 0, binding = 0) writeonly buffer Facts { uint data[]; } facts;

void main() {
    const uint word = gl_GlobalInvocationID.x;
    if (word >= fact_words)
        return;
    const bool is_lowest = word == fact_key_low ||
                           (word >= fact_light && word < fact_key_offset && (word - fact_light) % fact_light_words < 3u);
    facts.data[word] = is_lowest ? 0xffffffffu : 0u;
}
