// The reference of every stage of motion blur: slow, obvious, scalar, in double precision. The shaders are written from
// it and must agree with it tap for tap, so every position, rounding, tie and guard is spelled out here or in the .cpp
// file.
//
// It follows
//   McGuire, Hennessy, Bukowski, Osman: A Reconstruction Filter for Plausible Motion Blur, I3D 2012;
//   Bukowski, Hennessy, McGuire, Osman: Scalable High Quality Motion Blur and Ambient Occlusion, SIGGRAPH 2012 course;
//   Guertin, McGuire, Nowrouzezahrai: A Fast and Stable Feature-Aware Motion Blur Filter, HPG 2014;
//   Jimenez: Next Generation Post Processing in Call of Duty: Advanced Warfare, SIGGRAPH 2014 course;
// and adds the `coverage` weighting, which is described above its function in the .cpp file.
//
// Conventions. Images have their origin at the top left, x to the right, y down. Velocity is in pixels per frame,
// current minus previous; the optional next velocity is next minus current. A *half displacement* v is what the content
// moves in half the shutter: while the shutter is open, what is seen at Y passes through Y + s v, where s runs over [c
// - 1, c + 1]; c is 0 for a centred shutter, +1 for one that opens at the frame's time and -1 for one that closes then.
// So a tap with parameter s lies at X - s v: what is seen there at the frame's time is at X at time s. Depth is linear,
// positive, growing away from the camera.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace sfumato::reference {

// An image. A grid without texels stands for an input that is not there.
template <int N>
struct Grid {
    int width = 0;
    int height = 0;
    std::vector<std::array<double, N>> texels;

    Grid() = default;
    Grid(int w, int h) : width(w), height(h), texels(static_cast<std::size_t>(w) * static_cast<std::size_t>(h)) {}

    bool empty() const { return texels.empty(); }
    std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
    }
    std::array<double, N>& at(int x, int y) { return texels[index(x, y)]; }
    const std::array<double, N>& at(int x, int y) const { return texels[index(x, y)]; }
    // Outside, the nearest texel of the border.
    const std::array<double, N>& clamped(int x, int y) const {
        return at(std::clamp(x, 0, width - 1), std::clamp(y, 0, height - 1));
    }
};

struct Vector {
    double x = 0;
    double y = 0;
};

using Matrix = std::array<double, 16>; // column-major, for column vectors

enum class ShutterPosition { start, centre, end };
enum class ShutterCurve { box, triangle, smooth };
enum class Storage { exact, half, packed };
enum class Dilation { box, selective, line };
enum class Weighting { talk, guertin, jimenez, coverage };
enum class SoftExtent { relative, absolute };
enum class TapJitter { none, checkerboard, ordered, gradient_noise };
enum class LayerBlend { add, replace, larger };
enum class TileClass { still, uniform, full };

// Artificial velocity: particles, full-screen masks, game events.
struct VelocityLayer {
    Grid<2> velocity; // pixels per frame of the layer's own image
    Grid<1> mask;     // optional, 1 = the layer applies in full
    LayerBlend blend = LayerBlend::add;
    double strength = 1;
};

// Camera motion, for pixels that have no velocity of their own. View space is right-handed, -Z ahead, +Y up.
struct CameraMotion {
    bool given = false;
    Matrix clip_from_view{};          // projection of this frame
    Matrix previous_clip_from_view{}; // this frame's view space, at the previous frame's time, to the previous frame's
                                      // clip space
    Matrix next_clip_from_view{};     // the same for the next frame; used only if next_given
    bool next_given = false;
};

struct MotionBlurInput {
    Grid<4> colour;        // linear, alpha premultiplied
    Grid<1> depth;         // may be empty: then all of the picture lies at depth 1
    Grid<2> velocity;      // may be empty; its resolution may differ from the colour's
    Grid<2> next_velocity; // may be empty
    Grid<1> exclusion;     // may be empty; 1 = not blurred at all
    CameraMotion camera;
    std::vector<VelocityLayer> layers; // at most two
};

// The defaults are those of `coverage` at `high`.
struct MotionBlurSettings {
    double shutter = 0.5; // of a frame
    ShutterPosition position = ShutterPosition::centre;
    ShutterCurve curve = ShutterCurve::box;
    double radius = 0.06; // longest half displacement, a fraction of the image height
    bool repair_edges = true;
    Storage storage = Storage::half;

    int tile_size = 32;
    Dilation dilation = Dilation::line;
    bool test_edge_neighbours = false;
    bool classify = true;
    double uniform_tolerance = 0.05;   // of the length of the longest vector, or
    double uniform_pixels = 1 / 1080.; // this fraction of the image height

    Weighting weighting = Weighting::coverage;
    int taps = 10;                // without the centre
    int search_taps = 8;          // coverage: of velocity and depth only, for what passes in front
    int least_taps = 6;           // below which taps_per_pixel does not go
    bool second_direction = true; // coverage: search along the widest other vector as well
    bool filter_taps = true;      // bilinear colour
    double taps_per_pixel = 1;    // above 0: min(taps, ceil(length of the half displacement * this))
    bool alternate = false;       // odd taps along the pixel's own velocity
    bool tile_jitter = false;
    TapJitter jitter = TapJitter::gradient_noise;
    double jitter_amount = 0.5; // of the spacing of taps
    bool hdr_weighting = false;
    SoftExtent soft_extent_kind = SoftExtent::relative;
    double soft_extent = 0.02; // a fraction of the nearer depth, or scene units
    double background_weight = 1;
    double foreground_weight = 0.25;
    double mutual_weight = 1;
    double centre_weight = 0.5;
    int iterations = 1;
    int frame = 0;
    bool is_steady = true; // no other noise will follow, of iterations or frames
};

// ---- stages ----

double round_to_half(double value);
double centre_of(ShutterPosition position);             // c
double shutter_weight(ShutterCurve curve, double u);    // openness at u in [-1, 1]; 0 outside
double jitter(TapJitter kind, int x, int y, int frame); // [-0.5, 0.5)
double gradient_noise(double x, double y);              // [0, 1)
std::array<int, 4> pack(Vector v, double depth, double radius_pixels);
std::array<double, 3> unpack(const std::array<int, 4>& code, double radius_pixels);

// Half displacement (x, y) and depth (z) of every pixel of the colour image, as the storage format holds them.
Grid<3> velocity_stage(const MotionBlurInput& input, const MotionBlurSettings& settings);

// Of every tile: the longest vector (x, y); the one that reaches farthest to its side (z, w); the spread, which is the
// greatest distance of any vector from the longest.
Grid<5> tile_maximum(const Grid<3>& surface, const MotionBlurSettings& settings);

// The same over all vectors that reach the tile; the spread over all in reach.
Grid<5> neighbour_maximum(const Grid<5>& tiles, const MotionBlurSettings& settings, double radius_pixels);

// Whether the vectors of a tile at offset (tiles) can reach the tile in the middle.
bool reaches(Vector v, Vector second, int offset_x, int offset_y, const MotionBlurSettings& settings);

TileClass classify(const std::array<double, 5>& neighbour, const MotionBlurSettings& settings, int height);

Grid<4> gather(const Grid<4>& colour, const Grid<3>& surface, const Grid<5>& neighbours,
               const MotionBlurSettings& settings, int iteration);

// All stages.
Grid<4> motion_blur(const MotionBlurInput& input, const MotionBlurSettings& settings);

} // namespace sfumato::reference
