// A camera that stands still, as text on the command line.
#pragma once

#include "scene/scene.h"
#include "sfumato/result.h"

#include <string>

namespace sfumato::cli {

inline constexpr const char* viewpoint_doc =
    "A camera in place of the scene's own: X,Y,Z of the eye, X,Y,Z of what it looks at[,vertical degrees]";

// Six or seven numbers; `view_angle` stands for a seventh that is not there. Error (invalid_argument): anything else,
// or a camera that looks nowhere or straight up or down.
Result<scene::View> parse_viewpoint(const std::string& text, double view_angle);

// Rounded to what anyone would type: render what parse_viewpoint makes of it, and the text tells exactly that.
std::string viewpoint_text(const scene::View& view);

scene::CameraPath standing_at(const scene::View& view);

} // namespace sfumato::cli
