// Proposes settings of an effect: a random search that starts from the presets and then climbs from the best so far.
// The proposals follow from the seed and from what is told of the earlier ones.
#pragma once

#include "sfumato/parameters.h"

#include <cstdint>
#include <random>
#include <set>
#include <string>
#include <vector>

namespace sfumato::bench {

struct Outcome {
    double milliseconds = 0.0;
    double merit = 0.0; // the higher the better
    bool is_within_budget = false;
};

// Whether `a` is to be preferred: within the budget the closer one, above it the faster one.
bool is_better(const Outcome& a, const Outcome& b);

class TuneSearch {
  public:
    // `start` holds everything that is not varied.
    TuneSearch(const ParameterSet& start, std::vector<const ParameterInfo*> knobs, uint64_t seed);

    // A setting that was not proposed before. False: none was found, the search is at its end.
    bool propose(ParameterSet& proposal);
    void tell(const ParameterSet& setting, const Outcome& outcome);

    bool has_best() const { return has_best_; }
    const ParameterSet& best() const { return best_; }
    const Outcome& best_outcome() const { return best_outcome_; }

  private:
    double uniform(); // 0 ≤ x < 1
    size_t pick(size_t count);
    double fresh_value(const ParameterInfo& info);
    double near_value(const ParameterInfo& info, double value);
    ParameterSet from_preset(const Preset& preset) const;
    ParameterSet mutated(const ParameterSet& parent, bool far);
    std::string key(const ParameterSet& setting) const;

    ParameterSet start_;
    std::vector<const ParameterInfo*> knobs_;
    std::mt19937_64 random_;
    std::set<std::string> seen_;
    size_t proposed_ = 0;
    ParameterSet best_;
    Outcome best_outcome_;
    bool has_best_ = false;
};

// What differs from `reference`, as --set takes it: "effect.parameter=value".
std::vector<std::string> differences(const ParameterSet& setting, const ParameterSet& reference);

} // namespace sfumato::bench
