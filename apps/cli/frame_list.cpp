// Inputs, outputs, neighbours and pre-roll.
#include "apps/cli/frame_list.h"

#include "apps/cli/exit_code.h"
#include "media/sequence.h"

#include <algorithm>
#include <cctype>
#include <fmt/format.h>
#include <map>

namespace sfumato::cli {

namespace fs = std::filesystem;

namespace {

bool is_there(const fs::path& path) {
    std::error_code failed;
    return fs::exists(path, failed);
}

std::optional<fs::path> if_exists(fs::path path) {
    return is_there(path) ? std::optional(std::move(path)) : std::nullopt;
}

// The pattern that a numbered file belongs to: shot.0006.exr to shot.####.exr.
std::optional<std::string> pattern_of(const fs::path& path, int& number) {
    const std::string name = path.filename().string();
    size_t end = name.size() - path.extension().string().size();
    const auto is_digit = [&](size_t i) { return std::isdigit(static_cast<unsigned char>(name[i])) != 0; };
    while (end > 0 && !is_digit(end - 1))
        --end;
    size_t begin = end;
    while (begin > 0 && is_digit(begin - 1))
        --begin;
    if (begin == end || end - begin > 9)
        return std::nullopt;
    number = std::stoi(name.substr(begin, end - begin));
    // A number without leading zeros may have any length; every other character stands for itself.
    const bool padded = name[begin] == '0' && end - begin > 1;
    std::string before = name.substr(0, begin), after = name.substr(end);
    if ((before + after).find_first_of("#@%") != std::string::npos)
        return std::nullopt;
    return (path.parent_path() / (before + (padded ? std::string(end - begin, '#') : "@") + after)).string();
}

// What an input argument stands for; `pattern` tells where its neighbours are.
struct Source {
    std::vector<media::SequenceFrame> frames;
    std::optional<media::FramePattern> pattern;
};

Result<std::vector<media::SequenceFrame>> files_of(const media::FramePattern& pattern,
                                                   const FrameListOptions& options) {
    if (!options.allow_missing || !pattern.is_sequence() || options.frames.empty())
        return media::find_frames(pattern, options.frames);
    auto numbers = media::parse_frame_range(options.frames);
    if (!numbers)
        return numbers.error();
    return media::output_frames(pattern, *numbers);
}

Result<Source> find_source(const std::string& input, const FrameListOptions& options) {
    auto pattern = media::FramePattern::parse(input);
    if (!pattern)
        return pattern.error();
    auto found = files_of(*pattern, options);
    if (!found)
        return found.error();
    Source source{std::move(*found), std::nullopt};
    if (pattern->is_sequence()) {
        source.pattern = std::move(*pattern);
    } else {
        int number = 0;
        const auto text = pattern_of(input, number);
        auto beside = text ? media::FramePattern::parse(*text) : Result<media::FramePattern>(usage_error(""));
        if (beside && beside->path_of(number) == fs::path(input)) {
            source.frames.front().frame = number;
            source.pattern = std::move(*beside);
        }
    }
    return source;
}

void add_jobs(const Source& source, int preroll, std::vector<FrameJob>& jobs) {
    const auto make = [&](const media::SequenceFrame& frame) {
        FrameJob job{frame.frame, frame.path, {}, {}, {}, false};
        if (source.pattern) {
            job.previous = if_exists(source.pattern->path_of(frame.frame - 1));
            job.next = if_exists(source.pattern->path_of(frame.frame + 1));
        }
        return job;
    };
    for (const media::SequenceFrame& frame : source.frames) {
        const bool restarts = jobs.empty() || jobs.back().frame + 1 != frame.frame;
        std::vector<FrameJob> before;
        for (int back = 1; restarts && source.pattern && back <= preroll; ++back) {
            const fs::path path = source.pattern->path_of(frame.frame - back);
            if (!is_there(path))
                break;
            before.insert(before.begin(), make({frame.frame - back, path}));
        }
        jobs.insert(jobs.end(), before.begin(), before.end());
        jobs.push_back(make(frame));
        jobs[jobs.size() - 1 - before.size()].restarts = restarts;
    }
}

Result<void> check_output(const FrameJob& job, const FrameListOptions& options) {
    std::error_code failed;
    if (fs::equivalent(job.input, job.output, failed))
        return usage_error(
            fmt::format("{}: the output is the input itself; write to another name", job.output.string()));
    if (options.no_clobber && is_there(job.output))
        return input_error(
            fmt::format("{}: exists already, and --no-clobber forbids to overwrite it", job.output.string()));
    return {};
}

// Every frame that is not pre-roll gets its file, and no file two frames.
Result<void> assign_outputs(std::vector<FrameJob>& jobs, const std::vector<int>& wanted,
                            const FrameListOptions& options) {
    auto pattern = media::FramePattern::parse(options.output);
    if (!pattern)
        return pattern.error();
    if (!pattern->is_sequence() && wanted.size() > 1)
        return usage_error(
            fmt::format("{} frames go in, but the output '{}' is one file; write the number as #### or %04d",
                        wanted.size(), options.output));
    size_t next = 0;
    for (FrameJob& job : jobs) {
        if (next == wanted.size() || job.frame != wanted[next])
            continue;
        job.output = pattern->path_of(job.frame);
        ++next;
        if (auto checked = check_output(job, options); !checked)
            return checked;
    }
    return {};
}

Result<void> check_numbers(const std::vector<Source>& sources) {
    std::map<int, fs::path> seen;
    for (const Source& source : sources)
        for (const auto& [frame, path] : source.frames)
            if (const auto [place, fresh] = seen.emplace(frame, path); !fresh)
                return usage_error(fmt::format("{} and {} are both frame {}; process them one by one",
                                               place->second.string(), path.string(), frame));
    return {};
}

} // namespace

Result<std::vector<FrameJob>> list_frames(const FrameListOptions& options) {
    std::vector<Source> sources;
    for (const std::string& input : options.inputs) {
        auto source = find_source(input, options);
        if (!source)
            return source.error();
        sources.push_back(std::move(*source));
    }
    if (auto checked = check_numbers(sources); !checked)
        return checked.error();
    std::vector<FrameJob> jobs;
    std::vector<int> wanted;
    for (const Source& source : sources) {
        // Pre-roll belongs to the start of a run, so runs are laid out source by source.
        add_jobs(source, options.preroll, jobs);
        for (const auto& frame : source.frames)
            wanted.push_back(frame.frame);
    }
    if (auto assigned = assign_outputs(jobs, wanted, options); !assigned)
        return assigned.error();
    return jobs;
}

Neighbours neighbours_of(const fs::path& path) {
    int number = 0;
    const auto text = pattern_of(path, number);
    if (!text)
        return {};
    const auto pattern = media::FramePattern::parse(*text);
    if (!pattern || pattern->path_of(number) != path)
        return {};
    return {if_exists(pattern->path_of(number - 1)), if_exists(pattern->path_of(number + 1)), number};
}

Result<void> make_parent_folder(const fs::path& output) {
    const fs::path folder = output.parent_path();
    if (folder.empty())
        return {};
    std::error_code failed;
    fs::create_directories(folder, failed);
    if (failed)
        return input_error(
            fmt::format("{}: cannot make the folder {}: {}", output.string(), folder.string(), failed.message()));
    return {};
}

Result<std::string> output_format(const std::string& output) {
    std::string extension = fs::path(output).extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (extension == ".exr" || extension == ".png")
        return extension.substr(1);
    return usage_error(fmt::format("output '{}': cannot write '{}'; .exr and .png are known", output, extension));
}

} // namespace sfumato::cli
