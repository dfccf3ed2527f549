// Ground truth of how a particle's optical depth is spread over its disc, in double precision.
#pragma once

#include "sfumato/effects/particles.h"

#include <array>
#include <span>
#include <vector>

namespace sfumato::scene {

// The image `profile`, one value a texel, of at most 256 a side. Finite values from 0 on are asked for.
struct ParticleTexture {
    Extent extent;
    std::span<const float> values;
};

class ParticleProfileTruth {
  public:
    ParticleProfileTruth(const ParticleVolumeParameters& parameters, const ParticleTexture& texture);

    // Optical depth over that through a sphere's middle: of the particle with that number, at (u, v) radii to the right
    // of and below its middle, u² + v² < 1, where its disc has a radius of so many pixels.
    double at(uint32_t number, double u, double v, double pixels) const;

  private:
    struct Place {
        double x, y; // of the disc's middle in the table, whose side is 1
        double mass; // over a sphere's
    };

    double factor(const Place& place, double x, double y, double level) const; // x, y: turned, in radii
    double mass_of(const Place& place) const;

    ParticleProfile kind_ = ParticleProfile::sphere;
    double strength_ = 0.0, reach_ = 0.5, least_ = 2.0;
    std::vector<std::vector<double>> levels_; // of the table, 256 a side and its halvings
    std::vector<Place> places_;
};

} // namespace sfumato::scene
