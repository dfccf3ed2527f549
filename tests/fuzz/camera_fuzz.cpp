// The camera file's TOML: cameras of finite numbers in order, or an error.
#include "media/camera_file.h"

#include <cmath>
#include <cstdint>
#include <cstdlib>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    const auto track = sfumato::media::parse_camera_text(text, "fuzz.toml");
    if (!track) {
        if (track.error().message.empty())
            std::abort();
        return 0;
    }
    int last = INT32_MIN;
    for (const auto& frame : track->frames) {
        if (&frame != &track->frames.front() && frame.number <= last)
            std::abort();
        last = frame.number;
        for (const float value : frame.camera.world_to_view)
            if (!std::isfinite(value))
                std::abort();
        for (const float value : frame.camera.projection)
            if (!std::isfinite(value))
                std::abort();
        if (track->find(frame.number) != &frame.camera)
            std::abort();
    }
    return 0;
}
