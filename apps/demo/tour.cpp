// Plans the tour: for each effect its scenes, presets, inner stages and measurements.
#include "apps/demo/tour.h"

#include "apps/demo/known_effects.h"

#include <algorithm>
#include <fmt/format.h>
#include <set>

namespace sfumato::demo {
namespace {

constexpr const char* view_parameter = "debug_view"; // what effects call the parameter that shows their stages

std::string text_at(const Json& row, const char* key) {
    return row.value(key, std::string());
}

// "motion-blur" -> "Motion blur"
std::string title_of(std::string name) {
    std::ranges::replace(name, '-', ' ');
    if (!name.empty() && name[0] >= 'a' && name[0] <= 'z')
        name[0] = static_cast<char>(name[0] - 'a' + 'A');
    return name;
}

// A name as a part of a file name or of an id.
std::string plain(std::string text) {
    for (char& c : text)
        if (!((c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.'))
            c = '-';
    return text;
}

// One effect out of the lists, and what is known about it.
class Planner {
  public:
    Planner(const Settings& settings, const Lists& lists, const Json& effect)
        : settings_(settings), lists_(lists), effect_(effect), name_(text_at(effect, "name")),
          known_(known_effect(name_)) {
        for (const Json& preset : lists.presets)
            if (text_at(preset, "effect") == name_)
                all_presets_.push_back(preset);
        const auto is_too_much = [&](const Json& preset) {
            return settings.is_software &&
                   std::ranges::find(known_.for_gpus, text_at(preset, "name")) != known_.for_gpus.end();
        };
        for (const Json& preset : all_presets_)
            if (!is_too_much(preset) &&
                (text_at(preset, "name") == known_.usual || text_at(preset, "name") == "high" || usual_.empty()))
                usual_ = text_at(preset, "name");
        for (const Json& preset : all_presets_)
            if (is_too_much(preset))
                continue;
            else if (!settings.is_quick || presets_.empty() || text_at(preset, "name") == usual_ || has_history(preset))
                presets_.push_back(preset);
    }

    EffectTour plan() const {
        EffectTour tour;
        tour.name = name_;
        tour.title = title_of(name_);
        tour.summary = text_at(effect_, "summary");
        tour.source = text_at(effect_, "source");
        tour.text = known_.text;
        const std::vector<SceneTour> scenes = scenes_of();
        for (SceneTour scene : scenes) {
            scene.comparisons = comparisons(scene.name);
            tour.scenes.push_back(std::move(scene));
        }
        if (!scenes.empty()) {
            tour.views = views(scenes.front().name);
            tour.quality = quality(scenes);
            tour.times = times(scenes.front().name);
        }
        tour.views_text = usual_.empty() ? "" : fmt::format("preset {}", usual_);
        tour.figures = known_.figures;
        if (tour.figures.empty())
            tour.figures = {{"rmse", "RMSE", "", 4}, {"bias", "bias", "", 4}};
        tour.figures_text = known_.figures_text;
        return tour;
    }

  private:
    static bool has_history(const Json& preset) {
        return preset.value("overrides", Json::object()).value("temporal", "") == "true";
    }

    std::vector<SceneTour> scenes_of() const {
        std::vector<SceneTour> scenes;
        const auto add = [&](const Json& scene, const std::string& text) {
            scenes.push_back({text_at(scene, "name"), text_at(scene, "doc"), text, {}});
        };
        for (const KnownScene& known : known_.scenes)
            for (const Json& scene : lists_.scenes)
                if (text_at(scene, "name") == known.name)
                    add(scene, known.text);
        const auto is_for_this = [&](const Json& scene) {
            const Json effects = scene.value("effects", Json::array());
            return std::ranges::find(effects, Json(name_)) != effects.end();
        };
        for (const Json& scene : lists_.scenes)
            if (scenes.empty() && is_for_this(scene))
                add(scene, "");
        if (scenes.empty() && !lists_.scenes.empty())
            add(lists_.scenes.front(), "");
        if (settings_.is_quick && scenes.size() > 1)
            scenes.resize(1);
        return scenes;
    }

    Picture picture(const std::string& scene, const std::string& name, const std::string& doc,
                    const Arguments& arguments) const {
        Picture made;
        made.id = plain(fmt::format("{}.{}.{}", name_, scene, name));
        made.name = name;
        made.doc = doc;
        made.file = settings_.folder / "pictures" / (made.id + ".png");
        Arguments all = {"render", scene, "--size", settings_.size, "-o", made.file.string()};
        all.insert(all.end(), arguments.begin(), arguments.end());
        made.command = program(settings_, "sfumato", all);
        return made;
    }

    Arguments with_preset(const std::string& name) const {
        Arguments arguments = {"--effects", name_};
        if (!name.empty())
            arguments.insert(arguments.end(), {"--preset", name});
        for (const Json& preset : all_presets_)
            if (text_at(preset, "name") == name && has_history(preset))
                arguments.insert(arguments.end(), {"--preroll", "8"});
        return arguments;
    }

    // What presets show is the scene's colour, changed, and not a picture of something else.
    bool shows_colour() const { return known_.presets_heading.empty(); }

    // A colour that is not seen need not be smooth.
    Arguments for_preset(const std::string& name) const {
        Arguments arguments = with_preset(name);
        if (!shows_colour())
            arguments.insert(arguments.end(), {"--samples", "1"});
        return arguments;
    }

    bool is_shown_on(const std::string& scene, const std::string& preset) const {
        for (const KnownScene& known : known_.scenes)
            if (known.name == scene && !known.presets.empty())
                return std::ranges::find(known.presets, preset) != known.presets.end();
        return true;
    }

    std::vector<Comparison> comparisons(const std::string& scene) const {
        Comparison first{"", {picture(scene, "before", "The scene without the effect.", {})}, "before", ""};
        for (const KnownPicture& known : known_.pictures)
            first.pictures.push_back(picture(scene, known.name, known.doc, known.arguments));
        Comparison presets{known_.presets_heading, {}, "", usual_};
        for (const Json& preset : presets_) {
            const std::string name = text_at(preset, "name");
            if (is_shown_on(scene, name))
                presets.pictures.push_back(picture(scene, name, text_at(preset, "doc"), for_preset(name)));
        }
        if (presets_.empty())
            presets.pictures.push_back(picture(scene, "effect", "With its defaults.", for_preset("")));
        if (!shows_colour()) {
            first.right = first.pictures.back().name;
            presets.left = presets.pictures.front().name;
            add_known_truths(scene, presets);
            return {first, presets};
        }
        first.right = usual_.empty() ? "effect" : usual_;
        std::ranges::move(presets.pictures, std::back_inserter(first.pictures));
        add_known_truths(scene, first);
        return {first};
    }

    void add_known_truths(const std::string& scene, Comparison& comparison) const {
        for (const KnownPicture& known : known_.truths) {
            Arguments arguments = known.arguments;
            arguments.insert(arguments.end(), {"--truth-rays", std::to_string(settings_.rays)});
            comparison.pictures.push_back(picture(scene, known.name, known.doc, arguments));
            if (!shows_colour())
                comparison.left = known_.truths.front().name;
        }
    }

    std::vector<Picture> views(const std::string& scene) const {
        std::vector<Picture> made;
        for (const Json& parameter : lists_.parameters) {
            if (text_at(parameter, "effect") != name_ || text_at(parameter, "name") != view_parameter)
                continue;
            for (const Json& choice : parameter.value("choices", Json::array())) {
                const std::string view = choice.get<std::string>();
                if (view != "none" && !(settings_.is_quick && made.size() >= 2))
                    made.push_back(view_picture(scene, view));
            }
        }
        return made;
    }

    Picture view_picture(const std::string& scene, const std::string& view) const {
        const auto known = std::ranges::find_if(known_.views, [&](const KnownView& one) { return one.name == view; });
        const bool is_known = known != known_.views.end();
        Arguments arguments = with_preset(is_known && !known->preset.empty() ? known->preset : usual_);
        arguments.insert(arguments.end(),
                         {"--samples", "1", "--set", fmt::format("{}.{}={}", name_, view_parameter, view)});
        Picture made = picture(scene, "view " + view, is_known ? known->doc : "", arguments);
        made.name = view;
        return made;
    }

    Measurement measurement(const std::string& what, Arguments arguments) const {
        Measurement made;
        made.file = settings_.folder / "measured" / fmt::format("{}.{}.json", plain(name_), what);
        arguments.insert(arguments.end(), {"--json", made.file.string()});
        std::string names;
        for (const Json& preset : presets_)
            names += (names.empty() ? "" : ",") + text_at(preset, "name");
        if (presets_.size() < all_presets_.size())
            arguments.insert(arguments.end(), {"--preset", names});
        made.command = program(settings_, "sfumato-bench", arguments);
        return made;
    }

    Measurement quality(const std::vector<SceneTour>& scenes) const {
        const Json benched = lists_.benched.value("effects", Json::array());
        const bool is_scored = std::ranges::any_of(benched, [&](const Json& effect) {
            return text_at(effect, "name") == name_ && effect.value("scored", false);
        });
        if (!is_scored)
            return {};
        std::string names;
        for (const SceneTour& scene : scenes)
            names += (names.empty() ? "" : ",") + scene.name;
        Arguments arguments = {"quality", "--effect", name_, "--scene", names, "--size", settings_.size};
        arguments.insert(arguments.end(), {"--samples", shows_colour() ? "2" : "1"});
        arguments.insert(arguments.end(), {"--subframes", std::to_string(settings_.sub_frames)});
        arguments.insert(arguments.end(), {"--rays", std::to_string(settings_.rays), "--no-ssim"});
        if (known_.truths.empty())
            arguments.insert(arguments.end(), {"--pictures", (settings_.folder / "pictures").string()});
        return measurement("quality", arguments);
    }

    Measurement times(const std::string& scene) const {
        Arguments arguments = {"times", "--effect", name_, "--scene", scene, "--size", settings_.timed_size};
        if (settings_.timed_frames > 0)
            arguments.insert(arguments.end(),
                             {"--frames", std::to_string(settings_.timed_frames), "--warm-up", "0.02"});
        return measurement("times", arguments);
    }

    const Settings& settings_;
    const Lists& lists_;
    const Json& effect_;
    std::string name_;
    const KnownEffect& known_;
    std::vector<Json> all_presets_, presets_; // the latter are shown
    std::string usual_;                       // the preset that is shown where one has to be
};

} // namespace

Arguments program(const Settings& settings, const std::string& name, const Arguments& arguments) {
    Arguments all = {(settings.programs / name).string()};
    all.insert(all.end(), arguments.begin(), arguments.end());
    if (!settings.device.empty())
        all.insert(all.end(), {"--device", settings.device});
    return all;
}

std::vector<EffectTour> plan_tour(const Settings& settings, const Lists& lists) {
    std::vector<EffectTour> tour;
    for (const Json& effect : lists.effects)
        tour.push_back(Planner(settings, lists, effect).plan());
    return tour;
}

void add_truths(const Settings& settings, EffectTour& effect) {
    const Arguments& command = effect.quality.command;
    if (std::ranges::find(command, "--pictures") == command.end())
        return;
    for (SceneTour& scene : effect.scenes) {
        std::set<std::string> keys; // presets of one effect may have different truths, say of another radius
        for (const Json& row : effect.quality.figures.value("rows", Json::array()))
            if (text_at(row, "scene") == scene.name)
                keys.insert(text_at(row, "truth"));
        for (const std::string& key : keys) {
            Picture truth;
            truth.name = key.empty() ? "truth" : fmt::format("truth ({})", key);
            truth.doc = "Ground truth.";
            truth.id = plain(fmt::format("{}.{}.{}", effect.name, scene.name, truth.name));
            truth.command = effect.quality.command;
            std::string file = fmt::format("{}.{}.{}truth", effect.name, scene.name, key.empty() ? "" : key + ".");
            for (char& c : file) // as the bench does
                if (c == ' ' || c == '=' || c == '/')
                    c = '-';
            truth.file = settings.folder / "pictures" / (file + ".png");
            scene.comparisons.back().pictures.push_back(truth);
        }
    }
}

} // namespace sfumato::demo
