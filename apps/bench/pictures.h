// PNG pictures without a library.
#pragma once

#include "media/planes.h"
#include "sfumato/result.h"

#include <string>

namespace sfumato::bench {

// 8 bits a channel, three channels of display-encoded values (one is shown as grey), uncompressed. Error (input): the
// file cannot be written.
Result<void> write_png(const std::string& path, const media::Planes& encoded);

// Makes the folder unless it is there or the path is empty. Error (input): it cannot be made.
Result<void> make_picture_folder(const std::string& path);

} // namespace sfumato::bench
