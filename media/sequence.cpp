// Frame ranges, patterns and the files that match them.
#include "sequence.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <limits>
#include <system_error>
#include <unordered_set>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sfumato::media {

namespace fs = std::filesystem;

namespace {

Error usage(std::string message) {
    return Error{ErrorCode::invalid_argument, std::move(message)};
}

constexpr int64_t frame_limit = std::numeric_limits<int>::max();

// Reads a number at the start of `text` and removes it. The leading minus belongs to the number.
std::optional<int64_t> take_number(std::string_view& text, bool sign_allowed) {
    if (text.empty() || (text[0] == '-' && !sign_allowed))
        return std::nullopt;
    int64_t value = 0;
    const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (code != std::errc() || value > frame_limit || value < -frame_limit)
        return std::nullopt;
    text.remove_prefix(static_cast<size_t>(end - text.data()));
    return value;
}

struct Range {
    int64_t first = 0;
    int64_t last = 0;
    int64_t step = 1;
};

std::optional<Range> parse_range(std::string_view text) {
    Range range;
    const auto first = take_number(text, true);
    if (!first)
        return std::nullopt;
    range.first = range.last = *first;
    if (text.empty())
        return range;
    if (text[0] != '-')
        return std::nullopt;
    text.remove_prefix(1);
    const auto last = take_number(text, true);
    if (!last)
        return std::nullopt;
    range.last = *last;
    if (text.empty())
        return range;
    if (text[0] != 'x')
        return std::nullopt;
    text.remove_prefix(1);
    const auto step = take_number(text, false);
    if (!step || *step < 1 || !text.empty())
        return std::nullopt;
    range.step = *step;
    return range;
}

std::string_view trim(std::string_view text) {
    while (!text.empty() && std::isspace(static_cast<unsigned char>(text.front())))
        text.remove_prefix(1);
    while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back())))
        text.remove_suffix(1);
    return text;
}

bool is_digit(char c) {
    return c >= '0' && c <= '9';
}

} // namespace

Result<std::vector<int>> parse_frame_range(std::string_view text) {
    std::vector<int> frames;
    std::unordered_set<int64_t> seen;
    std::string_view rest = text;
    while (true) {
        const size_t comma = rest.find(',');
        const std::string_view item = trim(rest.substr(0, comma));
        const auto range = parse_range(item);
        if (!range)
            return usage(
                fmt::format("frames '{}': '{}' is not a frame or range; write 7, 1-100 or 1-100x2", text, item));
        const int64_t count = std::abs(range->last - range->first) / range->step + 1;
        if (static_cast<uint64_t>(count) + frames.size() > max_frames)
            return usage(fmt::format("frames '{}': more than the limit of {} frames", text, max_frames));
        const int64_t step = range->last < range->first ? -range->step : range->step;
        for (int64_t i = 0; i < count; ++i)
            if (seen.insert(range->first + i * step).second)
                frames.push_back(static_cast<int>(range->first + i * step));
        if (comma == std::string_view::npos)
            return frames;
        rest.remove_prefix(comma + 1);
    }
}

std::string format_frames(const std::vector<int>& frames) {
    std::string text;
    for (size_t i = 0; i < frames.size();) {
        size_t end = i + 1;
        const int64_t step = end < frames.size() ? int64_t{frames[end]} - frames[i] : 0;
        while (end < frames.size() && int64_t{frames[end]} - frames[end - 1] == step)
            ++end;
        // Two frames that are not neighbours say more as they are.
        if (end - i == 2 && std::abs(step) != 1)
            end = i + 1;
        text += fmt::format("{}{}", text.empty() ? "" : ",", frames[i]);
        if (end - i > 1)
            text += fmt::format("-{}", frames[end - 1]);
        if (end - i > 1 && std::abs(step) != 1)
            text += fmt::format("x{}", std::abs(step));
        i = end;
    }
    return text;
}

// ------------------------------------------------------------------------------------------------- patterns

namespace {

struct Placeholder {
    std::string before;
    std::string after;
    int padding = 1;
    int count = 0; // placeholders found
};

// Reads "%d", "%4d" or "%04d" at `at`; returns its length, 0 if there is none.
size_t percent_length(std::string_view name, size_t at, int& padding) {
    size_t end = at + 1;
    int width = 0;
    while (end < name.size() && is_digit(name[end]) && width < 100)
        width = width * 10 + (name[end++] - '0');
    if (end >= name.size() || name[end] != 'd')
        return 0;
    padding = std::max(1, width);
    return end + 1 - at;
}

Result<Placeholder> find_placeholder(std::string_view name) {
    Placeholder found;
    for (size_t i = 0; i < name.size();) {
        std::string& literal = found.count > 0 ? found.after : found.before;
        size_t length = 1;
        if (name[i] == '#' || name[i] == '@') {
            while (i + length < name.size() && name[i + length] == name[i])
                ++length;
            found.padding = name[i] == '#' ? static_cast<int>(length) : 1;
            ++found.count;
        } else if (name[i] == '%' && i + 1 < name.size() && name[i + 1] == '%') {
            literal += '%';
            length = 2;
        } else if (name[i] == '%') {
            length = percent_length(name, i, found.padding);
            if (length == 0)
                return usage(fmt::format("pattern '{}': after % stands d, 4d or 04d, or %% for a percent sign", name));
            ++found.count;
        } else {
            literal += name[i];
        }
        i += length;
    }
    return found;
}

} // namespace

Result<FramePattern> FramePattern::parse(std::string_view text) {
    FramePattern pattern;
    pattern.text_ = text;
    const fs::path path = pattern.text_;
    pattern.folder_ = path.parent_path();
    const std::string name = path.filename().string();
    if (name.empty())
        return usage(fmt::format("'{}' names no file", text));
    auto found = find_placeholder(name);
    if (!found) {
        // A file may really be called so.
        std::error_code failed;
        if (!fs::exists(path, failed))
            return found.error();
        found = Placeholder{name, {}, 1, 0};
    }
    if (found->count > 1)
        return usage(
            fmt::format("pattern '{}' has {} places for the frame number; one is allowed", text, found->count));
    if (found->padding > 20)
        return usage(
            fmt::format("pattern '{}' pads the frame number to {} digits; 20 are allowed", text, found->padding));
    pattern.numbered_ = found->count == 1;
    pattern.before_ = found->before;
    pattern.after_ = found->after;
    pattern.padding_ = found->padding;
    return pattern;
}

fs::path FramePattern::path_of(int frame) const {
    if (!numbered_)
        return folder_ / before_;
    // As printf's %04d: the minus sign counts as one place.
    return folder_ / fmt::format("{}{:0{}d}{}", before_, frame, padding_, after_);
}

std::optional<int> FramePattern::frame_of(std::string_view file_name) const {
    if (!numbered_ || file_name.size() <= before_.size() + after_.size() || !file_name.starts_with(before_) ||
        !file_name.ends_with(after_))
        return std::nullopt;
    const std::string_view digits = file_name.substr(before_.size(), file_name.size() - before_.size() - after_.size());
    std::string_view rest = digits;
    const auto number = take_number(rest, true);
    if (!number || !rest.empty())
        return std::nullopt;
    // "7" or "00007" is not a file of shot.####: only what path_of() would write counts.
    const int frame = static_cast<int>(*number);
    if (fmt::format("{:0{}d}", frame, padding_) != digits)
        return std::nullopt;
    return frame;
}

// ---------------------------------------------------------------------------------------------------- files

namespace {

// The last run of digits of a name before its extension: 6 for kinetic.0006.exr, 0 if there is none.
int number_in(const fs::path& path) {
    const std::string name = path.stem().string();
    size_t end = name.size();
    while (end > 0 && !is_digit(name[end - 1]))
        --end;
    size_t begin = end;
    while (begin > 0 && is_digit(name[begin - 1]))
        --begin;
    std::string_view digits = std::string_view(name).substr(begin, end - begin);
    return static_cast<int>(take_number(digits, false).value_or(0));
}

Result<std::vector<SequenceFrame>> discover(const FramePattern& pattern) {
    const fs::path folder = pattern.folder().empty() ? fs::path(".") : pattern.folder();
    std::vector<SequenceFrame> found;
    std::error_code failed;
    for (fs::directory_iterator entry(folder, failed), end; !failed && entry != end; entry.increment(failed)) {
        const auto frame = pattern.frame_of(entry->path().filename().string());
        if (!frame)
            continue;
        found.push_back({*frame, pattern.path_of(*frame)});
        if (found.size() > max_frames)
            return Error{ErrorCode::input,
                         fmt::format("{}: more than the limit of {} frames", pattern.text(), max_frames)};
    }
    if (failed)
        return Error{ErrorCode::input, fmt::format("{}: cannot list: {}", folder.string(), failed.message())};
    if (found.empty())
        return Error{ErrorCode::input, fmt::format("{}: no file matches", pattern.text())};
    std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.frame < b.frame; });
    return found;
}

} // namespace

Result<std::vector<SequenceFrame>> find_frames(const FramePattern& pattern, std::string_view range) {
    if (!pattern.is_sequence()) {
        const fs::path path = pattern.path_of(0);
        std::error_code failed;
        if (!fs::exists(path, failed))
            return Error{ErrorCode::input, fmt::format("{}: no such file", path.string())};
        if (!range.empty())
            return usage(fmt::format("frames '{}' are given, but '{}' is one file; write the number as #### or %04d",
                                     range, pattern.text()));
        return std::vector<SequenceFrame>{{number_in(path), path}};
    }
    if (range.empty())
        return discover(pattern);
    auto frames = parse_frame_range(range);
    if (!frames)
        return frames.error();
    std::vector<SequenceFrame> found;
    std::vector<int> missing;
    for (const int frame : *frames) {
        const fs::path path = pattern.path_of(frame);
        std::error_code failed;
        if (fs::exists(path, failed))
            found.push_back({frame, path});
        else
            missing.push_back(frame);
    }
    if (!missing.empty())
        return Error{ErrorCode::input, fmt::format("{}: {} of {} frames missing: {}", pattern.text(), missing.size(),
                                                   frames->size(), format_frames(missing))};
    return found;
}

Result<std::vector<SequenceFrame>> output_frames(const FramePattern& pattern, const std::vector<int>& frames) {
    if (!pattern.is_sequence() && frames.size() > 1)
        return usage(fmt::format("'{}' is one file for {} frames; write the number as #### or %04d", pattern.text(),
                                 frames.size()));
    std::vector<SequenceFrame> result;
    for (const int frame : frames)
        result.push_back({frame, pattern.path_of(frame)});
    return result;
}

} // namespace sfumato::media
