// `frontier`: error against time, one point a preset, over all scenes.
#include "apps/bench/commands.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace sfumato::bench {
namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();

// One variant on one source.
struct Place {
    std::string source;
    double milliseconds = 0.0;
    Score score;
};

struct Point {
    const EffectInfo* effect;
    std::string label;
    std::string key; // of the truth: points of different truths cannot be compared
    std::vector<Place> places = {};
    bool is_best = false; // nothing else is both faster and closer

    std::string text() const { return key.empty() ? label : label + " (" + key + ")"; }

    // Means over the places where the figure is known.
    template <class Figure>
    double mean(Figure figure) const {
        double sum = 0.0, count = 0.0;
        for (const Place& place : places)
            if (const double value = figure(place); std::isfinite(value)) {
                sum += value;
                count += 1.0;
            }
        return count > 0.0 ? sum / count : none;
    }
    double milliseconds() const {
        return mean([](const Place& place) { return place.milliseconds; });
    }
    const Adapter& adapter() const { return adapter_of(*effect); }
    double merit() const {
        return mean([&](const Place& place) { return bench::merit(adapter(), place.score); });
    }
    double psnr() const {
        return mean([](const Place& place) { return place.score.all.psnr; });
    }
    double ssim() const {
        return mean([](const Place& place) { return place.score.all.ssim; });
    }
    double rmse() const {
        return mean([](const Place& place) { return place.score.all.rmse; });
    }
    double bias() const {
        return mean([](const Place& place) { return place.score.all.bias; });
    }
    double region_rmse() const {
        return mean([](const Place& place) { return place.score.region.rmse; });
    }
};

// All variants of an effect on one source; the first point is doing nothing.
Result<void> add_source(Rig& rig, const Options& options, const std::vector<const Variant*>& variants,
                        const Source& source, std::vector<Point>& points, double warm_up) {
    const auto timed =
        load_timed_inputs(rig, options, *variants.front()->effect, source, times_sizes(options, rig, true).front());
    if (!timed)
        return timed.error();
    auto context = rig.create_context(2, false);
    if (!context)
        return context.error();
    std::unique_ptr<Judge> judge;
    std::string key;
    for (size_t i = 0; i < variants.size(); ++i) {
        const Variant& variant = *variants[i];
        if (!Judge::why_not(options, variant, source).empty())
            continue;
        if (!judge || key != Judge::key(options, variant)) {
            auto made = Judge::create(rig, options, variant, source);
            if (!made)
                return made.error();
            judge = std::move(*made);
            key = Judge::key(options, variant);
        }
        const bool is_scored = !points[0].places.empty() && points[0].places.back().source == source.name();
        if (!is_scored && key == points[0].key)
            points[0].places.push_back({source.name(), 0.0, judge->score(judge->do_nothing(), options.ssim)});
        const auto time = time_chain(rig, *variant.effect, variant.parameters.data(), timed->sets,
                                     timing_options(options, rig, warm_up));
        if (!time)
            return time.error();
        const auto picture = judge->run(rig, **context, variant);
        if (!picture)
            return picture.error();
        points[i + 1].places.push_back({source.name(), time->chain.median, judge->score(*picture, options.ssim)});
    }
    return {};
}

void mark_best(std::vector<Point>& points) {
    for (Point& point : points)
        point.is_best = std::ranges::none_of(points, [&](const Point& other) {
            const bool no_worse = other.milliseconds() <= point.milliseconds() && other.merit() >= point.merit();
            return other.key == point.key && no_worse &&
                   (other.milliseconds() < point.milliseconds() || other.merit() > point.merit());
        });
}

Json point_json(const Point& point) {
    Json places = Json::array();
    for (const Place& place : point.places) {
        Json entry = {{"scene", place.source}, {"ms", place.milliseconds}};
        entry.update(score_json(point.adapter(), place.score));
        places.push_back(std::move(entry));
    }
    Json json = {{"effect", point.effect->name},
                 {"preset", point.label},
                 {"truth", point.key},
                 {"ms", point.milliseconds()},
                 {"psnr", point.psnr()}};
    if (point.adapter().display_encoded)
        json["psnr_moving"] = point.merit();
    else
        json.update({{"rmse", point.rmse()}, {"bias", point.bias()}, {"rmse_occluded", point.region_rmse()}});
    json["on_frontier"] = point.is_best;
    json["scenes"] = places;
    return json;
}

Result<std::vector<Point>> points_of(Rig& rig, const Options& options, const EffectInfo& effect,
                                     const Variants& variants, const Sources& sources, const Output& output) {
    std::vector<const Variant*> chosen;
    std::vector<Point> points = {{&effect, "do nothing", ""}};
    for (const Variant& variant : variants)
        if (variant.effect == &effect) {
            chosen.push_back(&variant);
            points.push_back({&effect, variant.label, Judge::key(options, variant)});
        }
    points.front().key = points[1].key; // that is what it is scored against
    double warm_up = options.warm_up;
    for (const auto& source : sources) {
        if (!source->suits(effect.name))
            continue;
        output.progress(source->name());
        if (auto added = add_source(rig, options, chosen, *source, points, warm_up); !added)
            return added.error();
        warm_up = std::min(warm_up, 0.05);
    }
    std::erase_if(points, [](const Point& point) { return point.places.empty(); }); // no truth for it anywhere
    mark_best(points);
    std::ranges::stable_sort(points, {}, &Point::milliseconds);
    return points;
}

} // namespace

Result<void> measure_frontier(Rig& rig, const Options& options, const Variants& variants, const Sources& sources,
                              const Output& output) {
    const Extent size = times_sizes(options, rig, true).front();
    output.print(header_text("frontier", rig) + fmt::format("time at {}, error at {}, scenes: {}, means over them\n\n",
                                                            extent_text(size), extent_text(quality_size(options, rig)),
                                                            sources.size()));
    Table pictures({"effect", "preset", "best", "ms", "PSNR moving", "PSNR all", "SSIM"}, 3);
    Table values({"effect", "preset", "best", "ms", "RMSE", "bias", "RMSE occluded", "SSIM"}, 3);
    bool any_picture = false, any_value = false;
    Json json = {{"program", "sfumato-bench"}, {"command", "frontier"}, {"device", device_json(rig)},
                 {"width", size.width},        {"height", size.height}, {"points", Json::array()}};
    for (const EffectInfo* effect : effects()) {
        const bool is_wanted =
            std::ranges::any_of(variants, [&](const Variant& variant) { return variant.effect == effect; });
        if (!is_wanted || adapter_of(*effect).truth == nullptr)
            continue;
        const bool is_picture = adapter_of(*effect).display_encoded;
        (is_picture ? any_picture : any_value) = true;
        const auto points = points_of(rig, options, *effect, variants, sources, output);
        if (!points)
            return points.error();
        for (const Point& point : *points) {
            const std::string best = point.is_best ? "*" : "";
            if (is_picture)
                pictures.add({effect->name, point.text(), best, fixed(point.milliseconds(), 4), fixed(point.merit(), 2),
                              fixed(point.psnr(), 2), fixed(point.ssim(), 4)});
            else
                values.add({effect->name, point.text(), best, fixed(point.milliseconds(), 4), fixed(point.rmse(), 4),
                            fixed(point.bias(), 4), fixed(point.region_rmse(), 4), fixed(point.ssim(), 4)});
            json["points"].push_back(point_json(point));
        }
    }
    if (!any_picture && !any_value)
        return Error{ErrorCode::invalid_argument, "none of the effects has a ground truth"};
    output.print((any_picture ? pictures.text() : "") + (any_value ? values.text() : "") +
                 "*: nothing else is both faster and closer to the truth, of pictures where things move; rows with "
                 "another truth, which is in brackets, are told apart.\n");
    return output.write(json);
}

} // namespace sfumato::bench
