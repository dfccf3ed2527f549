// The search of `tune`.
#include "apps/bench/tune_search.h"

#include <algorithm>
#include <cmath>

namespace sfumato::bench {
namespace {

// Three digits are as many as anyone wants to read; parameters are floats anyway.
double rounded(double value) {
    if (value == 0.0)
        return 0.0;
    const double scale = std::pow(10.0, 2.0 - std::floor(std::log10(std::abs(value))));
    return std::round(value * scale) / scale;
}

double allowed(const ParameterInfo& info, double value) {
    const double valid = info.kind == ParameterKind::real ? rounded(value) : std::round(value);
    return std::clamp(valid, info.minimum, info.maximum);
}

// The least positive value that is worth trying.
double least_positive(const ParameterInfo& info) {
    if (info.minimum > 0.0)
        return info.minimum;
    return info.kind == ParameterKind::integer ? 1.0 : info.maximum / 1000.0;
}

} // namespace

bool is_better(const Outcome& a, const Outcome& b) {
    if (a.is_within_budget != b.is_within_budget)
        return a.is_within_budget;
    return a.is_within_budget ? a.merit > b.merit : a.milliseconds < b.milliseconds;
}

TuneSearch::TuneSearch(const ParameterSet& start, std::vector<const ParameterInfo*> knobs, uint64_t seed)
    : start_(start), knobs_(std::move(knobs)), random_(seed), best_(start) {}

// Not std::uniform_real_distribution, whose results differ between standard libraries.
double TuneSearch::uniform() {
    return static_cast<double>(random_() >> 11) * 0x1p-53;
}

size_t TuneSearch::pick(size_t count) {
    return std::min(static_cast<size_t>(uniform() * static_cast<double>(count)), count - 1);
}

double TuneSearch::fresh_value(const ParameterInfo& info) {
    if (info.kind == ParameterKind::boolean || info.kind == ParameterKind::choice)
        return static_cast<double>(pick(static_cast<size_t>(info.maximum) + 1));
    if (info.minimum <= 0.0 && uniform() < 0.2)
        return allowed(info, 0.0);
    if (info.minimum < 0.0)
        return allowed(info, info.minimum + uniform() * (info.maximum - info.minimum));
    // Most parameters act by their ratio.
    const double least = least_positive(info);
    return allowed(info, least * std::pow(info.maximum / least, uniform()));
}

double TuneSearch::near_value(const ParameterInfo& info, double value) {
    if (info.kind == ParameterKind::boolean)
        return 1.0 - value;
    if (info.kind == ParameterKind::choice || value <= 0.0 || uniform() < 0.15)
        return fresh_value(info);
    const double step = std::exp2((2.0 * uniform() - 1.0) * 1.2);
    const double near = allowed(info, value * step);
    if (near != value || info.kind == ParameterKind::real)
        return near;
    return allowed(info, value + (step < 1.0 ? -1.0 : 1.0));
}

ParameterSet TuneSearch::from_preset(const Preset& preset) const {
    ParameterSet whole(start_.table());
    ParameterSet result = start_;
    // Presets of the library are valid by its own tests.
    if (apply_preset(start_.table(), whole.data(), preset.name))
        for (const ParameterInfo* knob : knobs_)
            knob->set(result.data(), knob->get(whole.data()));
    return result;
}

ParameterSet TuneSearch::mutated(const ParameterSet& parent, bool far) {
    ParameterSet child = parent;
    const size_t changes = far ? 1 + pick(knobs_.size()) : 1 + pick(std::min<size_t>(3, knobs_.size()));
    for (size_t i = 0; i < changes; ++i) {
        const ParameterInfo& knob = *knobs_[pick(knobs_.size())];
        knob.set(child.data(), far ? fresh_value(knob) : near_value(knob, knob.get(child.data())));
    }
    return child;
}

std::string TuneSearch::key(const ParameterSet& setting) const {
    std::string text;
    for (const ParameterInfo* knob : knobs_)
        text += parameter_text(*knob, setting.data()) + " ";
    return text;
}

bool TuneSearch::propose(ParameterSet& proposal) {
    const auto presets = start_.table().presets;
    for (int attempt = 0; attempt < 1000; ++attempt) {
        if (proposed_ == 0)
            proposal = start_;
        else if (proposed_ <= presets.size())
            proposal = from_preset(presets[proposed_ - 1]);
        else if (knobs_.empty())
            return false;
        else // a fifth explores, the rest climbs
            proposal = mutated(best_, proposed_ % 5 == 0);
        ++proposed_;
        if (seen_.insert(key(proposal)).second)
            return true;
    }
    return false;
}

void TuneSearch::tell(const ParameterSet& setting, const Outcome& outcome) {
    if (has_best_ && !is_better(outcome, best_outcome_))
        return;
    has_best_ = true;
    best_ = setting;
    best_outcome_ = outcome;
}

std::vector<std::string> differences(const ParameterSet& setting, const ParameterSet& reference) {
    std::vector<std::string> texts;
    for (const ParameterInfo& info : setting.table().parameters)
        if (info.get(setting.data()) != info.get(reference.data()))
            texts.push_back(std::string(setting.table().effect) + "." + info.name + "=" +
                            parameter_text(info, setting.data()));
    return texts;
}

} // namespace sfumato::bench
