// What the results of effects lack, gathered over frames and told once.
#pragma once

#include "sfumato/effect.h"

#include <map>
#include <string>
#include <utility>
#include <vector>

namespace sfumato::cli {

struct EffectShortfall {
    const EffectInfo* effect = nullptr;
    Shortfall shortfall;
};

// "particles: what is missing; --set particles.pairs_per_particle=23"
std::string shortfall_text(const EffectShortfall& found);

// Used by one thread at a time.
class ShortfallLog {
  public:
    void add(int frame, const std::vector<EffectShortfall>& found);

    // One line for each lack of each effect, whatever the number of frames: the frames, then what the worst of them
    // says. `place`, if there is one, stands for the frames.
    std::vector<std::string> lines(const std::string& place = "") const;

  private:
    struct Entry {
        std::vector<int> frames;
        EffectShortfall worst;
    };
    std::map<std::pair<std::string, std::string>, Entry> entries_; // by effect and name
};

} // namespace sfumato::cli
