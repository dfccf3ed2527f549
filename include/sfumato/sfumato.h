// Sfumato: scalable screen-space effects on Vulkan compute.
#pragma once

#include "sfumato/context.h"
#include "sfumato/effect.h"
#include "sfumato/effects/motion_blur.h"
#include "sfumato/executor.h"
#include "sfumato/frame.h"
#include "sfumato/image.h"
#include "sfumato/parameters.h"
#include "sfumato/plan.h"
#include "sfumato/result.h"
