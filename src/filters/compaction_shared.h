// Constants of the compaction's passes, shared by compaction.cpp and compaction.comp.
#ifndef SFUMATO_COMPACTION_SHARED_H
#define SFUMATO_COMPACTION_SHARED_H

#include "shared.h"

#ifdef __cplusplus
namespace sfumato::gpu {
using uint = uint32_t;
#endif

struct CompactionConstants {
    uint capacity;   // most flags
    uint count_word; // where the count stands, see device_count.glsl
    uint group_size_0;
    uint group_size_1;
    uint group_size_2;
    uint group_size_3;
    uint padding_0;
    uint padding_1;
};

#ifdef __cplusplus
} // namespace sfumato::gpu
#endif

#endif
