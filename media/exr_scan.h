// A first, distrustful look at an EXR file: reads the headers and the chunk table without allocating what they promise.
// Only what passes goes on to OpenEXR.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "exr_file.h"
#include "file_io.h"

namespace sfumato::media {

struct ExrTiling {
    uint32_t width = 0;
    uint32_t height = 0;
    int level_mode = 0; // 0 one level, 1 mipmaps, 2 ripmaps
    bool round_up = false;
};

struct ExrScan {
    std::vector<ExrPart> parts; // headers without pixels
    std::vector<ExrTiling> tilings;
    bool multi_part = false;
};

Result<ExrScan> scan_exr(const InputFile& file, const ExrLimits& limits);

// Little-endian numbers, wherever the bytes lie.
uint32_t load_u32(const char* bytes);
uint64_t load_u64(const char* bytes);
int32_t load_i32(const char* bytes);
float load_f32(const char* bytes);
double load_f64(const char* bytes);

} // namespace sfumato::media
