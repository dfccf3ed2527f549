// The profiles' ground truth: the table of noise or texture from its formula, its halvings, and lookups in them.
#include "scene/particle_profile.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sfumato::scene {

namespace {

constexpr double pi = std::numbers::pi;
constexpr int side = 256;
constexpr int level_count = 6;
constexpr double cells = 16.0; // of the noise's largest ones, on a side of the table

uint32_t mixed(uint32_t h) {
    h = (h ^ h >> 16) * 0x7feb352du;
    h = (h ^ h >> 15) * 0x846ca68bu;
    return h ^ h >> 16;
}

// Falls from 1 to 0 as |x| goes from 0 to 1, its first two derivatives 0 at both ends.
double corner_weight(double x) {
    const double t = 1.0 - std::abs(x);
    return t * t * t * (10.0 - 15.0 * t + 6.0 * t * t);
}

// Gradient noise: the sum over a cell's corners of planes through 0 there, of slope 1, each weighted by how near it is.
double noise(double x, double y, uint32_t octave) {
    double sum = 0.0;
    for (int row = 0; row < 2; ++row)
        for (int column = 0; column < 2; ++column) {
            const double cx = std::floor(x) + column, cy = std::floor(y) + row;
            const uint32_t h =
                mixed(static_cast<uint32_t>(cx) * 0x9e3779b1u ^ static_cast<uint32_t>(cy) * 0x85ebca77u ^ octave);
            const double angle = 2.0 * pi * (h >> 8) / 16777216.0;
            sum += corner_weight(x - cx) * corner_weight(y - cy) *
                   (std::cos(angle) * (x - cx) + std::sin(angle) * (y - cy));
        }
    return sum;
}

double smoke(double x, double y) {
    return std::exp2(3.5 * (noise(x, y, 0) + 0.5 * noise(2.0 * x, 2.0 * y, 1) + 0.25 * noise(4.0 * x, 4.0 * y, 2)));
}

// Between the middles of four texels, in texels.
template <class Texel>
double interpolated(double x, double y, int width, int height, const Texel& texel) {
    const double left = std::floor(x - 0.5), top = std::floor(y - 0.5);
    const double px = x - 0.5 - left, py = y - 0.5 - top;
    const auto value = [&](double column, double row) {
        return texel(static_cast<size_t>(std::clamp(row, 0.0, height - 1.0)) * static_cast<size_t>(width) +
                     static_cast<size_t>(std::clamp(column, 0.0, width - 1.0)));
    };
    return (value(left, top) * (1.0 - px) + value(left + 1.0, top) * px) * (1.0 - py) +
           (value(left, top + 1.0) * (1.0 - px) + value(left + 1.0, top + 1.0) * px) * py;
}

double texture_at(const ParticleTexture& texture, double x, double y) {
    if (texture.values.empty())
        return 0.0;
    return interpolated(x * texture.extent.width, y * texture.extent.height, static_cast<int>(texture.extent.width),
                        static_cast<int>(texture.extent.height), [&](size_t i) { return double{texture.values[i]}; });
}

std::vector<double> halved(const std::vector<double>& level, size_t size) {
    std::vector<double> half;
    for (size_t y = 0; y < size; y += 2)
        for (size_t x = 0; x < size; x += 2)
            half.push_back(0.25 * (level[y * size + x] + level[y * size + x + 1] + level[(y + 1) * size + x] +
                                   level[(y + 1) * size + x + 1]));
    return half;
}

} // namespace

ParticleProfileTruth::ParticleProfileTruth(const ParticleVolumeParameters& parameters, const ParticleTexture& texture)
    : kind_(parameters.profile), strength_(double{parameters.profile_strength}) {
    if (kind_ == ParticleProfile::sphere || strength_ == 0.0)
        return;
    const bool is_noise = kind_ == ParticleProfile::noise;
    levels_.emplace_back();
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            const double u = (x + 0.5) / side, v = (y + 0.5) / side;
            levels_[0].push_back(is_noise ? smoke(cells * u, cells * v) : texture_at(texture, u, v));
        }
    for (size_t size = side; levels_.size() < level_count; size /= 2)
        levels_.push_back(halved(levels_.back(), size));
    places_ = {{0.5, 0.5, 1.0}};
    if (is_noise) {
        reach_ = double{parameters.profile_scale} / cells;
        least_ = std::max(2.0, double{parameters.profile_scale});
        places_.clear();
        for (int i = 0; i < 256; ++i)
            places_.push_back({reach_ + (1.0 - 2.0 * reach_) * (i % 16) / 15.0,
                               reach_ + (1.0 - 2.0 * reach_) * (i / 16) / 15.0, 1.0});
    }
    for (Place& place : places_)
        place.mass = mass_of(place);
}

double ParticleProfileTruth::factor(const Place& place, double x, double y, double level) const {
    const double below = std::floor(level);
    const auto in_level = [&](size_t number) {
        const int size = side >> number;
        return interpolated((place.x + reach_ * x) * size, (place.y + reach_ * y) * size, size, size,
                            [&](size_t i) { return levels_[number][i]; });
    };
    const double first = in_level(static_cast<size_t>(below));
    if (level == below)
        return first;
    return first + (level - below) * (in_level(static_cast<size_t>(below) + 1) - first);
}

// By rings: the sum over the disc, a sphere's being 2/3 pi.
double ParticleProfileTruth::mass_of(const Place& place) const {
    const int rings = kind_ == ParticleProfile::noise ? 40 : 200, spokes = 3 * rings;
    double sum = 0.0;
    for (int ring = 0; ring < rings; ++ring) {
        const double rho = (ring + 0.5) / rings;
        const double weight = rho * (kind_ == ParticleProfile::noise ? std::sqrt(1.0 - rho * rho) : 1.0);
        for (int spoke = 0; spoke < spokes; ++spoke) {
            const double angle = 2.0 * pi * (spoke + 0.5) / spokes;
            sum += weight * factor(place, rho * std::cos(angle), rho * std::sin(angle), 0.0);
        }
    }
    return sum * 2.0 * pi / (rings * spokes) / (2.0 / 3.0 * pi);
}

double ParticleProfileTruth::at(uint32_t number, double u, double v, double pixels) const {
    const double chord = std::sqrt(std::max(0.0, 1.0 - u * u - v * v));
    const double share = strength_ * std::clamp(pixels / least_ - 1.0, 0.0, 1.0);
    if (places_.empty() || share == 0.0)
        return chord;
    const uint32_t pattern = mixed(number + 0x9e3779b9u) & 0xffffu;
    const Place& place = places_[places_.size() == 1 ? 0 : pattern & 255u];
    const double angle = 2.0 * pi * (pattern >> 8) / 256.0;
    const double c = std::cos(angle), s = std::sin(angle);
    const double level = std::clamp(std::log2(reach_ * side / pixels), 0.0, level_count - 1.0);
    double profile = place.mass > 1e-4 ? factor(place, c * u - s * v, s * u + c * v, level) / place.mass : 0.0;
    if (kind_ == ParticleProfile::noise)
        profile *= chord;
    return (1.0 - share) * chord + share * profile;
}

} // namespace sfumato::scene
