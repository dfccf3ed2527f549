// The plan of ambient occlusion, and the numbers it rests on.
#pragma once

#include "sfumato/effects/ambient_occlusion.h"

#include <string>

namespace sfumato {

// Expects validated input.
Plan plan_ambient_occlusion(const Frame& frame, const AmbientOcclusionParameters& parameters,
                            const AmbientOcclusionImages& images);

// What is wrong with a combination of parameters and images, or "".
std::string check_ambient_occlusion(const Frame& frame, const AmbientOcclusionParameters& parameters,
                                    const AmbientOcclusionImages& images);

// What the mean over an estimator's taps is multiplied by, so that intensity 1 gives the ray-traced obscurance of the
// same falloff. docs/effects/ambient-occlusion.md has the fit and its residual.
float occlusion_calibration(const AmbientOcclusionParameters& parameters);

// Turns of a spiral of so many taps that spreads them best (SAO's table of least discrepancy).
int spiral_turns(int taps);

} // namespace sfumato
