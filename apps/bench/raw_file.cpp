// Reads the raw container. The file is hostile input: sizes are checked against the file's before memory is taken.
#include "apps/bench/raw_file.h"

#include <algorithm>
#include <bit>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <fmt/format.h>

namespace sfumato::bench {
namespace {

static_assert(std::endian::native == std::endian::little, "values are read as they lie in the file");

constexpr int64_t longest_side = 32768;
constexpr size_t most_images = 32;

Error broken(const std::string& path, const std::string& what) {
    return {ErrorCode::input, path + ": " + what};
}

Result<RawImage> parse_line(const std::string& path, const std::string& line) {
    std::istringstream words(line);
    RawImage image;
    std::string type, order, rest;
    int64_t width = 0, height = 0, channels = 0; // signed: a stream takes "-1" for a large unsigned number
    words >> image.name >> width >> height >> channels >> type >> order;
    if (words.fail() || type != "float32" || order != "little-endian" || words >> rest)
        return broken(path, fmt::format("the header line '{}' is not NAME WIDTH HEIGHT CHANNELS float32 little-endian",
                                        line.substr(0, 80)));
    if (width < 1 || width > longest_side || height < 1 || height > longest_side || channels < 1 || channels > 4)
        return broken(path,
                      fmt::format("image '{}' is {}x{} with {} channels; sides of 1 to {} and 1 to 4 channels are "
                                  "possible",
                                  image.name, width, height, channels, longest_side));
    image.extent = {static_cast<uint32_t>(width), static_cast<uint32_t>(height)};
    image.channels = static_cast<uint32_t>(channels);
    return image;
}

uint64_t value_count(const RawImage& image) {
    return uint64_t{image.extent.width} * image.extent.height * image.channels;
}

Result<void> check_images(const RawFrame& frame) {
    struct Need {
        const char* name;
        uint32_t least, most;
    };
    static constexpr Need needs[] = {{"colour", 3, 4},           {"depth", 1, 4},  {"velocity", 2, 4},
                                     {"next_velocity", 2, 4},    {"normal", 3, 4}, {"true_visibility", 1, 4},
                                     {"true_bent_normal", 3, 4}, {"shadow", 1, 4}, {"direct", 3, 4},
                                     {"ambient", 3, 4},          {"truth", 3, 4}};
    if (frame.find("colour") == nullptr)
        return broken(frame.path, "there is no image 'colour'");
    for (const Need& need : needs) {
        const RawImage* image = frame.find(need.name);
        if (image != nullptr && (image->channels < need.least || image->channels > need.most))
            return broken(frame.path, fmt::format("image '{}' has {} channels, {} to {} are possible", need.name,
                                                  image->channels, need.least, need.most));
    }
    const Extent extent = frame.find("colour")->extent;
    for (const char* name : {"truth", "true_visibility"})
        if (const RawImage* truth = frame.find(name); truth != nullptr && truth->extent != extent)
            return broken(frame.path, fmt::format("{} is {}, but colour is {}", name, extent_text(truth->extent),
                                                  extent_text(extent)));
    for (const char* name : {"world_to_view", "projection", "previous_world_to_view", "previous_projection"})
        if (const RawImage* matrix = frame.find(name);
            matrix != nullptr && (matrix->extent != Extent{4, 4} || matrix->channels != 1))
            return broken(frame.path, fmt::format("'{}' must be a matrix: 4x4 with one channel", name));
    if (const RawImage* radius = frame.find("truth_radius");
        radius != nullptr && (radius->extent != Extent{1, 1} || radius->channels != 1))
        return broken(frame.path, "'truth_radius' must be one number: 1x1 with one channel");
    return {};
}

} // namespace

const RawImage* RawFrame::find(std::string_view name) const {
    const auto found = std::ranges::find(images, name, &RawImage::name);
    return found == images.end() ? nullptr : &*found;
}

Result<RawFrame> read_raw_frame(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::error_code failed;
    const uint64_t size = std::filesystem::file_size(path, failed);
    if (!file || failed)
        return broken(path, "cannot be opened");
    const auto next_line = [&](std::string& line) {
        line.clear();
        char c = 0;
        while (line.size() < 256 && file.get(c) && c != '\n')
            line.push_back(c);
        return static_cast<bool>(file) && c == '\n';
    };
    std::string line;
    if (!next_line(line) || line != "SFRAW1")
        return broken(path, "is no raw frame: its first line must be SFRAW1");
    RawFrame frame;
    frame.path = path;
    uint64_t values = 0;
    while (next_line(line) && !line.empty() && frame.images.size() < most_images) {
        auto image = parse_line(path, line);
        if (!image)
            return image.error();
        if (frame.find(image->name) != nullptr)
            return broken(path, "image '" + image->name + "' comes twice");
        values += value_count(*image);
        frame.images.push_back(std::move(*image));
    }
    if (!line.empty() || !file)
        return broken(path, "the header does not end with an empty line");
    const auto start = static_cast<uint64_t>(file.tellg());
    if (size - start != values * sizeof(float))
        return broken(path, fmt::format("holds {} bytes of values, but its header announces {}", size - start,
                                        values * sizeof(float)));
    for (RawImage& image : frame.images) {
        image.values.resize(value_count(image));
        file.read(reinterpret_cast<char*>(image.values.data()),
                  static_cast<std::streamsize>(image.values.size() * sizeof(float)));
    }
    if (!file)
        return broken(path, "cannot be read to its end");
    if (auto checked = check_images(frame); !checked)
        return checked.error();
    return frame;
}

RawImage resized_nearest(const RawImage& image, Extent extent, const std::vector<float>& factors) {
    RawImage result{image.name, extent, image.channels, {}};
    result.values.reserve(value_count(result));
    for (uint32_t y = 0; y < extent.height; ++y) {
        const uint64_t from_y = (2 * uint64_t{y} + 1) * image.extent.height / (2 * uint64_t{extent.height});
        for (uint32_t x = 0; x < extent.width; ++x) {
            const uint64_t from_x = (2 * uint64_t{x} + 1) * image.extent.width / (2 * uint64_t{extent.width});
            const size_t from = (from_y * image.extent.width + from_x) * image.channels;
            for (uint32_t c = 0; c < image.channels; ++c)
                result.values.push_back(image.values[from + c] * (c < factors.size() ? factors[c] : 1.0f));
        }
    }
    return result;
}

} // namespace sfumato::bench
