// The simulation of particles in double precision, written for reading: one particle after the other, one step after
// the other, no closed forms for births. What src/effects/particles/particles.comp computes.
#pragma once

#include "scene/vec3.h"
#include "sfumato/effects/particles.h"

#include <optional>
#include <vector>

namespace sfumato::reference {

using scene::Vec3;

// Linear view depth, row by row from the top.
struct DepthImage {
    Extent extent;
    std::vector<float> values;
};

struct ReferenceParticle {
    Vec3 position = {};
    Vec3 velocity = {};
    double age = 0.0;
    uint32_t id = 0; // 0: dead
};

// Curl noise alone: mean square speed 1, eddies of size 1 in the units of `p`. `time` in turns of the slower of the two
// rotations times two.
Vec3 curl_noise(Vec3 p, double time, uint32_t salt);

class ParticleReference {
  public:
    explicit ParticleReference(const ParticleVolumeParameters& parameters);

    // One frame. Of the frame the time step, camera, colliders and reset count; depth must be linear.
    void run(const Frame& frame, const DepthImage& depth);

    const std::vector<ReferenceParticle>& particles() const { return particles_; }
    ParticleSprite sprite(size_t slot) const;

    // Signed distance and outward normal, below 0 inside; outside a box's faces the sign alone is right.
    static double distance(const Collider& collider, Vec3 position, Vec3* normal = nullptr);

  private:
    struct Motion {
        Vec3 position, velocity;
    };
    void give_birth(double step);
    void move(ReferenceParticle& particle, double step, const Frame& frame, const DepthImage& depth) const;
    Motion driven(const ReferenceParticle& particle, double step) const;
    Motion collide_with_shapes(const Motion& before, Motion after, double step, const Frame& frame) const;
    Motion collide_with_depth(const Motion& before, Motion after, const Frame& frame, const DepthImage& depth) const;
    Vec3 air_velocity(Vec3 position) const;
    Vec3 bounced(Vec3 velocity, Vec3 normal, Vec3 surface) const;
    Motion born(uint32_t id) const;
    double lifetime_of(uint32_t id) const;

    ParticleVolumeParameters parameters_;
    std::vector<ReferenceParticle> particles_;
    std::vector<double> birth_delay_; // share of the step that was over when the particle of the slot was born
    uint64_t births_ = 0;
    double due_ = 0.0; // births by rate so far, with fractions
    uint64_t rated_ = 0;
    double time_ = 0.0;
    bool has_begun_ = false;
};

} // namespace sfumato::reference
