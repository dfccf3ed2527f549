// A temporary directory for tests of files, and the shared data.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

namespace sfumato::media::test {

class TemporaryDirectory {
  public:
    TemporaryDirectory() {
        std::string name = (std::filesystem::temp_directory_path() / "sfumato-test-XXXXXX").string();
        const char* made = ::mkdtemp(name.data());
        EXPECT_NE(made, nullptr);
        path_ = name;
    }
    ~TemporaryDirectory() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    TemporaryDirectory(const TemporaryDirectory&) = delete;
    TemporaryDirectory& operator=(const TemporaryDirectory&) = delete;

    std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
    const std::filesystem::path& path() const { return path_; }
    size_t file_count() const {
        return static_cast<size_t>(std::distance(std::filesystem::directory_iterator(path_), {}));
    }

  private:
    std::filesystem::path path_;
};

inline std::vector<char> read_bytes(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

inline void write_bytes(const std::filesystem::path& path, const std::vector<char>& bytes) {
    std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

// Rendered frames are not part of the repository.
inline std::filesystem::path kinetic_folder() {
    return std::filesystem::path(SFUMATO_SOURCE_DIR) / ".." / "shared" / "data" / "kinetic";
}

} // namespace sfumato::media::test

#define SKIP_WITHOUT_KINETIC()                                                                                         \
    if (!std::filesystem::exists(sfumato::media::test::kinetic_folder() / "kinetic.0006.exr"))                         \
    GTEST_SKIP() << "no rendered frames in " << sfumato::media::test::kinetic_folder()
