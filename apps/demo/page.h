// The page: one HTML file that holds its pictures itself and fetches nothing.
#pragma once

#include "apps/demo/tour.h"

#include <string>

namespace sfumato::demo {

// Reads the pictures; one that is missing or broken is told on the page like any other failure.
std::string page_of(const Settings& settings, Tour& tour);

} // namespace sfumato::demo
