// How far a picture is from a reference.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "planes.h"
#include "sfumato/result.h"

namespace sfumato::media {

// One byte a pixel, 1 inside.
using Mask = std::vector<uint8_t>;

// sRGB-encodes linear colour and clamps it to [0, 1]; NaN stays. Depth, visibility and the like are compared as they
// are.
Planes encode_for_display(const Planes& linear);

struct Metrics {
    double psnr = 0.0; // dB for a peak of 1, from the mean squared error of all channels, at most 120
    double rmse = 0.0;
    double bias = 0.0;      // mean of picture minus reference
    double max_error = 0.0; // largest absolute difference of any channel
    double ssim = 0.0;      // see structural_similarity(); NaN if the picture is smaller than its window
    size_t pixels = 0;      // compared; with none, all figures are NaN
    size_t non_finite = 0;  // pixels with NaN or infinity in either picture: counted here and left out elsewhere
};

struct MetricOptions {
    const Mask* mask = nullptr; // only these pixels
    bool ssim = true;           // the slow one
};

// Both pictures need the same size and number of channels (`invalid_argument`). Values are compared as given.
Result<Metrics> measure(const Planes& picture, const Planes& reference, const MetricOptions& options = {});

// Structural similarity (Wang et al. 2004): Gaussian window of 11x11, sigma 1.5, K1 = 0.01, K2 = 0.03, peak 1, on every
// channel; the mean over channels and over the windows that lie wholly in the picture and whose centre is in the mask.
double structural_similarity(const Planes& picture, const Planes& reference, const Mask* mask = nullptr);

// Where motion changes the picture: the mean squared difference over channels exceeds `threshold`, grown by `grow`
// pixels up, down, left and right, step by step. Meant for display-encoded pictures, sharp and truly blurred.
Mask moving_region(const Planes& sharp, const Planes& truth, double threshold = 0.002, int grow = 3);
Mask inverse(const Mask& mask);

// Absolute differences, times `gain`.
Planes difference_picture(const Planes& picture, const Planes& reference, float gain = 1.0f);

} // namespace sfumato::media
