// The bytes of a model: the file itself, those beside it, data URIs, and the chunks of a .glb.
#include "scene/gltf/load_parts.h"

#include <algorithm>
#include <cstring>
#include <fstream>

namespace sfumato::scene::gltf {
namespace {

int hexadecimal(char c) {
    if (c >= '0' && c <= '9')
        return c - '0';
    if (c >= 'a' && c <= 'f')
        return c - 'a' + 10;
    if (c >= 'A' && c <= 'F')
        return c - 'A' + 10;
    return -1;
}

std::string percent_decoded(std::string_view text) {
    std::string result;
    for (size_t i = 0; i < text.size(); ++i) {
        if (text[i] == '%' && i + 2 < text.size() && hexadecimal(text[i + 1]) >= 0 && hexadecimal(text[i + 2]) >= 0) {
            result += static_cast<char>(hexadecimal(text[i + 1]) * 16 + hexadecimal(text[i + 2]));
            i += 2;
        } else {
            result += text[i];
        }
    }
    return result;
}

int base64_digit(char c) {
    if (c >= 'A' && c <= 'Z')
        return c - 'A';
    if (c >= 'a' && c <= 'z')
        return c - 'a' + 26;
    if (c >= '0' && c <= '9')
        return c - '0' + 52;
    if (c == '+' || c == '-')
        return 62;
    return c == '/' || c == '_' ? 63 : -1;
}

Bytes base64_decoded(std::string_view text, const std::string& what) {
    while (!text.empty() && text.back() == '=')
        text.remove_suffix(1);
    Bytes result;
    result.reserve(text.size() / 4 * 3 + 3);
    uint32_t bits = 0, held = 0;
    for (const char c : text) {
        const int digit = base64_digit(c);
        require(digit >= 0, what + " has a data URI that is not base64");
        bits = (bits << 6 | static_cast<uint32_t>(digit)) & 0xffffffu;
        held += 6;
        if (held >= 8) {
            held -= 8;
            result.push_back(static_cast<uint8_t>(bits >> held & 0xffu));
        }
    }
    return result;
}

// For error messages: no control characters, not endless.
std::string shown(const std::string& uri) {
    std::string result = uri.substr(0, 100);
    for (char& c : result)
        if (static_cast<unsigned char>(c) < 32)
            c = '?';
    return "'" + result + (uri.size() > 100 ? "…'" : "'");
}

uint32_t word(std::span<const uint8_t> bytes, size_t at) {
    uint32_t value = 0;
    std::memcpy(&value, bytes.data() + at, 4);
    return value;
}

} // namespace

Files::Files(const std::filesystem::path& path, uint64_t limit) : left_(limit) {
    std::error_code error;
    folder_ = std::filesystem::weakly_canonical(std::filesystem::absolute(path).parent_path(), error);
    require(!error, "the folder cannot be read: " + error.message());
    main_ = read_file(path, "the file");
}

Bytes Files::read_file(const std::filesystem::path& path, const std::string& what) {
    std::error_code error;
    const auto status = std::filesystem::status(path, error);
    require(std::filesystem::exists(status), what + " does not exist");
    require(std::filesystem::is_regular_file(status), what + " is not a regular file");
    const uint64_t size = std::filesystem::file_size(path, error);
    require(!error, what + " cannot be read: " + error.message());
    require(size <= left_, what + " has " + std::to_string(size) + " bytes; all files together may have " +
                               std::to_string(left_) + " more");
    Bytes bytes(size);
    std::ifstream file(path, std::ios::binary);
    file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
    require(file.good() && static_cast<uint64_t>(file.gcount()) == size, what + " cannot be read");
    left_ -= size;
    return bytes;
}

Bytes Files::read(const std::string& uri, const std::string& what) {
    if (uri.starts_with("data:")) {
        const size_t comma = uri.find(',');
        require(comma != std::string::npos && std::string_view(uri).substr(0, comma).ends_with(";base64"),
                what + " has a data URI that is not base64");
        return base64_decoded(std::string_view(uri).substr(comma + 1), what);
    }
    const std::string name = percent_decoded(uri);
    const std::string named = what + " names the file " + shown(name) + ", which ";
    require(name.find("://") == std::string::npos, named + "is elsewhere; only files in the model's folder are read");
    require(!name.empty() && name.find('\0') == std::string::npos, named + "is no file name");
    std::error_code error;
    const auto path = std::filesystem::weakly_canonical(folder_ / name, error);
    require(!error, named + "cannot be found: " + error.message());
    const auto relative = path.lexically_relative(folder_);
    require(!relative.empty() && *relative.begin() != "..",
            named + "is outside of the model's folder; only files in it are read");
    return read_file(path, what + "'s file " + shown(name));
}

Container open_container(std::span<const uint8_t> bytes) {
    require(!bytes.empty(), "the file is empty");
    constexpr uint32_t magic = 0x46546c67, json_chunk = 0x4e4f534a, binary_chunk = 0x004e4942;
    if (bytes.size() < 4 || word(bytes, 0) != magic) // a .gltf
        return {{reinterpret_cast<const char*>(bytes.data()), bytes.size()}, {}};
    require(bytes.size() >= 20, "the .glb ends within its header");
    require(word(bytes, 4) == 2, "the .glb has version " + std::to_string(word(bytes, 4)) + "; only 2 is known");
    require(word(bytes, 8) <= bytes.size(), "the .glb is cut off: it has " + std::to_string(bytes.size()) +
                                                " bytes, its header says " + std::to_string(word(bytes, 8)));
    require(word(bytes, 8) >= 20, "the .glb's header gives a length of " + std::to_string(word(bytes, 8)));
    bytes = bytes.first(word(bytes, 8));
    Container result;
    for (size_t at = 12; bytes.size() - at >= 8;) {
        const uint32_t size = word(bytes, at), type = word(bytes, at + 4);
        require(size <= bytes.size() - at - 8, "a chunk of the .glb reaches beyond the file's end");
        const auto chunk = bytes.subspan(at + 8, size);
        if (at == 12) {
            require(type == json_chunk, "the .glb's first chunk is not JSON");
            result.json = {reinterpret_cast<const char*>(chunk.data()), chunk.size()};
        } else if (type == binary_chunk && result.binary.empty()) {
            result.binary = chunk;
        }
        at += 8 + size_t{size};
    }
    return result;
}

} // namespace sfumato::scene::gltf
