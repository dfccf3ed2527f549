// What is worth saying about the effects that the project has. An effect without an entry gets a section all the same.
#pragma once

#include "apps/demo/tour.h"

#include <string>
#include <string_view>
#include <vector>

namespace sfumato::demo {

struct KnownScene {
    std::string name, text;
    std::vector<std::string> presets; // none: all
};

// A picture beside those of the presets.
struct KnownPicture {
    std::string name, doc;
    Arguments arguments; // of sfumato render, after scene, output and size
};

struct KnownView {
    std::string name, doc;
    std::string preset; // "": the usual one
};

struct KnownEffect {
    std::string name, text;
    std::vector<KnownScene> scenes;
    std::vector<KnownPicture> pictures;
    std::string presets_heading; // not "": what presets show is compared apart from the scene's colour
    // None: those that the bench writes, which are encoded for display only where the effect's own result is.
    std::vector<KnownPicture> truths;
    std::vector<KnownView> views;
    std::vector<Figure> figures;
    std::string figures_text;
    std::string usual = {};                 // preset of views and of the first comparison; "": high, or the first
    std::vector<std::string> for_gpus = {}; // presets that take minutes on a software device, and are left out there
};

// An empty entry for an effect that is not in the table.
const KnownEffect& known_effect(std::string_view name);

} // namespace sfumato::demo
