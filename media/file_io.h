// Files as the media layer needs them: positioned reads that never trust a size, and writes that appear under their
// final name whole or not at all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "sfumato/result.h"

namespace sfumato::media {

// A regular file opened for reading. Its size is taken once, at opening.
class InputFile {
  public:
    static Result<InputFile> open(const std::filesystem::path& path);
    InputFile(InputFile&& other) noexcept;
    InputFile& operator=(InputFile&& other) noexcept;
    ~InputFile();

    uint64_t size() const { return size_; }
    const std::filesystem::path& path() const { return path_; }

    // Reads up to `count` bytes at `offset`; returns how many there were (0 at the end or after a read error).
    size_t read_at(uint64_t offset, void* bytes, size_t count) const;

  private:
    InputFile(std::filesystem::path path, int descriptor, uint64_t size);

    std::filesystem::path path_;
    int descriptor_ = -1;
    uint64_t size_ = 0;
};

// The whole of a file of at most `limit` bytes.
Result<std::vector<char>> read_whole_file(const std::filesystem::path& path, uint64_t limit);

struct AtomicFileOptions {
    bool no_clobber = false; // an existing target is an error and stays as it was
    bool sync = true;        // wait for the disk before renaming
};

// A file written under a hidden temporary name beside its target. commit() gives it the final name; without a
// successful commit() the destructor removes the temporary, so that a failure leaves nothing behind.
class AtomicFile {
  public:
    static Result<AtomicFile> create(const std::filesystem::path& target, const AtomicFileOptions& options);
    AtomicFile(AtomicFile&& other) noexcept;
    AtomicFile& operator=(AtomicFile&&) = delete;
    ~AtomicFile();

    // Both return false on failure; commit() then reports the first failure.
    bool write(const void* bytes, size_t count);
    bool seek(uint64_t position);
    uint64_t position() const { return position_; }
    Result<void> commit();

    const std::filesystem::path& temporary_path() const { return temporary_; }
    // What went wrong first, as errno; 0 while nothing did.
    int failure() const { return failure_; }
    Error failure_error() const;

  private:
    AtomicFile() = default;
    bool fail(const char* action);
    bool take_final_name();

    std::filesystem::path target_;   // as the caller named it, for messages
    std::filesystem::path resolved_; // the same with links followed
    std::filesystem::path temporary_;
    AtomicFileOptions options_;
    int descriptor_ = -1;
    uint64_t position_ = 0;
    int failure_ = 0;
    const char* failed_action_ = "";
};

// "No such file or directory" and the like.
std::string errno_text(int code);

} // namespace sfumato::media
