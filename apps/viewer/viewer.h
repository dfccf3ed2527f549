// The interactive viewer: in a window, or without one for pictures of what the window would show.
#pragma once

#include "apps/cli/effect_chain.h"
#include "sfumato/image.h"
#include "sfumato/result.h"

#include <functional>
#include <optional>
#include <string>

namespace sfumato::viewer {

struct ViewerOptions {
    std::string scene;     // a name, or the path of a .gltf or .glb
    std::string animation; // of a model: name, number or `none`; "": the first
    bool no_ground = false;
    cli::ChainOptions chain;
    std::string save_config; // written once the effects are known
    std::string device;
    Extent size = {1280, 720}; // of the window, panels included
    double scale = 1.0;        // picture pixels for one of the window's
    std::optional<int> frame;  // else the scene's key frame
    std::string viewpoint;     // as --viewpoint takes it; "": the scene's own camera
    int samples = 2;
    int preroll = 8;
    std::string left = "before", right = "result"; // pictures by id
    double split = 0.5;                            // where the divider is, 0…1; below 0: no divider
    std::string truth;                             // "", "motion-blur" or "ambient-occlusion"
    bool play = false;

    bool headless = false;
    int turns = 1;       // headless: turns to run
    bool panels = false; // headless: with the panels
    std::string output;  // headless: the picture; else what the panel offers to save to

    bool validate = false;  // under the validation layer; its messages are an error
    std::string widget_log; // for tests, see WidgetLog
};

// Runs until the window is closed, or for so many turns. `note` receives
// what is worth telling: the device, or without a window what was written and its distance from the truth. Errors:
// invalid_argument (names and values in the options), input (files), everything else is the device's or the display's.
Result<void> run_viewer(const ViewerOptions& options, const std::function<void(const std::string&)>& note);

} // namespace sfumato::viewer
