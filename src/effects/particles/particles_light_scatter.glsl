// One layer's step of light that spreads as it goes on: what is left of the light after this layer is blurred and
// becomes the next layer's light. Blurring light, not optical depth, keeps its sum. What enters a layer stands as
// optical depth in the layer before, which nothing reads any more; a last step without a layer writes the last.

layout(local_size_x = 16, local_size_y = 16) in;

layout(set = 0, binding = 0) readonly buffer Facts { uint data[]; } facts;
layout(set = 0, binding = 1) buffer Volume { uint data[]; } volume;
layout(set = 0, binding = 2) readonly buffer Before { float data[]; } before; // light that enters the layer
layout(set = 0, binding = 3) writeonly buffer After { float data[]; } after;

#include "particles_light_volume.glsl"

const int reach = 4;
const uint wide = 16u + 2u * uint(reach);

shared float left[wide * wide];

// A bell of the given variance in texels. Below half a texel three taps have exactly this variance.
float[reach + 1] bell(float variance) {
    if (variance <= 0.5)
        return float[](1.0 - variance, 0.5 * variance, 0.0, 0.0, 0.0);
    float weights[reach + 1];
    float total = 0.0;
    [[unroll]] for (int k = 0; k <= reach; ++k) {
        weights[k] = exp(-0.5 * float(k * k) / variance);
        total += k == 0 ? weights[k] : 2.0 * weights[k];
    }
    [[unroll]] for (int k = 0; k <= reach; ++k)
        weights[k] /= total;
    return weights;
}

void load_light(ivec2 origin, uint start, float unit) {
    for (uint i = gl_LocalInvocationIndex; i < wide * wide; i += 256u) {
        const ivec2 at = origin + ivec2(i % wide, i / wide);
        float here = 1.0; // outside the buffer nothing is in the light's way
        if (all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, ivec2(constants.side)))) {
            const uint word = uint(at.y) * constants.side + uint(at.x);
            here = exp(-float(volume.data[start + word]) * unit);
            if (constants.step_layer > 0u)
                here *= before.data[word];
        }
        left[i] = here;
    }
}

void main() {
    const uint start = layer_start(constants.step_light, constants.step_layer);
    const float unit = uintBitsToFloat(facts.data[fact_unit]);
    const uint word = gl_GlobalInvocationID.y * constants.side + gl_GlobalInvocationID.x;
    const bool is_inside = all(lessThan(gl_GlobalInvocationID.xy, uvec2(constants.side)));
    if (constants.step_layer > 0u && is_inside) // e^-16 is no light at all
        volume.data[start - constants.area + word] = uint(-log(clamp(before.data[word], 1.125e-7, 1.0)) / unit);
    if (constants.step_layer == constants.layers)
        return;
    load_light(ivec2(gl_WorkGroupID.xy) * 16 - reach, start, unit);
    barrier();
    const LightSpace space = space_of(constants.step_light);
    const float weights[reach + 1] =
        bell(clamp(constants.layer_spread * space.spacing / (space.texel * space.texel), 0.0, 8.0));
    const ivec2 here = ivec2(gl_LocalInvocationID.xy) + reach;
    float sum = 0.0;
    for (int y = -reach; y <= reach; ++y)
        for (int x = -reach; x <= reach; ++x)
            sum += weights[abs(x)] * weights[abs(y)] * left[uint(here.y + y) * wide + uint(here.x + x)];
    if (is_inside)
        after.data[word] = sum;
}
