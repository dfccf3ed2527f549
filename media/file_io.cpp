// POSIX files: pread for input; temporary, fsync and rename for output.
#include "file_io.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <fcntl.h>
#include <limits>
#include <new>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>
#include <utility>

#include <fmt/format.h>

namespace sfumato::media {

namespace fs = std::filesystem;

std::string errno_text(int code) {
    return std::generic_category().message(code);
}

// ---------------------------------------------------------------------------------------------------- input

InputFile::InputFile(fs::path path, int descriptor, uint64_t size)
    : path_(std::move(path)), descriptor_(descriptor), size_(size) {}

InputFile::InputFile(InputFile&& other) noexcept
    : path_(std::move(other.path_)), descriptor_(std::exchange(other.descriptor_, -1)), size_(other.size_) {}

InputFile& InputFile::operator=(InputFile&& other) noexcept {
    std::swap(path_, other.path_);
    std::swap(descriptor_, other.descriptor_);
    std::swap(size_, other.size_);
    return *this;
}

InputFile::~InputFile() {
    if (descriptor_ >= 0)
        ::close(descriptor_);
}

Result<InputFile> InputFile::open(const fs::path& path) {
    // O_NONBLOCK: opening a pipe that nobody writes to must not hang; it has no effect on regular files.
    const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (descriptor < 0)
        return Error{ErrorCode::input, fmt::format("{}: cannot open: {}", path.string(), errno_text(errno))};
    struct stat status = {};
    if (::fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode)) {
        ::close(descriptor);
        return Error{ErrorCode::input, fmt::format("{}: not a regular file", path.string())};
    }
    return InputFile(path, descriptor, static_cast<uint64_t>(status.st_size));
}

size_t InputFile::read_at(uint64_t offset, void* bytes, size_t count) const {
    if (offset >= size_)
        return 0;
    size_t done = 0;
    while (done < count) {
        const ssize_t got =
            ::pread(descriptor_, static_cast<char*>(bytes) + done, count - done, static_cast<off_t>(offset + done));
        if (got < 0 && errno == EINTR)
            continue;
        if (got <= 0)
            break;
        done += static_cast<size_t>(got);
    }
    return done;
}

Result<std::vector<char>> read_whole_file(const fs::path& path, uint64_t limit) {
    auto file = InputFile::open(path);
    if (!file)
        return file.error();
    if (file->size() > limit)
        return Error{ErrorCode::input,
                     fmt::format("{}: {} bytes exceed the limit of {} bytes", path.string(), file->size(), limit)};
    std::vector<char> bytes(static_cast<size_t>(file->size()));
    if (file->read_at(0, bytes.data(), bytes.size()) != bytes.size())
        return Error{ErrorCode::input, fmt::format("{}: cannot read all {} bytes", path.string(), bytes.size())};
    return bytes;
}

// --------------------------------------------------------------------------------------------------- output

AtomicFile::AtomicFile(AtomicFile&& other) noexcept
    : target_(std::move(other.target_)), resolved_(std::move(other.resolved_)),
      temporary_(std::exchange(other.temporary_, fs::path())), options_(other.options_),
      descriptor_(std::exchange(other.descriptor_, -1)), position_(other.position_), failure_(other.failure_),
      failed_action_(other.failed_action_) {}

AtomicFile::~AtomicFile() {
    if (descriptor_ >= 0)
        ::close(descriptor_);
    if (!temporary_.empty())
        ::unlink(temporary_.c_str());
}

namespace {

Error cannot_write(const fs::path& target, const std::string& why) {
    return Error{ErrorCode::input, fmt::format("{}: cannot write: {}", target.string(), why)};
}

// A name of its own for every file of every process that writes beside the target.
fs::path temporary_name(const fs::path& resolved, unsigned attempt) {
    static std::atomic<unsigned> counter = 0;
    // Long final names would exceed the file system's 255 bytes with the additions.
    const std::string stem = resolved.filename().string().substr(0, 200);
    return resolved.parent_path() / fmt::format(".{}.{}-{}-{}.tmp", stem, ::getpid(), counter++, attempt);
}

} // namespace

Result<AtomicFile> AtomicFile::create(const fs::path& target, const AtomicFileOptions& options) {
    AtomicFile file;
    file.target_ = target;
    file.options_ = options;
    // Writing through a link must replace what it points to, not the link.
    std::error_code failed;
    file.resolved_ = fs::is_symlink(target, failed) ? fs::weakly_canonical(target, failed) : target;
    if (failed)
        file.resolved_ = target;
    if (file.resolved_.filename().empty())
        return cannot_write(target, "the name of a file is needed");

    struct stat existing = {};
    const bool exists = ::stat(file.resolved_.c_str(), &existing) == 0;
    if (exists && S_ISDIR(existing.st_mode))
        return cannot_write(target, errno_text(EISDIR));
    // A rename would replace a device or pipe by a file.
    if (exists && !S_ISREG(existing.st_mode))
        return cannot_write(target, "not a regular file");
    if (exists && options.no_clobber)
        return cannot_write(target, "the file exists already and must not be overwritten");
    if (exists && ::access(file.resolved_.c_str(), W_OK) != 0)
        return cannot_write(target, errno_text(errno));

    for (unsigned attempt = 0; attempt < 100 && file.descriptor_ < 0; ++attempt) {
        const fs::path name = temporary_name(file.resolved_, attempt);
        file.descriptor_ = ::open(name.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (file.descriptor_ >= 0)
            file.temporary_ = name;
        else if (errno != EEXIST)
            return cannot_write(target, errno_text(errno));
    }
    if (file.descriptor_ < 0)
        return cannot_write(target, "no free temporary name beside it");
    if (exists && ::fchmod(file.descriptor_, existing.st_mode & 07777) != 0)
        return cannot_write(target, errno_text(errno));
    return file;
}

bool AtomicFile::fail(const char* action) {
    if (failure_ == 0) {
        failure_ = errno != 0 ? errno : EIO;
        failed_action_ = action;
    }
    return false;
}

Error AtomicFile::failure_error() const {
    return cannot_write(target_, fmt::format("{}{}{}", failed_action_, *failed_action_ ? ": " : "",
                                             errno_text(failure_ != 0 ? failure_ : EIO)));
}

bool AtomicFile::write(const void* bytes, size_t count) {
    if (failure_ != 0)
        return false;
    size_t done = 0;
    while (done < count) {
        const ssize_t put = ::pwrite(descriptor_, static_cast<const char*>(bytes) + done, count - done,
                                     static_cast<off_t>(position_ + done));
        if (put < 0 && errno == EINTR)
            continue;
        if (put <= 0)
            return fail("");
        done += static_cast<size_t>(put);
    }
    position_ += count;
    return true;
}

bool AtomicFile::seek(uint64_t position) {
    if (failure_ != 0 || position > static_cast<uint64_t>(std::numeric_limits<off_t>::max())) {
        errno = EFBIG;
        return fail("seek");
    }
    position_ = position;
    return true;
}

bool AtomicFile::take_final_name() {
    if (!options_.no_clobber) {
        if (::rename(temporary_.c_str(), resolved_.c_str()) != 0)
            return fail("rename");
        temporary_.clear();
        return true;
    }
    // link() fails where a file appeared meanwhile; rename() would replace it.
    if (::link(temporary_.c_str(), resolved_.c_str()) == 0)
        return true; // the destructor removes the second name
    if (errno == EEXIST)
        return fail("appeared meanwhile");
    // File systems without hard links: a last look, then rename.
    if (::access(resolved_.c_str(), F_OK) == 0) {
        errno = EEXIST;
        return fail("appeared meanwhile");
    }
    if (::rename(temporary_.c_str(), resolved_.c_str()) != 0)
        return fail("rename");
    temporary_.clear();
    return true;
}

Result<void> AtomicFile::commit() {
    if (failure_ != 0)
        return failure_error();
    if (options_.sync && ::fsync(descriptor_) != 0 && errno != EINVAL && errno != EROFS)
        fail("fsync");
    // Network file systems report a full disk here.
    if (::close(std::exchange(descriptor_, -1)) != 0 && failure_ == 0)
        fail("close");
    if (failure_ == 0)
        take_final_name();
    if (failure_ != 0)
        return failure_error();
    return {};
}

} // namespace sfumato::media
