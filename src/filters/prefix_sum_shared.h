// Constants of the prefix sum's passes, shared by prefix_sum.cpp and prefix_sum.comp.
#ifndef SFUMATO_PREFIX_SUM_SHARED_H
#define SFUMATO_PREFIX_SUM_SHARED_H

#include "shared.h"

#ifdef __cplusplus
namespace sfumato::gpu {
using uint = uint32_t;
#endif

struct PrefixSumConstants {
    uint capacity;   // most numbers
    uint count_word; // where the count stands, see device_count.glsl
    uint padding_0;
    uint padding_1;
};

#ifdef __cplusplus
} // namespace sfumato::gpu
#endif

#endif
