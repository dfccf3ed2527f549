#include "motion_blur_reference.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <tuple>

namespace sfumato::reference {

namespace {

constexpr double still_length = 0.5;   // pixels; shorter half displacements are not blurred
constexpr double no_length = 1.0 / 64; // pixels; shorter ones are rounding, and count as zero
constexpr double sky_depth = 1e9;      // renderers write 1e10 where nothing was hit; infinity is sky as well
constexpr double largest_half = 65504;

double length(Vector v) {
    return std::sqrt(v.x * v.x + v.y * v.y);
}
double dot(Vector a, Vector b) {
    return a.x * b.x + a.y * b.y;
}
Vector operator+(Vector a, Vector b) {
    return {a.x + b.x, a.y + b.y};
}
Vector operator-(Vector a, Vector b) {
    return {a.x - b.x, a.y - b.y};
}
Vector operator*(double s, Vector v) {
    return {s * v.x, s * v.y};
}
bool finite(Vector v) {
    return std::isfinite(v.x) && std::isfinite(v.y);
}
double saturate(double x) {
    return std::clamp(x, 0.0, 1.0);
}
double fraction(double x) {
    return x - std::floor(x);
}
double lerp(double a, double b, double t) {
    return a + (b - a) * t;
}
double smoothstep(double a, double b, double x) {
    const double t = saturate((x - a) / (b - a));
    return t * t * (3 - 2 * t);
}

// An order on vectors without ties, so that a reduction in any order gives the same one: by length, then by x, then by
// y. The shaders compare the stored bits of vectors of one length instead.
bool longer(Vector a, Vector b) {
    return std::make_tuple(dot(a, a), a.x, a.y) > std::make_tuple(dot(b, b), b.x, b.y);
}

double cross(Vector a, Vector b) {
    return a.x * b.y - a.y * b.x;
}

// The same by how far the vectors reach to the side of a given one.
bool wider(Vector a, Vector b, Vector of) {
    return std::make_tuple(std::fabs(cross(a, of)), a.x, a.y) > std::make_tuple(std::fabs(cross(b, of)), b.x, b.y);
}

double luminance(const std::array<double, 4>& c) {
    return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
}

// Nearest texel of an image of another size under the centre of pixel (x, y).
template <int N>
const std::array<double, N>& nearest(const Grid<N>& image, int x, int y, int width, int height) {
    const int u = static_cast<int>(std::floor((x + 0.5) * image.width / width));
    const int v = static_cast<int>(std::floor((y + 0.5) * image.height / height));
    return image.clamped(u, v);
}

std::array<double, 4> transform(const Matrix& m, const std::array<double, 4>& p) {
    std::array<double, 4> r{};
    for (std::size_t row = 0; row < 4; ++row)
        for (std::size_t column = 0; column < 4; ++column)
            r[row] += m[column * 4 + row] * p[column];
    return r;
}

bool is_sky(double depth) {
    return !(depth < sky_depth);
} // NaN as well

// Where the point seen at pixel (x, y) lies at another time, minus where it lies now, in pixels. The point is found by
// inverting the projection without reading near or far off it: clip x = P00 X + P01 Y + P02 Z + P03, and so on, with Z
// = -depth. Sky is a direction.
Vector camera_displacement(const Matrix& now, const Matrix& other, double depth, int x, int y, int width, int height) {
    const bool perspective = now[3 + 8] != 0; // P32
    const bool sky = is_sky(depth);
    if (sky && !perspective)
        return {}; // parallel rays: the sky has no position at all
    const double z = sky ? -1 : -depth;
    const double w = sky ? 0 : 1;
    const double ndc_x = 2 * (x + 0.5) / width - 1;
    const double ndc_y = 2 * (y + 0.5) / height - 1; // Vulkan: y down
    const double clip_w = now[11] * z + now[15] * w;
    const double position_x = (ndc_x * clip_w - now[8] * z - now[12] * w) / now[0];
    const double position_y = (ndc_y * clip_w - now[9] * z - now[13] * w) / now[5];
    const std::array<double, 4> point{position_x, position_y, z, w};
    const std::array<double, 4> here = transform(now, point);
    std::array<double, 4> there = transform(other, point);
    // A point that was behind the camera would come out mirrored. The way between the two is cut where it passes close
    // in front of the camera; what is left is in proportion to the time it takes.
    double part = 1;
    const double nearest_w = 0.01 * here[3];
    if (there[3] < nearest_w) {
        part = (here[3] - nearest_w) / (here[3] - there[3]);
        for (std::size_t i = 0; i < 4; ++i)
            there[i] = lerp(here[i], there[i], part);
    }
    const Vector moved{(there[0] / there[3] - ndc_x) * 0.5 * width, (there[1] / there[3] - ndc_y) * 0.5 * height};
    return part > 0 ? (1 / part) * moved : Vector{};
}

} // namespace

double round_to_half(double value) {
    if (std::isnan(value))
        return value;
    const double magnitude = std::fabs(value);
    int exponent = 0;
    std::frexp(magnitude, &exponent); // magnitude = [0.5, 1) * 2^exponent
    const double step = std::ldexp(1.0, std::max(exponent - 11, -24));
    return std::copysign(std::min(std::nearbyint(magnitude / step) * step, largest_half), value);
}

double centre_of(ShutterPosition position) {
    return position == ShutterPosition::start ? 1 : position == ShutterPosition::end ? -1 : 0;
}

double shutter_weight(ShutterCurve curve, double u) {
    const double a = std::fabs(u);
    if (a > 1)
        return 0;
    switch (curve) {
    case ShutterCurve::box:
        return 1;
    case ShutterCurve::triangle:
        return 1 - a;
    case ShutterCurve::smooth:
        return (1 - a * a) * (1 - a * a); // close to a Gaussian of deviation 0.4, and zero at the ends
    }
    return 1;
}

double gradient_noise(double x, double y) {
    return fraction(52.9829189 * fraction(0.06711056 * x + 0.00583715 * y));
}

// The frame index moves the pattern, so that passes of different index do not repeat each other's errors.
double jitter(TapJitter kind, int x, int y, int frame) {
    static constexpr std::array<int, 16> bayer{0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5};
    constexpr double golden = 0.61803398875;
    switch (kind) {
    case TapJitter::none:
        // Without a pattern in space, passes still differ from each other.
        return frame == 0 ? 0 : fraction(0.5 + frame * golden) - 0.5;
    case TapJitter::checkerboard:
        return ((x + y + frame) & 1) != 0 ? 0.25 : -0.25;
    case TapJitter::ordered: {
        const int rank = bayer[static_cast<std::size_t>((y & 3) * 4 + (x & 3))];
        return fraction((rank + 0.5) / 16 + frame * golden) - 0.5;
    }
    case TapJitter::gradient_noise:
        return gradient_noise(x + 5.588238 * frame, y + 5.588238 * frame) - 0.5;
    }
    return 0;
}

// Four 8-bit channels. Velocity: 128 is zero and decodes to exactly zero, 1 and 255 are the ends. Depth: sixteen bits,
// high byte first: a float of five bits of exponent and eleven of mantissa, from 2^-12 to 2^20; the step is at most
// 0.05 % of the depth, which is what a relative comparison wants. 65535 is sky and whatever lies beyond.
std::array<int, 4> pack(Vector v, double depth, double radius_pixels) {
    const auto channel = [radius_pixels](double value) {
        return std::clamp(128 + static_cast<int>(std::nearbyint(value / radius_pixels * 127)), 1, 255);
    };
    int code = 65535;
    if (!is_sky(depth)) {
        int exponent = 0;
        const double mantissa = std::frexp(std::max(depth, std::ldexp(1.0, -12)), &exponent); // [0.5, 1)
        const double step = (exponent - 1 + 12) * 2048.0 + std::floor((2 * mantissa - 1) * 2048 + 0.5);
        code = static_cast<int>(std::min(step, 65535.0));
    }
    return {channel(v.x), channel(v.y), code / 256, code % 256};
}

std::array<double, 3> unpack(const std::array<int, 4>& code, double radius_pixels) {
    const int depth = code[2] * 256 + code[3];
    const double z = depth == 65535 ? sky_depth : std::ldexp(1 + depth % 2048 / 2048.0, depth / 2048 - 12);
    return {(code[0] - 128) / 127.0 * radius_pixels, (code[1] - 128) / 127.0 * radius_pixels, z};
}

// ---- velocity ----

namespace {

// Renderers filter their vectors like their colours: at a silhouette a vector is a mixture of both surfaces'. Where a
// pixel has neighbours of unlike depth, it takes among its 3x3 neighbours of like depth the vector farthest from the
// mean of the unlike ones. Pixels whose neighbours are all of like depth keep their own.
// Vectors that are not finite neither count nor are taken.
Grid<2> repair(const Grid<2>& velocity, const Grid<1>& depth) {
    Grid<2> result = velocity;
    for (int y = 0; y < velocity.height; ++y) {
        for (int x = 0; x < velocity.width; ++x) {
            const double z = depth.at(x, y)[0];
            const auto like = [&](double other) { return std::fabs(other - z) <= 0.02 * std::min(other, z); };
            const auto at = [&](int i, int j) {
                const auto& v = velocity.clamped(x + i, y + j);
                return Vector{v[0], v[1]};
            };
            Vector others;
            int count = 0;
            for (int j = -1; j <= 1; ++j)
                for (int i = -1; i <= 1; ++i)
                    if (!like(depth.clamped(x + i, y + j)[0]) && finite(at(i, j))) {
                        others = others + at(i, j);
                        ++count;
                    }
            if (count == 0)
                continue;
            others = (1.0 / count) * others;
            double farthest = -1;
            for (int j = -1; j <= 1; ++j) // row by row; the first of equals stays
                for (int i = -1; i <= 1; ++i)
                    if (like(depth.clamped(x + i, y + j)[0]) && finite(at(i, j))) {
                        const Vector difference = at(i, j) - others;
                        if (dot(difference, difference) > farthest) {
                            farthest = dot(difference, difference);
                            result.at(x, y) = {at(i, j).x, at(i, j).y};
                        }
                    }
        }
    }
    return result;
}

Vector apply_layers(Vector v, const std::vector<VelocityLayer>& layers, int x, int y, int width, int height) {
    for (const VelocityLayer& layer : layers) {
        if (layer.velocity.empty())
            continue;
        const auto& texel = nearest(layer.velocity, x, y, width, height);
        Vector added{texel[0] * width / layer.velocity.width, texel[1] * height / layer.velocity.height};
        if (!finite(added))
            added = {};
        added = layer.strength * added;
        double mask = layer.mask.empty() ? 1 : nearest(layer.mask, x, y, width, height)[0];
        mask = mask > 0 ? std::min(mask, 1.0) : 0; // NaN is 0
        switch (layer.blend) {
        case LayerBlend::add:
            v = v + mask * added;
            break;
        case LayerBlend::replace:
            v = v + mask * (added - v);
            break;
        case LayerBlend::larger:
            if (mask * mask * dot(added, added) > dot(v, v))
                v = mask * added;
            break;
        }
    }
    return v;
}

} // namespace

Grid<3> velocity_stage(const MotionBlurInput& input, const MotionBlurSettings& settings) {
    const int width = input.colour.width;
    const int height = input.colour.height;
    const double radius = settings.radius * height;
    const auto depth_at = [&](int x, int y) {
        return input.depth.empty() ? 1.0 : nearest(input.depth, x, y, width, height)[0];
    };
    Grid<1> depth(width, height);
    Grid<2> to_now(width, height);
    Grid<2> to_next(width, height);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const double z = depth_at(x, y);
            depth.at(x, y) = {is_sky(z) ? sky_depth : std::max(z, 0.0)};
            const auto stored = [&](const Grid<2>& image) -> std::array<double, 2> {
                if (image.empty())
                    return {std::numeric_limits<double>::quiet_NaN(), 0};
                const auto& texel = nearest(image, x, y, width, height);
                return {texel[0] * width / image.width, texel[1] * height / image.height};
            };
            to_now.at(x, y) = stored(input.velocity);
            to_next.at(x, y) = stored(input.next_velocity);
        }
    }
    if (settings.repair_edges) {
        to_now = repair(to_now, depth);
        to_next = repair(to_next, depth);
    }
    const bool next_camera =
        input.camera.given && input.camera.next_given && (input.velocity.empty() || !input.next_velocity.empty());
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            // Pixels without a velocity, and sky, which renderers leave without one, take the camera's motion.
            const double z = depth.at(x, y)[0];
            const auto complete = [&](std::array<double, 2> v, const Matrix& other, double sign, bool camera) {
                Vector result{v[0], v[1]};
                if (camera && (!finite(result) || is_sky(z)))
                    result = sign * camera_displacement(input.camera.clip_from_view, other, z, x, y, width, height);
                return result;
            };
            const Vector now = complete(to_now.at(x, y), input.camera.previous_clip_from_view, -1, input.camera.given);
            const Vector next = complete(to_next.at(x, y), input.camera.next_clip_from_view, 1, next_camera);
            const Vector known_now = finite(now) ? now : Vector{};
            const Vector known_next = finite(next) ? next : known_now;
            to_now.at(x, y) = {known_now.x, known_now.y};
            to_next.at(x, y) = {known_next.x, known_next.y};
        }
    }

    Grid<3> result(width, height);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const Vector previous{to_now.at(x, y)[0], to_now.at(x, y)[1]};
            const Vector next{to_next.at(x, y)[0], to_next.at(x, y)[1]};
            // The path through the three known points is a parabola, p(t) = t (next + previous) / 2 + t^2 (next -
            // previous) / 2. The shutter is open from (c - 1) E/2 to (c + 1) E/2; the half displacement is half the
            // chord between the two. With the next velocity this follows rotating and accelerating things; without, it
            // is the velocity times E/2.
            const double c = centre_of(settings.position);
            const Vector mean = 0.5 * (previous + next);
            const Vector bend = 0.5 * (next - previous);
            Vector v = (settings.shutter / 2) * (mean + (c * settings.shutter) * bend);
            v = (settings.shutter / 2) * apply_layers((settings.shutter > 0 ? 2 / settings.shutter : 0.0) * v,
                                                      input.layers, x, y, width, height);
            if (!input.exclusion.empty()) {
                const double mask = nearest(input.exclusion, x, y, width, height)[0];
                v = (mask > 0 ? 1 - std::min(mask, 1.0) : 1.0) * v;
            }
            const double l = length(v);
            if (!std::isfinite(l) || l < no_length)
                v = {};
            else if (l > radius)
                v = (radius / l) * v;
            const double z = depth.at(x, y)[0];
            switch (settings.storage) {
            case Storage::exact:
                result.at(x, y) = {v.x, v.y, z};
                break;
            case Storage::half:
                result.at(x, y) = {round_to_half(v.x), round_to_half(v.y), z};
                break;
            case Storage::packed:
                result.at(x, y) = unpack(pack(v, z, radius), radius);
                break;
            }
        }
    }
    return result;
}

// ---- tiles ----

Grid<5> tile_maximum(const Grid<3>& surface, const MotionBlurSettings& settings) {
    const int size = settings.tile_size;
    Grid<5> tiles((surface.width + size - 1) / size, (surface.height + size - 1) / size); // partial tiles count
    for (int ty = 0; ty < tiles.height; ++ty) {
        for (int tx = 0; tx < tiles.width; ++tx) {
            const int x1 = std::min((tx + 1) * size, surface.width);
            const int y1 = std::min((ty + 1) * size, surface.height);
            Vector longest;
            for (int y = ty * size; y < y1; ++y)
                for (int x = tx * size; x < x1; ++x) {
                    const Vector v{surface.at(x, y)[0], surface.at(x, y)[1]};
                    if (longer(v, longest))
                        longest = v;
                }
            double spread = 0;
            Vector second;
            for (int y = ty * size; y < y1; ++y)
                for (int x = tx * size; x < x1; ++x) {
                    const Vector v{surface.at(x, y)[0], surface.at(x, y)[1]};
                    spread = std::max(spread, length(v - longest));
                    if (wider(v, second, longest))
                        second = v;
                }
            tiles.at(tx, ty) = {longest.x, longest.y, second.x, second.y, spread};
        }
    }
    return tiles;
}

// A tile swept along the segment from -reach to +reach meets the middle tile exactly if that segment meets a square of
// twice the tile's size around the middle tile. `across` widens the square by what the tile's other vectors reach to
// the side of the longest one, so that none of its pixels is missed. `selective` takes the segment's whole line, `line`
// its true length.
bool reaches(Vector v, Vector second, int offset_x, int offset_y, const MotionBlurSettings& settings) {
    if (settings.dilation == Dilation::box || (offset_x == 0 && offset_y == 0))
        return true;
    const bool diagonal = offset_x != 0 && offset_y != 0;
    if (settings.dilation == Dilation::selective && !diagonal && !settings.test_edge_neighbours)
        return true;
    const double l = length(v);
    const double across = l > 0 ? std::fabs(cross(second, v)) / l : 0;
    const double half_size = settings.tile_size + across;
    const double shutter_reach = 1 + std::fabs(centre_of(settings.position));
    double limit = settings.dilation == Dilation::line ? shutter_reach : std::numeric_limits<double>::infinity();
    double low = -limit;
    double high = limit;
    const std::array<double, 2> direction{v.x, v.y};
    const std::array<double, 2> middle{-static_cast<double>(offset_x * settings.tile_size),
                                       -static_cast<double>(offset_y * settings.tile_size)};
    for (std::size_t axis = 0; axis < 2; ++axis) {
        if (direction[axis] == 0) {
            if (std::fabs(middle[axis]) >= half_size)
                return false;
            continue;
        }
        const double a = (middle[axis] - half_size) / direction[axis];
        const double b = (middle[axis] + half_size) / direction[axis];
        low = std::max(low, std::min(a, b));
        high = std::min(high, std::max(a, b));
    }
    return low < high;
}

Grid<5> neighbour_maximum(const Grid<5>& tiles, const MotionBlurSettings& settings, double radius_pixels) {
    const double reach = radius_pixels * (1 + std::fabs(centre_of(settings.position)));
    const int rings = std::max(1, static_cast<int>(std::ceil(reach / settings.tile_size)));
    Grid<5> result(tiles.width, tiles.height);
    for (int ty = 0; ty < tiles.height; ++ty) {
        for (int tx = 0; tx < tiles.width; ++tx) {
            const int x0 = std::max(tx - rings, 0);
            const int x1 = std::min(tx + rings, tiles.width - 1);
            const int y0 = std::max(ty - rings, 0);
            const int y1 = std::min(ty + rings, tiles.height - 1);
            Vector longest;
            for (int y = y0; y <= y1; ++y)
                for (int x = x0; x <= x1; ++x) {
                    const auto& t = tiles.at(x, y);
                    if (longer({t[0], t[1]}, longest) && reaches({t[0], t[1]}, {t[2], t[3]}, x - tx, y - ty, settings))
                        longest = {t[0], t[1]};
                }
            // Whether motion is even concerns what reaches the tile, and what its own vectors reach.
            const auto& own = tiles.at(tx, ty);
            const double own_reach = length({own[0], own[1]}) * (1 + std::fabs(centre_of(settings.position)));
            const int own_rings = static_cast<int>(std::ceil(own_reach / settings.tile_size));
            double spread = 0;
            Vector second;
            for (int y = y0; y <= y1; ++y)
                for (int x = x0; x <= x1; ++x) {
                    const auto& t = tiles.at(x, y);
                    const bool is_near = std::max(std::abs(x - tx), std::abs(y - ty)) <= own_rings;
                    if (is_near || reaches({t[0], t[1]}, {t[2], t[3]}, x - tx, y - ty, settings))
                        spread = std::max(spread, length(Vector{t[0], t[1]} - longest) + t[4]);
                    for (const Vector v : {Vector{t[0], t[1]}, Vector{t[2], t[3]}})
                        if (wider(v, second, longest) && reaches({t[0], t[1]}, {t[2], t[3]}, x - tx, y - ty, settings))
                            second = v;
                }
            result.at(tx, ty) = {longest.x, longest.y, second.x, second.y, spread};
        }
    }
    return result;
}

TileClass classify(const std::array<double, 5>& neighbour, const MotionBlurSettings& settings, int height) {
    const double l = length({neighbour[0], neighbour[1]});
    if (l < still_length)
        return TileClass::still;
    if (settings.classify && neighbour[4] <= std::max(settings.uniform_tolerance * l, settings.uniform_pixels * height))
        return TileClass::uniform;
    return TileClass::full;
}

// ---- gather ----

namespace {

struct Tap {
    Vector v;
    double speed = 0;
    double z = 0;
    std::array<double, 4> colour{};
    double hdr = 1;
};

struct Gather {
    const Grid<4>& colour;
    const Grid<3>& surface;
    const MotionBlurSettings& settings;
    int x;
    int y;
    int frame;
    double centre; // c of the shutter position
    Tap here;

    // Velocity and depth are those of one pixel.
    Tap fetch_surface(Vector offset) const {
        const int tx = static_cast<int>(std::floor(x + 0.5 + offset.x));
        const int ty = static_cast<int>(std::floor(y + 0.5 + offset.y));
        Tap tap;
        const auto& s = surface.clamped(tx, ty);
        tap.v = {s[0], s[1]};
        tap.speed = length(tap.v);
        tap.z = s[2];
        return tap;
    }
    // Colour is that pixel's too, or, with filter_taps, the bilinear mean at the exact place.
    void fetch_colour(Tap& tap, Vector offset) const {
        if (settings.filter_taps) {
            const double px = x + offset.x;
            const double py = y + offset.y;
            const int tx = static_cast<int>(std::floor(px));
            const int ty = static_cast<int>(std::floor(py));
            for (std::size_t i = 0; i < 4; ++i)
                tap.colour[i] =
                    lerp(lerp(colour.clamped(tx, ty)[i], colour.clamped(tx + 1, ty)[i], px - tx),
                         lerp(colour.clamped(tx, ty + 1)[i], colour.clamped(tx + 1, ty + 1)[i], px - tx), py - ty);
        } else {
            tap.colour = colour.clamped(static_cast<int>(std::floor(x + 0.5 + offset.x)),
                                        static_cast<int>(std::floor(y + 0.5 + offset.y)));
        }
        // NaN counts as 0, infinity as the largest half float.
        for (double& channel : tap.colour)
            if (!std::isfinite(channel))
                channel = std::isnan(channel) ? 0 : std::copysign(largest_half, channel);
        tap.hdr = settings.hdr_weighting ? 1 / (1 + std::max(luminance(tap.colour), 0.0)) : 1;
    }
    Tap fetch(Vector offset) const {
        Tap tap = fetch_surface(offset);
        fetch_colour(tap, offset);
        return tap;
    }
    bool inside(Vector offset) const {
        const double px = std::floor(x + 0.5 + offset.x);
        const double py = std::floor(y + 0.5 + offset.y);
        return px >= 0 && py >= 0 && px < colour.width && py < colour.height;
    }
    double soft(double a, double b) const { // the extent of a soft comparison of two depths
        const double e = settings.soft_extent;
        return std::max(settings.soft_extent_kind == SoftExtent::relative ? e * std::min(a, b) : e, 1e-6);
    }
    // Distance from the middle of the streak of a surface of this speed, in pixels.
    double streak_distance(double d, double speed) const { return std::fabs(d - std::fabs(centre) * speed); }
    double cone(double d, double speed) const {
        return speed > 0 ? saturate(1 - streak_distance(d, speed) / speed) : 0;
    }
    bool within(double d, double speed) const { return streak_distance(d, speed) <= speed; }
    double cylinder(double d, double speed) const {
        return speed > 0 ? 1 - smoothstep(0.95 * speed, 1.05 * speed, streak_distance(d, speed)) : 0;
    }
    int tap_count(double blur_length, int most) const {
        if (settings.taps_per_pixel <= 0)
            return most;
        const int wanted = static_cast<int>(std::ceil(blur_length * settings.taps_per_pixel));
        return std::clamp(wanted, std::min(settings.least_taps, most), most);
    }
};

// Sums are kept as differences from the pixel's own colour: where no tap weighs anything, the pixel comes out bit for
// bit.
struct Sum {
    std::array<double, 4> difference{};
    double weight = 0;

    void add(const Tap& tap, const Tap& here, double w) {
        w *= tap.hdr;
        weight += w;
        for (std::size_t i = 0; i < 4; ++i)
            difference[i] += w * (tap.colour[i] - here.colour[i]);
    }
    std::array<double, 4> over(const Tap& here, double total) const {
        std::array<double, 4> result = here.colour;
        if (total > 0)
            for (std::size_t i = 0; i < 4; ++i)
                result[i] += difference[i] / total;
        return result;
    }
};

// Tap i of n, as a place u in [-1, 1] of the shutter.
double tap_place(int i, int n, double j) {
    return -1 + 2 * (i + 0.5 + j) / n;
}

// The directions of even and odd taps. A pixel that is nearly as fast as the fastest thing in reach has nothing to look
// for along another vector than its own; one that hardly moves, beside the fastest thing in reach, has none of its own:
// half of the taps would fall on itself, and what passes over it would be lost.
std::array<Vector, 2> tap_directions(const Gather& g, Vector n) {
    if (g.here.speed >= 0.7 * length(n))
        return {g.here.v, g.here.v};
    const bool own = g.settings.alternate && g.here.speed >= std::max(0.1 * length(n), still_length);
    return {n, own ? g.here.v : n};
}

// The talk. Background taps are weighted by how far the pixel itself moves, foreground taps by how far they move, both
// moving adds more.
std::array<double, 4> gather_talk(const Gather& g, Vector n, double j) {
    const MotionBlurSettings& set = g.settings;
    const int taps = g.tap_count(length(n), set.taps);
    const std::array<Vector, 2> direction = tap_directions(g, n);
    Sum sum;
    for (int i = 0; i < taps; ++i) {
        const double u = tap_place(i, taps, j);
        const Vector offset = -(g.centre + u) * direction[static_cast<std::size_t>(i & 1)];
        const Tap tap = g.fetch(offset);
        const double d = length(offset);
        const double extent = g.soft(g.here.z, tap.z);
        const double background = saturate(1 - (g.here.z - tap.z) / extent);
        const double foreground = saturate(1 - (tap.z - g.here.z) / extent);
        const double both = g.within(d, tap.speed) && g.within(d, g.here.speed) ? 1 : 0;
        const double w = set.background_weight * background * g.cone(d, g.here.speed) +
                         set.foreground_weight * foreground * g.cone(d, tap.speed) + set.mutual_weight * both;
        sum.add(tap, g.here, w * shutter_weight(set.curve, u));
    }
    const double centre = set.centre_weight * g.here.hdr;
    return sum.over(g.here, sum.weight + centre);
}

// Guertin et al.: depth compared relative to depth, directions compared, slow pixels look across the dominant
// direction.
std::array<double, 4> gather_guertin(const Gather& g, Vector n, double j) {
    constexpr double gamma = 1.5; // pixels
    constexpr double kappa = 40;
    const MotionBlurSettings& set = g.settings;
    const double reach = length(n);
    const int taps = g.tap_count(reach, set.taps);
    const Vector along = (1 / reach) * n;
    Vector across{-along.y, along.x};
    if (dot(across, g.here.v) < 0)
        across = -1.0 * across;
    const Vector unit = g.here.speed > 0 ? (1 / g.here.speed) * g.here.v : across;
    const double t = saturate((g.here.speed - still_length) / gamma);
    const Vector mixed = across + t * (unit - across);
    const Vector own = length(mixed) > 1e-6 ? (1 / length(mixed)) * mixed : across;
    Sum sum;
    for (int i = 0; i < taps; ++i) {
        const double u = tap_place(i, taps, 0.95 * j);
        const Vector direction = (i & 1) != 0 ? own : along;
        const Vector offset = -(g.centre + u) * reach * direction;
        const Tap tap = g.fetch(offset);
        const double d = length(offset);
        const auto nearer = [&](double a, double b) { return saturate(1 - (a - b) / std::max(std::min(a, b), 1e-6)); };
        const double foreground = nearer(tap.z, g.here.z);
        const double background = nearer(g.here.z, tap.z);
        const double agree_here = std::fabs(dot(own, direction));
        const double agree_tap = tap.speed > 0 ? std::fabs(dot(tap.v, direction)) / tap.speed : 0;
        const double w = foreground * g.cone(d, tap.speed) * agree_tap +
                         background * g.cone(d, g.here.speed) * agree_here +
                         2 * g.cylinder(d, std::min(tap.speed, g.here.speed)) * std::max(agree_here, agree_tap);
        sum.add(tap, g.here, w * shutter_weight(set.curve, u));
    }
    const double centre = set.centre_weight * taps / (kappa * std::max(g.here.speed, still_length)) * g.here.hdr;
    return sum.over(g.here, sum.weight + centre);
}

// Jimenez: foreground and background shares sum to one; taps come in pairs and fill each other's background; what
// weight is missing stays with the pixel.
std::array<double, 4> gather_jimenez(const Gather& g, Vector n, double j) {
    const MotionBlurSettings& set = g.settings;
    const double reach = length(n);
    const int steps = std::max(g.tap_count(reach, set.taps) / 2, 1);
    const double steps_per_pixel = steps / reach;
    Sum sum;
    double total = 0;
    for (int i = 0; i < steps; ++i) {
        const double u = (i + 0.5 + j) / steps;
        std::array<Tap, 2> pair;
        std::array<double, 2> weight{};
        for (std::size_t side = 0; side < 2; ++side) {
            const Vector offset = -(g.centre + (side == 0 ? u : -u)) * n;
            pair[side] = g.fetch(offset);
            const double d = length(offset);
            const double away = (pair[side].z - g.here.z) / g.soft(g.here.z, pair[side].z);
            const double background = saturate(0.5 + away);
            const double foreground = saturate(0.5 - away);
            const auto spread = [&](double speed) {
                return saturate(steps_per_pixel * (speed - g.streak_distance(d, speed)) + 1);
            };
            const auto moves = [&](double speed) { return speed < still_length ? 0 : spread(speed); };
            weight[side] = background * moves(g.here.speed) + foreground * moves(pair[side].speed);
        }
        const bool farther = pair[0].z > pair[1].z;
        const bool faster = pair[1].speed > pair[0].speed;
        if (farther && faster)
            weight[0] = weight[1];
        else if (farther || faster)
            weight[1] = weight[0];
        const double open = shutter_weight(set.curve, u);
        total += 2 * open;
        sum.add(pair[0], g.here, weight[0] * open);
        sum.add(pair[1], g.here, weight[1] * open);
    }
    // With HDR weighting the missing weight is the pixel's own, which weighs less if it is bright.
    double missing = total;
    if (set.hdr_weighting)
        missing = sum.weight + std::max(total - sum.weight / std::max(g.here.hdr, 1e-6), 0.0) * g.here.hdr;
    return sum.over(g.here, missing);
}

std::array<double, 4> gather_coverage(const Gather& g, Vector n, Vector second, double j, double phase);

// All vectors in reach are nearly equal: the plain mean along the pixel's own.
std::array<double, 4> gather_uniform(const Gather& g, double j) {
    if (g.here.speed < still_length)
        return g.here.colour;
    const int taps = g.tap_count(g.here.speed, g.settings.taps);
    // Bilinear taps up to two pixels apart leave nothing out, so that noise has nothing to hide.
    if (g.settings.is_steady && 2 * g.here.speed / taps <= 2)
        j = 0;
    Sum sum;
    for (int i = 0; i < taps; ++i) {
        const double u = tap_place(i, taps, j);
        const Vector offset = -(g.centre + u) * g.here.v;
        if (g.inside(offset))
            sum.add(g.fetch(offset), g.here, shutter_weight(g.settings.curve, u));
    }
    return sum.over(g.here, sum.weight);
}

} // namespace

Grid<4> gather(const Grid<4>& colour, const Grid<3>& surface, const Grid<5>& neighbours,
               const MotionBlurSettings& settings, int iteration) {
    Grid<4> result(colour.width, colour.height);
    const int size = settings.tile_size;
    const int frame = settings.frame * settings.iterations + iteration;
    for (int y = 0; y < colour.height; ++y) {
        for (int x = 0; x < colour.width; ++x) {
            const auto& own_tile = neighbours.at(x / size, y / size);
            const TileClass kind = classify(own_tile, settings, colour.height);
            if (kind == TileClass::still) {
                result.at(x, y) = colour.at(x, y);
                continue;
            }
            Gather g{colour, surface, settings, x, y, frame, centre_of(settings.position), {}};
            g.here = g.fetch({0, 0});
            const double j = settings.jitter_amount * jitter(settings.jitter, x, y, frame);
            if (kind == TileClass::uniform) {
                result.at(x, y) = gather_uniform(g, j);
                continue;
            }
            Vector n{own_tile[0], own_tile[1]};
            if (settings.tile_jitter) {
                // A quarter of a tile either way. A neighbour that has nothing to say, or less than the pixel itself,
                // is not taken.
                const double shift = 5.588238 * frame;
                const double a = gradient_noise(x + shift + 47, y + shift + 17) - 0.5;
                const double b = gradient_noise(x + shift + 131, y + shift + 71) - 0.5;
                const int tx = std::clamp(static_cast<int>(std::floor((x + 0.5 + a * 0.5 * size) / size)), 0,
                                          neighbours.width - 1);
                const int ty = std::clamp(static_cast<int>(std::floor((y + 0.5 + b * 0.5 * size) / size)), 0,
                                          neighbours.height - 1);
                const Vector other{neighbours.at(tx, ty)[0], neighbours.at(tx, ty)[1]};
                if (length(other) >= std::max(still_length, g.here.speed))
                    n = other;
            }
            switch (settings.weighting) {
            case Weighting::talk:
                result.at(x, y) = gather_talk(g, n, j);
                break;
            case Weighting::guertin:
                result.at(x, y) = gather_guertin(g, n, j);
                break;
            case Weighting::jimenez:
                result.at(x, y) = gather_jimenez(g, n, j);
                break;
            case Weighting::coverage:
                result.at(x, y) =
                    gather_coverage(g, n, {own_tile[2], own_tile[3]}, j,
                                    settings.jitter_amount * jitter(settings.jitter, x + 47, y + 17, frame));
                break;
            }
        }
    }
    return result;
}

Grid<4> motion_blur(const MotionBlurInput& input, const MotionBlurSettings& settings) {
    const Grid<3> surface = velocity_stage(input, settings);
    const Grid<5> tiles = tile_maximum(surface, settings);
    const Grid<5> neighbours = neighbour_maximum(tiles, settings, settings.radius * input.colour.height);
    Grid<4> result(input.colour.width, input.colour.height);
    for (int i = 0; i < settings.iterations; ++i) {
        const Grid<4> pass = gather(input.colour, surface, neighbours, settings, i);
        for (std::size_t k = 0; k < result.texels.size(); ++k)
            for (std::size_t channel = 0; channel < 4; ++channel) {
                // The running mean, in this form, leaves equal passes exactly as they are.
                double& mean = result.texels[k][channel];
                mean = i == 0 ? pass.texels[k][channel] : mean + (pass.texels[k][channel] - mean) / (i + 1);
            }
    }
    return result;
}

namespace {

// ---- coverage ----
//
// Ask of each pixel which surface is seen there for what share of the time that the shutter is open. The shares sum to
// one, so there is no centre weight and no renormalisation.
//
// First, surfaces that pass in front. A search along the dominant vector n fetches no colour: it looks for nearer taps
// that move unlike the pixel. Where there are none, which is nearly everywhere, that is all. Where the ones found move
// like n, the taps of the search serve; where they do not (a rotating thing, a slower thing in a fast thing's tile),
// the mean of their vectors takes the place of n and the line is walked again. A tap counts if its own path passes over
// the pixel while the shutter is open, and stands for (spacing of taps) / (its speed) of the time.
//
// In the rest of the time, the pixel's own surface. Taps run along its own path. A tap that moves like the pixel, or
// lies at like depth, is carried over the pixel at that moment, so the surface is seen; a nearer one hides what was
// there and says nothing; one behind shows that the surface has moved away.
//
// When it has moved away, the background. Of the taps behind, the ones closest to the pixel weigh most.
//
// Paths bend where velocity changes over the surface. What is at X at time s came from Y with Y + s v(Y) = X; to second
// order Y = X - s v + s^2 a, where a is the change of v along v. Two taps measure it.
constexpr double alike = 0.3;         // of the longer vector: closer vectors move together
constexpr double steady = 0.1;        // of n: vectors this close to n need no second walk
constexpr double across_least = 1;    // pixels that the second vector must reach to the side of n
constexpr double curved_above = 2;    // pixels: shorter paths are taken as straight
constexpr double clear_of_edge = 0.5; // pixels
constexpr int least_hits = 2;         // one hit alone says too little of its surface's motion

struct Share {
    Sum sum;
    double share = 0; // without the HDR weight

    void add(const Tap& tap, const Tap& here, double w) {
        sum.add(tap, here, w);
        share += w;
    }
};

bool moves_alike(const Tap& a, const Tap& b) {
    return length(a.v - b.v) <= alike * std::max(a.speed, b.speed);
}

bool passes_in_front(const Gather& g, const Tap& tap) {
    return tap.speed >= still_length && tap.z < g.here.z - g.soft(g.here.z, tap.z) && !moves_alike(tap, g.here);
}

struct Arrival {
    double u;    // place in the shutter at which the tap is closest to the pixel
    double miss; // how far it passes from it, pixels
    double over; // how much of it passes over the pixel, [0, 1]
};

Arrival arrival(const Gather& g, const Tap& tap, Vector offset) {
    const double s = -dot(offset, tap.v) / (tap.speed * tap.speed);
    Arrival a{s - g.centre, length(offset + s * tap.v), 0};
    // Both edges are a pixel wide. The farther away, the less straight the way can be expected to be.
    a.over = saturate((1 - std::fabs(a.u)) * tap.speed + 0.5) * saturate(1.5 + 0.3 * length(offset) - a.miss);
    return a;
}

double mean_weight(ShutterCurve curve) {
    return curve == ShutterCurve::box ? 1 : curve == ShutterCurve::triangle ? 0.5 : 8.0 / 15;
}

// Share of the time for which a tap covers the pixel, where taps are `spacing` apart along the line.
double front_share(const Gather& g, const Tap& tap, const Arrival& a, double spacing) {
    const ShutterCurve curve = g.settings.curve;
    return a.over * shutter_weight(curve, std::clamp(a.u, -1.0, 1.0)) / mean_weight(curve) * spacing / (2 * tap.speed);
}

// `phase` is a second jitter, so that the search and the walks do not fall on the same places.
Share walk_front(const Gather& g, Vector n, double j, double phase) {
    Share front;
    // Both ways along n, whatever the shutter position: there may be things that move against it.
    const double reach = 1 + std::fabs(g.centre);
    const int count = g.tap_count(length(n), g.settings.search_taps);
    const double spacing = 2 * reach * length(n) / count;
    Vector mean;
    double weight = 0;
    double deviation = 0;
    int hits = 0;
    for (int i = 0; i < count; ++i) {
        const Vector offset = -(reach * tap_place(i, count, phase)) * n;
        const Tap tap = g.fetch_surface(offset);
        if (!passes_in_front(g, tap))
            continue;
        const Arrival a = arrival(g, tap, offset);
        // Taps whose paths come close to the pixel tell most of what passes over it. The line has no sign.
        const double w =
            saturate(3 * (1.2 - std::fabs(a.u))) * saturate(2 - a.miss / (1 + 0.5 * length(offset))) + 1e-6;
        const Vector v = dot(tap.v, n) < 0 ? -1.0 * tap.v : tap.v;
        mean = mean + w * v;
        weight += w;
        deviation = std::max(deviation, length(v - n));
        ++hits;
    }
    if (hits == 0)
        return front;
    mean = (1 / weight) * mean;
    const bool again = hits >= least_hits && deviation > steady * length(n) && length(mean) >= still_length;
    const Vector line = again ? mean : n;
    const int walk_count = again ? g.tap_count(length(line), g.settings.taps) : count;
    const double walk_spacing = again ? 2 * reach * length(line) / walk_count : spacing;
    for (int i = 0; i < walk_count; ++i) {
        const Vector offset = -(reach * tap_place(i, walk_count, again ? j : phase)) * line;
        Tap tap = g.fetch_surface(offset);
        if (!passes_in_front(g, tap))
            continue;
        const double share = front_share(g, tap, arrival(g, tap, offset), walk_spacing);
        if (share <= 0)
            continue;
        g.fetch_colour(tap, offset);
        front.add(tap, g.here, share);
    }
    return front;
}

// The change of velocity along the pixel's own path, from the surface half way along it on both sides.
Vector bend(const Gather& g) {
    Vector sum;
    int count = 0;
    for (const double u : {-0.5, 0.5}) {
        const double s = g.centre + u;
        const Tap tap = g.fetch_surface(-s * g.here.v);
        if (length(tap.v - g.here.v) > 0.5 * g.here.speed)
            continue; // another surface
        sum = sum + (1 / s) * (g.here.v - tap.v);
        ++count;
    }
    return count > 0 ? (1.0 / count) * sum : Vector{};
}

std::array<double, 4> gather_coverage(const Gather& g, Vector n, Vector second, double j, double phase) {
    Share front;
    Share own;
    Share back;
    double own_time = 0;
    double back_time = 0;
    const bool moves = g.here.speed >= still_length;
    // Where nothing in reach is faster than the pixel or moves otherwise, its own path meets whatever there is.
    const bool search = length(n) >= still_length && length(n - g.here.v) > steady * length(n);
    if (search)
        front = walk_front(g, n, j, phase);
    // Something that passes across the dominant vector is met by none of its taps.
    const bool search_second = g.settings.second_direction && front.share <= 0 &&
                               std::fabs(cross(second, n)) > across_least * length(n) &&
                               length(second - g.here.v) > steady * length(second);
    if (search_second)
        front = walk_front(g, second, j, phase);
    if (moves) {
        const int count = g.tap_count(g.here.speed, g.settings.taps);
        const Vector a = g.here.speed > curved_above ? bend(g) : Vector{};
        for (int i = 0; i < count; ++i) {
            const double u = tap_place(i, count, j);
            const double s = g.centre + u;
            const Vector offset = -s * g.here.v + s * s * a;
            if (!g.inside(offset))
                continue; // unknown, as if hidden
            Tap tap = g.fetch_surface(offset);
            const double open = shutter_weight(g.settings.curve, u);
            const double away = (tap.z - g.here.z) / g.soft(g.here.z, tap.z);
            if (moves_alike(tap, g.here) || std::fabs(away) <= 1) {
                g.fetch_colour(tap, offset);
                own_time += open;
                own.add(tap, g.here, open);
            } else if (away > 1) {
                // The pixels next to a silhouette hold some of both colours; take it from a little farther out.
                const double d = length(offset);
                g.fetch_colour(tap, (1 + clear_of_edge / std::max(d, 0.5)) * offset);
                const double near = std::max(d * d, 0.25);
                back_time += open;
                back.add(tap, g.here, open / (near * near));
            } else if (!search && !search_second && passes_in_front(g, tap)) {
                g.fetch_colour(tap, offset);
                const double spacing = 2 * g.here.speed / count;
                front.add(tap, g.here, front_share(g, tap, arrival(g, tap, offset), spacing));
            }
        }
    }
    const double covered = std::min(front.share, 1.0);
    const double known = own_time + back_time;
    const double left = 1 - covered;
    std::array<double, 4> difference{};
    double total = 0;
    const auto mix = [&](const Share& part, double share) {
        if (part.share <= 0 || share <= 0)
            return;
        const double scale = share / part.share;
        total += scale * part.sum.weight;
        for (std::size_t i = 0; i < 4; ++i)
            difference[i] += scale * part.sum.difference[i];
    };
    mix(front, covered);
    if (known > 0) {
        mix(own, left * own_time / known);
        mix(back, left * back_time / known);
    } else {
        total += left * g.here.hdr; // still, or hidden at every other moment: the pixel's own colour
    }
    std::array<double, 4> result = g.here.colour;
    if (total > 0)
        for (std::size_t i = 0; i < 4; ++i)
            result[i] += difference[i] / total;
    return result;
}

} // namespace

} // namespace sfumato::reference
