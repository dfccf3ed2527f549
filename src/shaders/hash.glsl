// Bits that look like chance, from bits that do not.
#ifndef HASH_GLSL
#define HASH_GLSL

uint mix_bits(uint h) {
    h = (h ^ h >> 16) * 0x7feb352du;
    h = (h ^ h >> 15) * 0x846ca68bu;
    return h ^ h >> 16;
}

#endif
