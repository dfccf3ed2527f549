// The simulation of particles alone, without drawing, with its sprites and states readable.
#pragma once

#include "tests/gpu/gpu_test.h"
#include "tests/reference/particles_reference.h"

namespace sfumato::test {

class ParticleSimulation {
  public:
    // A depth image of sky unless `depth` says otherwise.
    explicit ParticleSimulation(const ParticleVolumeParameters& parameters, int poison = 0);

    ParticleVolumeParameters parameters;

    void set_depth(const FloatImage& depth);
    const std::vector<ParticleSprite>& run(const Frame& frame);
    const std::vector<ParticleSprite>& sprites() const { return sprites_; }
    size_t alive() const;

    // Eight words a particle, see particles_simulate.glsl; for tests that break them. Kept outside the executor: a
    // reset does not clear them.
    std::span<uint32_t> states();

  private:
    std::unique_ptr<Context> context_;
    std::unique_ptr<Executor> executor_;
    apps::HostImage colour_, output_, depth_;
    apps::HostBuffer sprite_buffer_, state_buffer_;
    bool own_states_ = false;
    std::vector<ParticleSprite> sprites_;
};

// Nothing acts on the particles: no force, no air, no collision, all alive for 1000 s, constant look.
ParticleVolumeParameters calm_parameters();

// A camera at the origin that looks along -z, 90° high and wide; linear depth. Frames of 1/24 s.
Frame particle_frame(uint64_t index, bool reset = false);

inline scene::Vec3 vec(const std::array<float, 3>& v) {
    return {double{v[0]}, double{v[1]}, double{v[2]}};
}

} // namespace sfumato::test
