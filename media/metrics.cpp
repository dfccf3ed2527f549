// PSNR, RMSE, bias, SSIM (Wang, Bovik, Sheikh, Simoncelli 2004) and the mask of moving pixels.
#include "metrics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "colour.h"

namespace sfumato::media {

Planes encode_for_display(const Planes& linear) {
    Planes encoded = linear;
    for (std::vector<float>& plane : encoded.channels)
        for (float& value : plane)
            value = std::isnan(value) ? value : std::clamp(srgb_encode(value), 0.0f, 1.0f);
    return encoded;
}

Result<Metrics> measure(const Planes& picture, const Planes& reference, const MetricOptions& options) {
    const size_t channels = picture.channels.size(), pixels = picture.pixel_count();
    if (picture.width != reference.width || picture.height != reference.height ||
        channels != reference.channels.size() || channels == 0)
        return Error{ErrorCode::invalid_argument,
                     fmt::format("pictures of {}x{} pixels with {} channels and of {}x{} with {} cannot be compared",
                                 picture.width, picture.height, channels, reference.width, reference.height,
                                 reference.channels.size())};
    if (options.mask && options.mask->size() != pixels)
        return Error{ErrorCode::invalid_argument,
                     fmt::format("a mask of {} pixels does not fit {} pixels", options.mask->size(), pixels)};
    Metrics metrics;
    double squares = 0.0, sum = 0.0;
    for (size_t i = 0; i < pixels; ++i) {
        if (options.mask && !(*options.mask)[i])
            continue;
        double pixel_squares = 0.0, pixel_sum = 0.0, pixel_max = 0.0;
        for (size_t c = 0; c < channels; ++c) {
            const double error = double{picture.channels[c][i]} - double{reference.channels[c][i]};
            pixel_squares += error * error;
            pixel_sum += error;
            pixel_max = std::max(pixel_max, std::abs(error));
        }
        if (!std::isfinite(pixel_squares)) {
            ++metrics.non_finite;
            continue;
        }
        ++metrics.pixels;
        squares += pixel_squares;
        sum += pixel_sum;
        metrics.max_error = std::max(metrics.max_error, pixel_max);
    }
    if (metrics.pixels == 0) {
        const double nan = std::numeric_limits<double>::quiet_NaN();
        return Metrics{nan, nan, nan, nan, nan, 0, metrics.non_finite};
    }
    const double count = static_cast<double>(metrics.pixels) * static_cast<double>(channels);
    metrics.rmse = std::sqrt(squares / count);
    metrics.bias = sum / count;
    metrics.psnr = -10.0 * std::log10(std::max(squares / count, 1e-12));
    metrics.ssim = options.ssim ? structural_similarity(picture, reference, options.mask)
                                : std::numeric_limits<double>::quiet_NaN();
    return metrics;
}

namespace {

constexpr int ssim_radius = 5;

std::array<double, 2 * ssim_radius + 1> gaussian_weights() {
    std::array<double, 2 * ssim_radius + 1> weights = {};
    double sum = 0.0;
    for (int i = -ssim_radius; i <= ssim_radius; ++i)
        sum += weights[static_cast<size_t>(i + ssim_radius)] = std::exp(-i * i / (2.0 * 1.5 * 1.5));
    for (double& weight : weights)
        weight /= sum;
    return weights;
}

struct Moments {
    double a = 0.0, b = 0.0, aa = 0.0, bb = 0.0, ab = 0.0;

    void add(double weight, const Moments& m) {
        a += weight * m.a;
        b += weight * m.b;
        aa += weight * m.aa;
        bb += weight * m.bb;
        ab += weight * m.ab;
    }
};

double similarity(const Moments& m) {
    constexpr double c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;
    const double variance_a = m.aa - m.a * m.a, variance_b = m.bb - m.b * m.b, covariance = m.ab - m.a * m.b;
    return (2 * m.a * m.b + c1) * (2 * covariance + c2) /
           ((m.a * m.a + m.b * m.b + c1) * (variance_a + variance_b + c2));
}

// Sums one plane's similarity; windows that touch NaN or infinity do not count.
void sum_similarity(const std::vector<float>& a, const std::vector<float>& b, int width, int height, const Mask* mask,
                    double& sum, size_t& count) {
    const auto weights = gaussian_weights();
    const size_t stride = static_cast<size_t>(width);
    std::vector<Moments> columns(stride);
    for (int y = ssim_radius; y < height - ssim_radius; ++y) {
        for (size_t x = 0; x < stride; ++x) {
            columns[x] = {};
            for (int dy = -ssim_radius; dy <= ssim_radius; ++dy) {
                const size_t i = static_cast<size_t>(y + dy) * stride + x;
                const double va = a[i], vb = b[i];
                columns[x].add(weights[static_cast<size_t>(dy + ssim_radius)], {va, vb, va * va, vb * vb, va * vb});
            }
        }
        for (int x = ssim_radius; x < width - ssim_radius; ++x) {
            if (mask && !(*mask)[static_cast<size_t>(y) * stride + static_cast<size_t>(x)])
                continue;
            Moments m;
            for (int dx = -ssim_radius; dx <= ssim_radius; ++dx)
                m.add(weights[static_cast<size_t>(dx + ssim_radius)], columns[static_cast<size_t>(x + dx)]);
            const double value = similarity(m);
            if (std::isfinite(value)) {
                sum += value;
                ++count;
            }
        }
    }
}

} // namespace

double structural_similarity(const Planes& picture, const Planes& reference, const Mask* mask) {
    double sum = 0.0;
    size_t count = 0;
    for (size_t c = 0; c < std::min(picture.channels.size(), reference.channels.size()); ++c)
        sum_similarity(picture.channels[c], reference.channels[c], picture.width, picture.height, mask, sum, count);
    return count > 0 ? sum / static_cast<double>(count) : std::numeric_limits<double>::quiet_NaN();
}

Mask moving_region(const Planes& sharp, const Planes& truth, double threshold, int grow) {
    const size_t width = static_cast<size_t>(sharp.width), height = static_cast<size_t>(sharp.height);
    const size_t channels = std::min(sharp.channels.size(), truth.channels.size());
    Mask mask(width * height, 0);
    if (channels == 0 || truth.pixel_count() != mask.size())
        return mask;
    for (size_t i = 0; i < mask.size(); ++i) {
        double squares = 0.0;
        for (size_t c = 0; c < channels; ++c) {
            const double difference = double{sharp.channels[c][i]} - double{truth.channels[c][i]};
            squares += difference * difference;
        }
        mask[i] = squares / static_cast<double>(channels) > threshold ? 1 : 0;
    }
    for (int step = 0; step < grow; ++step) {
        const Mask before = mask;
        for (size_t y = 0; y < height; ++y)
            for (size_t x = 0; x < width; ++x) {
                const size_t i = y * width + x;
                mask[i] = before[i] || (y > 0 && before[i - width]) || (y + 1 < height && before[i + width]) ||
                          (x > 0 && before[i - 1]) || (x + 1 < width && before[i + 1]);
            }
    }
    return mask;
}

Mask inverse(const Mask& mask) {
    Mask result(mask.size());
    std::transform(mask.begin(), mask.end(), result.begin(),
                   [](uint8_t inside) { return inside ? uint8_t{0} : uint8_t{1}; });
    return result;
}

Planes difference_picture(const Planes& picture, const Planes& reference, float gain) {
    Planes difference = picture;
    for (size_t c = 0; c < std::min(picture.channels.size(), reference.channels.size()); ++c) {
        const size_t count = std::min(picture.channels[c].size(), reference.channels[c].size());
        for (size_t i = 0; i < count; ++i)
            difference.channels[c][i] = std::abs(picture.channels[c][i] - reference.channels[c][i]) * gain;
    }
    return difference;
}

} // namespace sfumato::media
