// The simulation of particles: against the reference, against closed forms, and what must hold whatever the settings.
#include "tests/gpu/particles_support.h"

#include <cmath>
#include <cstring>

namespace sfumato::test {
namespace {

using scene::operator+;
using scene::operator-;
using scene::operator*;
using scene::dot;
using scene::Vec3;

double length(Vec3 v) {
    return std::sqrt(dot(v, v));
}

class ParticlesSimulation : public GpuTest {};

bool is_alive(const ParticleSprite& sprite) {
    return sprite.radius > 0.0f;
}

bool same_bits(const std::vector<ParticleSprite>& a, const std::vector<ParticleSprite>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(ParticleSprite)) == 0;
}

// ------------------------------------------------------------------------------------------ against the reference

// A wall that leans, a post before it, sky above.
FloatImage obstacles(Extent extent) {
    return make_image(extent, 1, [&](uint32_t x, uint32_t y, float* pixel) {
        const float u = (static_cast<float>(x) + 0.5f) / static_cast<float>(extent.width);
        const float v = (static_cast<float>(y) + 0.5f) / static_cast<float>(extent.height);
        *pixel = v < 0.1f ? 1e10f : u > 0.45f && u < 0.55f ? 4.5f : 7.0f - 2.0f * v + u;
    });
}

std::vector<Collider> solids() {
    std::vector<Collider> made(3);
    made[0].centre = {0, -1.2f, 0};
    made[1].shape = ColliderShape::sphere;
    made[1].centre = {0.4f, 0.2f, -5.0f};
    made[1].size = {0.5f, 1, 1};
    made[1].velocity = {0.3f, 0, 0};
    made[2].shape = ColliderShape::box;
    made[2].centre = {-0.8f, 0, -5.2f};
    made[2].size = {0.3f, 0.6f, 0.4f};
    made[2].axes = {{{0.8f, 0, 0.6f}, {0, 1, 0}, {-0.6f, 0, 0.8f}}};
    return made;
}

struct Comparison {
    const char* name;
    std::function<void(ParticleVolumeParameters&)> change;
};

TEST_F(ParticlesSimulation, agrees_with_the_reference) {
    const Comparison cases[] = {
        {"forces", [](ParticleVolumeParameters& p) { p.collision = ParticleCollision::none; }},
        {"point, no drag",
         [](ParticleVolumeParameters& p) {
             p.emitter = ParticleEmitter::point;
             p.collision = ParticleCollision::none;
             p.drag = 0.0f;
             p.gravity = 9.81f;
         }},
        {"box, large drag",
         [](ParticleVolumeParameters& p) {
             p.emitter = ParticleEmitter::box;
             p.collision = ParticleCollision::none;
             p.drag = 40.0f;
             p.curl_octaves = 4;
         }},
        {"solids", [](ParticleVolumeParameters& p) { p.collision = ParticleCollision::analytic; }},
        {"depth", [](ParticleVolumeParameters& p) { p.collision = ParticleCollision::depth; }},
    };
    const std::vector<Collider> colliders = solids();
    const FloatImage depth = obstacles({64, 48});
    for (const Comparison& item : cases) {
        SCOPED_TRACE(item.name);
        ParticleVolumeParameters p;
        p.count = 150;
        p.rate = 230.0f;
        p.burst = 20;
        p.emitter = ParticleEmitter::sphere;
        p.emitter_size = 0.5f;
        p.position_z = -5.0f;
        p.position_y = -0.5f;
        p.direction_azimuth = 200.0f - 360.0f;
        p.direction_elevation = 20.0f;
        p.spread = 70.0f;
        p.speed = 3.0f;
        p.lifetime = 0.7f;
        p.wind_x = 0.5f;
        p.attractor_strength = 3.0f;
        p.attractor_z = -6.0f;
        p.attractor_y = 2.0f;
        p.seed = 7;
        p.emission = 3.0f;
        p.warm_up = 0.21f;
        p.bounce = 0.6f;
        item.change(p);
        ParticleSimulation simulation(p);
        simulation.set_depth(depth);
        reference::ParticleReference expected(p);
        size_t compared = 0, beyond = 0;
        for (uint64_t index = 0; index < 14; ++index) {
            Frame frame = particle_frame(index, index == 0);
            frame.colliders = colliders;
            frame.time_step = index == 7 ? 0.11f : 0.03f; // one of three steps
            simulation.run(frame);
            expected.run(frame, {depth.extent, depth.values});
            for (size_t slot = 0; slot < simulation.sprites().size(); ++slot) {
                const ParticleSprite a = simulation.sprites()[slot], b = expected.sprite(slot);
                const double d = length(vec(a.position) - vec(b.position)) +
                                 0.1 * length(vec(a.velocity) - vec(b.velocity)) +
                                 std::abs(double{a.radius} - double{b.radius}) +
                                 std::abs(double{a.extinction} - double{b.extinction}) +
                                 std::abs(double{a.emission} - double{b.emission});
                compared += is_alive(b);
                beyond += d <= 2e-3 ? 0 : 1;
            }
        }
        EXPECT_GT(compared, 1200u);
        // A ray that grazes an edge goes either way.
        EXPECT_LE(beyond, compared / 50) << "of " << compared;
    }
}

// ------------------------------------------------------------------------------------------ closed forms

TEST_F(ParticlesSimulation, without_forces_particles_fly_straight) {
    ParticleSimulation simulation(calm_parameters());
    const std::vector<ParticleSprite> first = simulation.run(particle_frame(0, true));
    for (uint64_t index = 1; index <= 24; ++index)
        simulation.run(particle_frame(index));
    for (size_t i = 0; i < first.size(); ++i) {
        ASSERT_TRUE(is_alive(first[i]));
        EXPECT_EQ(first[i].velocity, simulation.sprites()[i].velocity);
        EXPECT_NEAR(length(vec(first[i].velocity)), 1.5, 1e-5);
        EXPECT_LT(length(vec(simulation.sprites()[i].position) - vec(first[i].position) - vec(first[i].velocity)),
                  1e-4);
    }
}

// The same end after one second, however many frames it takes.
TEST_F(ParticlesSimulation, gravity_and_drag_follow_their_closed_form) {
    for (const float drag : {0.0f, 0.001f, 0.7f, 60.0f})
        for (const int frames : {1, 3, 24, 90}) {
            ParticleVolumeParameters p = calm_parameters();
            p.drag = drag;
            p.gravity = 9.81f;
            p.wind_x = 2.0f;
            p.emitter = ParticleEmitter::point;
            ParticleSimulation simulation(p);
            for (int index = 0; index < frames; ++index) {
                Frame frame = particle_frame(static_cast<uint64_t>(index), index == 0);
                frame.time_step = 1.0f / static_cast<float>(frames);
                simulation.run(frame);
            }
            // Averaged over directions that sum to nothing, or one by one: start = what is left of the velocity.
            const double k = double{drag}, g = 9.81;
            for (const ParticleSprite& s : simulation.sprites()) {
                const Vec3 terminal = k > 0.0 ? Vec3{2.0, -g / k, 0.0} : Vec3{};
                const Vec3 v = vec(s.velocity), x = vec(s.position) - Vec3{0, 0, -5};
                if (k > 0.5 && k < 10.0) {
                    // v = T + (v0 - T) e, x = T + (v0 - T) (1 - e) / k
                    const double e = std::exp(-k);
                    const Vec3 apart = (v - terminal) * (1.0 / e);
                    EXPECT_LT(length(x - terminal - apart * ((1.0 - e) / k)), 2e-4) << drag << " " << frames;
                    EXPECT_NEAR(length(apart + terminal), 1.5, 1e-4);
                } else if (k > 10.0) {
                    EXPECT_LT(length(v - terminal), 1e-3);
                } else {
                    EXPECT_LT(length(v + Vec3{0, g, 0} * 0.5 - x), 0.02) << drag << " " << frames;
                    EXPECT_NEAR(length(v + Vec3{0, g, 0}), 1.5, 0.02);
                }
            }
        }
}

TEST_F(ParticlesSimulation, attractors_pull_and_push) {
    for (const float strength : {4.0f, -4.0f}) {
        ParticleVolumeParameters p = calm_parameters();
        p.attractor_strength = strength;
        p.attractor_x = 3.0f;
        p.attractor_z = -5.0f;
        p.speed = 0.0f;
        ParticleSimulation simulation(p);
        simulation.run(particle_frame(0, true));
        for (const ParticleSprite& s : simulation.sprites()) {
            const Vec3 to = Vec3{3, 0, -5} - vec(s.position);
            const double expected = double{strength} / 24.0 * length(to) / (dot(to, to) + 1.0);
            EXPECT_NEAR(dot(vec(s.velocity), to) / length(to), expected, 0.003);
        }
    }
}

// Heights of a ball that bounces go with the square of the restitution.
TEST_F(ParticlesSimulation, bounces_give_back_their_share) {
    ParticleVolumeParameters p = calm_parameters();
    p.count = p.burst = 1;
    p.emitter = ParticleEmitter::point;
    p.speed = 0.0f;
    p.gravity = 9.81f;
    p.collision = ParticleCollision::analytic;
    p.friction = 0.0f;
    p.bounce = 0.8f;
    p.position_y = 1.0f;
    const std::vector<Collider> floor(1);
    for (const float step : {1.0f / 24.0f, 1.0f / 200.0f}) {
        ParticleSimulation simulation(p);
        double highest = 0.0, time = 0.0;
        const double falls = std::sqrt(2.0 / 9.81);
        for (uint64_t index = 0; time < falls * 2.5; ++index) {
            Frame frame = particle_frame(index, index == 0);
            frame.time_step = step;
            frame.colliders = floor;
            const ParticleSprite s = simulation.run(frame)[0];
            time += double{step};
            ASSERT_GE(s.position[1], 0.0f);
            // The height it would rise to, right after the bounce.
            if (time > falls && s.velocity[1] > 0.0f)
                highest = std::max(highest, double{s.position[1]} + double{s.velocity[1] * s.velocity[1]} / 19.62);
        }
        EXPECT_NEAR(highest, 0.64, step > 0.01f ? 0.03 : 0.005) << step;
    }
}

TEST_F(ParticlesSimulation, friction_slows_along_the_surface_and_the_surface_carries) {
    ParticleVolumeParameters p = calm_parameters();
    p.count = p.burst = 1;
    p.emitter = ParticleEmitter::point;
    p.position_y = 0.05f;
    p.direction_elevation = -45.0f;
    p.direction_azimuth = 90.0f; // +x
    p.spread = 0.0f;
    p.speed = 2.0f;
    p.collision = ParticleCollision::analytic;
    p.friction = 0.25f;
    p.bounce = 0.5f;
    std::vector<Collider> floor(1);
    const double side = 2.0 * std::sqrt(0.5);
    for (const float lift : {0.0f, 1.0f}) {
        floor[0].velocity = {0, lift, 0};
        ParticleSimulation simulation(p);
        Frame frame = particle_frame(0, true);
        frame.colliders = floor;
        const ParticleSprite s = simulation.run(frame)[0];
        EXPECT_NEAR(double{s.velocity[0]}, 0.75 * side, 1e-4);
        EXPECT_NEAR(double{s.velocity[1]}, double{lift} + 0.5 * (side + double{lift}), 1e-4);
    }
}

// ------------------------------------------------------------------------------------------ collisions

// Whatever moves, nothing ends a frame inside a solid.
TEST_F(ParticlesSimulation, particles_never_end_inside_solids) {
    ParticleVolumeParameters p = calm_parameters();
    p.count = 600;
    p.burst = 300;
    p.rate = 1000.0f;
    p.lifetime = 1.0f;
    p.emitter = ParticleEmitter::box;
    p.emitter_size = 1.5f; // births inside solids too
    p.speed = 20.0f;
    p.gravity = 9.81f;
    p.drag = 0.5f;
    p.wind_z = -6.0f;
    p.curl_strength = 3.0f;
    p.collision = ParticleCollision::analytic;
    std::vector<Collider> colliders = solids();
    colliders[1].size[0] = 0.45f;
    colliders.push_back(colliders[2]);
    colliders[3].centre = {0, 0.5f, -9.0f};
    colliders[3].size = {9.0f, 9.0f, 0.01f}; // thin
    colliders[3].axes = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    ParticleSimulation simulation(p);
    size_t seen = 0, passed = 0;
    for (uint64_t index = 0; index < 30; ++index) {
        colliders[1].centre[0] = 0.4f + 0.3f * static_cast<float>(index) / 24.0f;
        Frame frame = particle_frame(index, index == 0);
        frame.colliders = colliders;
        for (const ParticleSprite& s : simulation.run(frame)) {
            if (!is_alive(s))
                continue;
            ++seen;
            for (const Collider& collider : colliders)
                ASSERT_GE(reference::ParticleReference::distance(collider, vec(s.position)), -2e-5)
                    << "frame " << index;
            passed += s.position[2] < -9.0f && std::abs(s.position[0]) < 7.0f && std::abs(s.position[1]) < 7.0f;
        }
    }
    EXPECT_GT(seen, 10000u);
    EXPECT_EQ(passed, 0u) << "through the thin wall";
}

// Shot at a wall that only the depth image knows, faster in a step than it is thick.
TEST_F(ParticlesSimulation, visible_surfaces_stop_particles) {
    ParticleVolumeParameters p = calm_parameters();
    p.count = p.burst = 400;
    p.emitter = ParticleEmitter::disc;
    p.emitter_size = 0.3f;
    p.position_z = -2.0f;
    p.direction_elevation = 0.0f;
    p.direction_azimuth = 180.0f; // -z
    p.spread = 30.0f;
    p.speed = 25.0f;
    p.collision = ParticleCollision::depth;
    p.collision_thickness = 0.02f;
    p.bounce = 0.5f;
    for (const Extent extent : {Extent{64, 48}, Extent{1, 1}}) {
        ParticleSimulation simulation(p);
        simulation.set_depth(make_image(extent, 1, [](uint32_t, uint32_t, float* pixel) { *pixel = 6.0f; }));
        size_t back = 0;
        for (uint64_t index = 0; index < 8; ++index)
            for (const ParticleSprite& s : simulation.run(particle_frame(index, index == 0))) {
                ASSERT_GE(s.position[2], -6.001f) << "frame " << index;
                back += s.velocity[2] > 8.0f && s.velocity[2] < 13.0f;
            }
        EXPECT_GT(back, 1000u);
    }
}

TEST_F(ParticlesSimulation, what_the_camera_does_not_see_stops_nothing) {
    ParticleVolumeParameters p = calm_parameters();
    p.emitter_size = 0.1f;
    p.speed = 4.0f;
    p.spread = 20.0f;
    p.direction_elevation = 0.0f;
    // Behind the camera, left of its view, and hidden behind the wall.
    const std::array<float, 4> places[] = {{0, 0, 3, 0}, {-9, 0, -5, -90}, {0, 0, -8, 180}};
    for (const auto& place : places) {
        p.position_x = place[0];
        p.position_z = place[2];
        p.direction_azimuth = place[3];
        ParticleVolumeParameters free = p;
        p.collision = ParticleCollision::depth;
        ParticleSimulation simulation(p), other(free);
        simulation.set_depth(make_image({32, 32}, 1, [](uint32_t, uint32_t, float* pixel) { *pixel = 4.0f; }));
        for (uint64_t index = 0; index < 10; ++index)
            EXPECT_TRUE(same_bits(simulation.run(particle_frame(index, index == 0)),
                                  other.run(particle_frame(index, index == 0))));
    }
}

// ------------------------------------------------------------------------------------------ births and deaths

TEST_F(ParticlesSimulation, births_are_exactly_rate_times_time) {
    for (const float rate : {0.0f, 0.3f, 7.31f, 1000.0f}) {
        ParticleVolumeParameters p = calm_parameters();
        p.count = 4000;
        p.burst = 0;
        p.rate = rate;
        ParticleSimulation simulation(p);
        double time = 0.0;
        for (uint64_t index = 0; index < 150; ++index) {
            Frame frame = particle_frame(index, index == 0);
            frame.time_step = index % 3 == 0 ? 0.0173f : 0.0031f;
            time += double{frame.time_step};
            simulation.run(frame);
            ASSERT_EQ(simulation.alive(), static_cast<size_t>(std::floor(double{rate} * time + 1e-6)))
                << rate << " after " << time;
        }
    }
}

// No clumps: in a stream of fast particles neighbours lie equally far apart, within a frame and across frames.
TEST_F(ParticlesSimulation, births_are_spread_over_the_step) {
    ParticleVolumeParameters p = calm_parameters();
    p.burst = 0;
    p.rate = 240.0f;
    p.emitter = ParticleEmitter::point;
    p.spread = 0.0f;
    p.speed = 24.0f;
    ParticleSimulation simulation(p);
    for (uint64_t index = 0; index < 4; ++index)
        simulation.run(particle_frame(index, index == 0));
    for (size_t i = 1; i < 40; ++i)
        EXPECT_NEAR(simulation.sprites()[i - 1].position[1] - simulation.sprites()[i].position[1], 0.1f, 1e-4f) << i;
}

TEST_F(ParticlesSimulation, particles_die_of_age) {
    ParticleVolumeParameters p = calm_parameters();
    p.lifetime = 0.49f; // 12 frames
    ParticleSimulation simulation(p);
    for (uint64_t index = 0; index < 14; ++index) {
        simulation.run(particle_frame(index, index == 0));
        EXPECT_EQ(simulation.alive(), index < 11 ? 64u : 0u) << index;
    }
    p.lifetime_variation = 0.5f; // 6 to 18 frames
    ParticleSimulation varied(p);
    size_t before = 64;
    for (uint64_t index = 0; index < 18; ++index) {
        varied.run(particle_frame(index, index == 0));
        EXPECT_LE(varied.alive(), before);
        before = varied.alive();
        if (index == 4) {
            EXPECT_EQ(before, 64u);
        }
        if (index == 11) {
            EXPECT_TRUE(before > 15 && before < 49) << before;
        }
    }
    EXPECT_EQ(before, 0u);
}

TEST_F(ParticlesSimulation, the_oldest_make_way_and_every_slot_is_used) {
    for (const int burst : {0, 5, 10000}) {
        ParticleVolumeParameters p = calm_parameters();
        p.count = 37;
        p.burst = burst;
        p.rate = 300.0f; // more than the count in a frame of 1/4 s
        ParticleSimulation simulation(p);
        for (uint64_t index = 0; index < 3; ++index) {
            Frame frame = particle_frame(index, index == 0);
            frame.time_step = 0.25f;
            simulation.run(frame);
            EXPECT_EQ(simulation.alive(), 37u);
            // Newborn ones alone: none is older than 37 births.
            for (const ParticleSprite& s : simulation.sprites())
                EXPECT_LT(length(vec(s.position) - Vec3{0, 0, -5}), 1.0 + 1.5 * 38.0 / 300.0);
        }
    }
    ParticleVolumeParameters p = calm_parameters();
    p.count = 1;
    p.burst = 3;
    p.rate = 24.0f;
    ParticleSimulation single(p);
    for (uint64_t index = 0; index < 5; ++index) {
        single.run(particle_frame(index, index == 0));
        EXPECT_EQ(single.alive(), 1u);
    }
}

// ------------------------------------------------------------------------------------------ determinism

ParticleVolumeParameters lively_parameters() {
    ParticleVolumeParameters p;
    p.count = 700;
    p.rate = 400.0f;
    p.burst = 100;
    p.position_z = -5.0f;
    p.lifetime = 1.0f;
    p.warm_up = 0.0f;
    return p;
}

TEST_F(ParticlesSimulation, equal_input_gives_equal_bits_and_a_reset_begins_anew) {
    ParticleVolumeParameters p = lively_parameters();
    p.warm_up = 3.0f; // more than one pass
    ParticleSimulation a(p, 0), b(p, 1);
    const FloatImage depth = obstacles({64, 48});
    const std::vector<Collider> colliders = solids();
    std::vector<std::vector<ParticleSprite>> first;
    for (ParticleSimulation* simulation : {&a, &b}) {
        simulation->set_depth(depth);
        for (uint64_t index = 0; index < 8; ++index) {
            Frame frame = particle_frame(index, index % 4 == 0);
            frame.colliders = colliders;
            first.push_back(simulation->run(frame));
        }
    }
    for (size_t i = 0; i < 4; ++i)
        for (const size_t other : {i + 4, i + 8, i + 12})
            EXPECT_TRUE(same_bits(first[i], first[other])) << i << " and " << other;
    EXPECT_FALSE(same_bits(first[0], first[1]));
    p.seed = 1;
    ParticleSimulation c(p);
    EXPECT_FALSE(same_bits(first[0], c.run(particle_frame(0, true))));
}

// Simulated at once or frame by frame: the same cloud.
TEST_F(ParticlesSimulation, warming_up_equals_waiting) {
    ParticleVolumeParameters p = lively_parameters();
    p.collision = ParticleCollision::none;
    ParticleSimulation waits(p);
    for (uint64_t index = 0; index < 97; ++index)
        waits.run(particle_frame(index, index == 0));
    p.warm_up = 4.0f;
    ParticleSimulation warm(p);
    warm.run(particle_frame(0, true));
    EXPECT_EQ(warm.alive(), waits.alive());
    size_t near = 0;
    for (size_t i = 0; i < waits.sprites().size(); ++i)
        near += length(vec(waits.sprites()[i].position) - vec(warm.sprites()[i].position)) < 2e-3;
    EXPECT_GE(near, waits.sprites().size() * 99 / 100);
}

TEST_F(ParticlesSimulation, a_time_scale_of_zero_stands_still) {
    ParticleSimulation simulation(lively_parameters());
    for (uint64_t index = 0; index < 5; ++index)
        simulation.run(particle_frame(index, index == 0));
    const std::vector<ParticleSprite> before = simulation.sprites();
    EXPECT_GT(simulation.alive(), 100u);
    simulation.parameters.time_scale = 0.0f;
    for (uint64_t index = 5; index < 8; ++index)
        EXPECT_TRUE(same_bits(before, simulation.run(particle_frame(index))));
    simulation.parameters.time_scale = 1.0f;
    EXPECT_FALSE(same_bits(before, simulation.run(particle_frame(8))));
}

// ------------------------------------------------------------------------------------------ broken states

TEST_F(ParticlesSimulation, states_that_are_not_finite_die) {
    ParticleVolumeParameters p = lively_parameters();
    p.rate = 0.0f;
    p.burst = 700;
    p.lifetime = 100.0f;
    ParticleSimulation simulation(p);
    simulation.set_depth(obstacles({64, 48}));
    const std::span<uint32_t> states = simulation.states();
    const std::vector<Collider> colliders = solids();
    const auto frame_at = [&](uint64_t index) {
        Frame frame = particle_frame(index, index == 0);
        frame.colliders = colliders;
        return frame;
    };
    simulation.run(frame_at(0));
    ASSERT_EQ(simulation.alive(), 700u);
    const float wild[] = {NAN, INFINITY, -INFINITY, 1e30f, -1e30f};
    size_t broken = 0;
    for (size_t component = 0; component < 7; ++component) // not the age's and the number's place
        for (const float value : wild)
            if (component != 3)
                std::memcpy(&states[8 * (broken++) + component], &value, 4);
    simulation.run(frame_at(1));
    EXPECT_EQ(simulation.alive(), 700u - broken);
    for (const ParticleSprite& s : simulation.sprites())
        for (const float value : {s.position[0], s.position[1], s.position[2], s.velocity[0], s.velocity[1],
                                  s.velocity[2], s.extinction, s.emission, s.radius})
            EXPECT_TRUE(std::isfinite(value));
}

TEST_F(ParticlesSimulation, wild_depth_breaks_nothing) {
    ParticleVolumeParameters p = lively_parameters();
    p.collision = ParticleCollision::depth;
    for (const float value : {NAN, INFINITY, -INFINITY, 0.0f, -3.0f, 1e-41f, 1e30f}) {
        ParticleSimulation simulation(p);
        simulation.set_depth(
            make_image({9, 7}, 1, [&](uint32_t x, uint32_t, float* pixel) { *pixel = x % 2 == 0 ? value : 5.0f; }));
        for (uint64_t index = 0; index < 6; ++index)
            for (const ParticleSprite& s : simulation.run(particle_frame(index, index == 0)))
                ASSERT_TRUE(std::isfinite(s.position[0] + s.position[1] + s.position[2] + s.velocity[0]));
    }
}

// ------------------------------------------------------------------------------------------ the field of eddies

TEST(CurlNoise, has_no_divergence_and_mean_square_one) {
    double squares = 0.0, divergence = 0.0, slopes = 0.0;
    constexpr int count = 5000;
    for (int i = 0; i < count; ++i) {
        const Vec3 p = {0.731 * i, 0.377 * i - 40.0, 0.513 * i + 3.0};
        const auto at = [&](double x, double y, double z) {
            return reference::curl_noise(p + Vec3{x, y, z}, 0.01 * i, 5);
        };
        const double e = 1e-3;
        const Vec3 v = at(0, 0, 0);
        squares += dot(v, v) / count;
        const double dx = (at(e, 0, 0).x - at(-e, 0, 0).x) / (2 * e);
        const double dy = (at(0, e, 0).y - at(0, -e, 0).y) / (2 * e);
        const double dz = (at(0, 0, e).z - at(0, 0, -e).z) / (2 * e);
        divergence += (dx + dy + dz) * (dx + dy + dz) / count;
        slopes += (dx * dx + dy * dy + dz * dz) / count;
    }
    EXPECT_NEAR(squares, 1.0, 0.05);
    EXPECT_GT(slopes, 1.0);
    EXPECT_LT(divergence, 1e-5 * slopes);
}

// ------------------------------------------------------------------------------------------ plans

TEST(ParticlePlan, hosts_own_sprites_are_not_simulated) {
    ParticleVolumeParameters parameters;
    ParticleVolumeImages images;
    images.colour = images.output = {VK_NULL_HANDLE, VK_NULL_HANDLE, VK_FORMAT_R16G16B16A16_SFLOAT, {16, 9}};
    images.depth = {VK_NULL_HANDLE, VK_NULL_HANDLE, VK_FORMAT_R32_SFLOAT, {16, 9}};
    const auto has_state = [&] {
        const Plan plan = expect_value(ParticleVolume::plan(particle_frame(0), parameters, images), "plan");
        return std::any_of(plan.resources.begin(), plan.resources.end(),
                           [](const Resource& r) { return r.kind == ResourceKind::state; });
    };
    EXPECT_TRUE(has_state());
    images.sprites = {VK_NULL_HANDLE, 0, 48 * 10};
    EXPECT_FALSE(has_state());
    // Four million are one dispatch, and hours are no more passes than a minute.
    images.sprites = {};
    parameters.count = most_particles;
    parameters.warm_up = 60.0f;
    parameters.time_scale = 10.0f;
    Frame frame = particle_frame(0, true);
    frame.time_step = 1e6f;
    const Plan plan = expect_value(ParticleVolume::plan(frame, parameters, images), "plan");
    EXPECT_LE(std::count_if(plan.passes.begin(), plan.passes.end(), [](const Pass& p) { return p.name == "simulate"; }),
              32);
}

} // namespace
} // namespace sfumato::test
