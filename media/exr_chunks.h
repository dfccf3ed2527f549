// Whether an EXR file holds all the chunks of pixels that its headers promise.
#pragma once

#include <cstdint>
#include <vector>

#include "exr_scan.h"
#include "file_io.h"
#include "sfumato/result.h"

namespace sfumato::media {

// `table_position` is where the chunk tables begin, `stated_counts` the chunkCount attribute of each part or -1.
Result<void> check_chunks(const InputFile& file, uint64_t table_position, const ExrScan& scan,
                          const std::vector<int64_t>& stated_counts);

} // namespace sfumato::media
