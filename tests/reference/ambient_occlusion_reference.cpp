// Depth preparation, normals and estimators.
#include "tests/reference/ambient_occlusion_reference.h"

#include <bit>
#include <cmath>
#include <numbers>
#include <utility>

namespace sfumato::reference {
namespace {

constexpr double pi = std::numbers::pi;
constexpr int tile = 32; // the finest texels below one of the coarsest
constexpr int coarsest = 5;

Place operator+(const Place& a, const Place& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
Place operator-(const Place& a, const Place& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
Place operator*(double s, const Place& a) {
    return {s * a.x, s * a.y, s * a.z};
}
double dot(const Place& a, const Place& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
Place cross(const Place& a, const Place& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
double length(const Place& a) {
    return std::sqrt(dot(a, a));
}
Place unit(const Place& a) {
    return (1.0 / length(a)) * a;
}
double fraction(double x) {
    return x - std::floor(x);
}

// Interleaved gradient noise is defined by single precision: its large factor brings the rounding to light.
double gradient_noise(float x, float y) {
    const float inner = x * 0.06711056f + y * 0.00583715f;
    const float scaled = 52.9829189f * (inner - std::floor(inner));
    return double{scaled - std::floor(scaled)};
}

// An average that leans to the farthest: what is nearer than it by three quarters of the radius has no weight.
double farthest_mean(const std::array<double, 4>& z, double radius) {
    double farthest = 0.0;
    for (const double each : z)
        farthest = each < sky ? std::max(farthest, each) : farthest;
    if (farthest == 0.0)
        return sky;
    double total = 0.0, weights = 0.0;
    for (const double each : z) {
        const double weight = each < sky ? std::max(0.0, 1.0 - (farthest - each) / (0.75 * radius)) : 0.0;
        total += weight > 0.0 ? weight * each : 0.0;
        weights += weight;
    }
    return total / weights;
}

} // namespace

AmbientOcclusionReference::AmbientOcclusionReference(Grid<1> depth, Grid<3> normal, const Frame& frame,
                                                     const AmbientOcclusionParameters& parameters, double calibration,
                                                     int turns)
    : depth_(std::move(depth)), normal_(std::move(normal)), frame_(frame), parameters_(parameters),
      calibration_(calibration), turns_(turns), perspective_(frame.camera->projection[11] != 0.0f) {
    prepare();
}

double AmbientOcclusionReference::z_at(int x, int y) const {
    const double z = depth_.clamped(x, y)[0];
    return z > 0.0 && z < 1e9 ? z : sky;
}

void AmbientOcclusionReference::prepare() {
    const auto padded = [](int side) { return (side + tile - 1) / tile * tile; };
    DepthLevel finest{padded(working_width()), padded(working_height()), {}};
    finest.texels.resize(static_cast<size_t>(finest.width) * static_cast<size_t>(finest.height));
    for (int y = 0; y < finest.height; ++y)
        for (int x = 0; x < finest.width; ++x) {
            DepthTexel& texel = finest.at(x, y);
            if (!is_half()) {
                texel = {z_at(x, y), x + 0.5, y + 0.5};
                continue;
            }
            const bool nearest = parameters_.half_depth == HalfDepthChoice::nearest ||
                                 (parameters_.half_depth == HalfDepthChoice::checkerboard && (x + y) % 2 == 0);
            texel = {z_at(2 * x, 2 * y), 2 * x + 0.5, 2 * y + 0.5};
            for (const auto& [dx, dy] : {std::pair{1, 0}, {0, 1}, {1, 1}}) {
                const double z = z_at(2 * x + dx, 2 * y + dy);
                const bool exists = 2 * x + dx < width() && 2 * y + dy < height();
                if (exists && (nearest ? z < texel.z : z > texel.z))
                    texel = {z, 2 * x + dx + 0.5, 2 * y + dy + 0.5};
            }
        }
    levels_ = {finest};
    for (int m = 1; m <= coarsest; ++m) {
        const DepthLevel& below = levels_.back();
        DepthLevel made{below.width / 2, below.height / 2, {}};
        made.texels.resize(static_cast<size_t>(made.width) * static_cast<size_t>(made.height));
        const double side = std::ldexp(working_pixel(), m);
        for (int y = 0; y < made.height; ++y)
            for (int x = 0; x < made.width; ++x) {
                if (parameters_.depth_mips == DepthMips::farthest)
                    made.at(x, y) = {farthest_mean({below.at(2 * x, 2 * y).z, below.at(2 * x + 1, 2 * y).z,
                                                    below.at(2 * x, 2 * y + 1).z, below.at(2 * x + 1, 2 * y + 1).z},
                                                   double{parameters_.radius}),
                                     (x + 0.5) * side, (y + 0.5) * side};
                else
                    made.at(x, y) = below.at(2 * x + y % 2, 2 * y + x % 2);
            }
        levels_.push_back(std::move(made));
    }
}

Place AmbientOcclusionReference::position(double pixel_x, double pixel_y, double z) const {
    const Matrix4& p = frame_.camera->projection;
    const auto at = [&](size_t i) { return double{p[i]}; };
    const double ndc_x = 2.0 * pixel_x / width() - 1.0, ndc_y = 2.0 * pixel_y / height() - 1.0;
    const double w = at(15) - at(11) * z;
    return {(ndc_x * w + at(8) * z - at(12)) / at(0), (ndc_y * w + at(9) * z - at(13)) / at(5), -z};
}

Place AmbientOcclusionReference::normal(int x, int y) const {
    const DepthTexel& here = level(0).at(x, y);
    const Place p = position(here.x, here.y, here.z);
    if (!normal_.empty() && parameters_.normals == NormalSource::given) {
        const auto& n = normal_.at(static_cast<int>(here.x), static_cast<int>(here.y));
        const Place given{n[0], n[1], n[2]};
        if (length(given) > 0.1)
            return unit(given);
    }
    // Per axis the shorter of the two one-sided differences; not one that runs along the other axis's, as half
    // resolution's chosen depths may: there the next neighbours but one help.
    Place along[2];
    double step_x = 0.0, step_y = 0.0; // the first axis's, in pixels
    for (int axis = 0; axis < 2; ++axis) {
        double shortest = sky;
        for (const int offset : {-1, 1, -2, 2}) {
            if (std::abs(offset) == 2 && (!is_half() || shortest < sky))
                break;
            const int sign = offset < 0 ? -1 : 1;
            const int qx = x + (axis == 0 ? offset : 0), qy = y + (axis == 1 ? offset : 0);
            if (qx < 0 || qy < 0 || qx >= working_width() || qy >= working_height())
                continue;
            const DepthTexel& there = level(0).at(qx, qy);
            if (there.z == sky || !(std::fabs(there.z - here.z) < shortest))
                continue;
            const double dx = there.x - here.x, dy = there.y - here.y;
            if (axis == 1 && std::fabs(step_x * dy - step_y * dx) < 0.5)
                continue;
            if (axis == 0) {
                step_x = dx;
                step_y = dy;
            }
            shortest = std::fabs(there.z - here.z);
            along[axis] = sign * (position(there.x, there.y, there.z) - p);
        }
    }
    const Place n = cross(along[0], along[1]);
    if (!(length(n) > 0.0))
        return {0, 0, 1};
    // A visible surface faces the eye.
    const Place to_eye = perspective_ ? -1.0 * p : Place{0, 0, 1};
    return unit(dot(n, to_eye) < 0.0 ? -1.0 * n : n);
}

struct AmbientOcclusionReference::Centre {
    int x, y;      // working texel
    double px, py; // its place, full-resolution pixels
    Place p;       // pulled towards the eye by the bias
    Place n, v;
    double radius, radius_pixels;
};

struct AmbientOcclusionReference::Sum {
    double visible = 0.0, weight = 0.0;
};

AmbientOcclusionReference::Centre AmbientOcclusionReference::centre(int x, int y) const {
    const DepthTexel& here = level(0).at(x, y);
    Centre c{x, y, here.x, here.y, {}, normal(x, y), {0, 0, 1}, 0.0, 0.0};
    const double z = here.z * (1.0 - double{parameters_.depth_bias});
    c.p = position(here.x, here.y, z);
    if (perspective_)
        c.v = unit(-1.0 * position(here.x, here.y, here.z));
    // Interpolated normals may face away.
    if (dot(c.n, c.v) < 0.01)
        c.n = unit(c.n + (0.01 - dot(c.n, c.v)) * c.v);
    // One scene unit upright at this depth, in pixels.
    const double unit_pixels = 1.0 / std::fabs(position(0, 1, z).y - position(0, 0, z).y);
    const double limit = std::max(1.0, double{parameters_.radius_limit} * height());
    c.radius_pixels = double{parameters_.radius} * unit_pixels;
    c.radius = double{parameters_.radius} * std::min(1.0, limit / c.radius_pixels);
    c.radius_pixels = std::min(c.radius_pixels, limit);
    return c;
}

bool AmbientOcclusionReference::on_screen(double x, double y) const {
    return x >= 0.0 && y >= 0.0 && x < width() && y < height();
}

Place AmbientOcclusionReference::tap(double x, double y, double away) const {
    int m = 0;
    if (parameters_.depth_mips != DepthMips::none)
        m = static_cast<int>(std::clamp(std::floor(std::log2(away / working_pixel()) - double{parameters_.mip_rate}),
                                        0.0, double{coarsest}));
    const int qx = static_cast<int>(x / working_pixel()) >> m, qy = static_cast<int>(y / working_pixel()) >> m;
    const DepthTexel& texel = level(m).at(qx, qy);
    return texel.z == sky ? Place{0, 0, -sky} : position(texel.x, texel.y, texel.z);
}

double AmbientOcclusionReference::falloff(double t) const {
    if (t >= 1.0)
        return 0.0;
    switch (parameters_.falloff) {
    case OcclusionFalloff::hard:
        return 1.0;
    case OcclusionFalloff::linear:
        return 1.0 - t;
    case OcclusionFalloff::quadratic:
        return 1.0 - t * t;
    case OcclusionFalloff::sao:
        return std::pow(1.0 - t * t, 3.0);
    case OcclusionFalloff::contact:
        return std::pow(1.0 - t, 2.0);
    case OcclusionFalloff::wide:
        return 1.0 - std::pow(t, 4.0);
    }
    return 0.0;
}

std::array<double, 2> AmbientOcclusionReference::noise(int x, int y, int iteration) const {
    const auto frame = static_cast<double>(parameters_.animate_noise ? frame_.index % 64 : 0);
    const auto shifted = [](double a, double b, double number) {
        return std::array{fraction(a + number * 0.75487767), fraction(b + number * 0.56984029)};
    };
    switch (parameters_.noise) {
    case OcclusionNoise::none:
        return shifted(0.0, 0.5, iteration);
    case OcclusionNoise::gradient_noise: {
        const float shift = static_cast<float>(5.588238 * frame);
        const float add = 5.588238f * static_cast<float>(iteration);
        const float fx = static_cast<float>(x) + shift + add, fy = static_cast<float>(y) + shift + add;
        return {gradient_noise(fx, fy), gradient_noise(fx + 31.0f, fy + 71.0f)};
    }
    case OcclusionNoise::hash: {
        const double turn = ((3 * x ^ (y + x * y)) & 0xffff) * 10.0 / (2.0 * pi);
        return shifted(turn, turn * 1.61803399, iteration + frame);
    }
    case OcclusionNoise::blocks:
        break;
    }
    // The order of a 4×4 Bayer matrix: every pair once in any block.
    constexpr int order[4][4] = {{0, 8, 2, 10}, {12, 4, 14, 6}, {3, 11, 1, 9}, {15, 7, 13, 5}};
    const int number = order[y & 3][x & 3];
    return shifted(number / 16.0, ((number * 7 + 3) % 16 + 0.5) / 16.0, iteration + frame);
}

void AmbientOcclusionReference::add_obscurance(const Centre& c, const std::array<double, 2>& noise, Sum& sum) const {
    const int taps = parameters_.taps;
    const bool sao = parameters_.falloff == OcclusionFalloff::sao;
    const double bias = double{parameters_.bias};
    double total = 0.0;
    int count = 0;
    for (int i = 0; i < taps; ++i) {
        double distance = 0.0, angle = 2.0 * pi * noise[0];
        switch (parameters_.pattern) {
        case TapPattern::growing_circle: // SOMA: 2, 3, 4 … of 18ths, pairs opposite, each pair turned on by 137.5°
            distance = (i + 2.0) / (taps + 2.0);
            angle += (i / 2) * pi * (3.0 - std::sqrt(5.0)) + (i % 2) * pi;
            break;
        case TapPattern::spiral: // jittered within its ring by the second noise
            distance = (i + noise[1]) / taps;
            angle += 2.0 * pi * turns_ * (i + 0.5) / taps;
            break;
        case TapPattern::mirrored_spiral: {
            const int pairs = (taps + 1) / 2;
            distance = (i / 2 + 0.5) / pairs;
            angle += 2.0 * pi * turns_ * distance + (i % 2) * pi;
            break;
        }
        }
        const double away = std::max(distance * c.radius_pixels, working_pixel());
        const double x = c.px + away * std::cos(angle), y = c.py + away * std::sin(angle);
        if (!on_screen(x, y))
            continue;
        ++count;
        const Place d = tap(x, y, away) - c.p;
        if (!(d.z > -sky))
            continue;
        const double t = length(d) / c.radius;
        const double elevation = dot(unit(d), c.n);
        total += sao ? falloff(t) * std::max(elevation * t - bias, 0.0) / (t * t + 0.01)
                     : falloff(t) * std::max(elevation - bias, 0.0);
    }
    if (count == 0)
        return;
    double occlusion = double{parameters_.intensity} * calibration_ * total / count;
    if (parameters_.normalisation == OcclusionNormalisation::vicarious_visions)
        occlusion *= occlusion;
    sum.visible += 1.0 - occlusion;
    sum.weight += 1.0;
}

double sky_between(double a, double b, double gamma) {
    if (a < 0.0 && b > 0.0) // |sin t| has a kink
        return sky_between(a, 0.0, gamma) + sky_between(0.0, b, gamma);
    constexpr int parts = 12;
    const auto f = [&](double t) { return std::cos(t - gamma) * std::fabs(std::sin(t)); };
    double total = f(a) + f(b);
    for (int i = 1; i < parts; ++i)
        total += (i % 2 == 1 ? 4.0 : 2.0) * f(a + (b - a) * i / parts);
    return total * (b - a) / (3.0 * parts);
}

// How much a side counts that the edge of the screen cuts off: with half of its length on the screen seven eighths.
double AmbientOcclusionReference::seen_share(const Centre& c, double dx, double dy, double radius_pixels) const {
    double unseen = 1.0;
    // In small steps along the line: slow and plain.
    constexpr int parts = 4096;
    for (int i = 1; i <= parts; ++i) {
        const double away = std::max(radius_pixels, working_pixel()) * i / parts;
        if (!on_screen(c.px + away * dx, c.py + away * dy))
            break;
        unseen = 1.0 - static_cast<double>(i) / parts;
    }
    return 1.0 - unseen * unseen * unseen;
}

void AmbientOcclusionReference::add_horizons(const Centre& c, const std::array<double, 2>& noise, Sum& sum) const {
    const HorizonMeasure measure = parameters_.measure;
    for (int i = 0; i < parameters_.slices; ++i) {
        const double turn = pi * (i + noise[0]) / parameters_.slices;
        // The slice: the plane through the eye that the line on the screen spans.
        const double reach = c.p.z * -1.0;
        const Place ahead = position(c.px + std::cos(turn), c.py + std::sin(turn), reach) - position(c.px, c.py, reach);
        const Place across = unit(ahead - dot(ahead, c.v) * c.v);
        const double radius_pixels = c.radius / length(ahead);
        const double gamma = std::atan2(dot(c.n, across), dot(c.n, c.v)); // of the projected normal
        const double weight = std::hypot(dot(c.n, across), dot(c.n, c.v));
        const double ends[2] = {gamma - pi / 2, gamma + pi / 2};
        const double all_sky = sky_between(ends[0], ends[1], gamma);

        uint32_t mask = 0;             // sectors of equal sky, from the left end
        double hidden[2] = {0.0, 0.0}; // left, right
        double seen[2] = {0.0, 0.0};   // how much of what a side tells is on the screen
        for (const int way : {1, 0}) { // to the right, to the left
            const double sign = way == 1 ? 1.0 : -1.0;
            double horizon = measure == HorizonMeasure::hbao ? std::sin(-sign * gamma) : ends[way];
            for (int k = 0; k < parameters_.steps; ++k) {
                const double at =
                    std::pow((k + noise[1]) / parameters_.steps, double{parameters_.step_power}) * radius_pixels;
                const double away = std::max(at, working_pixel());
                const double x = c.px + sign * away * std::cos(turn), y = c.py + sign * away * std::sin(turn);
                if (!on_screen(x, y))
                    break;
                seen[way] = measure == HorizonMeasure::hbao
                                ? 1.0
                                : seen_share(c, sign * std::cos(turn), sign * std::sin(turn), radius_pixels);
                const Place d = tap(x, y, away) - c.p;
                const double t = length(d) / c.radius;
                if (!(d.z > -sky) || t >= 1.0 || dot(unit(d), c.n) <= double{parameters_.bias})
                    continue;
                const double side = dot(d, across), front = dot(d, c.v);
                // An angle in this slice, or the end of the sky where it is below the surface.
                const auto angle_of = [&](double s, double f) {
                    const double theta = std::atan2(s, f);
                    return std::cos(theta - gamma) <= 0.0 ? ends[way] : theta;
                };
                if (measure == HorizonMeasure::hbao) {
                    const double sine = front / std::hypot(side, front);
                    hidden[way] += std::max(0.0, sine - horizon) * falloff(t);
                    horizon = std::max(horizon, sine);
                } else if (measure == HorizonMeasure::cosine) {
                    const double theta = angle_of(side, front);
                    if (sign * (horizon - theta) > 0.0) { // rises above the horizon
                        hidden[way] += sign * sky_between(theta, horizon, gamma) * falloff(t);
                        horizon = theta;
                    }
                } else {
                    const double thick = double{parameters_.thickness} * double{parameters_.radius};
                    const double a = angle_of(side, front);
                    const double b = parameters_.thickness >= 100.0f ? ends[way] : angle_of(side, front - thick);
                    const double first = sky_between(ends[0], std::min(a, b), gamma) / all_sky * 32.0 + 0.5;
                    const double last = sky_between(ends[0], std::max(a, b), gamma) / all_sky * 32.0 + 0.5;
                    for (int sector = static_cast<int>(first); sector < static_cast<int>(last) && sector < 32; ++sector)
                        if ((mask >> sector & 1u) == 0) {
                            mask |= 1u << sector;
                            hidden[way] += falloff(t) * all_sky / 32.0;
                        }
                }
            }
        }
        const double strength = double{parameters_.intensity} * calibration_;
        const double left_sky = sky_between(ends[0], 0.0, gamma), right_sky = all_sky - left_sky;
        const bool is_hbao = measure == HorizonMeasure::hbao;
        const double sky_of[2] = {is_hbao ? 1.0 : left_sky, is_hbao ? 1.0 : right_sky};
        for (const int way : {0, 1}) {
            const double counts = (is_hbao ? 1.0 : weight) * seen[way];
            sum.visible += counts * (sky_of[way] - strength * hidden[way]);
            sum.weight += counts * sky_of[way];
        }
    }
}

double AmbientOcclusionReference::estimate(int x, int y) const {
    if (level(0).at(x, y).z == sky)
        return 1.0;
    const Centre c = centre(x, y);
    const double guard = parameters_.guard_band;
    if (c.px < guard || c.py < guard || c.px > width() - guard || c.py > height() - guard)
        return 1.0;
    Sum sum;
    for (int i = 0; i < parameters_.iterations; ++i)
        if (parameters_.estimator == OcclusionEstimator::obscurance)
            add_obscurance(c, noise(x, y, i), sum);
        else
            add_horizons(c, noise(x, y, i), sum);
    const double visibility = sum.weight > 0.0 ? sum.visible / sum.weight : 1.0;
    // A radius of one working pixel finds nothing but rounding; it counts in full from three on.
    const double known = std::clamp((c.radius_pixels / working_pixel() - 1.0) / 2.0, 0.0, 1.0);
    return 1.0 + known * (visibility - 1.0);
}

// The ray through the middle meets the plane of the surface.
double AmbientOcclusionReference::depth_in_middle(int x, int y) const {
    const DepthTexel& here = level(0).at(x, y);
    if (!is_half() || here.z == sky || parameters_.upsample == OcclusionUpsample::soma)
        return here.z;
    const Place n = centre(x, y).n, p = position(here.x, here.y, here.z);
    const Place a = position(2 * x + 1.0, 2 * y + 1.0, 1.0), b = position(2 * x + 1.0, 2 * y + 1.0, 2.0);
    const double z = 1.0 + dot(n, p - a) / dot(n, b - a);
    if (!perspective_)
        return std::clamp(z, here.z - 0.1 * double{parameters_.radius}, here.z + 0.1 * double{parameters_.radius});
    return here.z / std::clamp(here.z / z, 0.8, 1.25);
}

OcclusionSignal AmbientOcclusionReference::estimates() const {
    OcclusionSignal signal(working_width(), working_height());
    for (int y = 0; y < signal.height; ++y)
        for (int x = 0; x < signal.width; ++x)
            signal.at(x, y) = {estimate(x, y), depth_in_middle(x, y), 1.0, 0.0};
    return signal;
}

} // namespace sfumato::reference
