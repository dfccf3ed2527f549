// The plan of motion blur, and the numbers it rests on.
#pragma once

#include "sfumato/effects/motion_blur.h"

namespace sfumato {

// Expects validated input.
Plan plan_motion_blur(const Frame& frame, const MotionBlurParameters& parameters, const MotionBlurImages& images);

// The open fraction of this frame's interval, after the frame rate mode and generated frames.
float effective_shutter(const Frame& frame, const MotionBlurParameters& parameters);

// Pixels; a multiple of 8 from 8 to 32.
uint32_t tile_size(const MotionBlurParameters& parameters, Extent extent);

} // namespace sfumato
