// Walks the tables of chunk offsets and the first bytes of every chunk: a truncated file is known as such, with how
// much is missing, before a pixel is allocated, and a header cannot promise more than the file's size can hold.
#include "exr_chunks.h"

#include <algorithm>
#include <string_view>

#include <fmt/format.h>

#include "exr_streams.h"

namespace sfumato::media {

namespace {

struct Method {
    std::string_view name;
    uint32_t lines;      // scan lines in a chunk
    uint64_t best_ratio; // of uncompressed to compressed bytes, rounded up generously; 0: no bound known
};

constexpr Method methods[] = {
    {"none", 1, 1},      {"rle", 1, 100}, {"zips", 1, 1100}, {"zip", 16, 1100}, {"piz", 32, 0},
    {"pxr24", 16, 2200}, {"b44", 32, 3},  {"b44a", 32, 12},  {"dwaa", 32, 0},   {"dwab", 256, 0},
};

const Method& method_of(const ExrPart& part) {
    for (const Method& method : methods)
        if (method.name == part.compression)
            return method;
    return methods[0];
}

uint64_t divide_up(uint64_t a, uint64_t b) {
    return (a + b - 1) / b;
}

uint64_t level_size(uint64_t size, unsigned level, bool round_up) {
    const uint64_t divided = round_up ? divide_up(size, uint64_t{1} << level) : size >> level;
    return std::max<uint64_t>(1, divided);
}

unsigned level_count(uint64_t size, bool round_up) {
    unsigned levels = 1;
    while (level_size(size, levels - 1, round_up) > 1)
        ++levels;
    return levels;
}

uint64_t tile_count(const ExrPart& part, const ExrTiling& tiling) {
    const auto width = static_cast<uint64_t>(part.width()), height = static_cast<uint64_t>(part.height());
    auto tiles = [&](unsigned x_level, unsigned y_level) {
        return divide_up(level_size(width, x_level, tiling.round_up), tiling.width) *
               divide_up(level_size(height, y_level, tiling.round_up), tiling.height);
    };
    if (tiling.level_mode == 0)
        return tiles(0, 0);
    uint64_t count = 0;
    if (tiling.level_mode == 1) {
        const unsigned levels = level_count(std::max(width, height), tiling.round_up);
        for (unsigned level = 0; level < levels; ++level)
            count += tiles(level, level);
        return count;
    }
    for (unsigned y = 0; y < level_count(height, tiling.round_up); ++y)
        for (unsigned x = 0; x < level_count(width, tiling.round_up); ++x)
            count += tiles(x, y);
    return count;
}

uint64_t chunk_count(const ExrPart& part, const ExrTiling& tiling) {
    if (part.type == "tiledimage")
        return tile_count(part, tiling);
    return divide_up(static_cast<uint64_t>(part.height()), method_of(part).lines);
}

uint64_t bytes_per_pixel(const ExrPart& part) {
    uint64_t bytes = 0;
    for (const ExrChannel& channel : part.channels)
        bytes += channel.type == PixelType::half ? 2 : 4;
    return bytes;
}

class ChunkCheck {
  public:
    ChunkCheck(const InputFile& file, const ExrScan& scan) : file_(file), scan_(scan) {}

    Result<void> check_promise(const std::vector<int64_t>& stated_counts);
    Result<void> check_table(uint64_t position, size_t part);
    uint64_t count(size_t part) const { return counts_[part]; }

  private:
    Error error(const std::string& what) const {
        return Error{ErrorCode::input, fmt::format("{}: {}", file_.path().string(), one_line(what))};
    }
    Error missing(size_t part, uint64_t present) const;
    bool chunk_is_whole(uint64_t offset, size_t part) const;

    const InputFile& file_;
    const ExrScan& scan_;
    std::vector<uint64_t> counts_;
};

Result<void> ChunkCheck::check_promise(const std::vector<int64_t>& stated_counts) {
    uint64_t least = 0;
    for (size_t i = 0; i < scan_.parts.size(); ++i) {
        const ExrPart& part = scan_.parts[i];
        const uint64_t count = chunk_count(part, scan_.tilings[i]);
        if (stated_counts[i] >= 0 && static_cast<uint64_t>(stated_counts[i]) != count)
            return error(
                fmt::format("broken header: {} chunks are stated where the windows need {}", stated_counts[i], count));
        if (scan_.multi_part && stated_counts[i] < 0)
            return error("broken header: attribute 'chunkCount' is missing");
        const Method& method = method_of(part);
        // OpenEXR holds the lines of a chunk in one buffer that it counts in 31 bits.
        if (part.type != "tiledimage" &&
            static_cast<uint64_t>(part.width()) * bytes_per_pixel(part) * method.lines > uint64_t{0x7fffffff})
            return error(fmt::format("lines of {} pixels with {} channels are too long for {} compression",
                                     part.width(), part.channels.size(), part.compression));
        const uint64_t raw = part.pixel_count() * bytes_per_pixel(part);
        least += count * 16 + (method.best_ratio > 0 ? raw / method.best_ratio : 0);
        counts_.push_back(count);
    }
    if (least > file_.size()) {
        const ExrPart& part = scan_.parts.front();
        return error(
            fmt::format("truncated: the header promises {}x{} pixels in {} channels, at least {} bytes, but the "
                        "file has {}",
                        part.width(), part.height(), part.channels.size(), least, file_.size()));
    }
    return {};
}

Error ChunkCheck::missing(size_t part, uint64_t present) const {
    const std::string where = scan_.multi_part ? fmt::format(" of part {} '{}'", part, scan_.parts[part].name) : "";
    return error(fmt::format("truncated or incomplete: only {} of {} chunks{} lie whole within the file's {} bytes",
                             present, counts_[part], where, file_.size()));
}

bool ChunkCheck::chunk_is_whole(uint64_t offset, size_t part) const {
    const bool tiled = scan_.parts[part].type == "tiledimage";
    const size_t header = (scan_.multi_part ? 4u : 0u) + (tiled ? 16u : 4u) + 4u;
    char bytes[24] = {};
    if (offset == 0 || file_.read_at(offset, bytes, header) != header)
        return false;
    const int32_t size = load_i32(bytes + header - 4);
    return size >= 0 && static_cast<uint64_t>(size) <= file_.size() - offset - header;
}

Result<void> ChunkCheck::check_table(uint64_t position, size_t part) {
    uint64_t whole = 0;
    std::vector<char> block(size_t{1} << 16);
    for (uint64_t done = 0; done < counts_[part];) {
        const uint64_t entries = std::min<uint64_t>(counts_[part] - done, block.size() / 8);
        const size_t bytes = static_cast<size_t>(entries) * 8;
        if (file_.read_at(position + done * 8, block.data(), bytes) != bytes)
            return error(fmt::format("truncated within the table of chunks ({} bytes)", file_.size()));
        for (size_t i = 0; i < bytes; i += 8)
            whole += chunk_is_whole(load_u64(&block[i]), part) ? 1 : 0;
        done += entries;
    }
    if (whole < counts_[part])
        return missing(part, whole);
    return {};
}

} // namespace

Result<void> check_chunks(const InputFile& file, uint64_t table_position, const ExrScan& scan,
                          const std::vector<int64_t>& stated_counts) {
    ChunkCheck check(file, scan);
    if (auto checked = check.check_promise(stated_counts); !checked)
        return checked;
    for (size_t part = 0; part < scan.parts.size(); ++part) {
        if (auto checked = check.check_table(table_position, part); !checked)
            return checked;
        table_position += check.count(part) * 8;
    }
    return {};
}

} // namespace sfumato::media
