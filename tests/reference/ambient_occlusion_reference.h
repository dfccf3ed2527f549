// The reference of every stage of ambient occlusion: slow, obvious, scalar, in double precision. It is written from the
// documents, not from the shaders, and in another form wherever there is one: positions are solved from the projection,
// mips go up child by child, the sky's share between two angles is integrated numerically.
//
// It follows
//   Bukowski, Hennessy, McGuire, Osman: Scalable High Quality Motion Blur and Ambient Occlusion, SIGGRAPH 2012 course;
//   McGuire, Mara, Luebke: Scalable Ambient Obscurance, HPG 2012;
//   Bavoil, Sainz, Dimitrov: Image-Space Horizon-Based Ambient Occlusion, SIGGRAPH 2008;
//   Jimenez et al.: Practical Realtime Strategies for Accurate Indirect Occlusion, 2016;
//   Therrien, Levesque, Gilbert: Screen Space Indirect Lighting with Visibility Bitmask, 2023;
//   Frictional Games: SSAO and Temporal Blur, 2014.
//
// Pixels count from the top left, their middles at +0.5. View space looks along -Z; depth is positive, `sky` where
// nothing is.
#pragma once

#include "sfumato/effects/ambient_occlusion.h"
#include "tests/reference/motion_blur_reference.h"

#include <cstdint>
#include <limits>
#include <utility>

namespace sfumato::reference {

inline constexpr double sky = std::numeric_limits<double>::infinity();

struct Place {
    double x = 0.0, y = 0.0, z = 0.0;
};

// One texel of prepared depth and the full-resolution place it was taken from.
struct DepthTexel {
    double z = sky;
    double x = 0.5, y = 0.5; // pixels
};

struct DepthLevel {
    int width = 0, height = 0;
    std::vector<DepthTexel> texels;
    const DepthTexel& at(int x, int y) const {
        return texels[static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)];
    }
    DepthTexel& at(int x, int y) { return const_cast<DepthTexel&>(std::as_const(*this).at(x, y)); }
};

// A signal as it travels from stage to stage.
struct OcclusionTexel {
    double visibility = 1.0;
    double z = sky;
    double shadow = 1.0;
    double count = 0.0; // frames of history
};

struct OcclusionSignal {
    int width = 0, height = 0;
    std::vector<OcclusionTexel> texels;
    OcclusionSignal(int w, int h) : width(w), height(h), texels(static_cast<size_t>(w) * static_cast<size_t>(h)) {}
    bool contains(int x, int y) const { return x >= 0 && y >= 0 && x < width && y < height; }
    const OcclusionTexel& at(int x, int y) const {
        return texels[static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)];
    }
    OcclusionTexel& at(int x, int y) { return const_cast<OcclusionTexel&>(std::as_const(*this).at(x, y)); }
};

class AmbientOcclusionReference {
  public:
    // `depth` is linear; `normal` in view space or empty. `calibration` and `turns` are the effect's own factor on the
    // mean over taps and turns of the spiral.
    AmbientOcclusionReference(Grid<1> depth, Grid<3> normal, const Frame& frame,
                              const AmbientOcclusionParameters& parameters, double calibration, int turns);

    int width() const { return depth_.width; }
    int height() const { return depth_.height; }
    int working_width() const { return is_half() ? (width() + 1) / 2 : width(); }
    int working_height() const { return is_half() ? (height() + 1) / 2 : height(); }

    // ------------------------------------------------------------------------------ depth and normals
    const DepthLevel& level(int m) const { return levels_[static_cast<size_t>(m)]; }
    Place position(double pixel_x, double pixel_y, double z) const;
    Place normal(int x, int y) const; // of a working texel, unit

    // ------------------------------------------------------------------------------ estimator
    double estimate(int x, int y) const; // at a working texel
    // View depth that filters take the texel to have: at half resolution that of its middle, on the surface's plane.
    double depth_in_middle(int x, int y) const;
    OcclusionSignal estimates() const;

    // ------------------------------------------------------------------------------ filters
    // Rows, then columns.
    OcclusionSignal filtered(const OcclusionSignal& signal) const;
    // `share`: the part of the present, where asked for.
    OcclusionSignal blended(const OcclusionSignal& present, const OcclusionSignal& history,
                            std::vector<double>* share = nullptr) const;
    OcclusionSignal upsampled(const OcclusionSignal& signal) const;

  private:
    struct Centre;
    struct Sum;
    bool is_half() const { return parameters_.resolution == OcclusionResolution::half; }
    double working_pixel() const { return is_half() ? 2.0 : 1.0; }
    double z_at(int x, int y) const;
    void prepare();
    Centre centre(int x, int y) const;
    bool on_screen(double x, double y) const;
    Place tap(double x, double y, double away) const;
    double falloff(double t) const;
    std::array<double, 2> noise(int x, int y, int iteration) const;
    void add_obscurance(const Centre& c, const std::array<double, 2>& noise, Sum& sum) const;
    double seen_share(const Centre& c, double dx, double dy, double radius_pixels) const;
    void add_horizons(const Centre& c, const std::array<double, 2>& noise, Sum& sum) const;
    OcclusionSignal filtered_along(const OcclusionSignal& signal, int dx, int dy) const;
    double planar(double z) const;

    Grid<1> depth_;
    Grid<3> normal_;
    Frame frame_;
    AmbientOcclusionParameters parameters_;
    double calibration_;
    int turns_;
    bool perspective_;
    std::vector<DepthLevel> levels_;
};

// The cosine-weighted sky between the angles a and b (from the eye's direction) in a slice whose normal is at gamma:
// the integral of cos(t - gamma) |sin t|, by Simpson's rule.
double sky_between(double a, double b, double gamma);

// Weights of the four half-resolution taps nearest to a full-resolution pixel, in the order (0,0) (1,0) (0,1) (1,1).
std::array<double, 4> upsample_weights(OcclusionUpsample kind, double part_x, double part_y,
                                       const std::array<double, 4>& differences);

// The visibility applied to a colour.
Place applied(OcclusionApplication application, const Place& colour, const Place& ambient, double visibility);

} // namespace sfumato::reference
