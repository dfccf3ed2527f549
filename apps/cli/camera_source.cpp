// Cameras by frame number, or from the headers of neighbouring files.
#include "apps/cli/camera_source.h"

#include "apps/cli/exit_code.h"

#include <cmath>
#include <cstring>
#include <fmt/format.h>

namespace sfumato::cli {

Result<CameraSource> CameraSource::open(const std::string& path) {
    CameraSource source;
    source.path_ = path;
    if (path.empty())
        return source;
    auto track = media::read_camera_file(path);
    if (!track)
        return as_input(track.error());
    source.track_ = std::move(*track);
    return source;
}

std::optional<double> frames_per_second(const media::ExrPart& part) {
    const media::ExrAttribute* attribute = part.find_attribute("framesPerSecond");
    if (attribute && attribute->type == "rational" && attribute->bytes.size() == 8) {
        int32_t numerator = 0;
        uint32_t denominator = 0;
        std::memcpy(&numerator, attribute->bytes.data(), 4);
        std::memcpy(&denominator, attribute->bytes.data() + 4, 4);
        if (numerator > 0 && denominator > 0)
            return static_cast<double>(numerator) / denominator;
    }
    if (const auto number = part.number_attribute("framesPerSecond"); number && *number > 0.0 && *number < 1e6)
        return number;
    return std::nullopt;
}

namespace {

// Cameras show the display window; the pixels are those of the data window.
Camera fit_to_data_window(Camera camera, const media::ExrPart& part) {
    const media::Window &data = part.data_window, &display = part.display_window;
    if (data == display || data.width() < 1 || data.height() < 1)
        return camera;
    const auto scale_x = static_cast<float>(static_cast<double>(display.width()) / static_cast<double>(data.width()));
    const auto scale_y = static_cast<float>(static_cast<double>(display.height()) / static_cast<double>(data.height()));
    const auto shift = [](int64_t from, int64_t to, int64_t size, int64_t display_size) {
        return static_cast<float>(static_cast<double>(display_size + 2 * (from - to)) / static_cast<double>(size) -
                                  1.0);
    };
    const float shift_x = shift(display.min_x, data.min_x, data.width(), display.width());
    const float shift_y = shift(display.min_y, data.min_y, data.height(), display.height());
    for (size_t column = 0; column < 4; ++column) {
        float* values = &camera.projection[column * 4];
        values[0] = values[0] * scale_x + values[3] * shift_x;
        values[1] = values[1] * scale_y + values[3] * shift_y;
    }
    return camera;
}

// Only the header is read. A neighbour that cannot be used is none.
std::optional<Camera> neighbour_camera(const std::optional<std::filesystem::path>& path) {
    if (!path)
        return std::nullopt;
    media::ExrReadOptions options;
    options.pixels = false;
    const auto image = media::read_exr(*path, options);
    if (!image || image->parts.empty())
        return std::nullopt;
    const auto camera = camera_of(image->parts.front(), path->string());
    return camera ? *camera : std::nullopt;
}

} // namespace

Result<std::optional<Camera>> camera_of(const media::ExrPart& part, const std::string& file) {
    auto camera = media::camera_from_attributes(part, file);
    if (!camera)
        return as_input(camera.error());
    if (!*camera)
        return std::optional<Camera>();
    return std::optional<Camera>(fit_to_data_window(**camera, part));
}

Result<void> CameraSource::fill(Frame& facts, const FrameJob& job, const media::ExrPart& part) const {
    double rate = frames_per_second(part).value_or(24.0);
    if (track_) {
        rate = track_->frames_per_second.value_or(rate);
        const auto find = [&](int frame) -> std::optional<Camera> {
            const Camera* camera = track_->find(frame);
            return camera ? std::optional(fit_to_data_window(*camera, part)) : std::nullopt;
        };
        facts.camera = find(job.frame);
        if (!facts.camera)
            return input_error(fmt::format("{}: no camera for frame {} of {}; it has {} to {}", path_, job.frame,
                                           job.input.string(),
                                           track_->frames.empty() ? 0 : track_->frames.front().number,
                                           track_->frames.empty() ? 0 : track_->frames.back().number));
        facts.previous_camera = find(job.frame - 1);
        facts.next_camera = find(job.frame + 1);
    } else {
        auto camera = camera_of(part, job.input.string());
        if (!camera)
            return camera.error();
        facts.camera = *camera;
        if (facts.camera) {
            facts.previous_camera = neighbour_camera(job.previous);
            facts.next_camera = neighbour_camera(job.next);
        }
    }
    facts.time_step = static_cast<float>(1.0 / rate);
    return {};
}

} // namespace sfumato::cli
