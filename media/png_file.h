// PNG pictures, for looking at results and for tests.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "sfumato/result.h"

namespace sfumato::media {

// Encoded samples, row after row from the top, channels interleaved.
struct PngImage {
    int width = 0;
    int height = 0;
    int channels = 3; // 3: RGB, 4: RGB with straight alpha
    int bits = 8;     // 8 or 16 a channel; 8-bit samples use the low byte
    std::vector<uint16_t> samples;
};

struct PngWriteOptions {
    bool no_clobber = false;
    bool sync = true;
};

// The picture carries the sRGB mark. The file appears under its name whole or not at all.
Result<void> write_png(const std::filesystem::path& path, const PngImage& image, const PngWriteOptions& options = {});

// Any PNG as 8-bit RGB or RGBA (grey and palettes expanded, 16 bits reduced). At most 2^28 pixels.
Result<PngImage> read_png(const std::filesystem::path& path);

// Linear planes to samples: exposure in stops, sRGB encoding, clamping. `alpha` may be null; otherwise colour is
// premultiplied by it, and the picture gets straight alpha.
PngImage make_picture(int width, int height, const float* red, const float* green, const float* blue,
                      const float* alpha = nullptr, float stops = 0.0f, int bits = 8);

} // namespace sfumato::media
