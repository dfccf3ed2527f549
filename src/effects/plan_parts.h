// What the plans of several effects say alike.
#pragma once

#include "sfumato/plan.h"
#include "shared.h"

namespace sfumato {

inline Access read(ResourceId resource) {
    return {resource, AccessKind::fetch, 0, false};
}

// The size of an input to that of what the effect works on; inputs may have any. 0 for an absent one.
inline gpu::vec2 ratio(const Image& image, Extent extent) {
    return {static_cast<float>(image.extent.width) / static_cast<float>(extent.width),
            static_cast<float>(image.extent.height) / static_cast<float>(extent.height)};
}

} // namespace sfumato
