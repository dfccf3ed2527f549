// OpenEXR files in memory: every part, channel, window and attribute, so that writing an image back keeps what the
// program did not understand. Files are hostile input: sizes are checked before anything is allocated for them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sfumato/result.h"

namespace sfumato::media {

enum class PixelType { uint32, half, float32 };

// Corners of a rectangle of pixels, both inside it, as OpenEXR writes windows. May lie anywhere, negative included.
struct Window {
    int32_t min_x = 0;
    int32_t min_y = 0;
    int32_t max_x = -1;
    int32_t max_y = -1;

    int64_t width() const { return int64_t{max_x} - min_x + 1; }
    int64_t height() const { return int64_t{max_y} - min_y + 1; }
    friend bool operator==(const Window&, const Window&) = default;
};

// An attribute as the file stores it: type name and little-endian bytes.
struct ExrAttribute {
    std::string name;
    std::string type;
    std::vector<char> bytes;
    friend bool operator==(const ExrAttribute&, const ExrAttribute&) = default;
};

// One channel, row after row from the top of the data window. Half and float channels live in `values`, 32-bit
// integers (object identifiers and the like, which a float could not hold) in `integers`.
struct ExrChannel {
    std::string name;
    PixelType type = PixelType::half;
    bool perceptually_linear = false;
    std::vector<float> values;
    std::vector<uint32_t> integers;
};

struct ExrPart {
    std::string name; // empty where the file gives none
    std::string type; // "scanlineimage" or "tiledimage" as read; written as scan lines
    std::string compression = "zip";
    Window data_window;
    Window display_window;
    float pixel_aspect = 1.0f;
    std::array<float, 2> screen_window_centre = {0.0f, 0.0f};
    float screen_window_width = 1.0f;
    std::vector<ExrChannel> channels;
    std::vector<ExrAttribute> attributes; // all but those that the members above hold

    int64_t width() const { return data_window.width(); }
    int64_t height() const { return data_window.height(); }
    size_t pixel_count() const { return static_cast<size_t>(width() * height()); }

    const ExrChannel* find_channel(std::string_view channel_name) const;
    const ExrAttribute* find_attribute(std::string_view attribute_name) const;
    // The value where the attribute exists with that type (numbers: int, float or double).
    std::optional<std::string> string_attribute(std::string_view attribute_name) const;
    std::optional<double> number_attribute(std::string_view attribute_name) const;
    // 16 numbers of an m44f or m44d in the file's order: row after row of a matrix for row vectors.
    std::optional<std::array<double, 16>> matrix_attribute(std::string_view attribute_name) const;

    void set_string_attribute(std::string_view attribute_name, std::string_view value);
    // Replaces the values of a channel or adds it; `values` has pixel_count() elements.
    void set_channel(std::string_view channel_name, std::vector<float> values, PixelType pixel_type = PixelType::half);
};

struct ExrImage {
    std::filesystem::path path; // where it was read from
    std::vector<ExrPart> parts;
};

// What a file may ask for. A file over a limit is an error that names file, size and limit.
struct ExrLimits {
    uint64_t max_pixels = uint64_t{1} << 29; // of one part: 537 megapixels
    uint64_t max_side = uint64_t{1} << 20;   // width or height in pixels
    uint64_t max_parts = 256;
    uint64_t max_channels = 1024;             // of one part
    uint64_t max_memory = uint64_t{32} << 30; // bytes of all decoded channels of all parts
    uint64_t max_header = uint64_t{64} << 20; // bytes of all headers
};

struct ExrReadOptions {
    ExrLimits limits;
    bool pixels = true; // false: headers only; channels have names and types but no values
    int threads = 0;    // decoding threads; 0: the calling thread alone
};

// Reads any flat EXR: scan lines or tiles (the full-resolution level), one or several parts, half, float and uint.
// Errors (`input`, `unsupported` for deep data and sub-sampled channels, `out_of_memory`) are one line that begins
// with the file's name.
Result<ExrImage> read_exr(const std::filesystem::path& path, const ExrReadOptions& options = {});

enum class ExrCompression { zip, zips, none, rle, piz, keep }; // keep: as each part was read

struct ExrWriteOptions {
    ExrCompression compression = ExrCompression::zip;
    bool no_clobber = false;
    bool sync = true;
    int threads = 0;
};

// Writes scan lines, one part or several, each channel with its own pixel type; finite values beyond the range of half
// are clamped to it, so that no infinity appears. The file appears under its name whole or not at all.
Result<void> write_exr(const std::filesystem::path& path, const ExrImage& image, const ExrWriteOptions& options = {});

} // namespace sfumato::media
