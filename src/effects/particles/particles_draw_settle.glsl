// From the extremes of all particles: how keys are scaled, where each light's shadow buffer lies, and what one unit of
// it is worth.

layout(local_size_x = 32) in;

layout(constant_id = 0) const uint light_count = 1u;

layout(set = 0, binding = 0) buffer Facts { uint data[]; } facts;

void store(uint word, float value) { facts.data[word] = floatBitsToUint(value); }

void settle_light(uint light) {
    const uint at = fact_light + fact_light_words * light;
    vec3 low = vec3(0), high = vec3(0);
    if (facts.data[at] <= facts.data[at + 3u]) { // some particle is alive
        low = vec3(from_ordered(facts.data[at]), from_ordered(facts.data[at + 1u]), from_ordered(facts.data[at + 2u]));
        high = vec3(from_ordered(facts.data[at + 3u]), from_ordered(facts.data[at + 4u]),
                    from_ordered(facts.data[at + 5u]));
    }
    // Texels grow in steps and lie on a grid of the world, so that shadows stand still while the bounds tremble. A rim
    // stays free: what lies outside is not shadowed.
    const vec2 extent = high.xy - low.xy;
    const float wanted = max(max(extent.x, extent.y), 1e-6) / (float(constants.side) - 4.0);
    const float texel = exp2(ceil(log2(wanted) * 8.0) / 8.0);
    const vec2 corner = (floor(low.xy / texel) - 1.0) * texel;
    // Where all lie at one depth none shadows another: it has to be a face of every row's.
    const float least = max(1e-6, 1e-6 * abs(low.z));
    const float shift = high.z - low.z > least * float(constants.layers) ? constants.row_shift : 0.0;
    const float spacing = max((high.z - low.z) / (float(constants.layers) - shift), least);
    const uint to = fact_space + fact_space_words * light;
    store(to, corner.x);
    store(to + 1u, corner.y);
    store(to + 2u, texel);
    store(to + 3u, low.z);
    store(to + 4u, spacing);
    store(to + 5u, shift);
}

void main() {
    const uint thread = gl_LocalInvocationIndex;
    if (thread < light_count)
        settle_light(thread);
    if (thread != 0u)
        return;
    float low = 0.0, high = 0.0;
    if (facts.data[fact_key_low] <= facts.data[fact_key_high]) {
        low = from_ordered(facts.data[fact_key_low]);
        high = from_ordered(facts.data[fact_key_high]);
    }
    store(fact_key_offset, low);
    store(fact_key_scale, high > low ? constants.key_range / (high - low) : 0.0);
    // If all particles fell on one texel their sum would be at most this: no sum can overflow. A particle smaller than
    // a texel adds up to 2/3 pi of its depth to one texel, which the two spare bits hold.
    const float all_depth = float(facts.data[fact_optical]) / 16.0;
    store(fact_unit, max(exp2(ceil(log2(all_depth + 1.0)) - 30.0), 1.0 / 4194304.0));
}
