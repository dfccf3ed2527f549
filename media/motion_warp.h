// Proof of a motion convention: the vectors must carry the neighbouring frame's picture onto this one.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "motion_convention.h"
#include "planes.h"
#include "sfumato/result.h"

namespace sfumato::media {

// All pictures have the size of `colour`. What is not at hand is null; one neighbour's colour is needed.
struct WarpInput {
    const Planes* colour = nullptr; // linear
    const Planes* motion = nullptr; // the channels as the file has them
    const Planes* companion = nullptr;
    const Planes* previous_colour = nullptr;
    const Planes* next_colour = nullptr;
    const std::vector<float>* depth = nullptr; // linear, greater is farther; used with the neighbour's
    const std::vector<float>* previous_depth = nullptr;
    const std::vector<float>* next_depth = nullptr;
    int screen_width = 0; // what ndc and uv refer to; 0: the picture's own size
    int screen_height = 0;
};

enum class WarpVerdict { confirmed, wrong, inconclusive };

// Another reading of the same channels.
struct WarpHypothesis {
    MotionConvention convention;
    std::string change;        // against the checked convention: "flip-y", "swap", "time reversed, scale=2"
    double error = 0.0;        // over all pixels used
    double local_error = 0.0;  // over those where it differs from the checked convention by more than a pixel
    double local_chosen = 0.0; // the checked convention's error there
    size_t differing = 0;      // how many those are
};

// Errors are mean absolute differences of tone-mapped colour c / (1 + c), lightly blurred against noise, each pixel's
// cut off at 0.25 so that uncovered background does not decide.
struct WarpReport {
    WarpVerdict verdict = WarpVerdict::inconclusive;
    size_t moving = 0; // pixels that move by half a pixel or more
    size_t used = 0;   // those with enough detail to tell, twice where both neighbours are given
    double error_still = 0.0;
    double error_chosen = 0.0;
    WarpHypothesis best_other;
    double margin =
        0.0; // the best other's error over the chosen one's where they differ; above 1 speaks for the choice
    std::vector<WarpHypothesis> others; // all, lowest error first
    std::vector<std::string> reasons;

    std::string text() const; // "confirmed: ...", "wrong: better explained by flip-y (blender,flip-y): ..."
};

// Scores `convention` against every combination of turned signs, swapped axes, and half or double length (turned both
// signs at once is turned time), and with four channels also the pairs exchanged. Deterministic. Errors:
// `invalid_argument` for missing or unequal pictures.
Result<WarpReport> check_by_warping(const WarpInput& input, const MotionConvention& convention);

} // namespace sfumato::media
