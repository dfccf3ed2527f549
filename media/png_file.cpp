// PNG through libpng. Its errors jump out of C code, so that every function that calls setjmp keeps its C++ objects
// outside of itself.
#include "png_file.h"

#include <algorithm>
#include <csetjmp>
#include <cstring>
#include <new>
#include <string>

#include <fmt/format.h>
#include <png.h>

#include "colour.h"
#include "file_io.h"

namespace sfumato::media {

namespace {

struct PngErrorText {
    char text[200] = "unknown";
};

void on_error(png_structp png, png_const_charp message) {
    auto* out = static_cast<PngErrorText*>(png_get_error_ptr(png));
    std::strncpy(out->text, message, sizeof(out->text) - 1);
    png_longjmp(png, 1);
}

void on_warning(png_structp, png_const_charp) {}

// ---------------------------------------------------------------------------------------------------- write

void write_bytes(png_structp png, png_bytep bytes, size_t count) {
    if (!static_cast<AtomicFile*>(png_get_io_ptr(png))->write(bytes, count))
        png_error(png, "write failed");
}

void flush_nothing(png_structp) {}

bool write_body(png_structp png, png_infop info, const PngImage& image, png_bytepp rows) {
    if (setjmp(png_jmpbuf(png)))
        return false;
    png_set_IHDR(png, info, static_cast<png_uint_32>(image.width), static_cast<png_uint_32>(image.height), image.bits,
                 image.channels == 4 ? PNG_COLOR_TYPE_RGB_ALPHA : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_write_info(png, info);
    png_write_image(png, rows);
    png_write_end(png, nullptr);
    return true;
}

// Samples as PNG stores them: one byte, or two with the higher first.
std::vector<png_byte> pack_samples(const PngImage& image) {
    std::vector<png_byte> bytes;
    bytes.reserve(image.samples.size() * (image.bits == 16 ? 2 : 1));
    for (const uint16_t sample : image.samples) {
        if (image.bits == 16)
            bytes.push_back(static_cast<png_byte>(sample >> 8));
        bytes.push_back(static_cast<png_byte>(sample & 0xff));
    }
    return bytes;
}

Result<void> write_file(const std::filesystem::path& path, const PngImage& image, const PngWriteOptions& options) {
    const auto width = static_cast<size_t>(std::max(image.width, 0)),
               height = static_cast<size_t>(std::max(image.height, 0));
    const auto channels = static_cast<size_t>(image.channels);
    if (width == 0 || height == 0 || (channels != 3 && channels != 4) || (image.bits != 8 && image.bits != 16) ||
        image.samples.size() != width * height * channels)
        return Error{ErrorCode::invalid_argument,
                     fmt::format("{}: cannot write: {} samples for {}x{} pixels of {} channels with {} bits",
                                 path.string(), image.samples.size(), image.width, image.height, image.channels,
                                 image.bits)};
    auto file = AtomicFile::create(path, {options.no_clobber, options.sync});
    if (!file)
        return file.error();
    std::vector<png_byte> bytes = pack_samples(image);
    std::vector<png_bytep> rows;
    for (size_t y = 0; y < height; ++y)
        rows.push_back(bytes.data() + y * (bytes.size() / height));

    PngErrorText error;
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &error, on_error, on_warning);
    png_infop info = png ? png_create_info_struct(png) : nullptr;
    if (!info) {
        png_destroy_write_struct(&png, nullptr);
        return Error{ErrorCode::out_of_memory, fmt::format("{}: out of memory", path.string())};
    }
    png_set_write_fn(png, &*file, write_bytes, flush_nothing);
    const bool written = write_body(png, info, image, rows.data());
    png_destroy_write_struct(&png, &info);
    if (!written && file->failure() != 0)
        return file->failure_error();
    if (!written)
        return Error{ErrorCode::input, fmt::format("{}: cannot write: {}", path.string(), error.text)};
    return file->commit();
}

// ----------------------------------------------------------------------------------------------------- read

struct ByteReader {
    const std::vector<char>* bytes;
    size_t position = 0;
};

void read_bytes(png_structp png, png_bytep out, size_t count) {
    auto* reader = static_cast<ByteReader*>(png_get_io_ptr(png));
    if (count > reader->bytes->size() - reader->position)
        png_error(png, "truncated");
    std::memcpy(out, reader->bytes->data() + reader->position, count);
    reader->position += count;
}

struct PngShape {
    size_t width = 0;
    size_t height = 0;
    size_t channels = 0;
};

bool read_header(png_structp png, png_infop info, PngShape& shape) {
    if (setjmp(png_jmpbuf(png)))
        return false;
    png_read_info(png, info);
    shape.width = png_get_image_width(png, info);
    shape.height = png_get_image_height(png, info);
    if (shape.width * shape.height > size_t{1} << 28)
        png_error(png, "more than the limit of 268 megapixels");
    png_set_expand(png);
    png_set_scale_16(png);
    png_set_gray_to_rgb(png);
    png_set_interlace_handling(png);
    png_read_update_info(png, info);
    shape.channels = png_get_channels(png, info);
    return true;
}

bool read_body(png_structp png, png_bytepp rows) {
    if (setjmp(png_jmpbuf(png)))
        return false;
    png_read_image(png, rows);
    png_read_end(png, nullptr);
    return true;
}

Result<PngImage> read_file(const std::filesystem::path& path) {
    auto bytes = read_whole_file(path, uint64_t{2} << 30);
    if (!bytes)
        return bytes.error();
    PngErrorText error;
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &error, on_error, on_warning);
    png_infop info = png ? png_create_info_struct(png) : nullptr;
    if (!info) {
        png_destroy_read_struct(&png, nullptr, nullptr);
        return Error{ErrorCode::out_of_memory, fmt::format("{}: out of memory", path.string())};
    }
    ByteReader reader{&*bytes};
    png_set_read_fn(png, &reader, read_bytes);
    PngShape shape;
    bool good = read_header(png, info, shape);
    std::vector<png_byte> pixels;
    std::vector<png_bytep> rows;
    try {
        pixels.resize(shape.width * shape.height * shape.channels);
        for (size_t y = 0; good && y < shape.height; ++y)
            rows.push_back(pixels.data() + y * shape.width * shape.channels);
    } catch (const std::bad_alloc&) {
        png_destroy_read_struct(&png, &info, nullptr);
        throw;
    }
    good = good && read_body(png, rows.data());
    png_destroy_read_struct(&png, &info, nullptr);
    if (!good)
        return Error{ErrorCode::input, fmt::format("{}: {}", path.string(), error.text)};
    PngImage image{
        static_cast<int>(shape.width), static_cast<int>(shape.height), static_cast<int>(shape.channels), 8, {}};
    image.samples.assign(pixels.begin(), pixels.end());
    return image;
}

Error out_of_memory(const std::filesystem::path& path) {
    return Error{ErrorCode::out_of_memory, fmt::format("{}: out of memory", path.string())};
}

} // namespace

Result<void> write_png(const std::filesystem::path& path, const PngImage& image, const PngWriteOptions& options) {
    try {
        return write_file(path, image, options);
    } catch (const std::bad_alloc&) {
        return out_of_memory(path);
    }
}

Result<PngImage> read_png(const std::filesystem::path& path) {
    try {
        return read_file(path);
    } catch (const std::bad_alloc&) {
        return out_of_memory(path);
    }
}

PngImage make_picture(int width, int height, const float* red, const float* green, const float* blue,
                      const float* alpha, float stops, int bits) {
    PngImage image{width, height, alpha ? 4 : 3, bits, {}};
    const size_t count = static_cast<size_t>(width) * static_cast<size_t>(height);
    image.samples.reserve(count * static_cast<size_t>(image.channels));
    const float maximum = bits == 16 ? 65535.0f : 255.0f;
    for (size_t i = 0; i < count; ++i) {
        const float opacity = alpha ? std::clamp(alpha[i], 0.0f, 1.0f) : 1.0f;
        for (const float* plane : {red, green, blue}) {
            const float linear = opacity > 0.0f ? plane[i] / opacity : 0.0f;
            image.samples.push_back(bits == 16 ? display_16bit(linear, stops) : display_8bit(linear, stops));
        }
        if (alpha)
            image.samples.push_back(static_cast<uint16_t>(opacity >= 0.0f ? opacity * maximum + 0.5f : 0.0f));
    }
    return image;
}

} // namespace sfumato::media
