// The cameras of a sequence: from a file given with --camera, else from the attributes of the frames.
#pragma once

#include "apps/cli/frame_list.h"
#include "media/camera_file.h"
#include "media/exr_file.h"
#include "sfumato/frame.h"
#include "sfumato/result.h"

#include <optional>
#include <string>

namespace sfumato::cli {

class CameraSource {
  public:
    // `path` may be empty.
    static Result<CameraSource> open(const std::string& path);

    // Fills in the cameras and the time step of a frame. `part` is the part of the colour: its windows make the cameras
    // fit the pixels that there are. Errors (input): the track lacks the frame, unusable attributes.
    Result<void> fill(Frame& facts, const FrameJob& job, const media::ExrPart& part) const;

    const std::optional<media::CameraTrack>& track() const { return track_; }
    const std::string& path() const { return path_; }

  private:
    std::optional<media::CameraTrack> track_;
    std::string path_;
};

// Frames per second of a part's header, if it says so.
std::optional<double> frames_per_second(const media::ExrPart& part);

// The camera of a header, fitted to the data window.
Result<std::optional<Camera>> camera_of(const media::ExrPart& part, const std::string& file);

} // namespace sfumato::cli
