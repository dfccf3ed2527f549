// Frame ranges and file patterns: what was read can be written and read again.
#include "media/sequence.h"

#include <cstdint>
#include <cstdlib>

using namespace sfumato::media;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    if (const auto frames = parse_frame_range(text)) {
        if (frames->empty() || frames->size() > max_frames)
            std::abort();
        const auto again = parse_frame_range(format_frames(*frames));
        if (!again || *again != *frames)
            std::abort();
    }
    if (const auto pattern = FramePattern::parse(text))
        for (const int frame : {-2147483647, -1, 0, 7, 1001, 2147483647}) {
            const auto path = pattern->path_of(frame);
            const auto back = pattern->frame_of(path.filename().string());
            if (pattern->is_sequence() && back && *back != frame)
                std::abort();
        }
    return 0;
}
