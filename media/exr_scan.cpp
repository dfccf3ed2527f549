// Header and chunk-table scan, after the file layout that the OpenEXR project documents.
#include "exr_scan.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <string_view>

#include <fmt/format.h>

#include "exr_chunks.h"
#include "exr_streams.h"

namespace sfumato::media {

uint32_t load_u32(const char* bytes) {
    uint32_t value = 0;
    for (unsigned i = 0; i < 4; ++i)
        value |= uint32_t{static_cast<unsigned char>(bytes[i])} << (8 * i);
    return value;
}

uint64_t load_u64(const char* bytes) {
    return load_u32(bytes) | (uint64_t{load_u32(bytes + 4)} << 32);
}

int32_t load_i32(const char* bytes) {
    return std::bit_cast<int32_t>(load_u32(bytes));
}

float load_f32(const char* bytes) {
    return std::bit_cast<float>(load_u32(bytes));
}

double load_f64(const char* bytes) {
    return std::bit_cast<double>(load_u64(bytes));
}

namespace {

constexpr uint32_t magic_number = 20000630;
constexpr uint32_t flag_tiled = 0x200;
constexpr uint32_t flag_deep = 0x800;
constexpr uint32_t flag_multi_part = 0x1000;
constexpr uint32_t known_flags = 0x200 | 0x400 | 0x800 | 0x1000;

struct FixedSize {
    std::string_view type;
    size_t size;
};

// OpenEXR reads these by type and not by the stated size; where the two differ it would see another header than this
// scan did.
constexpr FixedSize fixed_sizes[] = {
    {"box2i", 16},      {"box2f", 16},   {"chromaticities", 32},
    {"compression", 1}, {"double", 8},   {"envmap", 1},
    {"float", 4},       {"int", 4},      {"keycode", 28},
    {"lineOrder", 1},   {"m33f", 36},    {"m33d", 72},
    {"m44f", 64},       {"m44d", 128},   {"rational", 8},
    {"tiledesc", 9},    {"timecode", 8}, {"v2i", 8},
    {"v2f", 8},         {"v2d", 16},     {"v3i", 12},
    {"v3f", 12},        {"v3d", 24},     {"deepImageState", 1},
};

constexpr const char* compression_names[] = {"none",  "rle", "zips", "zip",  "piz",
                                             "pxr24", "b44", "b44a", "dwaa", "dwab"};

// Reads forward through the file a block at a time. Running past the end sets `ended` and yields zeros.
class Cursor {
  public:
    Cursor(const InputFile& file, uint64_t limit) : file_(file), limit_(limit) {}

    bool bytes(size_t count, std::vector<char>& out) {
        if (count > file_.size() - std::min(file_.size(), position_))
            return fail();
        if (count > limit_ - std::min(limit_, position_))
            return too_long_ = true, false;
        out.resize(count);
        if (file_.read_at(position_, out.data(), count) != count)
            return fail();
        position_ += count;
        return true;
    }
    uint32_t u32() {
        std::vector<char> four;
        return bytes(4, four) ? load_u32(four.data()) : 0;
    }
    char peek() {
        char value = 0;
        if (file_.read_at(position_, &value, 1) != 1)
            fail();
        return value;
    }
    void skip() { ++position_; }
    // A name that ends with a zero byte; false if it is longer than `longest`.
    bool name(size_t longest, std::string& out) {
        char block[257] = {};
        const size_t got = file_.read_at(position_, block, longest + 1);
        const size_t length = static_cast<size_t>(std::find(block, block + got, '\0') - block);
        if (length == got)
            return got < longest + 1 ? fail() : false;
        out.assign(block, length);
        position_ += length + 1;
        return true;
    }
    uint64_t position() const { return position_; }
    bool ended() const { return ended_; }
    bool too_long() const { return too_long_; }

  private:
    bool fail() {
        ended_ = true;
        return false;
    }
    const InputFile& file_;
    uint64_t limit_;
    uint64_t position_ = 0;
    bool ended_ = false;
    bool too_long_ = false;
};

class Scanner {
  public:
    Scanner(const InputFile& file, const ExrLimits& limits)
        : file_(file), limits_(limits), cursor_(file, limits.max_header) {}

    Result<ExrScan> run();

  private:
    Error broken(const std::string& what) const {
        return Error{ErrorCode::input, fmt::format("{}: broken header: {}", file_.path().string(), one_line(what))};
    }
    Error refused(const std::string& what) const {
        return Error{ErrorCode::input, fmt::format("{}: {}", file_.path().string(), one_line(what))};
    }
    Error unsupported(const std::string& what) const {
        return Error{ErrorCode::unsupported, fmt::format("{}: {}", file_.path().string(), one_line(what))};
    }
    Error stopped(const char* where) const;
    Result<void> read_header();
    Result<void> read_attribute(ExrPart& part, ExrTiling& tiling);
    Result<void> take_attribute(ExrPart& part, ExrTiling& tiling, ExrAttribute attribute);
    Result<void> check_size(const ExrAttribute& attribute) const;
    Result<void> take_channels(ExrPart& part, const std::vector<char>& bytes) const;
    Result<void> check_part(const ExrPart& part, const ExrTiling& tiling) const;
    Result<void> check_total() const;

    const InputFile& file_;
    const ExrLimits& limits_;
    Cursor cursor_;
    ExrScan scan_;
    std::vector<std::string> seen_; // structural attributes of the header being read
    uint32_t flags_ = 0;
    int64_t chunk_count_ = -1;
    std::vector<int64_t> chunk_counts_;
};

Error Scanner::stopped(const char* where) const {
    if (cursor_.too_long())
        return refused(fmt::format("headers longer than the limit of {} bytes", limits_.max_header));
    return refused(fmt::format("truncated within the {} ({} bytes)", where, file_.size()));
}

Result<void> Scanner::take_channels(ExrPart& part, const std::vector<char>& bytes) const {
    size_t at = 0;
    while (at < bytes.size() && bytes[at] != '\0') {
        const auto end = std::find(bytes.begin() + static_cast<ptrdiff_t>(at), bytes.end(), '\0');
        const size_t length = static_cast<size_t>(end - bytes.begin()) - at;
        if (end == bytes.end() || length > 255 || bytes.size() - at - length - 1 < 16)
            return broken("the channel list does not end");
        ExrChannel channel;
        channel.name.assign(bytes.data() + at, length);
        const char* fields = bytes.data() + at + length + 1;
        const uint32_t type = load_u32(fields);
        const int32_t x_sampling = load_i32(fields + 8), y_sampling = load_i32(fields + 12);
        if (type > 2)
            return broken(fmt::format("channel '{}' has pixel type {}; 0, 1 or 2 are known", channel.name, type));
        if (x_sampling != 1 || y_sampling != 1)
            return unsupported(fmt::format("channel '{}' is sub-sampled {}x{}; convert the file to full-resolution RGB",
                                           channel.name, x_sampling, y_sampling));
        channel.type = static_cast<PixelType>(type);
        channel.perceptually_linear = fields[4] != 0;
        for (const ExrChannel& other : part.channels)
            if (other.name == channel.name)
                return broken(fmt::format("channel '{}' occurs twice", channel.name));
        part.channels.push_back(std::move(channel));
        if (part.channels.size() > limits_.max_channels)
            return refused(fmt::format("more than the limit of {} channels in one part", limits_.max_channels));
        at += length + 17;
    }
    if (at + 1 != bytes.size())
        return broken("the channel list does not end");
    if (part.channels.empty())
        return refused("a part without channels");
    return {};
}

Result<void> Scanner::check_size(const ExrAttribute& attribute) const {
    const auto& [name, type, bytes] = attribute;
    for (const FixedSize& fixed : fixed_sizes)
        if (type == fixed.type && bytes.size() != fixed.size)
            return broken(fmt::format("attribute '{}' of type {} has {} bytes in place of {}", name, type, bytes.size(),
                                      fixed.size));
    bool good = true;
    if (type == "floatvector") {
        good = bytes.size() % 4 == 0;
    } else if (type == "stringvector") {
        size_t at = 0;
        while (good && at < bytes.size()) {
            good = bytes.size() - at >= 4 && load_i32(&bytes[at]) >= 0 && load_u32(&bytes[at]) <= bytes.size() - at - 4;
            at += good ? 4 + load_u32(&bytes[at]) : 0;
        }
    } else if (type == "preview") {
        good = bytes.size() >= 8 && uint64_t{load_u32(&bytes[0])} * load_u32(&bytes[4]) == (bytes.size() - 8) / 4 &&
               bytes.size() % 4 == 0;
    }
    if (!good)
        return broken(fmt::format("attribute '{}' of type {} does not fit its {} bytes", name, type, bytes.size()));
    return {};
}

Window load_window(const std::vector<char>& bytes) {
    return {load_i32(&bytes[0]), load_i32(&bytes[4]), load_i32(&bytes[8]), load_i32(&bytes[12])};
}

Result<void> Scanner::take_attribute(ExrPart& part, ExrTiling& tiling, ExrAttribute attribute) {
    const auto& [name, type, bytes] = attribute;
    auto is = [&attribute](std::string_view a, std::string_view b) {
        return attribute.name == a && attribute.type == b;
    };
    bool structural = true;
    if (is("channels", "chlist")) {
        part.channels.clear();
        if (auto taken = take_channels(part, bytes); !taken)
            return taken;
    } else if (is("compression", "compression")) {
        const size_t index = static_cast<unsigned char>(bytes[0]);
        if (index >= std::size(compression_names))
            return unsupported(fmt::format("compression method {} is unknown", index));
        part.compression = compression_names[index];
    } else if (is("dataWindow", "box2i")) {
        part.data_window = load_window(bytes);
    } else if (is("displayWindow", "box2i")) {
        part.display_window = load_window(bytes);
    } else if (is("pixelAspectRatio", "float")) {
        part.pixel_aspect = load_f32(bytes.data());
    } else if (is("screenWindowCenter", "v2f")) {
        part.screen_window_centre = {load_f32(&bytes[0]), load_f32(&bytes[4])};
    } else if (is("screenWindowWidth", "float")) {
        part.screen_window_width = load_f32(bytes.data());
    } else if (is("name", "string")) {
        part.name.assign(bytes.begin(), bytes.end());
    } else if (is("type", "string")) {
        part.type.assign(bytes.begin(), bytes.end());
    } else if (is("tiles", "tiledesc")) {
        const int mode = static_cast<unsigned char>(bytes[8]);
        tiling = {load_u32(&bytes[0]), load_u32(&bytes[4]), mode & 15, (mode >> 4) != 0};
    } else if (is("chunkCount", "int")) {
        chunk_count_ = load_i32(bytes.data());
    } else if (!is("lineOrder", "lineOrder") && !is("version", "int")) {
        structural = false;
    }
    if (!structural) {
        part.attributes.push_back(std::move(attribute));
        return {};
    }
    if (std::find(seen_.begin(), seen_.end(), name) != seen_.end())
        return broken(fmt::format("attribute '{}' occurs twice", name));
    seen_.push_back(name);
    return {};
}

Result<void> Scanner::read_attribute(ExrPart& part, ExrTiling& tiling) {
    ExrAttribute attribute;
    if (!cursor_.name(255, attribute.name) || !cursor_.name(255, attribute.type)) {
        if (cursor_.ended())
            return stopped("header");
        return broken("a name of more than 255 bytes");
    }
    const int64_t size = static_cast<int32_t>(cursor_.u32());
    if (cursor_.ended() || cursor_.too_long())
        return stopped("header");
    if (size < 0)
        return broken(fmt::format("attribute '{}' has {} bytes", attribute.name, size));
    if (!cursor_.bytes(static_cast<size_t>(size), attribute.bytes))
        return stopped("header");
    if (auto checked = check_size(attribute); !checked)
        return checked;
    static constexpr std::string_view structural[][2] = {
        {"channels", "chlist"},
        {"compression", "compression"},
        {"dataWindow", "box2i"},
        {"displayWindow", "box2i"},
        {"lineOrder", "lineOrder"},
        {"pixelAspectRatio", "float"},
        {"screenWindowCenter", "v2f"},
        {"screenWindowWidth", "float"},
        {"tiles", "tiledesc"},
        {"name", "string"},
        {"type", "string"},
        {"chunkCount", "int"},
        {"version", "int"},
    };
    for (const auto& [name, type] : structural)
        if (attribute.name == name && attribute.type != type)
            return broken(fmt::format("attribute '{}' has type '{}' in place of '{}'", name, attribute.type, type));
    return take_attribute(part, tiling, std::move(attribute));
}

Result<void> Scanner::check_part(const ExrPart& part, const ExrTiling& tiling) const {
    for (const char* needed : {"channels", "compression", "dataWindow", "displayWindow"})
        if (std::find(seen_.begin(), seen_.end(), needed) == seen_.end())
            return broken(fmt::format("attribute '{}' is missing", needed));
    if ((flags_ & flag_deep) != 0 || part.type.starts_with("deep"))
        return unsupported("deep data (several samples a pixel) is not supported; flatten the file first");
    if (!part.type.empty() && part.type != "scanlineimage" && part.type != "tiledimage")
        return unsupported(fmt::format("parts of type '{}' are not supported", part.type));
    const int64_t width = part.width(), height = part.height();
    if (width < 1 || height < 1)
        return broken(fmt::format("the data window has {}x{} pixels", width, height));
    const uint64_t pixels = static_cast<uint64_t>(width) * static_cast<uint64_t>(height);
    if (pixels > limits_.max_pixels)
        return refused(fmt::format("{}x{} pixels ({} megapixels) exceed the limit of {} megapixels", width, height,
                                   pixels / 1000000, limits_.max_pixels / 1000000));
    if (static_cast<uint64_t>(std::max(width, height)) > limits_.max_side)
        return refused(
            fmt::format("{}x{} pixels exceed the limit of {} pixels a side", width, height, limits_.max_side));
    const Window& display = part.display_window;
    if (display.width() < 1 || display.height() < 1)
        return broken(fmt::format("the display window has {}x{} pixels", display.width(), display.height()));
    // OpenEXR computes with window corners in 32 bits.
    for (const Window& window : {part.data_window, display})
        if (std::min({window.min_x, window.min_y}) < -(1 << 30) || std::max({window.max_x, window.max_y}) > 1 << 30)
            return refused("a window that lies more than 2^30 pixels from the origin");
    const bool tiled = part.type == "tiledimage" || (part.type.empty() && (flags_ & flag_tiled) != 0);
    if (!tiled)
        return {};
    if (tiling.width < 1 || tiling.height < 1 || tiling.level_mode > 2)
        return broken(fmt::format("tiles of {}x{} pixels", tiling.width, tiling.height));
    const int64_t side = std::max<int64_t>(4096, std::max(width, height));
    if (tiling.width > side || tiling.height > side ||
        uint64_t{tiling.width} * tiling.height * part.channels.size() > uint64_t{1} << 28)
        return refused(fmt::format("tiles of {}x{} pixels are too large", tiling.width, tiling.height));
    return {};
}

Result<void> Scanner::check_total() const {
    uint64_t memory = 0;
    for (const ExrPart& part : scan_.parts)
        memory += uint64_t{4} * part.pixel_count() * part.channels.size();
    if (memory > limits_.max_memory)
        return refused(fmt::format("{} MiB of decoded channels exceed the limit of {} MiB", memory >> 20,
                                   limits_.max_memory >> 20));
    return {};
}

Result<void> Scanner::read_header() {
    ExrPart part;
    ExrTiling tiling;
    seen_.clear();
    chunk_count_ = -1;
    while (cursor_.peek() != '\0') {
        if (auto read = read_attribute(part, tiling); !read)
            return read;
    }
    if (cursor_.ended())
        return stopped("header");
    cursor_.skip();
    if (auto checked = check_part(part, tiling); !checked)
        return checked;
    if (!scan_.multi_part || part.type.empty())
        part.type = (flags_ & flag_tiled) != 0 || part.type == "tiledimage" ? "tiledimage" : "scanlineimage";
    scan_.parts.push_back(std::move(part));
    scan_.tilings.push_back(tiling);
    chunk_counts_.push_back(chunk_count_);
    return {};
}

Result<ExrScan> Scanner::run() {
    const uint32_t magic = cursor_.u32(), version = cursor_.u32();
    if (file_.size() == 0)
        return refused("truncated: the file is empty");
    if (magic != magic_number)
        return refused("not an OpenEXR file");
    if (cursor_.ended())
        return stopped("header");
    flags_ = version & ~0xffu;
    if ((version & 0xff) != 2 || (flags_ & ~known_flags) != 0)
        return unsupported(
            fmt::format("OpenEXR file format version {} with flags {:#x} is unknown", version & 0xff, flags_));
    scan_.multi_part = (flags_ & flag_multi_part) != 0;
    do {
        if (auto read = read_header(); !read)
            return read.error();
        if (scan_.parts.size() > limits_.max_parts)
            return refused(fmt::format("more than the limit of {} parts", limits_.max_parts));
    } while (scan_.multi_part && cursor_.peek() != '\0');
    if (cursor_.ended())
        return stopped("header");
    if (scan_.multi_part)
        cursor_.skip();
    if (auto checked = check_total(); !checked)
        return checked.error();
    if (auto checked = check_chunks(file_, cursor_.position(), scan_, chunk_counts_); !checked)
        return checked.error();
    return std::move(scan_);
}

} // namespace

Result<ExrScan> scan_exr(const InputFile& file, const ExrLimits& limits) {
    return Scanner(file, limits).run();
}

} // namespace sfumato::media
