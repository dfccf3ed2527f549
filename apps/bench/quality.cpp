// `quality`: how far each preset is from ground truth, between doing nothing and the best that can be told apart.
#include "apps/bench/commands.h"
#include "apps/bench/pictures.h"

#include <filesystem>
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
    double moving_share = 0.0;
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
                (*judge)->extent(),       Judge::key(*variants.front()),
                (*judge)->moving_share(), {}};
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
std::vector<std::vector<const Variant*>> groups_of(const Variants& variants) {
    std::vector<std::vector<const Variant*>> groups;
    for (const Variant& variant : variants) {
        if (adapter_of(*variant.effect).truth == nullptr)
            continue;
        bool found = false;
        for (auto& group : groups)
            if (!found && group.front()->effect == variant.effect &&
                Judge::key(*group.front()) == Judge::key(variant)) {
                group.push_back(&variant);
                found = true;
            }
        if (!found)
            groups.push_back({&variant});
    }
    return groups;
}

std::string table_text(const std::vector<Block>& blocks) {
    Table table({"effect", "scene", "size", "preset", "PSNR all", "moving", "still", "SSIM", "max error", "moving %"},
                4);
    for (const Block& block : blocks)
        for (const ScoredRow& row : block.rows) {
            const std::string label = block.key.empty() ? row.label : row.label + " (" + block.key + ")";
            table.add({block.effect->name, block.source, extent_text(block.extent), label, fixed(row.score.all.psnr, 2),
                       fixed(row.score.moving_psnr, 2), fixed(row.score.still_psnr, 2), fixed(row.score.all.ssim, 4),
                       fixed(row.score.all.max_error, 3), fixed(100.0 * block.moving_share, 1)});
            if (row.score.all.non_finite > 0)
                table.add({"", "", "", fmt::format("  {} pixels are NaN or infinite", row.score.all.non_finite)});
        }
    return table.text() + "PSNR in dB of sRGB-encoded colour, 120 for equality; moving: where truth and sharp frame "
                          "differ; ceiling: truth with half the sub-frames.\n";
}

} // namespace

Result<void> measure_quality(Rig& rig, const Options& options, const Variants& variants, const Sources& sources,
                             const Output& output) {
    const auto groups = groups_of(variants);
    if (groups.empty())
        return Error{ErrorCode::invalid_argument, "none of the effects has a ground truth"};
    for (const auto& source : sources) // before hours of work on the others
        for (const auto& group : groups)
            if (const char* truth = adapter_of(*group.front()->effect).truth;
                source->suits(group.front()->effect->name) && !source->has(truth))
                return Error{ErrorCode::input, source->name() + " has no image '" + truth + "' to score against"};
    if (!options.pictures.empty()) {
        std::error_code failed;
        std::filesystem::create_directories(options.pictures, failed);
        if (failed)
            return Error{ErrorCode::input, options.pictures + ": cannot be made a folder for pictures"};
    }
    output.print(header_text("quality", rig) + fmt::format("{} sub-frames, {} samples a pixel\n\n",
                                                           truth_sub_frames(options, rig),
                                                           options.samples * options.samples));
    std::vector<Block> blocks;
    for (const auto& source : sources)
        for (const auto& group : groups) {
            if (!source->suits(group.front()->effect->name))
                continue;
            output.progress(source->name());
            auto block = measure_block(rig, options, group, *source);
            if (!block)
                return block.error();
            blocks.push_back(std::move(*block));
        }
    output.print(table_text(blocks));
    Json json = {{"program", "sfumato-bench"},
                 {"command", "quality"},
                 {"device", device_json(rig)},
                 {"sub_frames", truth_sub_frames(options, rig)},
                 {"samples", options.samples * options.samples},
                 {"rows", Json::array()}};
    for (const Block& block : blocks)
        for (const ScoredRow& row : block.rows) {
            Json entry = {{"effect", block.effect->name},      {"scene", block.source}, {"width", block.extent.width},
                          {"height", block.extent.height},     {"truth", block.key},    {"preset", row.label},
                          {"moving_share", block.moving_share}};
            entry.update(score_json(row.score));
            json["rows"].push_back(std::move(entry));
        }
    return output.write(json);
}

} // namespace sfumato::bench
