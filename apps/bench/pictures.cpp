// A PNG writer of stored blocks: larger than compressed, but needs nothing. PNG and zlib (RFC 1950, 1951) as specified.
#include "apps/bench/pictures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string_view>
#include <vector>

namespace sfumato::bench {
namespace {

using Bytes = std::vector<uint8_t>;

void put_32(Bytes& bytes, uint32_t value) {
    for (int shift = 24; shift >= 0; shift -= 8)
        bytes.push_back(static_cast<uint8_t>(value >> shift));
}

uint32_t crc_32(const uint8_t* data, size_t size) {
    static const auto table = [] {
        std::array<uint32_t, 256> entries{};
        for (uint32_t i = 0; i < 256; ++i) {
            uint32_t c = i;
            for (int bit = 0; bit < 8; ++bit)
                c = (c & 1u) ? 0xedb88320u ^ (c >> 1) : c >> 1;
            entries[i] = c;
        }
        return entries;
    }();
    uint32_t crc = ~0u;
    for (size_t i = 0; i < size; ++i)
        crc = table[(crc ^ data[i]) & 0xffu] ^ (crc >> 8);
    return ~crc;
}

void put_chunk(Bytes& png, std::string_view type, const Bytes& data) {
    put_32(png, static_cast<uint32_t>(data.size()));
    const size_t start = png.size();
    png.insert(png.end(), type.begin(), type.end());
    png.insert(png.end(), data.begin(), data.end());
    put_32(png, crc_32(png.data() + start, png.size() - start));
}

Bytes stored_zlib(const Bytes& data) {
    Bytes result = {0x78, 0x01};
    uint32_t a = 1, b = 0; // Adler-32
    for (size_t begin = 0; begin < data.size(); begin += 65535) {
        const size_t size = std::min<size_t>(65535, data.size() - begin);
        const auto length = static_cast<uint32_t>(size);
        result.push_back(begin + size == data.size() ? 1 : 0);
        for (const uint32_t value : {length, ~length}) {
            result.push_back(static_cast<uint8_t>(value));
            result.push_back(static_cast<uint8_t>(value >> 8));
        }
        for (size_t i = begin; i < begin + size; ++i) {
            result.push_back(data[i]);
            a = (a + data[i]) % 65521;
            b = (b + a) % 65521;
        }
    }
    put_32(result, b << 16 | a);
    return result;
}

uint8_t to_byte(float value) {
    return static_cast<uint8_t>(std::lround(std::isnan(value) ? 0.0f : std::clamp(value, 0.0f, 1.0f) * 255.0f));
}

} // namespace

Result<void> write_png(const std::string& path, const media::Planes& encoded) {
    const auto width = static_cast<size_t>(encoded.width), height = static_cast<size_t>(encoded.height);
    Bytes rows;
    rows.reserve(height * (1 + 3 * width));
    for (size_t y = 0; y < height; ++y) {
        rows.push_back(0); // no filter
        for (size_t x = 0; x < width; ++x)
            for (size_t c = 0; c < 3; ++c)
                rows.push_back(to_byte(encoded.channels[std::min(c, encoded.channels.size() - 1)][y * width + x]));
    }
    Bytes png = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    Bytes header;
    put_32(header, static_cast<uint32_t>(width));
    put_32(header, static_cast<uint32_t>(height));
    header.insert(header.end(), {8, 2, 0, 0, 0}); // 8 bits, RGB, deflate, no interlace
    put_chunk(png, "IHDR", header);
    put_chunk(png, "sRGB", {0});
    put_chunk(png, "IDAT", stored_zlib(rows));
    put_chunk(png, "IEND", {});
    std::FILE* file = std::fopen(path.c_str(), "wb");
    const bool written = file != nullptr && std::fwrite(png.data(), 1, png.size(), file) == png.size();
    const bool closed = file != nullptr && std::fclose(file) == 0;
    if (written && closed)
        return {};
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
    return Error{ErrorCode::input, path + ": cannot be written"};
}

Result<void> make_picture_folder(const std::string& path) {
    std::error_code failed;
    if (!path.empty())
        std::filesystem::create_directories(path, failed);
    if (failed)
        return Error{ErrorCode::input, path + ": cannot be made a folder for pictures"};
    return {};
}

} // namespace sfumato::bench
