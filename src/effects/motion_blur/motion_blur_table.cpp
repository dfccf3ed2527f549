// The parameters, presets and images of motion blur, each described once.
#include "sfumato/effects/motion_blur.h"

#include "effects/motion_blur/motion_blur_plan.h"

namespace sfumato {

namespace {

using P = MotionBlurParameters;

constexpr const char* positions[] = {"start", "centre", "end"};
constexpr const char* curves[] = {"box", "triangle", "smooth"};
constexpr const char* frame_rate_modes[] = {"native", "reference", "fixed"};
constexpr const char* storages[] = {"half", "packed"};
constexpr const char* dilations[] = {"box", "selective", "line"};
constexpr const char* weightings[] = {"talk", "guertin", "jimenez", "coverage"};
constexpr const char* jitters[] = {"none", "checkerboard", "ordered", "gradient-noise"};
constexpr const char* comparisons[] = {"relative", "absolute"};
constexpr const char* blends[] = {"add", "replace", "larger"};
constexpr const char* views[] = {"none",       "velocity", "depth", "tile-maximum", "neighbour-maximum",
                                 "tile-class", "taps",     "share"};

constexpr ParameterInfo rows[] = {
    parameter<&P::shutter>("shutter", "of a frame", 0.0, 4.0,
                           "How long the shutter is open: 0.5 is 180°, film's usual; above 1 trails overlap."),
    parameter<&P::shutter_position>(
        "shutter_position", positions,
        "When the shutter opens: at the frame's time, around it, or so that it closes then."),
    parameter<&P::shutter_curve>("shutter_curve", curves,
                                 "How it opens and closes: at once, linearly, or smoothly (softer ends of trails)."),
    parameter<&P::frame_rate_mode>(
        "frame_rate_mode", frame_rate_modes,
        "What the shutter is a fraction of: this frame; a frame at the reference rate, but never more than native; or "
        "always a frame at the reference rate."),
    parameter<&P::reference_frame_rate>("reference_frame_rate", "Hz", 1.0, 1000.0,
                                        "Frame rate that the modes reference and fixed refer to."),
    parameter<&P::generated_frames>("generated_frames", "", 1, 8,
                                    "Displayed frames for every rendered one (frame generation): each gets its share."),
    parameter<&P::radius>("radius", "of the image height", 0.0, 0.25,
                          "Longest half displacement; what moves farther is clamped to it."),
    parameter<&P::taps>("taps", "", 1, 128, "Taps without the centre, along each direction that the weighting walks."),
    parameter<&P::taps_per_pixel>("taps_per_pixel", "1/px", 0.0, 4.0,
                                  "Above 0: taps in proportion to the half displacement, up to `taps`."),
    parameter<&P::least_taps>("least_taps", "", 1, 128, "Below which `taps_per_pixel` does not go.",
                              parameter_advanced),
    parameter<&P::search_taps>("search_taps", "", 1, 128,
                               "Taps of velocity and depth alone that look for what passes in front (coverage)."),
    parameter<&P::second_direction>("second_direction",
                                    "Looks along the widest other vector of the tile as well (coverage)."),
    parameter<&P::filter_taps>("filter_taps", "Bilinear colour at the exact place of a tap, not the nearest pixel's."),
    parameter<&P::weighting>("weighting", weightings,
                             "How taps are weighted: as in the talk, after Guertin 2014, after Jimenez 2014, or by the "
                             "share of the shutter that each surface covers."),
    parameter<&P::alternate>("alternate", "Odd taps along the pixel's own velocity (talk)."),
    parameter<&P::jitter>("jitter", jitters, "How taps are displaced from pixel to pixel: noise instead of bands."),
    parameter<&P::jitter_amount>("jitter_amount", "of the taps' spacing", 0.0, 1.0,
                                 "How far taps are displaced: 1 hides all bands, less is less noise."),
    parameter<&P::animate_jitter>("animate_jitter", "A new pattern every frame, for use before temporal antialiasing."),
    parameter<&P::tile_jitter>("tile_jitter",
                               "Looks the tile up with a random offset, so that no tile's border shows."),
    parameter<&P::iterations>(
        "iterations", "", 1, 32,
        "Runs the gather again with other jitter and averages: N converge to the many-tap image."),
    parameter<&P::hdr_weighting>("hdr_weighting",
                                 "Weights taps by 1/(1 + luminance): small bright lights give smooth trails, dimmer."),
    parameter<&P::depth_comparison>("depth_comparison", comparisons,
                                    "Whether soft_extent is a fraction of depth or a length in scene units."),
    parameter<&P::soft_extent>("soft_extent", "of depth, or scene units", 0.0001, 100.0,
                               "Depth difference over which foreground turns into background.", parameter_logarithmic),
    parameter<&P::weight_background>("weight_background", "", 0.0, 16.0, "Weight of taps behind the pixel (talk)."),
    parameter<&P::weight_foreground>("weight_foreground", "", 0.0, 16.0,
                                     "Weight of taps in front that move over it (talk)."),
    parameter<&P::weight_mutual>("weight_mutual", "", 0.0, 16.0, "Weight of taps where both are blurry (talk)."),
    parameter<&P::weight_centre>("weight_centre", "", 0.001, 64.0,
                                 "Weight of the pixel itself: higher is subtler, lower is thicker (talk, guertin).",
                                 parameter_logarithmic),
    parameter<&P::storage>("storage", storages,
                           "How velocity and depth are kept between passes: 8 bytes a pixel, or 4 as in the talk."),
    parameter<&P::repair_edges>("repair_edges",
                                "Restores velocities that antialiasing has mixed at silhouettes, as renderers do."),
    parameter<&P::layer_1_blend>("layer_1_blend", blends, "How velocity layer 1 combines with what is below."),
    parameter<&P::layer_1_strength>("layer_1_strength", "", -4.0, 4.0, "Factor on velocity layer 1."),
    parameter<&P::layer_2_blend>("layer_2_blend", blends, "How velocity layer 2 combines with what is below."),
    parameter<&P::layer_2_strength>("layer_2_strength", "", -4.0, 4.0, "Factor on velocity layer 2."),
    parameter<&P::tile>(
        "tile", "px", 0, 32,
        "Tile size, rounded up to a multiple of 8; 0 takes the maximum blur radius, as in the talk, up to 32.",
        parameter_advanced),
    parameter<&P::dilation>("dilation", dilations,
                            "Which neighbouring tiles count: all, those whose line crosses the tile, or those whose "
                            "vector reaches it.",
                            parameter_advanced),
    parameter<&P::test_edge_neighbours>("test_edge_neighbours",
                                        "Selective dilation tests neighbours in the same row or column as well.",
                                        parameter_advanced),
    parameter<&P::tile_classes>("tile_classes", "Tiles of one even motion skip the comparisons of every tap.",
                                parameter_advanced),
    parameter<&P::uniform_tolerance>("uniform_tolerance", "of the longest vector", 0.0, 0.5,
                                     "How far vectors may differ in a tile of even motion.", parameter_advanced),
    parameter<&P::uniform_pixels>("uniform_pixels", "px at 1080 lines", 0.0, 8.0,
                                  "Likewise in pixels; the larger of both holds.", parameter_advanced),
    parameter<&P::debug_view>("debug_view", views, "Shows the inside of the effect instead of the picture.",
                              parameter_debug),
};

// The talk gives taps, jitter, radius, packing and alternation. Weights, soft extent and tiles, which it leaves open,
// are found by search against ground truth.
constexpr PresetOverride current_gen[] = {
    {"weighting", "talk"},
    {"taps", "6"},
    {"least_taps", "2"},
    {"jitter", "checkerboard"},
    {"jitter_amount", "0.25"},
    {"radius", "0.013888889"},
    {"storage", "packed"},
    {"alternate", "true"},
    {"tile", "16"},
    {"dilation", "line"},
    {"soft_extent", "0.01"},
    {"uniform_pixels", "8"},
    {"uniform_tolerance", "0.1"},
};
constexpr PresetOverride dx11[] = {
    {"weighting", "talk"},
    {"taps", "8"},
    {"least_taps", "2"},
    {"jitter", "ordered"},
    {"jitter_amount", "0.25"},
    {"radius", "0.016666667"},
    {"storage", "packed"},
    {"alternate", "true"},
    {"tile", "16"},
    {"dilation", "line"},
    {"soft_extent", "0.01"},
    {"uniform_pixels", "8"},
    {"uniform_tolerance", "0.1"},
};
constexpr PresetOverride low[] = {
    {"taps", "4"},           {"search_taps", "4"},         {"least_taps", "2"}, {"second_direction", "false"},
    {"uniform_pixels", "3"}, {"uniform_tolerance", "0.1"},
};
constexpr PresetOverride medium[] = {
    {"taps", "6"},           {"search_taps", "5"},         {"least_taps", "3"}, {"second_direction", "false"},
    {"uniform_pixels", "3"}, {"uniform_tolerance", "0.1"},
};
constexpr PresetOverride high[] = {
    {"taps", "7"},           {"search_taps", "6"},         {"least_taps", "2"},       {"second_direction", "false"},
    {"uniform_pixels", "3"}, {"uniform_tolerance", "0.1"}, {"jitter_amount", "0.25"},
};
constexpr PresetOverride ultra[] = {
    {"taps", "32"}, {"search_taps", "16"}, {"least_taps", "10"}, {"taps_per_pixel", "2"}, {"repair_edges", "true"},
};

constexpr Preset presets[] = {
    {"current-gen", "The talk's version for PlayStation 3 and Xbox 360: 7 taps, checkerboard, 10 px at 720 lines.",
     current_gen},
    {"dx11", "The talk's version for DirectX 11: 9 taps, 4×4 jitter, 18 px at 1080 lines.", dx11},
    {"low", "Least time.", low},
    {"medium", "Between low and high.", medium},
    {"high", "The best picture for its time.", high},
    {"ultra", "Least error.", ultra},
};

template <Image MotionBlurImages::*member>
Image& image(void* images) {
    return static_cast<MotionBlurImages*>(images)->*member;
}

using I = MotionBlurImages;
constexpr ImageRole roles[] = {
    {"colour", "linear colour, alpha premultiplied", ImageUse::input, 3, false, image<&I::colour>},
    {"depth", "linear view depth or device depth, as Frame::depth_kind says", ImageUse::optional_input, 1, false,
     image<&I::depth>},
    {"velocity", "pixels per frame, current minus previous, +x right, +y down; NaN where unknown",
     ImageUse::optional_input, 2, true, image<&I::velocity>},
    {"next_velocity", "pixels per frame, next minus current", ImageUse::optional_input, 2, true,
     image<&I::next_velocity>},
    {"layer_1", "artificial velocity: particles, full-screen masks, game events", ImageUse::optional_input, 2, true,
     image<&I::layer_1>},
    {"layer_1_mask", "share of layer 1, 0 to 1", ImageUse::optional_input, 1, false, image<&I::layer_1_mask>},
    {"layer_2", "artificial velocity above layer 1", ImageUse::optional_input, 2, true, image<&I::layer_2>},
    {"layer_2_mask", "share of layer 2, 0 to 1", ImageUse::optional_input, 1, false, image<&I::layer_2_mask>},
    {"exclusion_mask", "1 where nothing is blurred: view model, vehicle", ImageUse::optional_input, 1, false,
     image<&I::exclusion_mask>},
    {"output", "the blurred colour", ImageUse::output, 3, false, image<&I::output>},
};

constexpr ParameterTable motion_blur_table = parameter_table<P>("motion-blur", rows, presets);

constexpr EffectInfo motion_blur_effect = {
    "motion-blur",
    "What moves smears along its path while the shutter is open.",
    "Bukowski et al., Scalable High Quality Motion Blur and Ambient Occlusion, SIGGRAPH 2012 course",
    &motion_blur_table,
    roles,
    sizeof(MotionBlurImages),
    false,
    [](const Frame& frame, const void* parameters, const void* images) {
        return plan_motion_blur(frame, *static_cast<const MotionBlurParameters*>(parameters),
                                *static_cast<const MotionBlurImages*>(images));
    },
};

} // namespace

const ParameterTable& MotionBlurParameters::table() {
    return motion_blur_table;
}
const EffectInfo& MotionBlurImages::effect() {
    return motion_blur_effect;
}

} // namespace sfumato
