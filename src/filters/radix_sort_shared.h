// Constants of the radix sort's passes, shared by radix_sort.cpp and radix_sort.comp.
#ifndef SFUMATO_RADIX_SORT_SHARED_H
#define SFUMATO_RADIX_SORT_SHARED_H

#include "shared.h"

#ifdef __cplusplus
namespace sfumato::gpu {
using uint = uint32_t;
#endif

struct RadixSortConstants {
    uint capacity;   // most pairs
    uint count_word; // where the count stands, see device_count.glsl
    uint totals;     // word of the table at which the 256 digit totals begin
    uint shift;      // of the digit at hand, bits
};

#ifdef __cplusplus
} // namespace sfumato::gpu
#endif

#endif
