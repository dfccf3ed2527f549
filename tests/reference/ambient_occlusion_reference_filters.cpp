// What happens to an estimate: bilateral filter, temporal filter, enlargement, application.
#include "tests/reference/ambient_occlusion_reference.h"

#include <cmath>
#include <utility>

namespace sfumato::reference {
namespace {

double lerp(double a, double b, double t) {
    return a + (b - a) * t;
}

// Column-major, as the library has them.
std::array<double, 4> transformed(const Matrix4& m, const std::array<double, 4>& v) {
    std::array<double, 4> result{};
    for (size_t row = 0; row < 4; ++row)
        for (size_t column = 0; column < 4; ++column)
            result[row] += double{m[4 * column + row]} * v[column];
    return result;
}

// The inverse of a rotation and translation.
std::array<double, 4> world_from_view(const Matrix4& view, const Place& p) {
    const double moved[3] = {p.x - double{view[12]}, p.y - double{view[13]}, p.z - double{view[14]}};
    std::array<double, 4> result = {0, 0, 0, 1};
    for (size_t axis = 0; axis < 3; ++axis)
        for (size_t row = 0; row < 3; ++row)
            result[axis] += double{view[4 * axis + row]} * moved[row];
    return result;
}

} // namespace

// On a plane 1/z (perspective) or z (orthographic) is linear in the image. 0 is sky.
double AmbientOcclusionReference::planar(double z) const {
    return z == sky ? 0.0 : perspective_ ? 1.0 / z : z;
}

OcclusionSignal AmbientOcclusionReference::filtered_along(const OcclusionSignal& signal, int dx, int dy) const {
    const AmbientOcclusionParameters& p = parameters_;
    const int step = std::min(p.filter_step, std::max(1, 8 / std::max(1, p.filter_radius)));
    OcclusionSignal result = signal;
    for (int y = 0; y < signal.height; ++y)
        for (int x = 0; x < signal.width; ++x) {
            const OcclusionTexel& here = signal.at(x, y);
            const double w = planar(here.z);
            // The slope: the smaller of the two one-sided differences of planar depth, of equal ones the second. Off
            // the image there is none.
            double slope = 0.0, smallest = sky;
            for (const int sign : {-1, 1}) {
                const int qx = x + sign * dx, qy = y + sign * dy;
                if (!signal.contains(qx, qy))
                    continue;
                const double difference = sign * (planar(signal.at(qx, qy).z) - w);
                if (p.filter_slope && here.z < sky && signal.at(qx, qy).z < sky && std::fabs(difference) <= smallest) {
                    smallest = std::fabs(difference);
                    slope = difference;
                }
            }
            double visibility = 0.0, shadow = 0.0, weights = 0.0;
            for (int k = -p.filter_radius; k <= p.filter_radius; ++k) {
                const int offset = k * step;
                const int qx = x + offset * dx, qy = y + offset * dy;
                if (!signal.contains(qx, qy))
                    continue;
                const OcclusionTexel& there = signal.at(qx, qy);
                double weight = std::exp(-0.5 * offset * offset / double{p.filter_sigma} / double{p.filter_sigma});
                if ((here.z == sky) != (there.z == sky))
                    continue;
                if (here.z < sky) {
                    const double difference_w = std::fabs(planar(there.z) - w - slope * offset);
                    // Of depth, or of the radius: dz = dw z².
                    const double dz_relative = difference_w / w;
                    const double dz = perspective_ ? difference_w / (w * w) : difference_w;
                    const double u =
                        (p.filter_comparison == DepthDifference::relative ? dz_relative : dz / double{p.radius}) /
                        double{p.filter_depth};
                    switch (p.filter_weight) {
                    case DepthWeight::gaussian:
                        weight *= std::exp2(-u * u);
                        break;
                    case DepthWeight::limit:
                        weight *= u <= 1.0 ? 1.0 : 0.0;
                        break;
                    case DepthWeight::tent:
                        weight *= std::max(0.0, 1.0 - u);
                        break;
                    }
                }
                if (p.filter_normal > 0.0f && !normal_.empty() && k != 0) {
                    const int scale = is_half() && signal.width == working_width() ? 2 : 1;
                    const auto& a = normal_.clamped(scale * x, scale * y);
                    const auto& b = normal_.clamped(scale * qx, scale * qy);
                    const double cosine = (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) / std::hypot(a[0], a[1], a[2]) /
                                          std::hypot(b[0], b[1], b[2]);
                    weight *= std::pow(std::clamp(cosine, 0.0, 1.0), double{p.filter_normal});
                }
                visibility += weight * there.visibility;
                shadow += weight * there.shadow;
                weights += weight;
            }
            result.at(x, y).visibility = visibility / weights;
            result.at(x, y).shadow = shadow / weights;
        }
    return result;
}

OcclusionSignal AmbientOcclusionReference::filtered(const OcclusionSignal& signal) const {
    return filtered_along(filtered_along(signal, 1, 0), 0, 1);
}

// SOMA's listing, with its bilinear fetches taken apart: a tap counts that lies near where the point was.
OcclusionSignal AmbientOcclusionReference::blended(const OcclusionSignal& present, const OcclusionSignal& history,
                                                   std::vector<double>* share_out) const {
    const AmbientOcclusionParameters& p = parameters_;
    const Camera& now = *frame_.camera;
    const Camera& then = frame_.previous_camera ? *frame_.previous_camera : now;
    const double per_length = double{p.history_position} / double{p.radius};
    const double least = std::min(1.0, double{p.history_time} * double{frame_.time_step});
    OcclusionSignal result = present;
    if (share_out)
        share_out->assign(present.texels.size(), 1.0);
    for (int y = 0; y < present.height; ++y)
        for (int x = 0; x < present.width; ++x) {
            OcclusionTexel& texel = result.at(x, y);
            texel.count = 0.0;
            if (texel.z == sky)
                continue;
            const double px = (x + 0.5) * working_pixel(), py = (y + 0.5) * working_pixel();
            const auto before =
                transformed(then.world_to_view, world_from_view(now.world_to_view, position(px, py, texel.z)));
            const auto clip = transformed(then.projection, before);
            if (!(clip[3] > 0.0))
                continue;
            const double at_x = (clip[0] / clip[3] * 0.5 + 0.5) * width(),
                         at_y = (clip[1] / clip[3] * 0.5 + 0.5) * height();
            if (!on_screen(at_x, at_y))
                continue;
            const double corner_x = at_x / working_pixel() - 0.5, corner_y = at_y / working_pixel() - 0.5;
            const int first_x = static_cast<int>(std::floor(corner_x)),
                      first_y = static_cast<int>(std::floor(corner_y));
            double visibility = 0.0, shadow = 0.0, w = 0.0, count = 0.0, weights = 0.0;
            for (int dy = 0; dy < 2; ++dy)
                for (int dx = 0; dx < 2; ++dx) {
                    if (!history.contains(first_x + dx, first_y + dy))
                        continue;
                    const OcclusionTexel& old = history.at(first_x + dx, first_y + dy);
                    if (old.z == sky || std::fabs(old.z + before[2]) * per_length >= 1.0)
                        continue;
                    const double fx = corner_x - first_x, fy = corner_y - first_y;
                    const double weight = (dx == 1 ? fx : 1.0 - fx) * (dy == 1 ? fy : 1.0 - fy);
                    visibility += weight * old.visibility;
                    shadow += weight * old.shadow;
                    w += weight * planar(old.z);
                    count += weight * old.count;
                    weights += weight;
                }
            if (weights < 1e-3)
                continue;
            visibility /= weights;
            shadow /= weights;
            count /= weights;
            const double z = perspective_ ? weights / w : w / weights;
            // Where the remembered point was in the previous view.
            const Matrix4& m = then.projection;
            const double clip_w = double{m[15]} - double{m[11]} * z;
            const double x_then =
                ((2.0 * at_x / width() - 1.0) * clip_w + double{m[8]} * z - double{m[12]}) / double{m[0]};
            const double y_then =
                ((2.0 * at_y / height() - 1.0) * clip_w + double{m[9]} * z - double{m[13]}) / double{m[5]};
            const double distance = std::hypot(x_then - before[0], y_then - before[1], -z - before[2]);
            double share = std::clamp(distance * per_length +
                                          double{p.history_visibility} * std::fabs(visibility - texel.visibility),
                                      least, 1.0);
            if (p.history_length > 0) { // the mean of as many frames as there have been
                share = std::max(share, 1.0 / (count + 2.0));
                texel.count = std::min(count + 1.0, static_cast<double>(p.history_length));
            }
            texel.visibility = lerp(visibility, texel.visibility, share);
            texel.shadow = lerp(shadow, texel.shadow, share);
            if (share_out)
                (*share_out)[static_cast<size_t>(y * present.width + x)] = share;
        }
    return result;
}

std::array<double, 4> upsample_weights(OcclusionUpsample kind, double part_x, double part_y,
                                       const std::array<double, 4>& differences) {
    std::array<double, 4> weights{};
    for (size_t i = 0; i < 4; ++i) {
        const double bilinear = (i % 2 == 1 ? part_x : 1.0 - part_x) * (i / 2 == 1 ? part_y : 1.0 - part_y);
        switch (kind) {
        case OcclusionUpsample::nearest:
            weights[i] = 0.0;
            break;
        case OcclusionUpsample::bilinear:
            weights[i] = bilinear;
            break;
        // max(0.00001, 0.1 - |dz|) * 30, with 0.1 the tolerated difference
        case OcclusionUpsample::soma:
            weights[i] = bilinear + std::max(0.00001, 0.1 - 0.1 * differences[i]) * 30.0;
            break;
        case OcclusionUpsample::relative:
            weights[i] = bilinear * std::pow(std::max(0.0, 1.0 - 0.5 * differences[i]), 2.0);
            break;
        }
    }
    return weights;
}

OcclusionSignal AmbientOcclusionReference::upsampled(const OcclusionSignal& signal) const {
    const AmbientOcclusionParameters& p = parameters_;
    OcclusionSignal result(width(), height());
    for (int y = 0; y < height(); ++y)
        for (int x = 0; x < width(); ++x) {
            const double z = z_at(x, y);
            OcclusionTexel& texel = result.at(x, y);
            texel = {1.0, z, 1.0, 0.0};
            const double corner_x = (x - 0.5) / 2.0, corner_y = (y - 0.5) / 2.0; // texels' middles at whole numbers
            const int first_x = static_cast<int>(std::floor(corner_x)),
                      first_y = static_cast<int>(std::floor(corner_y));
            std::array<const OcclusionTexel*, 4> taps{};
            std::array<double, 4> differences{};
            for (size_t i = 0; i < 4; ++i) {
                taps[i] = &signal.at(std::clamp(first_x + static_cast<int>(i % 2), 0, signal.width - 1),
                                     std::clamp(first_y + static_cast<int>(i / 2), 0, signal.height - 1));
                if (z == sky || taps[i]->z == sky)
                    differences[i] = z == taps[i]->z ? 0.0 : sky;
                else if (p.upsample == OcclusionUpsample::soma)
                    differences[i] = std::fabs(taps[i]->z - z) / double{p.radius} / double{p.upsample_depth};
                else
                    differences[i] = std::fabs(planar(taps[i]->z) - planar(z)) /
                                     std::max(planar(taps[i]->z), planar(z)) / double{p.upsample_depth};
            }
            auto weights = upsample_weights(p.upsample, corner_x - first_x, corner_y - first_y, differences);
            double total = 0.0, shadow = 0.0, sum = 0.0;
            size_t nearest = 0;
            for (size_t i = 0; i < 4; ++i) {
                if (differences[i] == sky)
                    weights[i] = 0.0;
                total += weights[i] * taps[i]->visibility;
                shadow += weights[i] * taps[i]->shadow;
                sum += weights[i];
                nearest = differences[i] < differences[nearest] ? i : nearest;
            }
            if (p.upsample == OcclusionUpsample::nearest)
                nearest = static_cast<size_t>(x % 2 == 0 ? 1 : 0) + static_cast<size_t>(y % 2 == 0 ? 2 : 0);
            const bool mean = p.upsample != OcclusionUpsample::nearest && sum > 0.01;
            texel.visibility = z == sky ? 1.0 : mean ? total / sum : taps[nearest]->visibility;
            texel.shadow = mean ? shadow / sum : taps[nearest]->shadow;
        }
    return result;
}

Place applied(OcclusionApplication application, const Place& colour, const Place& ambient, double visibility) {
    const double hidden = 1.0 - visibility;
    switch (application) {
    case OcclusionApplication::none:
        break;
    case OcclusionApplication::ambient:
        return {colour.x - hidden * ambient.x, colour.y - hidden * ambient.y, colour.z - hidden * ambient.z};
    case OcclusionApplication::everything:
        return {visibility * colour.x, visibility * colour.y, visibility * colour.z};
    }
    return colour;
}

} // namespace sfumato::reference
