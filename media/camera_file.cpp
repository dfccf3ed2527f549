// Camera files: TOML and EXR attributes to view and projection matrices.
#include "camera_file.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <initializer_list>
#include <limits>
#include <numbers>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include "file_io.h"

namespace sfumato::media {

const Camera* CameraTrack::find(int number) const {
    const auto place = std::lower_bound(frames.begin(), frames.end(), number,
                                        [](const CameraFrame& frame, int wanted) { return frame.number < wanted; });
    return place != frames.end() && place->number == number ? &place->camera : nullptr;
}

// ------------------------------------------------------------------------------------------------- matrices

Matrix4 make_projection(const Lens& lens) {
    Matrix4 m = {};
    auto at = [&m](size_t row, size_t column) -> float& { return m[column * 4 + row]; };
    auto f = [](double value) { return static_cast<float>(value); };
    const double n = lens.near_distance, far = lens.far_distance;
    const bool infinite = far == 0.0 || std::isinf(far);
    if (lens.orthographic_height > 0.0) {
        const double depth = infinite ? 1e6 : far - n;
        at(0, 0) = f(2.0 / (lens.orthographic_height * lens.aspect));
        at(1, 1) = f(-2.0 / lens.orthographic_height);
        at(2, 2) = f(-1.0 / depth);
        at(2, 3) = f(-n / depth);
        at(0, 3) = f(-2.0 * lens.shift[0]);
        at(1, 3) = f(2.0 * lens.shift[1]);
        at(3, 3) = 1.0f;
        return m;
    }
    const double scale = 1.0 / std::tan(lens.vertical_fov_degrees * std::numbers::pi / 360.0);
    at(0, 0) = f(scale / lens.aspect);
    at(1, 1) = f(-scale);
    // Moving the window right moves the picture's content left: x' = ... - 2 shift after the division by -z.
    at(0, 2) = f(2.0 * lens.shift[0]);
    at(1, 2) = f(-2.0 * lens.shift[1]);
    at(2, 2) = f(infinite ? -1.0 : far / (n - far));
    at(2, 3) = f(infinite ? -n : n * far / (n - far));
    at(3, 2) = -1.0f;
    return m;
}

Matrix4 multiply(const Matrix4& a, const Matrix4& b) {
    Matrix4 product = {};
    for (size_t column = 0; column < 4; ++column)
        for (size_t row = 0; row < 4; ++row) {
            double sum = 0.0;
            for (size_t k = 0; k < 4; ++k)
                sum += double{a[k * 4 + row]} * double{b[column * 4 + k]};
            product[column * 4 + row] = static_cast<float>(sum);
        }
    return product;
}

std::optional<Matrix4> inverse_of(const Matrix4& matrix) {
    // Gauss-Jordan with the largest pivot of each column, in double.
    double work[4][8] = {};
    double largest = 0.0;
    for (size_t row = 0; row < 4; ++row) {
        for (size_t column = 0; column < 4; ++column) {
            work[row][column] = double{matrix[column * 4 + row]};
            largest = std::max(largest, std::abs(work[row][column]));
        }
        work[row][4 + row] = 1.0;
    }
    for (size_t column = 0; column < 4; ++column) {
        size_t pivot = column;
        for (size_t row = column + 1; row < 4; ++row)
            if (std::abs(work[row][column]) > std::abs(work[pivot][column]))
                pivot = row;
        if (!(std::abs(work[pivot][column]) > largest * 1e-12))
            return std::nullopt;
        std::swap(work[pivot], work[column]);
        const double scale = 1.0 / work[column][column];
        for (double& value : work[column])
            value *= scale;
        for (size_t row = 0; row < 4; ++row) {
            const double factor = row == column ? 0.0 : work[row][column];
            for (size_t k = 0; k < 8; ++k)
                work[row][k] -= factor * work[column][k];
        }
    }
    Matrix4 inverse = {};
    for (size_t row = 0; row < 4; ++row)
        for (size_t column = 0; column < 4; ++column)
            inverse[column * 4 + row] = static_cast<float>(work[row][4 + column]);
    return inverse;
}

// ----------------------------------------------------------------------------------------------------- TOML

namespace {

constexpr size_t max_text = size_t{64} << 20;

// Reads values of one table; the first problem stays.
class Reader {
  public:
    Reader(const toml::table& table, const std::string& file, std::string where)
        : table_(table), file_(file), where_(std::move(where)) {}

    struct Limits {
        double low;
        double high;
        const char* allowed;
    };

    std::optional<double> number(const char* key, const Limits& limits) {
        const toml::node* node = table_.get(key);
        if (!node)
            return std::nullopt;
        const auto value = node->is_number() ? node->value<double>() : std::nullopt;
        if (!value || !(*value >= limits.low && *value <= limits.high)) {
            fail(*node, key, fmt::format("is {}; allowed is {}", print(*node), limits.allowed));
            return std::nullopt;
        }
        return value;
    }
    std::optional<int> integer(const char* key, int64_t low, int64_t high) {
        const toml::node* node = table_.get(key);
        if (!node)
            return std::nullopt;
        const auto value = node->is_integer() ? node->value<int64_t>() : std::nullopt;
        if (!value || *value < low || *value > high) {
            fail(*node, key, fmt::format("is {}; allowed are whole numbers from {} to {}", print(*node), low, high));
            return std::nullopt;
        }
        return static_cast<int>(*value);
    }
    std::optional<std::array<double, 2>> pair(const char* key) {
        const toml::node* node = table_.get(key);
        if (!node)
            return std::nullopt;
        std::array<double, 2> result = {};
        if (!numbers(node, result.data(), 2)) {
            fail(*node, key, fmt::format("is {}; allowed are two numbers like [0.0, 0.0]", print(*node)));
            return std::nullopt;
        }
        return result;
    }
    std::optional<Matrix4> matrix(const char* key);
    void only(std::initializer_list<const char*> keys) {
        for (const auto& [key, node] : table_)
            if (std::none_of(keys.begin(), keys.end(), [&k = key](const char* known) { return k.str() == known; }))
                fail(node, std::string(key.str()), fmt::format("is unknown; known are {}", fmt::join(keys, ", ")));
    }
    void fail(const toml::node& node, const std::string& key, const std::string& what) {
        if (!error_)
            error_ = Error{ErrorCode::input,
                           fmt::format("{}:{}: {}{} {}", file_, node.source().begin.line, where_, key, what)};
    }
    void fail_missing(const char* what) {
        if (!error_)
            error_ =
                Error{ErrorCode::input, fmt::format("{}:{}: {}{}", file_, table_.source().begin.line, where_, what)};
    }
    const std::optional<Error>& error() const { return error_; }

  private:
    static bool numbers(const toml::node* node, double* out, size_t count) {
        const toml::array* array = node->as_array();
        if (!array || array->size() != count)
            return false;
        for (size_t i = 0; i < count; ++i) {
            const toml::node& item = *array->get(i);
            const auto value = item.is_number() ? item.value<double>() : std::nullopt;
            if (!value || !std::isfinite(*value) || std::abs(*value) > 1e30)
                return false;
            out[i] = *value;
        }
        return true;
    }
    static std::string print(const toml::node& node) {
        std::string text;
        if (node.is_number())
            text = node.is_integer() ? fmt::format("{}", node.value_or(int64_t{0}))
                                     : fmt::format("{}", node.value_or(0.0));
        else if (node.is_string())
            text = fmt::format("\"{}\"", node.value_or(std::string()));
        else
            text = node.is_boolean() ? (node.value_or(false) ? "true" : "false")
                   : node.is_array() ? "a list"
                                     : "a table";
        return text.size() > 60 ? text.substr(0, 60) + "..." : text;
    }
    const toml::table& table_;
    const std::string& file_;
    std::string where_;
    std::optional<Error> error_;
};

std::optional<Matrix4> Reader::matrix(const char* key) {
    const toml::node* node = table_.get(key);
    if (!node) {
        fail_missing("world_to_camera is missing");
        return std::nullopt;
    }
    const toml::array* rows = node->as_array();
    Matrix4 result = {};
    bool good = rows && rows->size() == 4;
    for (size_t row = 0; good && row < 4; ++row) {
        double values[4] = {};
        good = numbers(rows->get(row), values, 4);
        for (size_t column = 0; column < 4; ++column)
            result[column * 4 + row] = static_cast<float>(values[column]);
    }
    if (!good) {
        fail(*node, key, "is not a matrix; allowed are four rows of four finite numbers");
        return std::nullopt;
    }
    if (std::abs(result[3]) + std::abs(result[7]) + std::abs(result[11]) + std::abs(result[15] - 1.0f) > 1e-4f) {
        fail(*node, key,
             fmt::format("has the last row [{}, {}, {}, {}]; allowed is [0, 0, 0, 1] (rows of a matrix for "
                         "column vectors)",
                         result[3], result[7], result[11], result[15]));
        return std::nullopt;
    }
    if (!inverse_of(result)) {
        fail(*node, key, "cannot be inverted");
        return std::nullopt;
    }
    return result;
}

void read_lens(Reader& reader, Lens& lens) {
    const double tiny = std::numeric_limits<float>::min(), infinity = std::numeric_limits<double>::infinity();
    if (auto value = reader.number("near", {tiny, 1e30, "a finite number above 0"}))
        lens.near_distance = *value;
    if (auto value = reader.number("far", {tiny, infinity, "a number above near, or inf"}))
        lens.far_distance = *value;
    const auto fov = reader.number("vertical_fov_degrees", {1e-3, 179.9, "an angle above 0.001 and below 179.9"});
    const auto height = reader.number("orthographic_height", {tiny, 1e30, "a finite number above 0"});
    if (fov && height)
        reader.fail_missing("vertical_fov_degrees and orthographic_height are both given; one is allowed");
    if (fov) {
        lens.vertical_fov_degrees = *fov;
        lens.orthographic_height = 0.0;
    }
    if (height)
        lens.orthographic_height = *height;
    if (auto value = reader.pair("shift"))
        lens.shift = *value;
    const double far = lens.far_distance;
    if (far != 0.0 && far <= lens.near_distance)
        reader.fail_missing(
            fmt::format("far is {} with near {}; allowed is a far above near", far, lens.near_distance).c_str());
}

Result<CameraFrame> read_frame(const toml::table& table, const std::string& file, size_t index, Lens lens) {
    Reader reader(table, file, fmt::format("frame {}: ", index + 1));
    reader.only({"number", "world_to_camera", "near", "far", "vertical_fov_degrees", "orthographic_height", "shift"});
    CameraFrame frame;
    const auto number = reader.integer("number", -2147483647, 2147483647);
    if (!number)
        reader.fail_missing("number is missing");
    const auto matrix = reader.matrix("world_to_camera");
    read_lens(reader, lens);
    if (lens.vertical_fov_degrees == 0.0 && lens.orthographic_height == 0.0)
        reader.fail_missing("vertical_fov_degrees or orthographic_height is missing, here or at the top of the file");
    if (reader.error())
        return *reader.error();
    frame.number = *number;
    frame.camera.world_to_view = *matrix;
    frame.camera.projection = make_projection(lens);
    return frame;
}

Result<void> read_frames(const toml::table& root, const std::string& file, const Lens& lens, CameraTrack& track) {
    const toml::node* node = root.get("frame");
    const toml::array* frames = node ? node->as_array() : nullptr;
    if (!frames || frames->empty())
        return Error{ErrorCode::input, fmt::format("{}: no [[frame]] with number and world_to_camera", file)};
    for (size_t i = 0; i < frames->size(); ++i) {
        const toml::table* table = frames->get(i)->as_table();
        if (!table)
            return Error{ErrorCode::input, fmt::format("{}: frame {} is not a [[frame]] table", file, i + 1)};
        auto frame = read_frame(*table, file, i, lens);
        if (!frame)
            return frame.error();
        track.frames.push_back(*frame);
    }
    auto by_number = [](const CameraFrame& a, const CameraFrame& b) { return a.number < b.number; };
    std::sort(track.frames.begin(), track.frames.end(), by_number);
    for (size_t i = 1; i < track.frames.size(); ++i)
        if (track.frames[i].number == track.frames[i - 1].number)
            return Error{ErrorCode::input,
                         fmt::format("{}: frame number {} occurs twice", file, track.frames[i].number)};
    return {};
}

Result<CameraTrack> read_track(const toml::table& root, const std::string& file) {
    Reader reader(root, file, "");
    reader.only({"name", "width", "height", "pixel_aspect", "near", "far", "vertical_fov_degrees",
                 "orthographic_height", "shift", "shutter", "frames_per_second", "frame"});
    CameraTrack track;
    Lens lens;
    if (const toml::node* name = root.get("name")) {
        if (!name->is_string())
            reader.fail(*name, "name", "is no text");
        track.name = name->value_or(std::string());
    }
    const auto width = reader.integer("width", 1, 1 << 20), height = reader.integer("height", 1, 1 << 20);
    if (!width || !height)
        reader.fail_missing("width or height is missing");
    const auto aspect = reader.number("pixel_aspect", {1e-3, 1e3, "a number from 0.001 to 1000"});
    track.shutter = reader.number("shutter", {0.0, 100.0, "a fraction of a frame from 0 to 100"});
    track.frames_per_second = reader.number("frames_per_second", {1e-3, 1e6, "a number from 0.001 to 1000000"});
    read_lens(reader, lens);
    if (reader.error())
        return *reader.error();
    track.width = *width;
    track.height = *height;
    lens.aspect = double{static_cast<double>(*width)} / *height * aspect.value_or(1.0);
    if (auto read = read_frames(root, file, lens, track); !read)
        return read.error();
    return track;
}

} // namespace

Result<CameraTrack> parse_camera_text(std::string_view text, const std::string& name) {
    if (text.size() > max_text)
        return Error{ErrorCode::input,
                     fmt::format("{}: {} bytes exceed the limit of {} bytes", name, text.size(), max_text)};
    try {
        const toml::table root = toml::parse(text, name);
        return read_track(root, name);
    } catch (const toml::parse_error& error) {
        std::string what(error.description());
        std::replace(what.begin(), what.end(), '\n', ' ');
        return Error{ErrorCode::input,
                     fmt::format("{}:{}:{}: {}", name, error.source().begin.line, error.source().begin.column, what)};
    } catch (const std::exception& error) {
        return Error{ErrorCode::input, fmt::format("{}: {}", name, error.what())};
    }
}

Result<CameraTrack> read_camera_file(const std::filesystem::path& path) {
    auto text = read_whole_file(path, max_text);
    if (!text)
        return text.error();
    return parse_camera_text({text->data(), text->size()}, path.string());
}

// ------------------------------------------------------------------------------------------- EXR attributes

namespace {

// The file's rows of a matrix for row vectors are, in the same order, the columns of one for column vectors.
Result<Matrix4> usable_matrix(const std::array<double, 16>& values, const char* name, const std::string& file) {
    Matrix4 matrix = {};
    for (size_t i = 0; i < 16; ++i) {
        if (!std::isfinite(values[i]) || std::abs(values[i]) > 1e30)
            return Error{ErrorCode::input,
                         fmt::format("{}: attribute {} holds {}; finite numbers are allowed", file, name, values[i])};
        matrix[i] = static_cast<float>(values[i]);
    }
    return matrix;
}

// The third row of worldToNDC means nothing by definition; one that gives depth takes its place.
void set_depth_row(Matrix4& projection) {
    const bool perspective = projection[11] != 0.0f;
    const float scale = 1.0f / (perspective ? -projection[11] : projection[15]);
    for (float& value : projection)
        value *= scale;
    const Matrix4 depth = make_projection(Lens{1.0, 60.0, perspective ? 0.0 : 1.0});
    for (size_t column = 0; column < 4; ++column)
        projection[column * 4 + 2] = depth[column * 4 + 2];
}

} // namespace

Result<std::optional<Camera>> camera_from_attributes(const ExrPart& part, const std::string& file_name) {
    const auto to_camera = part.matrix_attribute("worldToCamera"), to_ndc = part.matrix_attribute("worldToNDC");
    if (!to_camera && !to_ndc)
        return std::optional<Camera>();
    if (!to_camera || !to_ndc)
        return Error{ErrorCode::input,
                     fmt::format("{}: attribute {} is there, but {} is missing; both are needed for a camera",
                                 file_name, to_camera ? "worldToCamera" : "worldToNDC",
                                 to_camera ? "worldToNDC" : "worldToCamera")};
    auto view = usable_matrix(*to_camera, "worldToCamera", file_name);
    if (!view)
        return view.error();
    auto ndc = usable_matrix(*to_ndc, "worldToNDC", file_name);
    if (!ndc)
        return ndc.error();
    Camera camera;
    camera.world_to_view = *view;
    const auto to_world = inverse_of(*view);
    if (!to_world)
        return Error{ErrorCode::input, fmt::format("{}: attribute worldToCamera cannot be inverted", file_name)};
    // +Z forward to -Z forward: the third row changes its sign.
    for (size_t column = 0; column < 4; ++column)
        camera.world_to_view[column * 4 + 2] = -camera.world_to_view[column * 4 + 2];
    // 0...1 to -1...1; both have y down.
    const Matrix4 spread = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1, 0, -1, -1, 0, 1};
    camera.projection = multiply(spread, multiply(*ndc, *inverse_of(camera.world_to_view)));
    // In front of the camera w is positive.
    if (camera.projection[11] > 0.0f || (camera.projection[11] == 0.0f && !(camera.projection[15] > 0.0f)))
        return Error{ErrorCode::input,
                     fmt::format("{}: attributes worldToCamera and worldToNDC contradict each other: the "
                                 "camera would look backwards",
                                 file_name)};
    set_depth_row(camera.projection);
    return std::optional<Camera>(camera);
}

} // namespace sfumato::media
