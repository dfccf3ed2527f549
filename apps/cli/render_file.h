// Rendered frames as files whose channels and attributes say what they hold, so that apply and inspect find them.
#pragma once

#include "apps/cli/effect_chain.h"
#include "media/exr_file.h"
#include "sfumato/frame.h"
#include "sfumato/image.h"

#include <map>
#include <string>
#include <vector>

namespace sfumato::cli {

// A pass as the device gave it back: RGBA, or as many components as the format has.
struct RenderedPass {
    uint32_t components = 0;
    std::vector<float> values;
    std::vector<std::string> channels = {}; // what an effect's result is called
};

struct RenderedFrame {
    Extent extent;
    int number = 0;
    double frames_per_second = 24.0;
    Camera camera;
    std::map<std::string, RenderedPass> passes; // "colour", "depth", "normal", "velocity", "next_velocity", "truth", …
};

// The passes that are there as channels: R G B A, Z, N.X N.Y N.Z, sfumato_velocity.X Y Z W, and layers by their names;
// true visibility as AO, true bent normals as bent_normal.X Y Z, both within the layer `truth` if an effect has made
// AO.
media::ExrImage rendered_image(const RenderedFrame& frame, bool full_float);

} // namespace sfumato::cli
