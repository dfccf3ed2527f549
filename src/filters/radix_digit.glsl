// The digit that a pass of the radix sort looks at.
#ifndef RADIX_DIGIT_GLSL
#define RADIX_DIGIT_GLSL

layout(constant_id = 0) const uint digit_bits = 8; // 1…8

const uint radix_bins = 256u;

uint digit_of(uint key) { return bitfieldExtract(key, int(constants.shift), int(digit_bits)); }

#endif
