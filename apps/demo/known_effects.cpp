// The table of known effects.
#include "apps/demo/known_effects.h"

#include <algorithm>

namespace sfumato::demo {
namespace {

const std::vector<KnownEffect> table = {
    {.name = "motion-blur",
     .text = "The picture before is sharp, as a game renders it. Each preset gets that picture, its depth and its "
             "velocity, nothing else, and smears what moves as a camera would whose shutter is open for half of the "
             "frame. The truth is the mean of many sharp frames within that time.",
     .scenes = {{"fairground",
                 "Look at the sails of the windmill, sharp at the hub and ever softer towards their tips, and at the "
                 "wall behind them, which stays sharp.",
                 {}},
                {"two-trains",
                 "The hardest places are those where one train shows through the gaps of the other.",
                 {"dx11", "high", "ultra"}}},
     .pictures = {},
     .presets_heading = "",
     .truths = {},
     .views = {{"velocity", "Motion of each pixel: direction as hue, length against the longest blur as brightness.",
                ""},
               {"depth", "View depth, as the passes after the first read it.", ""},
               {"tile-maximum", "The longest motion within each tile.", ""},
               {"neighbour-maximum", "The longest motion that reaches each tile.", ""},
               {"tile-class", "Still tiles blue, tiles of one even motion green, all others red.", ""},
               {"taps", "How many samples each pixel takes; white is 64.", ""},
               {"share", "How much of each pixel other surfaces cover while the shutter is open.", ""}},
     .figures = {{"rmse_moving", "RMSE moving", "", 4},
                 {"psnr_moving", "PSNR moving", "dB", 2},
                 {"psnr_still", "PSNR still", "dB", 2}},
     .figures_text =
         "Errors are those of display-encoded colour (0 to 1), over the pixels that motion reaches and over the "
         "rest. RMSE: the less the better. PSNR: the more the better."},
    {.name = "ambient-occlusion",
     .text = "Corners and gaps see less of the sky, so less ambient light reaches them. The effect finds out how much "
             "from the depth and the normals of the picture alone. The truth is traced with rays through the scene.",
     .scenes = {{"contact", "Look where things meet the floor, and at those that hover a little above it.", {}}},
     .pictures = {{"with occlusion",
                   "Ambient light scaled by the visibility of preset high.",
                   {"--effects", "ambient-occlusion", "--preset", "high", "--set", "application=ambient"}}},
     .presets_heading = "visibility, white where the whole sky is seen",
     .truths = {{"truth", "Traced with rays of 1.5 m, as far as most presets reach.", {"--truth", "ambient-occlusion"}},
                {"truth, 0.3 m",
                 "Traced with rays of 0.3 m, as far as hbao-crease reaches.",
                 {"--truth", "ambient-occlusion", "--truth-radius", "0.3"}}},
     .views = {{"depth", "View depth, as the estimate reads it.", ""},
               {"normal", "Normals, lit from the upper left.", ""},
               {"mip", "The coarsest level of depth that the samples of a pixel read.", ""},
               {"radius", "How far the samples reach on the screen, as a share of the height.", ""},
               {"estimate", "Visibility before it is filtered.", ""},
               {"filtered", "Visibility after the first filter.", ""},
               {"history-weight", "How much of the picture before each pixel keeps.", "soma"}},
     .figures = {{"rmse", "RMSE all", "", 4}, {"rmse_occluded", "RMSE occluded", "", 4}, {"bias", "bias", "", 4}},
     .figures_text = "Errors are those of visibility, 1 open to 0 blocked, over all pixels and over those that are "
                     "occluded. Bias below 0: too dark."},
    {.name = "particles",
     .text = "Particles are simulated, sorted, shadowed and drawn on the device. They shadow themselves and the floor, "
             "and the columns shadow them. The command sfumato-bench particles holds the picture against brute force.",
     .scenes = {{"smoke-columns",
                 "Look at the shadow of the smoke on the floor, and at the ball that swings through it.",
                 {}}},
     .pictures = {},
     .presets_heading = "",
     .truths = {},
     .views = {{"order", "The order of drawing, from the first to the last.", ""},
               {"slices", "The layer or slice of the shadow buffer that each particle is in.", ""},
               {"shadow", "Optical depth from the light through the whole shadow buffer.", ""},
               {"tiles", "How many particles touch each tile.", ""}},
     .figures = {},
     .figures_text = "",
     .usual = "low",
     .for_gpus = {"explosion", "high", "ultra"}},
};

} // namespace

const KnownEffect& known_effect(std::string_view name) {
    static const KnownEffect nothing;
    const auto found = std::ranges::find_if(table, [&](const KnownEffect& effect) { return effect.name == name; });
    return found == table.end() ? nothing : *found;
}

} // namespace sfumato::demo
