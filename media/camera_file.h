// Cameras of rendered frames, from a TOML file or from attributes of an EXR file.
//
// TOML: all lengths in scene units, angles in degrees.
//   name = "shot"               optional, like all but width, height and the lens
//   width = 960                 pixels; with height and pixel_aspect they give the aspect ratio
//   height = 540
//   pixel_aspect = 1.0          width of a pixel over its height
//   near = 0.1                  default 0.1
//   far = 100.0                 default inf
//   vertical_fov_degrees = 35.1 above 0, below 180; or
//   orthographic_height = 4.0   height of the picture in scene units
//   shift = [0.0, 0.0]          the picture's window moved right and up, as fractions of its width and height
//   shutter = 0.5               fraction of a frame
//   frames_per_second = 24
//   [[frame]]
//   number = 4
//   world_to_camera = [[...], [...], [...], [...]]   four ROWS of a matrix for column vectors; the camera is
//                               right-handed, looks along -Z, +Y up; the last row is 0 0 0 1
// near, far, vertical_fov_degrees, orthographic_height and shift may stand in a [[frame]] for that frame alone.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "exr_file.h"
#include "sfumato/frame.h"
#include "sfumato/result.h"

namespace sfumato::media {

struct CameraFrame {
    int number = 0;
    Camera camera;
};

struct CameraTrack {
    std::string name;
    int width = 0;
    int height = 0;
    std::optional<double> shutter;
    std::optional<double> frames_per_second;
    std::vector<CameraFrame> frames; // by ascending number

    const Camera* find(int number) const;
};

// What a projection is made of.
struct Lens {
    double aspect = 1.0; // width over height
    double vertical_fov_degrees = 0.0;
    double orthographic_height = 0.0; // above 0: orthographic, and the angle does not count
    double near_distance = 0.1;
    double far_distance = 0.0; // 0 or infinity: no far plane (perspective only)
    std::array<double, 2> shift = {0.0, 0.0};
};

// View space to Vulkan clip space: +x right, +y down, depth 0 at the near plane and 1 at the far one.
Matrix4 make_projection(const Lens& lens);

Result<CameraTrack> read_camera_file(const std::filesystem::path& path);
// The same from text; `name` stands for the file in messages.
Result<CameraTrack> parse_camera_text(std::string_view text, const std::string& name);

// From the standard attributes worldToCamera (left-handed, +Z forward, matrices for row vectors) and worldToNDC (0...1,
// y down). No value where the part has neither; an error where they are not usable.
Result<std::optional<Camera>> camera_from_attributes(const ExrPart& part, const std::string& file_name);

// Product and inverse of column-major matrices; no value for a singular one.
Matrix4 multiply(const Matrix4& a, const Matrix4& b);
std::optional<Matrix4> inverse_of(const Matrix4& matrix);

} // namespace sfumato::media
