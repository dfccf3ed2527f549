// Checks of what a frame is asked for, and the moments of its truth.
#include "scene/scene_request.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

namespace sfumato::scene {
namespace {

template <class Fail>
Result<void> check_occlusion(const OcclusionTruth& occlusion, const Fail& fail) {
    if (occlusion.rays < 1 || occlusion.rays > 65536)
        return fail(std::to_string(occlusion.rays) + " rays a pixel, 1 to 65536 are possible");
    if (!(occlusion.radius > 0.0 && occlusion.radius <= 1e6))
        return fail("rays as long as " + std::to_string(occlusion.radius) + ", above 0 to 1000000 is possible");
    return {};
}

template <class Fail>
Result<void> check_lens(const Lens& lens, const Fail& fail) {
    if (!(lens.near_plane > 0.0 && lens.far_plane > lens.near_plane && std::isfinite(lens.far_plane)))
        return fail("near plane at " + std::to_string(lens.near_plane) + ", far plane at " +
                    std::to_string(lens.far_plane) + ": both must be above 0, the far one beyond the near one");
    if (!std::isfinite(lens.orthographic_height) || !std::isfinite(lens.shift_x) || !std::isfinite(lens.shift_y))
        return fail("the lens has a height or a shift that is not finite");
    return {};
}

} // namespace

Result<Extent> common_extent(const SceneImages& images) {
    std::optional<Extent> extent;
    for (const Image& image : host_images(images)) {
        if (!image)
            continue;
        if (extent && *extent != image.extent)
            return Error{ErrorCode::invalid_argument, "the scene's images differ in extent: " + extent_text(*extent) +
                                                          " and " + extent_text(image.extent)};
        extent = image.extent;
    }
    if (!extent)
        return Error{ErrorCode::invalid_argument, "none of the scene's images is present"};
    return *extent;
}

Result<void> check_request(const SceneInfo& info, const Lens& lens, double frame, const RenderOptions& options) {
    const auto fail = [&](const std::string& what) {
        return Error{ErrorCode::invalid_argument, "scene " + info.name + ": " + what};
    };
    if (!std::isfinite(frame))
        return fail("the frame's time is not finite");
    if (options.samples < 1 || options.samples > 8)
        return fail(std::to_string(options.samples) + " samples a side, 1 to 8 are possible");
    const Shutter& shutter = options.shutter;
    if (shutter.sub_frames < 1 || shutter.sub_frames > 256)
        return fail(std::to_string(shutter.sub_frames) + " sub-frames, 1 to 256 are possible");
    if (!(shutter.open >= 0.0 && shutter.open <= 16.0))
        return fail("the shutter is open for " + std::to_string(shutter.open) + " frames, 0 to 16 are possible");
    if (auto checked = check_lens(lens, fail); !checked)
        return checked;
    return check_occlusion(options.occlusion, fail);
}

std::vector<Moment> shutter_moments(const Shutter& shutter, double frame) {
    const double first = shutter.position == ShutterPosition::start    ? 0.0
                         : shutter.position == ShutterPosition::centre ? -0.5
                                                                       : -1.0;
    std::vector<Moment> moments;
    double weights = 0.0;
    for (int i = 0; i < shutter.sub_frames; ++i) {
        const double place = (i + 0.5) / shutter.sub_frames;
        const double weight = shutter.curve ? std::max(shutter.curve(place), 0.0) : 1.0;
        weights += weight;
        // Until there is any weight, the newest moment stands for the mean.
        const float share = i == 0 || weights == 0.0 ? 1.0f : static_cast<float>(weight / weights);
        moments.push_back({frame + (first + place) * shutter.open, share});
    }
    return moments;
}

} // namespace sfumato::scene
