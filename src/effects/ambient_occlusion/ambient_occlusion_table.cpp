// The parameters, presets and images of ambient occlusion, each described once.
#include "sfumato/effects/ambient_occlusion.h"

#include "effects/ambient_occlusion/ambient_occlusion_plan.h"

namespace sfumato {

namespace {

using P = AmbientOcclusionParameters;

constexpr const char* estimators[] = {"obscurance", "horizon"};
constexpr const char* measures[] = {"hbao", "cosine", "bitmask"};
constexpr const char* falloffs[] = {"hard", "linear", "quadratic", "sao", "contact", "wide"};
constexpr const char* patterns[] = {"mirrored-spiral", "spiral", "growing-circle"};
constexpr const char* normalisations[] = {"calibrated", "vicarious-visions", "plain"};
constexpr const char* noises[] = {"none", "gradient-noise", "hash", "blocks"};
constexpr const char* resolutions[] = {"full", "half"};
constexpr const char* half_depths[] = {"checkerboard", "nearest", "farthest"};
constexpr const char* depth_mips[] = {"none", "rotated", "farthest", "centre"};
constexpr const char* storages[] = {"full", "half"};
constexpr const char* normal_sources[] = {"given", "derived"};
constexpr const char* normal_spaces[] = {"view", "world"};
constexpr const char* depth_weights[] = {"gaussian", "limit", "tent"};
constexpr const char* differences[] = {"relative", "radius"};
constexpr const char* upsamples[] = {"nearest", "bilinear", "soma", "relative"};
constexpr const char* applications[] = {"none", "ambient", "everything"};
constexpr const char* views[] = {"none", "depth", "normal", "mip", "radius", "estimate", "filtered", "history-weight"};

constexpr ParameterInfo rows[] = {
    parameter<&P::radius>("radius", "scene units", 0.0001, 1e5, "How far occluders reach.", parameter_logarithmic),
    parameter<&P::intensity>("intensity", "", 0.0, 8.0,
                             "Factor on the occlusion: 1 is as dark as ray tracing with the same falloff."),
    parameter<&P::power>("power", "", 0.1, 8.0, "Exponent on the visibility: above 1 darkens what is dark already.",
                         parameter_logarithmic),
    parameter<&P::falloff>(
        "falloff", falloffs,
        "How occluders lose weight with distance: not at all up to the radius; 1-t; 1-t²; as in SAO; "
        "(1-t)² for contact shadows; 1-t⁴ for wide influence."),
    parameter<&P::estimator>("estimator", estimators,
                             "Sums taps in front of the surface, or marches lines for what they hide of the sky."),
    parameter<&P::measure>("measure", measures,
                           "What the horizon hides: of elevation angles, as in HBAO; of cosine-weighted sky; or of "
                           "32 sectors of it, so that thin things hide only what is behind them (horizon)."),
    parameter<&P::slices>("slices", "", 1, 16, "Lines through the pixel, each marched both ways (horizon)."),
    parameter<&P::steps>("steps", "", 1, 64, "Taps on each way of a line (horizon)."),
    parameter<&P::step_power>("step_power", "", 1.0, 4.0, "Above 1 taps crowd near the pixel (horizon)."),
    parameter<&P::thickness>("thickness", "of the radius", 0.01, 100.0,
                             "How far behind its visible face a thing goes on; 100 is endless (bitmask).",
                             parameter_logarithmic),
    parameter<&P::pattern>("pattern", patterns,
                           "Where taps lie: pairs on a spiral, a spiral of any count, or SOMA's growing circle "
                           "(obscurance)."),
    parameter<&P::taps>("taps", "", 1, 128, "Taps a pixel (obscurance)."),
    parameter<&P::bias>("bias", "sine of the angle", 0.0, 0.9,
                        "Occluders lower than this above the surface do not count: hides facets and rounding."),
    parameter<&P::depth_bias>("depth_bias", "of depth", 0.0, 0.01, "Pulls the pixel towards the eye.",
                              parameter_advanced),
    parameter<&P::normalisation>(
        "normalisation", normalisations,
        "How the mean over taps becomes occlusion: matched to ray tracing, squared with a factor of two as Vicarious "
        "Visions print it, or as it is."),
    parameter<&P::radius_limit>("radius_limit", "of the image height", 0.001, 2.0,
                                "Longest radius on screen; what would be longer is shortened in the falloff as well."),
    parameter<&P::noise>("noise", noises, "How the pattern turns from pixel to pixel."),
    parameter<&P::animate_noise>("animate_noise", "A new pattern every frame, for temporal filters."),
    parameter<&P::iterations>("iterations", "", 1, 16, "Runs the estimator again with other noise and averages."),
    parameter<&P::resolution>("resolution", resolutions, "Whether the estimate is made at full or half resolution."),
    parameter<&P::half_depth>("half_depth", half_depths,
                              "Which of four depths stands for them at half resolution: the nearest keeps thin things "
                              "and straight edges, a checkerboard of nearest and farthest both sides of an edge.",
                              parameter_advanced),
    parameter<&P::depth_mips>("depth_mips", depth_mips,
                              "Coarser depths for distant taps: none, picked on a rotated grid, averages that lean to "
                              "the farthest, or the middle one picked.",
                              parameter_advanced),
    parameter<&P::mip_rate>("mip_rate", "log2 px", 0.0, 8.0, "Taps nearer than two to this use the finest depths.",
                            parameter_advanced),
    parameter<&P::depth_storage>("depth_storage", storages,
                                 "32 bits of depth, or 16 (full resolution): half the traffic, more noise.",
                                 parameter_advanced),
    parameter<&P::normals>("normals", normal_sources, "From the image of normals where there is one, or from depth."),
    parameter<&P::normal_space>("normal_space", normal_spaces, "The space of the image of normals."),
    parameter<&P::guard_band>("guard_band", "px", 0, 1024,
                              "Border of the image that is there for taps alone: it comes out open."),
    parameter<&P::filter_radius>("filter_radius", "px", 0, 8, "Half width of the bilateral filter; 0 is none."),
    parameter<&P::filter_step>("filter_step", "px", 1, 4,
                               "Distance of the filter's taps; radius times step is at most 8.", parameter_advanced),
    parameter<&P::filter_sigma>("filter_sigma", "px", 0.3, 100.0, "Width of the filter's bell.", parameter_logarithmic),
    parameter<&P::filter_weight>("filter_weight", depth_weights,
                                 "How weights fall with the difference of depth: a bell, all or nothing, linearly.",
                                 parameter_advanced),
    parameter<&P::filter_comparison>("filter_comparison", differences,
                                     "Whether filter_depth is a share of depth or of the radius.", parameter_advanced),
    parameter<&P::filter_depth>("filter_depth", "of depth, or of the radius", 0.0001, 10.0,
                                "Difference of depth across which the filter does not mix.", parameter_logarithmic),
    parameter<&P::filter_slope>("filter_slope", "Compares depths with the slope at the pixel continued.",
                                parameter_advanced),
    parameter<&P::filter_normal>("filter_normal", "", 0.0, 128.0,
                                 "Exponent on the cosine between normals; 0 does not look at normals.",
                                 parameter_advanced),
    parameter<&P::full_resolution_filter>("full_resolution_filter",
                                          "Half resolution is filtered after it is enlarged, not before."),
    parameter<&P::temporal>("temporal", "Blends with the previous frame's result where it shows the same."),
    parameter<&P::second_filter>("second_filter",
                                 "Filters again after the blend, and keeps that: SOMA's temporal blur (temporal)."),
    parameter<&P::history_position>("history_position", "per radius", 0.0, 1000.0,
                                    "How fast a distance from the remembered position discards history (temporal).",
                                    parameter_advanced),
    parameter<&P::history_visibility>("history_visibility", "", 0.0, 100.0,
                                      "How fast a change of visibility discards history: less trailing, more noise "
                                      "(temporal).",
                                      parameter_advanced),
    parameter<&P::history_time>("history_time", "1/s", 0.0, 60.0,
                                "Share of a new frame for every second that it lasts, at least (temporal).",
                                parameter_advanced),
    parameter<&P::history_length>("history_length", "frames", 0, 30,
                                  "Above 0: new pixels take the mean of as many frames as they have been seen in "
                                  "(temporal).",
                                  parameter_advanced),
    parameter<&P::history_occluders>("history_occluders",
                                     "Discards history where occluders moved: no trail behind them (temporal).",
                                     parameter_advanced),
    parameter<&P::upsample>("upsample", upsamples, "How half resolution becomes full."),
    parameter<&P::upsample_depth>("upsample_depth", "of depth; of the radius for soma", 0.0001, 10.0,
                                  "Difference of depth across which enlarging does not mix.", parameter_logarithmic),
    parameter<&P::application>("application", applications,
                               "What `output` is: the colour as it is, with its ambient part scaled, or all of it "
                               "scaled."),
    parameter<&P::debug_view>("debug_view", views, "Shows the inside of the effect instead of the visibility.",
                              parameter_debug),
};

// Vicarious Visions: four mirrored taps, a radius of at most 20 px of 720 lines, a wide blur. Where the documents leave
// a thing open (noise, weights of the blur), it is what is fast here.
constexpr PresetOverride current_gen[] = {
    {"estimator", "obscurance"}, {"falloff", "linear"},           {"pattern", "mirrored-spiral"}, {"taps", "4"},
    {"depth_mips", "none"},      {"radius_limit", "0.027777778"}, {"filter_radius", "4"},         {"bias", "0.05"},
    {"intensity", "1.6"},
};
constexpr PresetOverride dx11[] = {
    {"estimator", "obscurance"}, {"falloff", "linear"},  {"pattern", "spiral"}, {"taps", "9"}, {"bias", "0.05"},
    {"filter_radius", "4"},      {"resolution", "half"}, {"intensity", "1.6"},
};
constexpr PresetOverride sao[] = {
    {"estimator", "obscurance"}, {"falloff", "sao"},    {"pattern", "spiral"},     {"taps", "11"},
    {"noise", "hash"},           {"bias", "0.01"},      {"depth_mips", "rotated"}, {"filter_radius", "4"},
    {"filter_step", "2"},        {"filter_sigma", "4"},
};
constexpr PresetOverride hbao_crease[] = {
    {"measure", "hbao"}, {"falloff", "quadratic"}, {"slices", "2"},        {"steps", "8"},
    {"radius", "0.3"},   {"bias", "0.17"},         {"filter_radius", "7"}, {"filter_sigma", "4"},
};
constexpr PresetOverride hbao[] = {
    {"measure", "hbao"}, {"falloff", "quadratic"}, {"slices", "3"},        {"steps", "6"},
    {"bias", "0.17"},    {"resolution", "half"},   {"filter_radius", "3"}, {"filter_sigma", "2"},
};
constexpr PresetOverride hbao_16x16[] = {
    {"measure", "hbao"}, {"falloff", "quadratic"}, {"slices", "8"},         {"steps", "16"},
    {"bias", "0.17"},    {"filter_radius", "2"},   {"filter_sigma", "1.7"},
};
constexpr PresetOverride hbao_16x64[] = {
    {"measure", "hbao"}, {"falloff", "quadratic"}, {"slices", "8"},         {"steps", "64"},
    {"bias", "0.17"},    {"filter_radius", "2"},   {"filter_sigma", "1.7"},
};
// SOMA: lengths are 1.5 m, 2 cm, 9 a metre and 10 cm.
constexpr PresetOverride soma[] = {
    {"estimator", "obscurance"},
    {"falloff", "linear"},
    {"pattern", "growing-circle"},
    {"taps", "16"},
    {"resolution", "half"},
    {"half_depth", "checkerboard"},
    {"animate_noise", "true"},
    {"filter_radius", "2"},
    {"filter_sigma", "2"},
    {"filter_weight", "limit"},
    {"filter_comparison", "radius"},
    {"filter_depth", "0.013333333"},
    {"temporal", "true"},
    {"history_position", "13.5"},
    {"upsample", "soma"},
    {"upsample_depth", "0.066666667"},
    {"intensity", "1.6"},
};
constexpr PresetOverride soma_spatial[] = {
    {"estimator", "obscurance"},
    {"falloff", "linear"},
    {"pattern", "growing-circle"},
    {"taps", "16"},
    {"resolution", "half"},
    {"half_depth", "checkerboard"},
    {"filter_radius", "8"},
    {"filter_sigma", "5"},
    {"filter_weight", "limit"},
    {"filter_comparison", "radius"},
    {"filter_depth", "0.013333333"},
    {"full_resolution_filter", "true"},
    {"upsample", "soma"},
    {"upsample_depth", "0.066666667"},
    {"intensity", "1.6"},
};
constexpr PresetOverride low[] = {{"resolution", "half"}, {"slices", "1"}, {"steps", "4"}};
constexpr PresetOverride medium[] = {{"resolution", "half"}, {"slices", "1"}, {"steps", "8"}};
constexpr PresetOverride high[] = {{"resolution", "half"}, {"slices", "2"}, {"steps", "8"}};
constexpr PresetOverride ultra[] = {
    {"slices", "4"},
    {"steps", "16"},
    {"filter_radius", "2"},
    {"filter_sigma", "1.7"},
};

constexpr Preset presets[] = {
    {"current-gen",
     "Vicarious Visions' version for PlayStation 3 and Xbox 360: 4 taps, radius up to 20 px at 720 lines.",
     current_gen},
    {"dx11", "Vicarious Visions' version for DirectX 11: 9 taps on a spiral, depth mips, any radius.", dx11},
    {"sao", "Scalable ambient obscurance: 11 taps with its own falloff.", sao},
    {"hbao-crease", "HBAO with a small radius: creases.", hbao_crease},
    {"hbao", "HBAO, 6 directions of 6 steps at half resolution.", hbao},
    {"hbao-16x16", "HBAO, 16 directions of 16 steps at full resolution.", hbao_16x16},
    {"hbao-16x64", "HBAO, 16 directions of 64 steps at full resolution.", hbao_16x64},
    {"soma", "SOMA: 16 taps at half resolution, smoothed by temporal blur.", soma},
    {"soma-spatial", "The same without history, by a 17×17 filter at full resolution: what SOMA compares with.",
     soma_spatial},
    {"low", "Least time.", low},
    {"medium", "Between low and high.", medium},
    {"high", "The best picture for its time.", high},
    {"ultra", "Least error.", ultra},
};

template <Image AmbientOcclusionImages::*member>
Image& image(void* images) {
    return static_cast<AmbientOcclusionImages*>(images)->*member;
}

using I = AmbientOcclusionImages;
constexpr ImageRole roles[] = {
    {"depth", "linear view depth or device depth, as Frame::depth_kind says", ImageUse::input, 1, false,
     image<&I::depth>},
    {"normal",
     "unit vectors in three channels, or octahedral in two; formats without sign hold n/2 + 1/2; where "
     "not finite, the direction to the eye stands for them",
     ImageUse::optional_input, 2, false, image<&I::normal>},
    {"velocity", "pixels per frame, current minus previous, +x right, +y down; NaN where unknown",
     ImageUse::optional_input, 2, true, image<&I::velocity>},
    {"shadow", "1 lit, 0 in shadow: filtered along with the visibility", ImageUse::optional_input, 1, false,
     image<&I::shadow>},
    {"colour", "linear colour to apply the visibility to", ImageUse::optional_input, 3, false, image<&I::colour>},
    {"ambient", "the part of the colour that is ambient light", ImageUse::optional_input, 3, false, image<&I::ambient>},
    {"visibility", "1 open, 0 blocked", ImageUse::output, 1, false, image<&I::visibility>},
    {"soft_shadow", "the filtered shadow", ImageUse::optional_output, 1, false, image<&I::soft_shadow>},
    {"bent_normal", "mean open direction, view space", ImageUse::optional_output, 3, true, image<&I::bent_normal>},
    {"output", "the colour with the visibility applied", ImageUse::optional_output, 3, false, image<&I::output>},
};

constexpr ParameterTable ambient_occlusion_table = parameter_table<P>("ambient-occlusion", rows, presets);

constexpr EffectInfo ambient_occlusion_effect = {
    "ambient-occlusion",
    "How much of the sky each visible point sees.",
    "Bukowski et al., SIGGRAPH 2012 course; Frictional Games, SSAO and Temporal Blur, 2014; Bavoil et al., HBAO, 2008",
    &ambient_occlusion_table,
    roles,
    sizeof(AmbientOcclusionImages),
    true,
    [](const Frame& frame, const void* parameters, const void* images) {
        return plan_ambient_occlusion(frame, *static_cast<const P*>(parameters), *static_cast<const I*>(images));
    },
    [](const Frame& frame, const void* parameters, const void* images) {
        return check_ambient_occlusion(frame, *static_cast<const P*>(parameters), *static_cast<const I*>(images));
    },
};

} // namespace

const ParameterTable& AmbientOcclusionParameters::table() {
    return ambient_occlusion_table;
}
const EffectInfo& AmbientOcclusionImages::effect() {
    return ambient_occlusion_effect;
}

} // namespace sfumato
