// sfumato compare: how far a picture is from a reference.
#include "apps/cli/command.h"
#include "apps/cli/conventions.h"
#include "apps/cli/frame_list.h"
#include "media/channels.h"
#include "media/colour.h"
#include "media/metrics.h"
#include "media/png_file.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <memory>
#include <nlohmann/json.hpp>

namespace sfumato::cli {

namespace {

struct CompareOptions {
    std::string picture, reference;
    std::string mask;  // "moving", "still", or a picture
    std::string sharp; // the frame without blur: tells what moves
    std::string layer;
    std::string channel;           // compare this one in place of colour
    std::string reference_channel; // and this one of the reference, where it has another name
    std::string difference;
    double gain = 8.0;
    bool linear = false; // compare values as they are
    bool no_clobber = false;
    std::optional<double> psnr_min, ssim_min, rmse_max, error_max;
};

bool is_png(const std::string& path) {
    return path.ends_with(".png") || path.ends_with(".PNG");
}

Result<media::Planes> load_png(const std::string& path) {
    auto picture = media::read_png(path);
    if (!picture)
        return as_input(picture.error());
    media::Planes planes{picture->width, picture->height, {}};
    const auto stride = static_cast<size_t>(picture->channels);
    for (size_t c = 0; c < 3; ++c) {
        std::vector<float>& plane = planes.channels.emplace_back(planes.pixel_count());
        for (size_t i = 0; i < plane.size(); ++i)
            plane[i] = media::srgb_decode(static_cast<float>(picture->samples[i * stride + c]) / 255.0f);
    }
    return planes;
}

// One channel by its whole name or the end of it: "AO" finds "View.AO". In place of a layer, its first channel.
Result<media::Planes> load_channel(const media::ExrImage& image, const std::string& wanted) {
    std::vector<std::string> names;
    for (const bool as_layer : {false, true})
        for (size_t p = 0; p < image.parts.size(); ++p)
            for (size_t c = 0; c < image.parts[p].channels.size(); ++c) {
                const std::string& full = image.parts[p].channels[c].name;
                names.push_back(full);
                const std::string name = as_layer ? full.substr(0, full.rfind('.')) : full;
                if (name == wanted || name.ends_with("." + wanted))
                    return media::planes_of(image, {p, "", {c}, "", "", 0});
            }
    return usage_error(fmt::format("{}: no channel '{}'{}", image.path.string(), wanted, did_you_mean(wanted, names)));
}

// Linear colour of a file, or one channel of it.
Result<media::Planes> load_picture(const std::string& path, const std::string& layer, const std::string& channel) {
    if (is_png(path))
        return load_png(path);
    media::ExrReadOptions options;
    options.threads = coding_threads();
    auto image = media::read_exr(path, options);
    if (!image)
        return as_input(image.error());
    if (!channel.empty())
        return load_channel(*image, channel);
    auto channels = choose_channels(*image, layer);
    if (!channels)
        return channels.error();
    if (channels->colour.chosen)
        return media::colour_planes_of(*image, *channels->colour.chosen);
    return input_error(fmt::format("{}: no colour channels; --channel compares one of another layer; the layers are {}",
                                   path, fmt::join(media::layer_names(*image), ", ")));
}

struct Region {
    std::string name;
    std::optional<media::Mask> mask;
    media::Metrics metrics;
};

Error different_size(const std::string& a, const media::Planes& x, const std::string& b, const media::Planes& y) {
    return input_error(
        fmt::format("{} has {}x{} pixels, but {} has {}x{}", a, x.width, x.height, b, y.width, y.height));
}

Result<std::vector<Region>> make_regions(const CompareOptions& options, const media::Planes& reference) {
    std::vector<Region> regions = {{"all", std::nullopt, {}}};
    if (!options.sharp.empty()) {
        const auto sharp = load_picture(options.sharp, options.layer, options.channel);
        if (!sharp)
            return sharp.error();
        if (sharp->width != reference.width || sharp->height != reference.height)
            return different_size(options.sharp, *sharp, options.reference, reference);
        // What moves is always judged as it is seen.
        const media::Mask moving = media::moving_region(
            media::encode_for_display(*sharp),
            options.linear || !options.channel.empty() ? media::encode_for_display(reference) : reference);
        regions.push_back({"moving", moving, {}});
        regions.push_back({"still", media::inverse(moving), {}});
    }
    if (!options.mask.empty() && options.mask != "moving" && options.mask != "still") {
        const auto picture = load_picture(options.mask, "", "");
        if (!picture)
            return picture.error();
        if (picture->width != reference.width || picture->height != reference.height)
            return different_size(options.mask, *picture, options.reference, reference);
        media::Mask mask(picture->pixel_count());
        for (size_t i = 0; i < mask.size(); ++i)
            mask[i] = picture->channels.front()[i] > 0.5f ? 1 : 0;
        regions.push_back({"mask", std::move(mask), {}});
    }
    return regions;
}

// Which thresholds the region passes; a NaN passes none.
std::vector<std::string> failures(const CompareOptions& options, const Region& region) {
    std::vector<std::string> failed;
    const media::Metrics& m = region.metrics;
    const auto check = [&](bool good, const char* name, double value, const char* relation, double limit) {
        if (!good)
            failed.push_back(fmt::format("{} {:.6g} {} {:.6g}", name, value, relation, limit));
    };
    if (options.psnr_min)
        check(m.psnr >= *options.psnr_min, "PSNR", m.psnr, "is below", *options.psnr_min);
    if (options.ssim_min)
        check(m.ssim >= *options.ssim_min, "SSIM", m.ssim, "is below", *options.ssim_min);
    if (options.rmse_max)
        check(m.rmse <= *options.rmse_max, "RMSE", m.rmse, "is above", *options.rmse_max);
    if (options.error_max)
        check(m.max_error <= *options.error_max, "largest error", m.max_error, "is above", *options.error_max);
    const bool any = options.psnr_min || options.ssim_min || options.rmse_max || options.error_max;
    if (any && m.non_finite > 0)
        failed.push_back(fmt::format("{} pixels are NaN or infinite", m.non_finite));
    return failed;
}

Result<void> write_difference(const CompareOptions& options, const media::Planes& picture,
                              const media::Planes& reference) {
    auto planes = media::difference_picture(picture, reference, static_cast<float>(options.gain));
    planes.channels.resize(std::min<size_t>(planes.channels.size(), 3));
    while (planes.channels.size() < 3)
        planes.channels.push_back(planes.channels.front());
    // The differences are shown as they are; the encoding of the picture format is undone before.
    for (std::vector<float>& plane : planes.channels)
        std::transform(plane.begin(), plane.end(), plane.begin(), [](float value) {
            return media::srgb_decode(std::isfinite(value) ? std::min(value, 1.0f) : 1.0f);
        });
    if (auto made = make_parent_folder(options.difference); !made)
        return made;
    const auto image = media::make_picture(planes.width, planes.height, planes.channels[0].data(),
                                           planes.channels[1].data(), planes.channels[2].data());
    return media::write_png(options.difference, image, {options.no_clobber, true});
}

void tell(const CompareOptions& options, const std::vector<Region>& regions, const std::vector<std::string>& failed,
          const Invocation& invocation, Console& console) {
    if (!invocation.verbosity.json) {
        for (const Region& region : regions) {
            const media::Metrics& m = region.metrics;
            const double share =
                regions[0].metrics.pixels + regions[0].metrics.non_finite == 0
                    ? 0.0
                    : 100.0 * static_cast<double>(m.pixels) /
                          static_cast<double>(regions[0].metrics.pixels + regions[0].metrics.non_finite);
            console.line(fmt::format("{:<7} PSNR {:6.2f} dB  SSIM {:.4f}  RMSE {:.6f}  bias {:+.6f}  max {:.6f}  "
                                     "{:.1f} % of pixels{}",
                                     region.name, m.psnr, m.ssim, m.rmse, m.bias, m.max_error, share,
                                     m.non_finite ? fmt::format("  {} NaN or infinite", m.non_finite) : ""));
        }
        for (const std::string& failure : failed)
            console.line("differs: " + failure);
        return;
    }
    nlohmann::ordered_json json = {{"picture", options.picture}, {"reference", options.reference}};
    for (const Region& region : regions) {
        const media::Metrics& m = region.metrics;
        json["regions"][region.name] = {{"psnr", m.psnr},
                                        {"ssim", m.ssim},
                                        {"rmse", m.rmse},
                                        {"bias", m.bias},
                                        {"max_error", m.max_error},
                                        {"pixels", m.pixels},
                                        {"non_finite", m.non_finite}};
    }
    json["differs"] = failed;
    console.result(json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
}

Result<void> check_options(const CompareOptions& options) {
    if ((options.mask == "moving" || options.mask == "still") && options.sharp.empty())
        return usage_error(fmt::format("--mask {} needs --sharp FILE, the frame without blur", options.mask));
    if (!options.difference.empty() && !is_png(options.difference))
        return usage_error(fmt::format("--diff {}: the difference is written as .png", options.difference));
    if (!options.reference_channel.empty() && options.channel.empty())
        return usage_error("--reference-channel needs --channel, the picture's own");
    return {};
}

Outcome run(const CompareOptions& options, const Invocation& invocation, Console& console) {
    if (auto checked = check_options(options); !checked)
        return checked.error();
    auto picture = load_picture(options.picture, options.layer, options.channel);
    if (!picture)
        return picture.error();
    auto reference = load_picture(options.reference, options.layer,
                                  options.reference_channel.empty() ? options.channel : options.reference_channel);
    if (!reference)
        return reference.error();
    if (picture->width != reference->width || picture->height != reference->height)
        return different_size(options.picture, *picture, options.reference, *reference);
    if (!options.linear && options.channel.empty()) {
        picture = media::encode_for_display(*picture);
        reference = media::encode_for_display(*reference);
    }
    auto regions = make_regions(options, *reference);
    if (!regions)
        return regions.error();
    std::vector<std::string> failed;
    const std::string judged = options.mask.empty()                                  ? "all"
                               : options.mask == "moving" || options.mask == "still" ? options.mask
                                                                                     : "mask";
    for (Region& region : *regions) {
        auto metrics = media::measure(*picture, *reference, {region.mask ? &*region.mask : nullptr, true});
        if (!metrics)
            return as_input(metrics.error());
        region.metrics = *metrics;
        if (region.name == judged)
            failed = failures(options, region);
    }
    if (!options.difference.empty())
        if (auto written = write_difference(options, *picture, *reference); !written)
            return written.error();
    tell(options, *regions, failed, invocation, console);
    return failed.empty() ? exit_done : exit_differs;
}

} // namespace

Command make_compare(CLI::App& app) {
    auto options = std::make_shared<CompareOptions>();
    app.add_option("PICTURE", options->picture, "EXR or PNG")->required();
    app.add_option("REFERENCE", options->reference, "What it should look like")->required();
    add_text(app, "--sharp", options->sharp, "The frame without blur: also measure what moves and what is still");
    add_text(app, "--mask", options->mask, "Region for the thresholds: moving, still, or a picture (inside above 0.5)");
    app.add_option("--psnr-min", options->psnr_min, "Least PSNR in dB")->type_name("");
    app.add_option("--ssim-min", options->ssim_min, "Least structural similarity")->type_name("");
    app.add_option("--rmse-max", options->rmse_max, "Greatest root mean square error")->type_name("");
    app.add_option("--error-max", options->error_max, "Greatest error of any pixel")->type_name("");
    add_text(app, "--diff", options->difference, "Write the absolute differences as a PNG");
    app.add_option("--gain", options->gain, "Makes the differences brighter")->capture_default_str()->type_name("");
    app.add_flag("--linear", options->linear, "Compare values as they are (default: as a display shows them)");
    add_text(app, "--layer", options->layer, "Layer to compare");
    add_text(app, "--channel", options->channel, "Compare one channel as it is: AO, View.Depth.Z");
    add_text(app, "--reference-channel", options->reference_channel,
             "The reference's channel, where its name is another: truth.AO");
    app.add_flag("--no-clobber", options->no_clobber, "Refuse to overwrite the difference picture");
    app.footer("Example: sfumato compare blur.exr truth.exr --sharp shot.exr --mask moving --psnr-min 30\n"
               "Exit codes: 0 within the thresholds, 1 beyond one, 2 usage, 3 input.");
    return [options](const Invocation& invocation, Console& console) { return run(*options, invocation, console); };
}

} // namespace sfumato::cli
