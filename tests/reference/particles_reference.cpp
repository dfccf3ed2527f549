#include "tests/reference/particles_reference.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sfumato::reference {

using scene::cross;
using scene::dot;
using scene::normalised;
using scene::operator+;
using scene::operator-;
using scene::operator*;

namespace {

constexpr double clearance = 1e-4;
constexpr double two_pi = 6.283185307179586;

uint32_t mix_bits(uint32_t h) {
    h = (h ^ h >> 16) * 0x7feb352du;
    h = (h ^ h >> 15) * 0x846ca68bu;
    return h ^ h >> 16;
}

double random(uint32_t& state) {
    state = state * 747796405u + 2891336453u;
    return static_cast<double>(mix_bits(state) >> 8) / 16777216.0;
}

Vec3 lattice_gradient(uint32_t h) {
    const auto part = [&](uint32_t shift) { return static_cast<double>(h >> shift & 1023u) * (2.0 / 1023.0) - 1.0; };
    return {part(0), part(10), part(20)};
}

// One noise: gradients that turn between two of their own.
double gradient_noise(Vec3 p, double turns, uint32_t factors[2], uint32_t offsets[2], uint32_t salt) {
    const Vec3 base = {std::floor(p.x), std::floor(p.y), std::floor(p.z)};
    double sum = 0.0;
    for (uint32_t i = 0; i < 8; ++i) {
        const Vec3 corner =
            base + Vec3{static_cast<double>(i & 1), static_cast<double>(i >> 1 & 1), static_cast<double>(i >> 2)};
        const auto cell = [](double v) { return static_cast<uint32_t>(static_cast<int64_t>(v)); };
        const uint32_t h =
            mix_bits(cell(corner.x) * 0x9e3779b1u ^ cell(corner.y) * 0x85ebca77u ^ cell(corner.z) * 0xc2b2ae3du ^ salt);
        const Vec3 gradient = lattice_gradient(h * factors[0] + offsets[0]) * std::cos(two_pi * turns) +
                              lattice_gradient(h * factors[1] + offsets[1]) * std::sin(two_pi * turns);
        const Vec3 from = p - corner;
        const auto weight = [](double x) {
            const double t = 1.0 - std::abs(x);
            return t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
        };
        sum += weight(from.x) * weight(from.y) * weight(from.z) * dot(gradient, from);
    }
    return sum;
}

// Central differences instead of the shader's exact derivatives.
template <class Function>
Vec3 gradient(const Function& f, Vec3 p) {
    const double e = 1e-4;
    return Vec3{f(p + Vec3{e, 0, 0}) - f(p - Vec3{e, 0, 0}), f(p + Vec3{0, e, 0}) - f(p - Vec3{0, e, 0}),
                f(p + Vec3{0, 0, e}) - f(p - Vec3{0, 0, e})} *
           (0.5 / e);
}

Vec3 vec(const std::array<float, 3>& v) {
    return {double{v[0]}, double{v[1]}, double{v[2]}};
}

struct Matrix {
    const Matrix4& m;
    std::array<double, 4> operator*(std::array<double, 4> v) const {
        std::array<double, 4> r{};
        for (size_t row = 0; row < 4; ++row)
            for (size_t column = 0; column < 4; ++column)
                r[row] += double{m[column * 4 + row]} * v[column];
        return r;
    }
};

// For poses: a rotation and a translation.
Vec3 to_view(const Matrix4& m, Vec3 p) {
    const auto r = Matrix{m} * std::array<double, 4>{p.x, p.y, p.z, 1.0};
    return {r[0], r[1], r[2]};
}
Vec3 turned_to_world(const Matrix4& m, Vec3 v) {
    const auto column = [&](size_t c) {
        return double{m[c * 4]} * v.x + double{m[c * 4 + 1]} * v.y + double{m[c * 4 + 2]} * v.z;
    };
    return {column(0), column(1), column(2)};
}
Vec3 to_world(const Matrix4& m, Vec3 p) {
    return turned_to_world(m, p - Vec3{double{m[12]}, double{m[13]}, double{m[14]}});
}

bool is_sky(double depth) {
    return !(std::isfinite(depth) && depth < 1e9);
}

} // namespace

Vec3 curl_noise(Vec3 p, double time, uint32_t salt) {
    uint32_t first_factors[] = {1u, 0x2c1b3c6du}, first_offsets[] = {0u, 1u};
    uint32_t second_factors[] = {0x297a2d39u, 0x4f1bbcdbu}, second_offsets[] = {3u, 7u};
    const Vec3 a =
        gradient([&](Vec3 q) { return gradient_noise(q, 0.5 * time, first_factors, first_offsets, salt); }, p);
    const Vec3 b =
        gradient([&](Vec3 q) { return gradient_noise(q, 0.3090170 * time, second_factors, second_offsets, salt); }, p);
    return cross(a, b) * 1.663;
}

ParticleReference::ParticleReference(const ParticleVolumeParameters& parameters)
    : parameters_(parameters), particles_(static_cast<size_t>(parameters.count)), birth_delay_(particles_.size()) {}

double ParticleReference::lifetime_of(uint32_t id) const {
    uint32_t state = mix_bits(id ^ mix_bits(static_cast<uint32_t>(parameters_.seed) + 0x9e3779b9u)) ^ 0x5bd1e995u;
    const double variation = double{parameters_.lifetime_variation} * (2.0 * random(state) - 1.0);
    return std::max(1e-3, double{parameters_.lifetime} * (1.0 + variation));
}

ParticleReference::Motion ParticleReference::born(uint32_t id) const {
    const ParticleVolumeParameters& p = parameters_;
    uint32_t state = mix_bits(id ^ mix_bits(static_cast<uint32_t>(p.seed) + 0x9e3779b9u));
    const double a = random(state), b = random(state), c = random(state);
    Vec3 place = {};
    if (p.emitter == ParticleEmitter::sphere) {
        const double z = 1.0 - 2.0 * a, r = std::sqrt(1.0 - z * z);
        place = Vec3{r * std::cos(two_pi * b), r * std::sin(two_pi * b), z} * std::cbrt(c);
    } else if (p.emitter == ParticleEmitter::box) {
        place = {2.0 * a - 1.0, 2.0 * b - 1.0, 2.0 * c - 1.0};
    } else if (p.emitter == ParticleEmitter::disc) {
        place = Vec3{std::cos(two_pi * b), 0.0, std::sin(two_pi * b)} * std::sqrt(a);
    }
    const double azimuth = scene::radians(double{p.direction_azimuth});
    const double elevation = scene::radians(double{p.direction_elevation});
    const Vec3 axis = {std::cos(elevation) * std::sin(azimuth), std::sin(elevation),
                       std::cos(elevation) * std::cos(azimuth)};
    const double u = random(state), v = random(state);
    const double along = 1.0 - u * (1.0 - std::cos(scene::radians(double{p.spread})));
    const double across = std::sqrt(std::max(0.0, 1.0 - along * along));
    const Vec3 side = normalised(cross(std::abs(axis.y) < 0.9 ? Vec3{0, 1, 0} : Vec3{1, 0, 0}, axis));
    const Vec3 direction =
        axis * along + (side * std::cos(two_pi * v) + cross(axis, side) * std::sin(two_pi * v)) * across;
    const Vec3 middle = {double{p.position_x}, double{p.position_y}, double{p.position_z}};
    return {middle + place * double{p.emitter_size}, direction * double{p.speed}};
}

void ParticleReference::give_birth(double step) {
    const uint64_t count = particles_.size();
    const auto put = [&](double delay) {
        const size_t slot = births_++ % count;
        const auto id = static_cast<uint32_t>(births_);
        const Motion start = born(id);
        particles_[slot] = {start.position, start.velocity, 0.0, id};
        birth_delay_[slot] = delay;
    };
    if (!has_begun_)
        for (uint64_t i = 0; i < std::min<uint64_t>(static_cast<uint64_t>(parameters_.burst), count); ++i)
            put(0.0);
    has_begun_ = true;
    due_ += double{parameters_.rate} * step;
    // Sums of fractions come out a hair below whole numbers.
    const uint64_t births = static_cast<uint64_t>(std::floor(due_ + 1e-7)) - rated_;
    for (uint64_t i = 0; i < births; ++i)
        put((static_cast<double>(i) + 0.5) / static_cast<double>(births));
    rated_ += births;
}

void ParticleReference::run(const Frame& frame, const DepthImage& depth) {
    const ParticleVolumeParameters& p = parameters_;
    if (frame.reset)
        *this = ParticleReference(p);
    const double seconds =
        std::min(double{frame.time_step} * double{p.time_scale}, 60.0) + (frame.reset ? double{p.warm_up} : 0.0);
    if (seconds == 0.0)
        return;
    const double steps = std::clamp(std::ceil(seconds * 24.0 - 1e-3), 1.0, 2048.0);
    const double step = seconds / steps;
    for (int i = 0; i < static_cast<int>(steps); ++i) {
        std::fill(birth_delay_.begin(), birth_delay_.end(), 0.0);
        give_birth(step);
        for (size_t slot = 0; slot < particles_.size(); ++slot)
            if (particles_[slot].id != 0)
                move(particles_[slot], step * (1.0 - birth_delay_[slot]), frame, depth);
        time_ += step;
    }
}

void ParticleReference::move(ReferenceParticle& particle, double step, const Frame& frame,
                             const DepthImage& depth) const {
    const ParticleCollision kind = parameters_.collision;
    const Motion before = {particle.position, particle.velocity};
    Motion after = driven(particle, step);
    if (kind == ParticleCollision::analytic || kind == ParticleCollision::both)
        after = collide_with_shapes(before, after, step, frame);
    if (kind == ParticleCollision::depth || kind == ParticleCollision::both)
        after = collide_with_depth(before, after, frame, depth);
    particle.position = after.position;
    particle.velocity = after.velocity;
    particle.age += step;
    if (particle.age >= lifetime_of(particle.id))
        particle = {};
}

Vec3 ParticleReference::air_velocity(Vec3 position) const {
    const ParticleVolumeParameters& p = parameters_;
    Vec3 velocity = {double{p.wind_x}, double{p.wind_y}, double{p.wind_z}};
    double squares = 0.0;
    for (int octave = 0; octave < p.curl_octaves; ++octave)
        squares += std::pow(0.7, 2 * octave);
    for (int octave = 0; octave < p.curl_octaves; ++octave) {
        const double frequency = std::pow(2.0, octave) / double{p.curl_scale};
        const double strength = double{p.curl_strength} * std::pow(0.7, octave) / std::sqrt(squares);
        const double turns = double{p.curl_speed} * std::pow(1.6, octave) * time_;
        const uint32_t salt = static_cast<uint32_t>(p.seed) * 31u + static_cast<uint32_t>(octave);
        velocity = velocity + curl_noise(position * frequency, turns, salt) * strength;
    }
    return velocity;
}

ParticleReference::Motion ParticleReference::driven(const ReferenceParticle& particle, double step) const {
    const ParticleVolumeParameters& p = parameters_;
    const double drag = double{p.drag};
    Vec3 push = {0, -double{p.gravity}, 0};
    const Vec3 to = Vec3{double{p.attractor_x}, double{p.attractor_y}, double{p.attractor_z}} - particle.position;
    push = push + to * (double{p.attractor_strength} / (dot(to, to) + 1.0));
    if (drag < 1e-9)
        return {particle.position + particle.velocity * step + push * (0.5 * step * step),
                particle.velocity + push * step};
    // dv/dt = drag (air - v) + push: towards a terminal velocity.
    const Vec3 terminal = air_velocity(particle.position) + push * (1.0 / drag);
    const double stays = std::exp(-drag * step);
    return {particle.position + terminal * step + (particle.velocity - terminal) * (-std::expm1(-drag * step) / drag),
            terminal + (particle.velocity - terminal) * stays};
}

Vec3 ParticleReference::bounced(Vec3 velocity, Vec3 normal, Vec3 surface) const {
    const Vec3 relative = velocity - surface;
    const double approach = dot(relative, normal);
    if (approach >= 0.0)
        return velocity;
    return surface + (relative - normal * approach) * (1.0 - double{parameters_.friction}) -
           normal * (approach * double{parameters_.bounce});
}

double ParticleReference::distance(const Collider& collider, Vec3 position, Vec3* normal) {
    const Vec3 from = position - vec(collider.centre);
    const std::array<Vec3, 3> axes = {vec(collider.axes[0]), vec(collider.axes[1]), vec(collider.axes[2])};
    Vec3 unit = axes[1];
    double result = dot(from, axes[1]);
    if (collider.shape == ColliderShape::sphere) {
        const double length = std::sqrt(dot(from, from));
        unit = from * (1.0 / length);
        result = length - double{collider.size[0]};
    } else if (collider.shape == ColliderShape::box) {
        result = -1e30;
        for (size_t i = 0; i < 3; ++i) {
            const double along = dot(from, axes[i]), face = std::abs(along) - double{collider.size[i]};
            if (face > result) {
                result = face;
                unit = axes[i] * (along < 0.0 ? -1.0 : 1.0);
            }
        }
    }
    if (normal)
        *normal = unit;
    return result;
}

namespace {

// The first change from outside to inside on the way from a to b, by looking closely instead of solving equations.
double entry(const Collider& collider, Vec3 a, Vec3 b) {
    constexpr int parts = 400;
    const Vec3 way = b - a;
    const auto is_outside = [&](double t) { return ParticleReference::distance(collider, a + way * t) >= 0.0; };
    if (!is_outside(0.0))
        return 2.0;
    for (int i = 1; i <= parts; ++i) {
        double outside = (i - 1.0) / parts, inside = static_cast<double>(i) / parts;
        if (is_outside(inside))
            continue;
        for (int halving = 0; halving < 50; ++halving) {
            const double middle = 0.5 * (outside + inside);
            (is_outside(middle) ? outside : inside) = middle;
        }
        return outside;
    }
    return 2.0;
}

} // namespace

ParticleReference::Motion ParticleReference::collide_with_shapes(const Motion& before, Motion after, double step,
                                                                 const Frame& frame) const {
    Motion start = before;
    for (int meeting = 0; meeting < 3; ++meeting) {
        double first = 2.0;
        const Collider* hit = nullptr;
        for (const Collider& collider : frame.colliders)
            if (const double t = entry(collider, start.position, after.position); t < first) {
                first = t;
                hit = &collider;
            }
        if (!hit)
            break;
        const Vec3 place = start.position + (after.position - start.position) * first;
        Vec3 normal;
        distance(*hit, place, &normal);
        const Vec3 change = (after.velocity - start.velocity) * (1.0 - first);
        step *= 1.0 - first;
        start.velocity = bounced(after.velocity - change, normal, vec(hit->velocity));
        start.position = place + normal * clearance;
        after.velocity = start.velocity + change;
        after.position = start.position;
        if (meeting < 2)
            after.position = after.position + (start.velocity + after.velocity) * (0.5 * step);
    }
    for (int round = 0; round < 2; ++round)
        for (const Collider& collider : frame.colliders) {
            Vec3 normal;
            const double inside = distance(collider, after.position, &normal);
            if (inside >= 0.0)
                continue;
            after.position = after.position + normal * (clearance - inside);
            after.velocity = bounced(after.velocity, normal, vec(collider.velocity));
        }
    return after;
}

namespace {

// Reads a depth image as a height field, for one camera.
struct Surface {
    const DepthImage& image;
    const Matrix4& projection;

    double at(int x, int y) const {
        const int column = std::clamp(x, 0, static_cast<int>(image.extent.width) - 1);
        const int row = std::clamp(y, 0, static_cast<int>(image.extent.height) - 1);
        return double{image.values[static_cast<size_t>(row) * image.extent.width + static_cast<size_t>(column)]};
    }
    Vec3 unproject(double x, double y, double depth) const {
        const Matrix4& p = projection;
        const double w = double{p[15]} - double{p[11]} * depth;
        return {(x * w + double{p[8]} * depth - double{p[12]}) / double{p[0]},
                (y * w + double{p[9]} * depth - double{p[13]}) / double{p[5]}, -depth};
    }
    Vec3 point(int x, int y) const {
        const int column = std::clamp(x, 0, static_cast<int>(image.extent.width) - 1);
        const int row = std::clamp(y, 0, static_cast<int>(image.extent.height) - 1);
        return unproject((column + 0.5) / image.extent.width * 2.0 - 1.0, (row + 0.5) / image.extent.height * 2.0 - 1.0,
                         at(x, y));
    }
    Vec3 slope(int x, int y, int dx, int dy) const {
        const double here = at(x, y), before = at(x - dx, y - dy), after = at(x + dx, y + dy);
        const bool no_before = is_sky(before), no_after = is_sky(after);
        if (no_before && no_after)
            return {};
        const bool backward = no_after || (!no_before && std::abs(before - here) < std::abs(after - here));
        return backward ? point(x, y) - point(x - dx, y - dy) : point(x + dx, y + dy) - point(x, y);
    }
    Vec3 normal(int x, int y, Vec3 place) const {
        const Vec3 to_eye = projection[11] != 0.0f ? normalised(place) * -1.0 : Vec3{0, 0, 1};
        const Vec3 n = cross(slope(x, y, 1, 0), slope(x, y, 0, 1));
        const double size = std::sqrt(dot(n, n));
        if (!(size > 0.0))
            return to_eye;
        return n * ((dot(n, to_eye) < 0.0 ? -1.0 : 1.0) / size);
    }
};

} // namespace

ParticleReference::Motion ParticleReference::collide_with_depth(const Motion& before, Motion after, const Frame& frame,
                                                                const DepthImage& depth) const {
    const Matrix4& view = frame.camera->world_to_view;
    const Vec3 place = to_view(view, after.position);
    const auto clip = Matrix{frame.camera->projection} * std::array<double, 4>{place.x, place.y, place.z, 1.0};
    if (clip[3] <= 0.0 || std::abs(clip[0]) >= clip[3] || std::abs(clip[1]) >= clip[3])
        return after;
    const double x = clip[0] / clip[3], y = clip[1] / clip[3];
    const Surface surface{depth, frame.camera->projection};
    const int column = static_cast<int>((x * 0.5 + 0.5) * depth.extent.width);
    const int row = static_cast<int>((y * 0.5 + 0.5) * depth.extent.height);
    const double here = surface.at(column, row);
    if (is_sky(here) || here <= 0.0)
        return after;
    const double behind = -place.z - here;
    const double farther = to_view(view, before.position).z - place.z;
    if (behind <= 0.0 || behind >= double{parameters_.collision_thickness} + std::max(farther, 0.0))
        return after;
    const Vec3 point = surface.unproject(x, y, here);
    const Vec3 normal = surface.normal(column, row, point);
    const Vec3 outside = place + normal * (clearance + std::max(0.0, dot(point - place, normal)));
    return {to_world(view, outside), bounced(after.velocity, turned_to_world(view, normal), {})};
}

ParticleSprite ParticleReference::sprite(size_t slot) const {
    const ReferenceParticle& particle = particles_[slot];
    const ParticleVolumeParameters& p = parameters_;
    if (particle.id == 0)
        return {};
    const double share = std::min(1.0, particle.age / lifetime_of(particle.id));
    const double first = double{p.radius_start}, last = double{p.radius_end};
    const double radius = first + (last - first) * share * (2.0 - share);
    const double appears = p.fade_in > 0.0f ? std::min(1.0, share / double{p.fade_in}) : 1.0;
    const double stays = p.fade_out > 0.0f ? std::min(1.0, (1.0 - share) / double{p.fade_out}) : 1.0;
    const double extinction =
        double{p.extinction} * std::pow(first / radius, 3.0 * double{p.dilution}) * appears * stays;
    const auto single = [](double v) { return static_cast<float>(v); };
    const auto triple = [&](Vec3 v) { return std::array{single(v.x), single(v.y), single(v.z)}; };
    return {triple(particle.position),
            single(radius),
            triple(particle.velocity),
            single(extinction),
            {p.albedo_r, p.albedo_g, p.albedo_b},
            single(double{p.emission} * std::exp(-particle.age / double{p.emission_time}))};
}

} // namespace sfumato::reference
