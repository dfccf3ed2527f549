// `tune`: least error within a time. Searches on one half of the scenes and reports on the other half, so that what is
// reported is not what was fitted.
#include "apps/bench/commands.h"
#include "apps/bench/tune_search.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

namespace sfumato::bench {
namespace {

// One scene with everything that an evaluation needs.
struct Case {
    std::string name;
    TimedInputs timed;
    std::unique_ptr<Judge> judge;
};

struct Figures {
    double milliseconds = 0.0;
    double merit = 0.0;
    double psnr = 0.0;
    double bias = 0.0;

    void add(const Figures& other, double weight) {
        merit += weight * other.merit;
        psnr += weight * other.psnr;
        bias += weight * other.bias;
    }
};

class Tuner {
  public:
    Tuner(Rig& rig, const Options& options, const Variant& start) : rig_(rig), options_(options), start_(start) {}

    // Scenes in which there is nothing to do tell nothing and are left out; the others alternate between the halves.
    Result<void> load(const Sources& sources, const Output& output) {
        size_t kept = 0;
        for (const auto& source : sources) {
            if (!source->suits(start_.effect->name))
                continue;
            output.progress("loading " + source->name());
            auto judge = Judge::create(rig_, options_, start_, *source);
            if (!judge)
                return judge.error();
            if ((*judge)->region_share() == 0.0)
                continue;
            auto timed =
                load_timed_inputs(rig_, options_, *start_.effect, *source, times_sizes(options_, rig_, true).front());
            if (!timed)
                return timed.error();
            auto& half = kept++ % 2 == 0 ? training_ : report_;
            half.push_back({source->name(), std::move(*timed), std::move(*judge)});
        }
        if (training_.empty())
            return Error{ErrorCode::input, std::string("nothing is ") + adapter_of(*start_.effect).region +
                                               " in any of the scenes: there is nothing to tune on"};
        return {};
    }

    const EffectInfo& effect() const { return *start_.effect; }
    const std::vector<Case>& training() const { return training_; }
    const std::vector<Case>& report() const { return report_.empty() ? training_ : report_; }

    Result<double> time(const std::vector<Case>& cases, const ParameterSet& setting, double warm_up) {
        double sum = 0.0;
        for (const Case& one : cases) {
            const auto time = time_chain(rig_, *start_.effect, setting.data(), one.timed.sets,
                                         timing_options(options_, rig_, warm_up));
            if (!time)
                return time.error();
            sum += time->chain.median;
        }
        return sum / static_cast<double>(cases.size());
    }

    Result<void> score(const std::vector<Case>& cases, const ParameterSet& setting, Figures& figures) {
        // Pipelines of settings long gone pile up in a context.
        if (runs_++ % 50 == 0) {
            auto context = rig_.create_context(2, false);
            if (!context)
                return context.error();
            context_ = std::move(*context);
        }
        const Variant variant{start_.effect, "", setting};
        figures = {};
        for (const Case& one : cases) {
            const auto picture = one.judge->run(rig_, *context_, variant);
            if (!picture)
                return picture.error();
            figures.add(figures_of(one, *picture), 1.0 / static_cast<double>(cases.size()));
        }
        return {};
    }

    Figures do_nothing(const std::vector<Case>& cases) const {
        Figures figures;
        for (const Case& one : cases)
            figures.add(figures_of(one, one.judge->do_nothing()), 1.0 / static_cast<double>(cases.size()));
        return figures;
    }

    Result<Outcome> evaluate(const ParameterSet& setting, double warm_up) {
        const auto time_taken = time(training_, setting, warm_up);
        if (!time_taken)
            return time_taken.error();
        Outcome outcome{*time_taken, 0.0, *time_taken <= options_.budget_ms};
        if (!outcome.is_within_budget) // its error would not be looked at
            return outcome;
        Figures figures;
        if (auto scored = score(training_, setting, figures); !scored)
            return scored.error();
        outcome.merit = figures.merit;
        return outcome;
    }

  private:
    static double known(double value) { return std::isfinite(value) ? value : 0.0; }

    Figures figures_of(const Case& one, const media::Planes& picture) const {
        const Score score = one.judge->score(picture, false);
        // Equality somewhere must not outweigh everything else.
        return {0.0, std::min(known(merit(adapter_of(*start_.effect), score)), 60.0),
                std::min(known(score.all.psnr), 60.0), known(score.all.bias)};
    }

    Rig& rig_;
    const Options& options_;
    const Variant& start_;
    std::vector<Case> training_, report_;
    std::unique_ptr<Context> context_;
    size_t runs_ = 0;
};

bool contains(const std::vector<std::string>& names, std::string_view name) {
    return std::ranges::find(names, name) != names.end();
}

// Everything that is not debugging, taste, or set by hand.
Result<std::vector<const ParameterInfo*>> choose_knobs(const Options& options, const EffectInfo& effect) {
    std::vector<std::string> held = options.fix;
    for (const std::string& set : options.variants.sets)
        if (const auto assignment = parse_assignment(set); assignment)
            held.push_back(assignment->parameter);
    for (const auto* names : {&options.only, &options.fix})
        for (const std::string& name : *names)
            if (effect.parameters->find(name) == nullptr) {
                ParameterSet scratch(*effect.parameters);
                return set_parameter(*effect.parameters, scratch.data(), name, "").error();
            }
    std::vector<const ParameterInfo*> knobs;
    const auto taste = adapter_of(effect).not_tuned;
    for (const ParameterInfo& info : effect.parameters->parameters) {
        const bool is_taste =
            std::ranges::any_of(taste, [&](const char* name) { return std::string_view(name) == info.name; });
        const bool is_wanted =
            options.only.empty() ? !is_taste && !(info.flags & parameter_debug) : contains(options.only, info.name);
        if (is_wanted && !contains(held, info.name))
            knobs.push_back(&info);
    }
    return knobs;
}

std::string names_of(const std::vector<Case>& cases) {
    std::string text;
    for (const Case& one : cases)
        text += (text.empty() ? "" : ", ") + one.name;
    return text;
}

struct ReportRow {
    std::string label;
    Figures training, report;
};

Result<ReportRow> report_row(Tuner& tuner, const std::string& label, const ParameterSet& setting) {
    ReportRow row{label, {}, {}};
    for (const bool is_training : {true, false}) {
        const auto& cases = is_training ? tuner.training() : tuner.report();
        Figures& figures = is_training ? row.training : row.report;
        const auto time = tuner.time(cases, setting, 0.05);
        if (!time)
            return time.error();
        if (auto scored = tuner.score(cases, setting, figures); !scored)
            return scored.error();
        figures.milliseconds = *time;
    }
    return row;
}

Json figures_json(const Adapter& adapter, const Figures& figures) {
    if (adapter.display_encoded)
        return {{"ms", figures.milliseconds}, {"psnr_moving", figures.merit}, {"psnr", figures.psnr}};
    return {{"ms", figures.milliseconds}, {"rmse", -figures.merit}, {"bias", figures.bias}};
}

std::vector<std::string> figures_cells(const Adapter& adapter, const Figures& figures) {
    if (adapter.display_encoded)
        return {fixed(figures.milliseconds, 4), fixed(figures.merit, 2), fixed(figures.psnr, 2)};
    return {fixed(figures.milliseconds, 4), fixed(-figures.merit, 4), fixed(figures.bias, 4)};
}

// Prints every improvement, so that a long search can be followed and broken off.
Result<void> search_all(Tuner& tuner, TuneSearch& search, const Options& options, const ParameterSet& start,
                        const Output& output) {
    const Adapter& adapter = adapter_of(tuner.effect());
    ParameterSet proposal = start;
    for (int i = 0; i < options.evaluations && search.propose(proposal); ++i) {
        output.progress(fmt::format("{} of {}", i + 1, options.evaluations));
        const auto outcome = tuner.evaluate(proposal, i == 0 ? options.warm_up : 0.02);
        if (!outcome)
            return outcome.error();
        const bool improves = !search.has_best() || is_better(*outcome, search.best_outcome());
        search.tell(proposal, *outcome);
        if (!improves)
            continue;
        std::string text =
            fmt::format("{:4}  {:.4f} ms  {}", i + 1, outcome->milliseconds,
                        outcome->is_within_budget ? merit_text(adapter, outcome->merit) + " " : "too slow");
        for (const std::string& difference : differences(proposal, start))
            text += " " + difference.substr(difference.find('.') + 1);
        output.print(text + "\n");
    }
    return {};
}

Result<void> report_all(Rig& rig, Tuner& tuner, const TuneSearch& search, const Options& options, const Variant& start,
                        const Output& output) {
    std::vector<ReportRow> rows = {
        {"do nothing", tuner.do_nothing(tuner.training()), tuner.do_nothing(tuner.report())}};
    for (const Preset& preset : start.effect->parameters->presets) {
        ParameterSet setting(*start.effect->parameters);
        if (auto applied = apply_preset(setting.table(), setting.data(), preset.name); !applied)
            return applied;
        // A preset that asks for another truth cannot be compared.
        if (Judge::key(options, {start.effect, preset.name, setting}) != Judge::key(options, start))
            continue;
        auto row = report_row(tuner, preset.name, setting);
        if (!row)
            return row.error();
        rows.push_back(std::move(*row));
    }
    auto found = report_row(tuner, "found", search.best());
    if (!found)
        return found.error();
    rows.push_back(std::move(*found));
    const Adapter& adapter = adapter_of(*start.effect);
    const char* merit_name = adapter.display_encoded ? "moving dB" : "RMSE";
    const char* other_name = adapter.display_encoded ? "all dB" : "bias";
    Table table({"setting", "training ms", merit_name, other_name, "report ms", merit_name, other_name}, 1);
    Json json = {{"program", "sfumato-bench"},
                 {"command", "tune"},
                 {"device", device_json(rig)},
                 {"effect", start.effect->name},
                 {"preset", start.label},
                 {"budget_ms", options.budget_ms},
                 {"seed", options.seed},
                 {"training", names_of(tuner.training())},
                 {"report", names_of(tuner.report())},
                 {"rows", Json::array()}};
    for (const ReportRow& row : rows) {
        std::vector<std::string> cells = {row.label};
        for (const Figures* figures : {&row.training, &row.report})
            std::ranges::copy(figures_cells(adapter, *figures), std::back_inserter(cells));
        table.add(std::move(cells));
        json["rows"].push_back({{"setting", row.label},
                                {"training", figures_json(adapter, row.training)},
                                {"report", figures_json(adapter, row.report)}});
    }
    const auto sets = differences(search.best(), start.parameters);
    json["sets"] = sets;
    json["within_budget"] = search.best_outcome().is_within_budget;
    std::string command = "--effect " + std::string(start.effect->name) + " --preset " + start.label;
    for (const std::string& set : sets)
        command += " --set " + set;
    output.print("\n" + table.text() + "\n" +
                 (search.best_outcome().is_within_budget ? "" : "Nothing within the budget was found; the fastest:\n") +
                 command + "\n");
    return output.write(json);
}

} // namespace

Result<void> tune(Rig& rig, const Options& options, const Variants& variants, const Sources& sources,
                  const Output& output) {
    if (options.variants.effect.empty() && effects().size() > 1)
        return Error{ErrorCode::invalid_argument, "tune needs --effect"};
    Variant start = variants.front();
    if (options.variants.presets.empty()) { // the defaults, with what is set by hand
        VariantRequest request = options.variants;
        request.presets = {"default"};
        auto made = make_variants(request);
        if (!made)
            return made.error();
        start = made->front();
    }
    const auto knobs = choose_knobs(options, *start.effect);
    if (!knobs)
        return knobs.error();
    output.print(header_text("tune", rig));
    Tuner tuner(rig, options, start);
    if (auto loaded = tuner.load(sources, output); !loaded)
        return loaded;
    std::string names;
    for (const ParameterInfo* knob : *knobs)
        names += std::string(names.empty() ? "" : ", ") + knob->name;
    output.print(fmt::format("budget {} ms at {}, seed {}\nvaries: {}\ntraining: {}\nreport: {}\n\n", options.budget_ms,
                             extent_text(times_sizes(options, rig, true).front()), options.seed, names,
                             names_of(tuner.training()), names_of(tuner.report())));
    TuneSearch search(start.parameters, *knobs, options.seed);
    if (auto searched = search_all(tuner, search, options, start.parameters, output); !searched)
        return searched;
    return report_all(rig, tuner, search, options, start, output);
}

} // namespace sfumato::bench
