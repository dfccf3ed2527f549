// Tables and plot of what sfumato-bench measured.
#pragma once

#include "apps/demo/tour.h"

#include <string>

namespace sfumato::demo {

// Everything that was measured of an effect, as HTML; says what is missing.
std::string measured_section(const EffectTour& effect, bool is_software);

// What a picture's caption says about its error, "" if it was not measured.
std::string figure_text(const EffectTour& effect, const std::string& scene, const std::string& picture);

// A command with a button that copies it.
std::string command_html(const Arguments& command, const std::string& what);

} // namespace sfumato::demo
