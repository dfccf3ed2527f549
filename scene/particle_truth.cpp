// The particles' ground truth: brute force, made bearable by cells in each light's plane and tiles of the picture.
#include "scene/particle_truth.h"

#include "scene/vec3.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>
#include <thread>

namespace sfumato::scene {

namespace {

constexpr double pi = std::numbers::pi;

Vec3 vec3_of(const std::array<float, 3>& a) {
    return {double{a[0]}, double{a[1]}, double{a[2]}};
}
Vec3 transform(const Matrix4& m, Vec3 p) {
    const auto row = [&](size_t r) {
        return double{m[r]} * p.x + double{m[4 + r]} * p.y + double{m[8 + r]} * p.z + double{m[12 + r]};
    };
    return {row(0), row(1), row(2)};
}
double homogeneous(const Matrix4& m, Vec3 p) {
    return double{m[3]} * p.x + double{m[7]} * p.y + double{m[11]} * p.z + double{m[15]};
}

bool is_alive(const ParticleSprite& s) {
    float numbers[12];
    std::copy(s.position.begin(), s.position.end(), numbers);
    std::copy(s.velocity.begin(), s.velocity.end(), numbers + 3);
    std::copy(s.albedo.begin(), s.albedo.end(), numbers + 6);
    numbers[9] = s.radius, numbers[10] = s.extinction, numbers[11] = s.emission;
    return std::all_of(std::begin(numbers), std::end(numbers), [](float x) { return std::isfinite(x); }) &&
           s.radius > 0.0f && s.extinction > 0.0f;
}

// One light's plane, cut into square cells; each holds the particles that reach into it, those nearer the light first.
class LightPlane {
  public:
    LightPlane(std::span<const ParticleSprite> sprites, Vec3 to_light) : to_light_(to_light) {
        right_ = normalised(cross(std::abs(to_light.y) < 0.9 ? Vec3{0, 1, 0} : Vec3{1, 0, 0}, to_light));
        up_ = cross(to_light, right_);
        if (!sprites.empty())
            fill(sprites);
    }

    double depth(Vec3 p) const { return -dot(p, to_light_); }

    // Of all particles whose middle lies before `depth`, along the light's ray through p.
    double optical_depth(Vec3 p, double depth) const {
        const double u = dot(p, right_), v = dot(p, up_);
        const double column = std::floor((u - low_u_) / side_), row = std::floor((v - low_v_) / side_);
        if (!(column >= 0.0 && row >= 0.0 && column < columns_ && row < rows_))
            return 0.0;
        double sum = 0.0;
        for (const Entry& e : cells_[static_cast<size_t>(row * columns_ + column)]) {
            if (e.depth >= depth)
                break;
            const double du = u - e.u, dv = v - e.v;
            const double q = 1.0 - (du * du + dv * dv) * e.inverse_square;
            if (q > 0.0)
                sum += e.optical_depth * std::sqrt(q);
        }
        return sum;
    }

  private:
    struct Entry {
        double depth, u, v, inverse_square, optical_depth;
    };

    void fill(std::span<const ParticleSprite> sprites) {
        double high_u = -1e300, high_v = -1e300, sum = 0.0;
        low_u_ = low_v_ = 1e300;
        for (const ParticleSprite& s : sprites) {
            const Vec3 p = vec3_of(s.position);
            const double r = double{s.radius};
            low_u_ = std::min(low_u_, dot(p, right_) - r), high_u = std::max(high_u, dot(p, right_) + r);
            low_v_ = std::min(low_v_, dot(p, up_) - r), high_v = std::max(high_v, dot(p, up_) + r);
            sum += r;
        }
        side_ =
            std::max({sum / static_cast<double>(sprites.size()), (high_u - low_u_) / 512.0, (high_v - low_v_) / 512.0});
        columns_ = std::floor((high_u - low_u_) / side_) + 1.0;
        rows_ = std::floor((high_v - low_v_) / side_) + 1.0;
        cells_.resize(static_cast<size_t>(columns_ * rows_));
        for (const ParticleSprite& s : sprites)
            add(s);
        for (auto& cell : cells_)
            std::ranges::sort(cell, {}, &Entry::depth);
    }

    void add(const ParticleSprite& s) {
        const Vec3 p = vec3_of(s.position);
        const double r = double{s.radius}, u = dot(p, right_), v = dot(p, up_);
        const Entry entry{depth(p), u, v, 1.0 / (r * r), 2.0 * r * double{s.extinction}};
        const auto cell = [&](double x, double low, double count) {
            return static_cast<size_t>(std::clamp(std::floor((x - low) / side_), 0.0, count - 1.0));
        };
        for (size_t y = cell(v - r, low_v_, rows_); y <= cell(v + r, low_v_, rows_); ++y)
            for (size_t x = cell(u - r, low_u_, columns_); x <= cell(u + r, low_u_, columns_); ++x)
                cells_[y * static_cast<size_t>(columns_) + x].push_back(entry);
    }

    Vec3 to_light_, right_, up_;
    double low_u_ = 0.0, low_v_ = 0.0, side_ = 1.0, columns_ = 0.0, rows_ = 0.0;
    std::vector<std::vector<Entry>> cells_;
};

struct LitPlane {
    LightPlane plane;
    Vec3 to_light, radiance;
};

// A sprite as the camera sees it, lengths on the picture in pixels.
struct Disc {
    double x, y, radius, depth, optical_depth, metres;
    const ParticleSprite* sprite;
    uint32_t number;
};

struct View {
    const Camera& camera;
    Extent extent;
    bool perspective;
    Vec3 rows[3]; // of the view's rotation: world space from view space
    Vec3 eye;

    // World position of what is seen at a pixel's middle at view depth z.
    Vec3 position(double x, double y, double z) const {
        const Matrix4& p = camera.projection;
        const double ndc_x = x / extent.width * 2.0 - 1.0, ndc_y = y / extent.height * 2.0 - 1.0;
        const double w = double{p[11]} * -z + double{p[15]};
        const double vx = (ndc_x * w + double{p[8]} * z - double{p[12]}) / double{p[0]};
        const double vy = (ndc_y * w + double{p[9]} * z - double{p[13]}) / double{p[5]};
        return eye + rows[0] * vx + rows[1] * vy - rows[2] * z;
    }
    Vec3 to_eye(Vec3 from) const { return perspective ? normalised(eye - from) : rows[2]; }
};

View make_view(const Camera& camera, Extent extent) {
    const Matrix4& m = camera.world_to_view;
    View view{camera, extent, camera.projection[11] != 0.0f, {}, {}};
    for (size_t r = 0; r < 3; ++r)
        view.rows[r] = {double{m[r]}, double{m[4 + r]}, double{m[8 + r]}};
    view.eye = (view.rows[0] * double{m[12]} + view.rows[1] * double{m[13]} + view.rows[2] * double{m[14]}) * -1.0;
    return view;
}

double near_plane(const Matrix4& p) {
    double nearest = 0.0;
    for (const double d : {0.0, 1.0}) {
        const double depth = (double{p[14]} - d * double{p[15]}) / (double{p[10]} - d * double{p[11]});
        if (std::isfinite(depth) && depth > 0.0 && (nearest == 0.0 || depth < nearest))
            nearest = depth;
    }
    return nearest;
}

// A disc below three pixels covers so few of them that their chords may sum to much more or less than the sphere's
// mass; one below a pixel would fall between them. Both are weighted so that the mass stays.
double small_disc_factor(const Disc& d) {
    double sum = 0.0;
    for (double y = std::floor(d.y - d.radius) - 0.5; y < d.y + d.radius + 1.0; ++y)
        for (double x = std::floor(d.x - d.radius) - 0.5; x < d.x + d.radius + 1.0; ++x) {
            const double rho = ((x - d.x) * (x - d.x) + (y - d.y) * (y - d.y)) / (d.radius * d.radius);
            sum += std::sqrt(std::max(0.0, 1.0 - rho));
        }
    return sum > 0.0 ? 2.0 / 3.0 * pi * d.radius * d.radius / sum : 1.0;
}

std::vector<Disc> discs_of(std::span<const ParticleSprite> sprites, const View& view,
                           const ParticleVolumeParameters& parameters) {
    std::vector<Disc> discs;
    const Matrix4& p = view.camera.projection;
    const double nearest = near_plane(p), fade = double{parameters.near_fade};
    const double pixels = 0.5 * view.extent.height * std::abs(double{p[5]});
    for (const ParticleSprite& s : sprites) {
        if (!is_alive(s))
            continue;
        const Vec3 v = transform(view.camera.world_to_view, vec3_of(s.position));
        if (-v.z <= nearest)
            continue;
        const Vec3 clip = transform(p, v);
        const double w = homogeneous(p, v);
        Disc d{(clip.x / w * 0.5 + 0.5) * view.extent.width,
               (clip.y / w * 0.5 + 0.5) * view.extent.height,
               double{s.radius} * pixels / (view.perspective ? -v.z : 1.0),
               -v.z,
               2.0 * double{s.radius} * double{s.extinction},
               double{s.radius},
               &s,
               static_cast<uint32_t>(&s - sprites.data())};
        const double grown = std::max(1.0, 1.0 / d.radius);
        d.radius *= grown, d.metres *= grown, d.optical_depth /= grown * grown;
        if (d.x + d.radius <= 0.0 || d.y + d.radius <= 0.0 || d.x - d.radius >= view.extent.width ||
            d.y - d.radius >= view.extent.height)
            continue;
        if (d.radius < 3.0)
            d.optical_depth *= small_disc_factor(d);
        if (fade > 0.0)
            d.optical_depth *= std::clamp((d.depth - nearest) / fade, 0.0, 1.0);
        discs.push_back(d);
    }
    std::ranges::stable_sort(discs, {}, &Disc::depth);
    return discs;
}

Vec3 glow(double strength) {
    const double heat = strength / (1.0 + strength);
    return Vec3{1.0, 0.15 + 0.75 * heat, 0.02 + 0.7 * heat * heat} * strength;
}

Vec3 times(Vec3 a, Vec3 b) {
    return {a.x * b.x, a.y * b.y, a.z * b.z};
}

// Henyey and Greenstein's function for each order of scattering: every further one is half as strong, shadowed half as
// much and half as directed.
Vec3 scattered(const LitPlane& light, double optical_depth, double cosine, const ParticleVolumeParameters& p) {
    Vec3 sum;
    double share = 1.0, g = double{p.phase};
    for (int order = 0; order < p.scattering_octaves; ++order, share *= 0.5, g *= 0.5) {
        const double phase = (1.0 - g * g) / std::pow(1.0 + g * g - 2.0 * g * cosine, 1.5) / (4.0 * pi);
        const auto left = [&](float c) { return std::exp(-double{c} * optical_depth * share); };
        sum = sum + Vec3{left(p.shadow_colour_r), left(p.shadow_colour_g), left(p.shadow_colour_b)} * (share * phase);
    }
    return times(sum, light.radiance);
}

std::vector<LitPlane> planes_of(std::span<const ParticleSprite> sprites, const Frame& frame,
                                const ParticleVolumeParameters& p) {
    std::vector<LitPlane> planes;
    for (const sfumato::Light& light : frame.lights) {
        const Vec3 to_light = normalised(vec3_of(light.to_light));
        planes.push_back({LightPlane(sprites, to_light), to_light, vec3_of(light.radiance)});
    }
    if (planes.empty()) {
        const double azimuth = radians(double{p.light_azimuth}), elevation = radians(double{p.light_elevation});
        const Vec3 to_light = {std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                               std::cos(azimuth) * std::cos(elevation)};
        const double s = double{p.light_strength};
        planes.push_back({LightPlane(sprites, to_light), to_light, {s, s, s}});
    }
    return planes;
}

constexpr uint32_t tile_side = 8;

// Everything that the threads read.
struct Work {
    View view;
    const ParticleVolumeParameters& parameters;
    std::vector<Disc> discs;
    std::vector<LitPlane> planes;
    std::span<const float> depth;
    std::vector<std::vector<uint32_t>> tiles; // numbers of discs, near ones first
    uint32_t columns;
    ParticleProfileTruth profile;
};

void bin(Work& work) {
    work.columns = (work.view.extent.width + tile_side - 1) / tile_side;
    const uint32_t rows = (work.view.extent.height + tile_side - 1) / tile_side;
    work.tiles.resize(size_t{work.columns} * rows);
    const auto tile = [](double x, uint32_t count) {
        return static_cast<uint32_t>(std::clamp(std::floor(x / tile_side), 0.0, count - 1.0));
    };
    for (uint32_t i = 0; i < work.discs.size(); ++i) {
        const Disc& d = work.discs[i];
        for (uint32_t y = tile(d.y - d.radius, rows); y <= tile(d.y + d.radius, rows); ++y)
            for (uint32_t x = tile(d.x - d.radius, work.columns); x <= tile(d.x + d.radius, work.columns); ++x)
                work.tiles[size_t{y} * work.columns + x].push_back(i);
    }
}

uint64_t draw_pixel(const Work& work, ParticleTruth& truth, uint32_t px, uint32_t py,
                    const std::vector<uint32_t>& list) {
    const double x = px + 0.5, y = py + 0.5;
    const size_t pixel = size_t{py} * work.view.extent.width + px;
    const double surface = work.depth.empty() || !std::isfinite(work.depth[pixel]) ? 1e9 : double{work.depth[pixel]};
    Vec3 colour;
    double through = 1.0;
    uint64_t fragments = 0;
    for (const uint32_t number : list) {
        const Disc& d = work.discs[number];
        const double q = 1.0 - ((x - d.x) * (x - d.x) + (y - d.y) * (y - d.y)) / (d.radius * d.radius);
        if (q <= 0.0)
            continue;
        const double half = std::max(d.metres * std::sqrt(q), 0.5 * double{work.parameters.soft_distance});
        const double seen = std::clamp(0.5 * ((surface - d.depth) / half + 1.0), 0.0, 1.0);
        const double spread = work.profile.at(d.number, (x - d.x) / d.radius, (y - d.y) / d.radius, d.radius);
        const double alpha = 1.0 - std::exp(-d.optical_depth * spread * seen);
        if (alpha <= 0.0)
            continue;
        const ParticleSprite& s = *d.sprite;
        const Vec3 at = work.view.position(x, y, d.depth);
        const float ambient = work.parameters.ambient;
        Vec3 light = {double{ambient}, double{ambient}, double{ambient}};
        for (const LitPlane& plane : work.planes) {
            const double depth = plane.plane.optical_depth(at, plane.plane.depth(vec3_of(s.position)));
            light = light + scattered(plane, depth, -dot(plane.to_light, work.view.to_eye(at)), work.parameters);
        }
        colour = colour + (times(vec3_of(s.albedo), light) + glow(double{s.emission})) * (through * alpha);
        through *= 1.0 - alpha;
        ++fragments;
        if (through < 1e-9)
            break;
    }
    truth.colour[3 * pixel] = colour.x;
    truth.colour[3 * pixel + 1] = colour.y;
    truth.colour[3 * pixel + 2] = colour.z;
    truth.transmittance[pixel] = through;
    return fragments;
}

} // namespace

ParticleTruth particle_truth(std::span<const ParticleSprite> sprites, const Frame& frame,
                             const ParticleVolumeParameters& parameters, Extent extent, std::span<const float> depth,
                             unsigned threads, const ParticleTexture& texture) {
    std::vector<ParticleSprite> alive;
    std::ranges::copy_if(sprites, std::back_inserter(alive), is_alive);
    Work work{
        make_view(*frame.camera, extent),         parameters, {}, planes_of(alive, frame, parameters), depth, {}, 0,
        ParticleProfileTruth(parameters, texture)};
    work.discs = discs_of(sprites, work.view, parameters);
    bin(work);
    ParticleTruth truth;
    truth.extent = extent;
    const size_t pixels = size_t{extent.width} * extent.height;
    truth.colour.assign(3 * pixels, 0.0);
    truth.transmittance.assign(pixels, 1.0);
    std::atomic<size_t> next = 0;
    std::atomic<uint64_t> fragments = 0;
    const auto run = [&] {
        for (size_t tile = next++; tile < work.tiles.size(); tile = next++) {
            const auto left = static_cast<uint32_t>(tile % work.columns) * tile_side;
            const auto top = static_cast<uint32_t>(tile / work.columns) * tile_side;
            for (uint32_t y = top; y < std::min(top + tile_side, extent.height); ++y)
                for (uint32_t x = left; x < std::min(left + tile_side, extent.width); ++x)
                    fragments += draw_pixel(work, truth, x, y, work.tiles[tile]);
        }
    };
    std::vector<std::thread> helpers;
    for (unsigned i = 1; i < threads; ++i)
        helpers.emplace_back(run);
    run();
    for (std::thread& helper : helpers)
        helper.join();
    truth.fragments = fragments;
    return truth;
}

ParticleError particle_error(const ParticleTruth& truth, std::span<const float> picture, size_t stride) {
    const size_t pixels = truth.transmittance.size();
    std::vector<double> differences(pixels);
    double squares = 0.0, sum = 0.0, all = 0.0;
    const auto luminance = [](double r, double g, double b) { return 0.2126 * r + 0.7152 * g + 0.0722 * b; };
    for (size_t i = 0; i < pixels; ++i) {
        const float* p = &picture[i * stride];
        const double expected = luminance(truth.colour[3 * i], truth.colour[3 * i + 1], truth.colour[3 * i + 2]);
        const double difference = luminance(double{p[0]}, double{p[1]}, double{p[2]}) - expected;
        differences[i] = std::abs(difference);
        squares += difference * difference, sum += difference, all += expected;
    }
    if (pixels == 0)
        return {};
    const size_t rank = pixels * 99 / 100;
    std::nth_element(differences.begin(), differences.begin() + static_cast<ptrdiff_t>(rank), differences.end());
    return {std::sqrt(squares / static_cast<double>(pixels)), all > 0.0 ? sum / all : 0.0, differences[rank]};
}

std::vector<ParticleSprite> particle_cloud(const ParticleCloud& cloud) {
    std::vector<ParticleSprite> sprites;
    sprites.reserve(cloud.count);
    uint64_t state = uint64_t{cloud.seed} * 0x9e3779b97f4a7c15u + 1;
    const auto random = [&] { // splitmix64, 24 bits
        uint64_t z = state += 0x9e3779b97f4a7c15u;
        z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
        z = (z ^ z >> 27) * 0x94d049bb133111ebu;
        return static_cast<double>((z ^ z >> 31) >> 40) / 16777216.0;
    };
    while (sprites.size() < cloud.count) {
        const Vec3 p = {2.0 * random() - 1.0, 2.0 * random() - 1.0, 2.0 * random() - 1.0};
        if (dot(p, p) > 1.0)
            continue;
        // Lobes: the ball's rim goes in and out; hollows: waves push its inside together.
        const double rim = 0.8 + 0.2 * std::sin(5.0 * p.x + 1.0) * std::sin(4.0 * p.y) + 0.1 * std::sin(7.0 * p.z);
        const Vec3 warped = {p.x * rim + 0.12 * std::sin(6.0 * p.y), p.y * rim + 0.12 * std::sin(5.0 * p.z + 2.0),
                             p.z * rim + 0.12 * std::sin(7.0 * p.x + 1.0)};
        ParticleSprite s{};
        const auto size = double{cloud.size}, variation = double{cloud.variation};
        s.position = {static_cast<float>(warped.x * size), static_cast<float>(warped.y * size),
                      static_cast<float>(warped.z * size)};
        s.radius = static_cast<float>(double{cloud.radius} * (1.0 + variation * (random() - 0.5)));
        s.extinction = cloud.extinction;
        for (float& albedo : s.albedo)
            albedo = static_cast<float>(1.0 - variation * 0.8 * random());
        sprites.push_back(s);
    }
    return sprites;
}

Camera look_at(std::array<double, 3> eye, std::array<double, 3> target, double focal, Extent extent) {
    const Vec3 e = {eye[0], eye[1], eye[2]};
    const Vec3 back = normalised(e - Vec3{target[0], target[1], target[2]});
    const Vec3 right = normalised(cross(std::abs(back.y) < 0.99 ? Vec3{0, 1, 0} : Vec3{0, 0, 1}, back));
    const Vec3 up = cross(back, right);
    Camera camera;
    const Vec3 rows[3] = {right, up, back};
    for (size_t r = 0; r < 3; ++r) {
        camera.world_to_view[r] = static_cast<float>(rows[r].x);
        camera.world_to_view[4 + r] = static_cast<float>(rows[r].y);
        camera.world_to_view[8 + r] = static_cast<float>(rows[r].z);
        camera.world_to_view[12 + r] = static_cast<float>(-dot(rows[r], e));
    }
    const double aspect = static_cast<double>(extent.width) / extent.height;
    camera.projection = {static_cast<float>(2.0 * focal / aspect),
                         0,
                         0,
                         0,
                         0,
                         static_cast<float>(-2.0 * focal),
                         0,
                         0,
                         0,
                         0,
                         0,
                         -1,
                         0,
                         0,
                         0.05f,
                         0};
    return camera;
}

} // namespace sfumato::scene
