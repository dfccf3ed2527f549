// Reading and writing a camera that stands still.
#include "apps/cli/viewpoint.h"

#include "apps/cli/exit_code.h"
#include "scene/vec3.h"

#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <vector>

namespace sfumato::cli {

Result<scene::View> parse_viewpoint(const std::string& text, double view_angle) {
    const auto wrong = [&](const char* why) { return usage_error(fmt::format("--viewpoint {}: {}", text, why)); };
    std::vector<double> numbers;
    const char* end = text.data() + text.size();
    for (const char* at = text.data();; ++at) {
        double value = 0.0;
        const auto [last, failed] = std::from_chars(at, end, value);
        if (failed != std::errc() || !(std::abs(value) <= 1e9))
            return wrong("write six or seven numbers with commas between them, as in 4,2,6,0,1,0,40");
        numbers.push_back(value);
        at = last;
        if (at == end)
            break;
        if (*at != ',')
            return wrong("write six or seven numbers with commas between them, as in 4,2,6,0,1,0,40");
    }
    if (numbers.size() != 6 && numbers.size() != 7)
        return wrong("the eye's place and what it looks at are six numbers, and a view angle may follow");
    using scene::operator-;
    scene::View view;
    view.eye = {numbers[0], numbers[1], numbers[2]};
    view.forward = scene::Vec3{numbers[3], numbers[4], numbers[5]} - view.eye;
    view.view_angle = numbers.size() == 7 ? numbers[6] : view_angle;
    if (!(view.view_angle >= 1.0 && view.view_angle <= 170.0))
        return wrong("the view angle must lie between 1 and 170 degrees");
    const double length = std::sqrt(dot(view.forward, view.forward));
    if (!(length > 1e-6))
        return wrong("the eye is where it looks at");
    if (std::abs(view.forward.y) > 0.99999 * length)
        return wrong("the camera must not look straight up or down");
    return view;
}

std::string viewpoint_text(const scene::View& view) {
    using scene::operator+;
    using scene::operator*;
    // As far off as the eye is from the origin, so that seven digits are fine enough for the direction at any scale.
    const double distance = std::max(1.0, std::sqrt(dot(view.eye, view.eye)));
    const scene::Vec3 target = view.eye + scene::normalised(view.forward) * distance;
    return fmt::format("{:.7g},{:.7g},{:.7g},{:.7g},{:.7g},{:.7g},{:.5g}", view.eye.x, view.eye.y, view.eye.z, target.x,
                       target.y, target.z, view.view_angle);
}

scene::CameraPath standing_at(const scene::View& view) {
    return [view](double) { return view; };
}

} // namespace sfumato::cli
