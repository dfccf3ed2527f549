// The pictures as they appear in the window: two of them with a divider between, the scene's values made visible.
#pragma once

#include "apps/common/device.h"
#include "apps/viewer/model.h"
#include "sfumato/executor.h"

#include <memory>

namespace sfumato::viewer {

struct Rectangle {
    float x = 0.0f, y = 0.0f, width = 0.0f, height = 0.0f;

    bool contains(float px, float py) const { return px >= x && py >= y && px < x + width && py < y + height; }
};

struct Side {
    Image image; // absent: black
    PictureKind kind = PictureKind::colour;
};

struct Composition {
    Side left, right;
    Image compared, truth; // of differences
    Rectangle area;        // of the picture on the canvas
    float divider = -1e6f; // canvas x; left of the area: only the right picture shows
    double exposure = 0.0; // stops
    double gain = 4.0;
    double near_depth = 5.0;
};

class Composer {
  public:
    static Result<std::unique_ptr<Composer>> create(Context& context);

    // Fills the whole canvas, a storage image in GENERAL. The previous call's commands have finished.
    Result<void> record(VkCommandBuffer commands, const Composition& composition, const Image& canvas);

  private:
    explicit Composer(std::unique_ptr<Executor> executor) : executor_(std::move(executor)) {}
    std::unique_ptr<Executor> executor_;
    uint64_t count_ = 0;
};

} // namespace sfumato::viewer
