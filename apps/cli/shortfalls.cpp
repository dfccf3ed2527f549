// Lines about what results lack.
#include "apps/cli/shortfalls.h"

#include "media/sequence.h"

#include <fmt/format.h>

namespace sfumato::cli {

std::string shortfall_text(const EffectShortfall& found) {
    const std::string& remedy = found.shortfall.remedy;
    return fmt::format("{}: {}{}", found.effect->name, found.shortfall.text,
                       remedy.empty() ? "" : fmt::format("; --set {}.{}", found.effect->name, remedy));
}

void ShortfallLog::add(int frame, const std::vector<EffectShortfall>& found) {
    for (const EffectShortfall& one : found) {
        Entry& entry = entries_[{one.effect->name, one.shortfall.name}];
        if (entry.frames.empty() || one.shortfall.excess > entry.worst.shortfall.excess)
            entry.worst = one;
        entry.frames.push_back(frame);
    }
}

std::vector<std::string> ShortfallLog::lines(const std::string& place) const {
    std::vector<std::string> result;
    for (const auto& [name, entry] : entries_) {
        const std::string frames =
            fmt::format("frame{} {}", entry.frames.size() > 1 ? "s" : "", media::format_frames(entry.frames));
        result.push_back(fmt::format("{}: {}", place.empty() ? frames : place, shortfall_text(entry.worst)));
    }
    return result;
}

} // namespace sfumato::cli
