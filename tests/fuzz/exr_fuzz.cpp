// The EXR reader on hostile files: an image within the limits or an error of one line, nothing else.
#include "media/exr_file.h"

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <unistd.h>

namespace {

std::filesystem::path scratch_file() {
    const std::filesystem::path folder =
        std::filesystem::exists("/dev/shm") ? "/dev/shm" : std::filesystem::temp_directory_path();
    return folder / ("sfumato_fuzz_" + std::to_string(getpid()) + ".exr");
}

struct Scratch {
    std::filesystem::path path = scratch_file();
    ~Scratch() {
        std::error_code ignored;
        std::filesystem::remove(path, ignored);
    }
};

void require(bool holds, const char* what) {
    if (!holds) {
        std::fprintf(stderr, "exr: %s\n", what);
        std::abort();
    }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    static const Scratch scratch;
    FILE* file = std::fopen(scratch.path.c_str(), "wb");
    require(file && std::fwrite(data, 1, size, file) == size, "the scratch file cannot be written");
    std::fclose(file);
    sfumato::media::ExrReadOptions options;
    options.limits.max_pixels = 1 << 16;
    options.limits.max_memory = 1 << 24;
    options.limits.max_header = 1 << 16;
    for (const bool pixels : {false, true}) {
        options.pixels = pixels;
        const auto image = sfumato::media::read_exr(scratch.path, options);
        if (!image) {
            require(!image.error().message.empty() && image.error().message.find('\n') == std::string::npos,
                    "an error must be one line");
            continue;
        }
        for (const auto& part : image->parts) {
            require(part.width() > 0 && part.height() > 0, "an empty part");
            require(part.pixel_count() <= options.limits.max_pixels, "more pixels than the limit");
            for (const auto& channel : part.channels)
                require(!pixels || channel.values.size() + channel.integers.size() == part.pixel_count(),
                        "a channel that is not as large as its part");
        }
    }
    return 0;
}
