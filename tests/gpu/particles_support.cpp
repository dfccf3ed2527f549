#include "tests/gpu/particles_support.h"

#include <algorithm>
#include <cstring>

namespace sfumato::test {

ParticleSimulation::ParticleSimulation(const ParticleVolumeParameters& given, int poison)
    : parameters(given), context_(make_context(poison)),
      executor_(expect_value(Executor::create(*context_), "executor")) {
    colour_ = expect_value(device().create_image(VK_FORMAT_R16G16B16A16_SFLOAT, {4, 4}), "colour");
    output_ = expect_value(device().create_image(VK_FORMAT_R16G16B16A16_SFLOAT, {4, 4}), "output");
    set_depth(make_image({4, 4}, 1, [](uint32_t, uint32_t, float* pixel) { *pixel = 1e10f; }));
    const auto count = static_cast<size_t>(parameters.count);
    sprite_buffer_ = expect_value(device().create_buffer(count * sizeof(ParticleSprite)), "sprites");
    sprites_.resize(count);
}

void ParticleSimulation::set_depth(const FloatImage& depth) {
    depth_ = upload(depth, VK_FORMAT_R32_SFLOAT);
}

std::span<uint32_t> ParticleSimulation::states() {
    if (!own_states_) {
        state_buffer_ = expect_value(device().create_buffer(sprites_.size() * 32), "states");
        std::memset(state_buffer_.bytes().data(), 0, state_buffer_.bytes().size());
        own_states_ = true;
    }
    return {reinterpret_cast<uint32_t*>(state_buffer_.bytes().data()), sprites_.size() * 8};
}

// The effect's own plan, with what the tests look at moved into host memory, and without the passes that draw.
const std::vector<ParticleSprite>& ParticleSimulation::run(const Frame& frame) {
    ParticleVolumeImages images;
    images.colour = colour_.image();
    images.depth = depth_.image();
    images.output = output_.image();
    Plan plan = expect_value(ParticleVolume::plan(frame, parameters, images), "plan");
    std::erase_if(plan.passes, [](const Pass& pass) { return pass.name != "simulate" && pass.name != "advance"; });
    for (Resource& resource : plan.resources) {
        if (resource.name == "sprites") {
            resource.kind = ResourceKind::host_buffer;
            resource.index = 0;
        } else if (resource.kind == ResourceKind::state && resource.name == "particles" && own_states_) {
            resource.kind = ResourceKind::host_buffer;
            resource.index = 1;
        }
    }
    place_barriers(plan);
    const std::array host_images = {images.colour, images.depth, Image{}, Image{}, Image{}, Image{}, images.output};
    const std::array buffers = {sprite_buffer_.buffer(), own_states_ ? state_buffer_.buffer() : Buffer{}};
    run_commands([&](VkCommandBuffer commands) {
        expect_done(executor_->execute(commands, plan, host_images, frame.index, frame.reset, buffers), "execute");
        show_host(commands);
    });
    std::memcpy(sprites_.data(), sprite_buffer_.bytes().data(), sprite_buffer_.bytes().size());
    return sprites_;
}

size_t ParticleSimulation::alive() const {
    return static_cast<size_t>(
        std::count_if(sprites_.begin(), sprites_.end(), [](const ParticleSprite& s) { return s.radius > 0.0f; }));
}

ParticleVolumeParameters calm_parameters() {
    ParticleVolumeParameters p;
    p.count = 64;
    p.burst = 64;
    p.rate = 0.0f;
    p.emitter = ParticleEmitter::sphere;
    p.emitter_size = 1.0f;
    p.position_z = -5.0f;
    p.spread = 180.0f;
    p.warm_up = 0.0f;
    p.lifetime = 1000.0f;
    p.lifetime_variation = 0.0f;
    p.gravity = p.drag = p.curl_strength = 0.0f;
    p.collision = ParticleCollision::none;
    p.fade_in = p.fade_out = 0.0f;
    return p;
}

Frame particle_frame(uint64_t index, bool reset) {
    Frame frame;
    frame.index = index;
    frame.time_step = 1.0f / 24.0f;
    frame.reset = reset;
    frame.camera.emplace();
    frame.camera->projection = {1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 0, -1, 0, 0, 0.1f, 0};
    return frame;
}

} // namespace sfumato::test
