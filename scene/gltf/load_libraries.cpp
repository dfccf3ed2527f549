// The libraries that come as headers, built here and nowhere else.
#define TINYGLTF_IMPLEMENTATION
#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_JPEG
#define STBI_ONLY_PNG
#define STBI_NO_STDIO
#define STBI_MAX_DIMENSIONS 65536

#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"
#endif
#include "scene/gltf/load_parts.h"

#include <stb/stb_image.h>
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

#include <limits>
#include <memory>

namespace sfumato::scene::gltf {

Pixels decode_image(std::span<const uint8_t> bytes, const LoadLimits& limits, uint64_t& pixels_left,
                    const std::string& what) {
    require(bytes.size() <= static_cast<size_t>(std::numeric_limits<int>::max()), what + " has too many bytes");
    const int size = static_cast<int>(bytes.size());
    int width = 0, height = 0, channels = 0;
    require(stbi_info_from_memory(bytes.data(), size, &width, &height, &channels) == 1 && width > 0 && height > 0,
            what + " is neither PNG nor JPEG");
    const auto side = static_cast<int64_t>(limits.image_side);
    require(width <= side && height <= side, what + " is " + std::to_string(width) + "×" + std::to_string(height) +
                                                 " pixels; at most " + std::to_string(side) + " a side are allowed");
    take(pixels_left, static_cast<uint64_t>(width), static_cast<uint64_t>(height), what);
    const std::unique_ptr<stbi_uc, void (*)(void*)> pixels(
        stbi_load_from_memory(bytes.data(), size, &width, &height, &channels, 4), stbi_image_free);
    require(pixels != nullptr, what + " is broken: " + stbi_failure_reason());
    Pixels result{static_cast<uint32_t>(width), static_cast<uint32_t>(height), {}};
    result.rgba.assign(pixels.get(), pixels.get() + size_t{result.width} * result.height * 4);
    return result;
}

} // namespace sfumato::scene::gltf
