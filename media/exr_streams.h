// OpenEXR's streams on this layer's files, and its exceptions as errors. Internal: the only place besides exr_read.cpp
// and exr_write.cpp that knows OpenEXR.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include <Iex.h>
#include <ImfIO.h>

#include "file_io.h"

namespace sfumato::media {

class ExrInputStream : public Imf::IStream {
  public:
    explicit ExrInputStream(const InputFile& file) : Imf::IStream(file.path().string().c_str()), file_(file) {}

    bool read(char bytes[], int count) override {
        if (count < 0 || file_.read_at(position_, bytes, static_cast<size_t>(count)) != static_cast<size_t>(count))
            throw IEX_NAMESPACE::InputExc("unexpected end of file");
        position_ += static_cast<uint64_t>(count);
        return position_ < file_.size();
    }
    uint64_t tellg() override { return position_; }
    void seekg(uint64_t position) override { position_ = position; }
    void clear() override {}

  private:
    const InputFile& file_;
    uint64_t position_ = 0;
};

class ExrOutputStream : public Imf::OStream {
  public:
    ExrOutputStream(AtomicFile& file, const char* name) : Imf::OStream(name), file_(file) {}

    void write(const char bytes[], int count) override {
        if (count < 0 || !file_.write(bytes, static_cast<size_t>(count)))
            throw IEX_NAMESPACE::IoExc("write failed");
    }
    uint64_t tellp() override { return file_.position(); }
    void seekp(uint64_t position) override {
        if (!file_.seek(position))
            throw IEX_NAMESPACE::IoExc("seek failed");
    }

  private:
    AtomicFile& file_;
};

// Bytes in memory, for attributes.
class ExrMemoryStream : public Imf::IStream {
  public:
    explicit ExrMemoryStream(const std::vector<char>& bytes) : Imf::IStream("memory"), bytes_(bytes) {}

    bool read(char out[], int count) override {
        if (count < 0 || static_cast<size_t>(count) > bytes_.size() - position_)
            throw IEX_NAMESPACE::InputExc("attribute is too short");
        if (count > 0)
            std::memcpy(out, bytes_.data() + position_, static_cast<size_t>(count));
        position_ += static_cast<size_t>(count);
        return position_ < bytes_.size();
    }
    uint64_t tellg() override { return position_; }
    void seekg(uint64_t position) override { position_ = std::min(static_cast<size_t>(position), bytes_.size()); }

  private:
    const std::vector<char>& bytes_;
    size_t position_ = 0;
};

// OpenEXR's messages may span lines, and names in a broken file hold anything: an error of this layer is one line
// without control characters, which a terminal would obey.
inline std::string one_line(const std::string& text) {
    std::string line;
    for (const char c : text)
        line += (c >= 0 && c < ' ') || c == '\x7f' ? ' ' : c;
    while (!line.empty() && (line.back() == ' ' || line.back() == '.'))
        line.pop_back();
    return line;
}

// Makes sure that OpenEXR's pool has at least that many threads.
void use_exr_threads(int threads);

} // namespace sfumato::media
