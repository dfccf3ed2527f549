// `quality`: how far each preset is from ground truth, between doing nothing and the best that can be told apart.
#include "apps/bench/commands.h"
#include "apps/bench/pictures.h"

#include <future>

#include <fmt/format.h>

namespace sfumato::bench {
namespace {

struct Picture {
    std::string label;
    media::Planes planes;
};

struct Block {
    const EffectInfo* effect;
    std::string source;
    Extent extent;
    std::string key;
    double region_share = 0.0;
    std::vector<ScoredRow> rows;
};

std::string file_name(std::string text) {
    for (char& c : text)
        if (c == ' ' || c == '=' || c == '/')
            c = '-';
    return text;
}

Result<void> write_pictures(const std::string& folder, const Block& block, const Judge& judge,
                            const std::vector<Picture>& pictures) {
    const std::string key = block.key.empty() ? "" : "." + block.key;
    const std::string start = folder + "/" + file_name(fmt::format("{}.{}{}", block.effect->name, block.source, key));
    if (auto written = write_png(start + ".truth.png", judge.truth()); !written)
        return written;
    for (const Picture& picture : pictures)
        if (auto written = write_png(start + "." + file_name(picture.label) + ".png", picture.planes); !written)
            return written;
    return {};
}

// The variants of one effect that share a truth.
Result<Block> measure_block(Rig& rig, const Options& options, const std::vector<const Variant*>& variants,
                            const Source& source) {
    auto judge = Judge::create(rig, options, *variants.front(), source);
    if (!judge)
        return judge.error();
    Block block{variants.front()->effect, source.name(),
                (*judge)->extent(),       Judge::key(options, *variants.front()),
                (*judge)->region_share(), {}};
    std::vector<Picture> pictures;
    pictures.push_back({"do nothing", (*judge)->do_nothing()});
    auto context = rig.create_context(2, false);
    if (!context)
        return context.error();
    for (const Variant* variant : variants) {
        auto picture = (*judge)->run(rig, **context, *variant);
        if (!picture)
            return picture.error();
        pictures.push_back({variant->label, std::move(*picture)});
    }
    if ((*judge)->ceiling())
        pictures.push_back({"ceiling", *(*judge)->ceiling()});
    // Structural similarity takes longer than everything before.
    std::vector<std::future<Score>> scores;
    for (const Picture& picture : pictures)
        scores.push_back(std::async(std::launch::async, [&] { return (*judge)->score(picture.planes, options.ssim); }));
    for (size_t i = 0; i < pictures.size(); ++i)
        block.rows.push_back({pictures[i].label, scores[i].get()});
    if (!options.pictures.empty())
        if (auto written = write_pictures(options.pictures, block, **judge, pictures); !written)
            return written.error();
    return block;
}

// Groups of variants with one effect and one truth, in their order.
std::vector<std::vector<const Variant*>> groups_of(const Options& options, const Variants& variants) {
    std::vector<std::vector<const Variant*>> groups;
    for (const Variant& variant : variants) {
        if (adapter_of(*variant.effect).truth == nullptr)
            continue;
        bool found = false;
        for (auto& group : groups)
            if (!found && group.front()->effect == variant.effect &&
                Judge::key(options, *group.front()) == Judge::key(options, variant)) {
                group.push_back(&variant);
                found = true;
            }
        if (!found)
            groups.push_back({&variant});
    }
    return groups;
}

std::string labels_of(const std::vector<const Variant*>& group) {
    std::string text;
    for (const Variant* variant : group)
        text += (text.empty() ? "" : ", ") + variant->label;
    return text;
}

std::string signed_text(double value) {
    return (value > 0.0 ? "+" : "") + fixed(value, 4);
}

std::string row_label(const Block& block, const ScoredRow& row) {
    return block.key.empty() ? row.label : row.label + " (" + block.key + ")";
}

// Pictures: in dB, apart where things move.
Table picture_table(const std::vector<const Block*>& blocks) {
    Table table({"effect", "scene", "size", "preset", "PSNR all", "moving", "still", "SSIM", "max error", "moving %"},
                4);
    for (const Block* block : blocks)
        for (const ScoredRow& row : block->rows) {
            const Score& score = row.score;
            table.add({block->effect->name, block->source, extent_text(block->extent), row_label(*block, row),
                       fixed(score.all.psnr, 2), fixed(score.region.psnr, 2), fixed(score.rest.psnr, 2),
                       fixed(score.all.ssim, 4), fixed(score.all.max_error, 3), fixed(100.0 * block->region_share, 1)});
            if (score.all.non_finite > 0)
                table.add({"", "", "", fmt::format("  {} pixels are NaN or infinite", score.all.non_finite)});
        }
    return table;
}

// Everything else: in its own unit, apart where doing nothing is wrong.
Table value_table(const std::vector<const Block*>& blocks) {
    Table table({"effect", "scene", "size", "preset", "RMSE", "bias", "RMSE occluded", "bias", "RMSE open", "bias",
                 "SSIM", "max error", "occluded %"},
                4);
    for (const Block* block : blocks)
        for (const ScoredRow& row : block->rows) {
            const Score& score = row.score;
            table.add({block->effect->name, block->source, extent_text(block->extent), row_label(*block, row),
                       fixed(score.all.rmse, 4), signed_text(score.all.bias), fixed(score.region.rmse, 4),
                       signed_text(score.region.bias), fixed(score.rest.rmse, 4), signed_text(score.rest.bias),
                       fixed(score.all.ssim, 4), fixed(score.all.max_error, 3), fixed(100.0 * block->region_share, 1)});
            if (score.all.non_finite > 0)
                table.add({"", "", "", fmt::format("  {} pixels are NaN or infinite", score.all.non_finite)});
        }
    return table;
}

std::string tables_text(const std::vector<Block>& blocks, const Options& options) {
    std::vector<const Block*> pictures, values;
    for (const Block& block : blocks)
        (adapter_of(*block.effect).display_encoded ? pictures : values).push_back(&block);
    std::string text;
    if (!pictures.empty())
        text += picture_table(pictures).text() +
                "PSNR in dB of sRGB-encoded colour, 120 for equality; moving: where truth and sharp frame differ; "
                "ceiling: truth with half the sub-frames.\n";
    if (!values.empty())
        text += std::string(text.empty() ? "" : "\n") + value_table(values).text() +
                fmt::format("Visibility, 1 open to 0 blocked; do nothing: 1; bias: mean of result less truth, below 0 "
                            "is too dark; occluded: where the truth is below 0.955, and 3 pixels around; ceiling: a "
                            "second truth with other rays. Falloff of the truth: {}. Presets with a history are scored "
                            "after {} more frames; a file's one frame is held still for them.\n",
                            options.truth_falloff, options.preroll);
    return text;
}

} // namespace

Result<void> measure_quality(Rig& rig, const Options& options, const Variants& variants, const Sources& sources,
                             const Output& output) {
    const auto groups = groups_of(options, variants);
    if (groups.empty())
        return Error{ErrorCode::invalid_argument, "none of the effects has a ground truth"};
    for (const auto& source : sources) // before hours of work on the others
        for (const auto& group : groups)
            if (const char* truth = adapter_of(*group.front()->effect).truth;
                source->suits(group.front()->effect->name) && !source->has(truth))
                return Error{ErrorCode::input, source->name() + " has no image '" + truth + "' to score against"};
    if (auto made = make_picture_folder(options.pictures); !made)
        return made.error();
    output.print(header_text("quality", rig) +
                 fmt::format("truth: {} sub-frames, {} rays a pixel; {} samples a pixel\n\n",
                             truth_sub_frames(options, rig), truth_rays(options, rig),
                             options.samples * options.samples));
    std::vector<Block> blocks;
    std::string without; // what has no truth, a line each
    for (const auto& source : sources)
        for (const auto& group : groups) {
            if (!source->suits(group.front()->effect->name))
                continue;
            if (const std::string why = Judge::why_not(options, *group.front(), *source); !why.empty()) {
                without += fmt::format("{}: not scored: {}\n", labels_of(group), why);
                continue;
            }
            output.progress(source->name());
            auto block = measure_block(rig, options, group, *source);
            if (!block)
                return block.error();
            blocks.push_back(std::move(*block));
        }
    if (blocks.empty())
        return Error{ErrorCode::input, without.empty() ? "there is nothing to score" : without};
    output.print(tables_text(blocks, options) + without);
    Json json = {{"program", "sfumato-bench"},
                 {"command", "quality"},
                 {"device", device_json(rig)},
                 {"sub_frames", truth_sub_frames(options, rig)},
                 {"samples", options.samples * options.samples},
                 {"rays", truth_rays(options, rig)},
                 {"truth_falloff", options.truth_falloff},
                 {"rows", Json::array()}};
    for (const Block& block : blocks)
        for (const ScoredRow& row : block.rows) {
            const Adapter& adapter = adapter_of(*block.effect);
            const std::string region_share = std::string(adapter.region) + "_share";
            Json entry = {{"effect", block.effect->name},    {"scene", block.source}, {"width", block.extent.width},
                          {"height", block.extent.height},   {"truth", block.key},    {"preset", row.label},
                          {region_share, block.region_share}};
            entry.update(score_json(adapter, row.score));
            json["rows"].push_back(std::move(entry));
        }
    return output.write(json);
}

} // namespace sfumato::bench
