// Numbered frames on disk: patterns such as shot.####.exr, frame ranges such as 1-100,200-300x2, and which files exist.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sfumato/result.h"

namespace sfumato::media {

inline constexpr size_t max_frames = 1'000'000;

// Grammar: RANGE[,RANGE...] with RANGE = FRAME | FRAME-FRAME[xSTEP]. Frames may be negative (-5--1), ranges may run
// backwards (10-1x3). Frames come in the order written, a repeated one only once. Limits: |frame| <= 2^31 - 1,
// STEP >= 1, at most max_frames frames.
Result<std::vector<int>> parse_frame_range(std::string_view text);

// The shortest such text: "1-5,10,20-30x2".
std::string format_frames(const std::vector<int>& frames);

// The name of one file or of a numbered sequence. The number stands in the last path component: a run of # (each one
// digit of padding), @ (no padding), or %d, %4d, %04d. "%%" is a percent sign.
class FramePattern {
  public:
    static Result<FramePattern> parse(std::string_view text);

    bool is_sequence() const { return numbered_; }
    const std::string& text() const { return text_; }
    // The file of a frame; a plain name is every frame's file.
    std::filesystem::path path_of(int frame) const;
    // The frame whose path is exactly that file name (without folder), if any.
    std::optional<int> frame_of(std::string_view file_name) const;
    std::filesystem::path folder() const { return folder_; }

  private:
    std::string text_;
    std::filesystem::path folder_;
    std::string before_; // of the file name
    std::string after_;
    int padding_ = 1;
    bool numbered_ = false;
};

struct SequenceFrame {
    int frame = 0;
    std::filesystem::path path;
};

// The files of a pattern. Without a range: all that exist, in order of number (a plain name: itself as frame 0, or the
// last run of digits in its name). With one: exactly those frames; missing files are an error that names them.
Result<std::vector<SequenceFrame>> find_frames(const FramePattern& pattern, std::string_view range = {});

// The same without looking at the disk, for outputs. A plain name with several frames is an error.
Result<std::vector<SequenceFrame>> output_frames(const FramePattern& pattern, const std::vector<int>& frames);

} // namespace sfumato::media
