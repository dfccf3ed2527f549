// Sfumato: scalable screen-space effects on Vulkan compute. The whole integration:
//
//     // Once, on your device (created with sfumato::requirements().features enabled):
//     sfumato::ContextInfo info;
//     info.instance = host.instance;
//     info.physical_device = host.physical_device;
//     info.device = host.device;
//     info.get_instance_proc_addr = vkGetInstanceProcAddr;
//     info.get_device_proc_addr = vkGetDeviceProcAddr;
//     auto context = sfumato::Context::create(info);
//     if (!context)
//         return fail(context.error().message.c_str());
//     auto motion_blur = sfumato::MotionBlur::create(**context);
//     if (!motion_blur)
//         return fail(motion_blur.error().message.c_str());
//     // Every frame, into your command buffer; your images stay in the layout they are in:
//     sfumato::Frame frame;
//     frame.index = frame_index;
//     frame.time_step = seconds;
//     sfumato::MotionBlurParameters parameters; // or *sfumato::preset<sfumato::MotionBlurParameters>("low")
//     sfumato::MotionBlurImages images;
//     images.colour = as_image(colour); // sfumato::Image{image, view, format, {width, height}, layout}
//     images.velocity = as_image(velocity);
//     images.output = as_image(output);
//     if (auto recorded = (*motion_blur)->record(commands, frame, parameters, images); !recorded)
//         return fail(recorded.error().message.c_str());
//
// The effect instance owns the history of one stream of frames; the context must outlive it, your device the context.
#pragma once

#include "sfumato/buffer.h"
#include "sfumato/context.h"
#include "sfumato/effect.h"
#include "sfumato/effects/ambient_occlusion.h"
#include "sfumato/effects/motion_blur.h"
#include "sfumato/effects/particles.h"
#include "sfumato/executor.h"
#include "sfumato/frame.h"
#include "sfumato/image.h"
#include "sfumato/parameters.h"
#include "sfumato/plan.h"
#include "sfumato/result.h"
