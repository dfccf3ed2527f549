// Which files are read and written, frame by frame.
#pragma once

#include "sfumato/result.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace sfumato::cli {

struct FrameJob {
    int frame = 0;
    std::filesystem::path input;
    std::filesystem::path output;                  // empty: pre-roll, only for the effects' history
    std::optional<std::filesystem::path> previous; // the files of the neighbouring frames, where they exist
    std::optional<std::filesystem::path> next;
    bool restarts = false; // does not follow on the job before: histories begin anew
};

struct FrameListOptions {
    std::vector<std::string> inputs; // patterns or files
    std::string frames;              // "" for all that exist
    std::string output;              // pattern or file
    int preroll = 0;
    bool no_clobber = false;
    bool allow_missing = false; // missing files of a range become jobs that fail when they are read
};

// Errors: usage (patterns and ranges that do not fit together), input (missing files, existing outputs).
Result<std::vector<FrameJob>> list_frames(const FrameListOptions& options);

// The numbered files beside one: of shot.0006.exr, shot.0005.exr and shot.0007.exr where they exist.
struct Neighbours {
    std::optional<std::filesystem::path> previous;
    std::optional<std::filesystem::path> next;
    int frame = 0; // the file's own number
};
Neighbours neighbours_of(const std::filesystem::path& path);

// Makes the folder of an output. Error (input): it cannot be made.
Result<void> make_parent_folder(const std::filesystem::path& output);

// "exr" or "png", by extension. Error (usage): another one.
Result<std::string> output_format(const std::string& output);

} // namespace sfumato::cli
