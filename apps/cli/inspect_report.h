// What sfumato inspect finds in one file, as data, text and JSON.
#pragma once

#include "apps/cli/camera_source.h"
#include "apps/cli/conventions.h"
#include "media/channels.h"
#include "media/depth_convention.h"
#include "media/motion_convention.h"
#include "media/motion_warp.h"
#include "sfumato/frame.h"

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace sfumato::cli {

struct ChannelValues {
    std::string name;
    std::string type;
    std::string role; // "colour", "depth", …
    double minimum = 0.0;
    double maximum = 0.0;
    size_t not_a_number = 0;
    size_t infinite = 0;
};

struct FileReport {
    media::ExrImage image;
    media::ChannelSelection channels;
    std::vector<ChannelValues> values; // of the channels that have a role
    std::optional<media::DepthDetection> depth;
    std::optional<media::MotionDetection> motion;
    WarpOutcome warp;
    std::optional<media::NormalDetection> normals;
    std::optional<Camera> camera;
    std::string camera_source; // what it comes from
    std::string camera_problem;
};

// Errors: the file cannot be read; a layer or convention that does not exist.
Result<FileReport> inspect_file(const std::filesystem::path& path, const ConventionOptions& options,
                                const CameraSource& cameras, int threads);

std::string report_text(const FileReport& report);
nlohmann::ordered_json report_json(const FileReport& report);

} // namespace sfumato::cli
