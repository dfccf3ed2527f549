// Runs motion blur on the device and in the reference from one description of the input.
#pragma once

#include "apps/common/device.h"
#include "sfumato/sfumato.h"
#include "tests/reference/motion_blur_reference.h"

#include <gtest/gtest.h>

#include <functional>
#include <optional>

namespace sfumato::test {

// An input in the reference's own terms: grids in double; what is empty is absent.
using BlurInput = reference::MotionBlurInput;

// The device's picture for the same input and parameters: reference::Grid<4> of what was read back.
reference::Grid<4> blur_on_device(const BlurInput& input, const MotionBlurParameters& parameters,
                                  const Frame& frame = {}, bool subgroups = true);

// The reference's settings that mean the same as the parameters.
reference::MotionBlurSettings settings_of(const MotionBlurParameters& parameters, const Frame& frame = {});

// A textured picture with a disc that moves in front of a moving background beside a still pillar.
BlurInput disc_scene(int width, int height);

// The same texture everywhere, one depth, one velocity.
BlurInput pan_scene(int width, int height, double velocity_x, double velocity_y);

struct Difference {
    double root_mean_square = 0.0;
    double largest = 0.0;
    double share_above = 0.0; // of pixels that differ by more than `threshold`
};
Difference difference(const reference::Grid<4>& a, const reference::Grid<4>& b, double threshold = 2e-3);

} // namespace sfumato::test
