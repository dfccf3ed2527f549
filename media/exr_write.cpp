// Writing through OpenEXR into a temporary file that gets its name when everything is on the disk.
#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>
#include <new>
#include <string_view>
#include <utility>

#include <ImfChannelList.h>
#include <ImfFloatAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOpaqueAttribute.h>
#include <ImfOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfStandardAttributes.h>
#include <half.h>

#include <fmt/format.h>

#include "exr_file.h"
#include "exr_scan.h"
#include "exr_streams.h"
#include "file_io.h"

namespace sfumato::media {

namespace {

constexpr std::pair<std::string_view, Imf::Compression> compressions[] = {
    {"none", Imf::NO_COMPRESSION},   {"rle", Imf::RLE_COMPRESSION},   {"zips", Imf::ZIPS_COMPRESSION},
    {"zip", Imf::ZIP_COMPRESSION},   {"piz", Imf::PIZ_COMPRESSION},   {"pxr24", Imf::PXR24_COMPRESSION},
    {"b44", Imf::B44_COMPRESSION},   {"b44a", Imf::B44A_COMPRESSION}, {"dwaa", Imf::DWAA_COMPRESSION},
    {"dwab", Imf::DWAB_COMPRESSION},
};

Imf::Compression compression_of(const ExrPart& part, ExrCompression wanted) {
    switch (wanted) {
    case ExrCompression::none:
        return Imf::NO_COMPRESSION;
    case ExrCompression::rle:
        return Imf::RLE_COMPRESSION;
    case ExrCompression::zips:
        return Imf::ZIPS_COMPRESSION;
    case ExrCompression::piz:
        return Imf::PIZ_COMPRESSION;
    case ExrCompression::keep:
        for (const auto& [name, method] : compressions)
            if (name == part.compression)
                return method;
        break;
    case ExrCompression::zip:
        break;
    }
    return Imf::ZIP_COMPRESSION;
}

Imath::Box2i box_of(const Window& window) {
    return {Imath::V2i(window.min_x, window.min_y), Imath::V2i(window.max_x, window.max_y)};
}

void insert_attribute(Imf::Header& header, const ExrAttribute& attribute) {
    ExrMemoryStream bytes(attribute.bytes);
    const int size = static_cast<int>(attribute.bytes.size());
    // OpenEXR looks into this one when it is inserted; all others pass as the bytes they are.
    if (attribute.name == "dwaCompressionLevel" && attribute.type == "float" && size == 4) {
        header.insert(attribute.name, Imf::FloatAttribute(load_f32(attribute.bytes.data())));
        return;
    }
    Imf::OpaqueAttribute opaque(attribute.type.c_str());
    opaque.readValueFrom(bytes, size, 2);
    header.insert(attribute.name, opaque);
}

Imf::Header make_header(const ExrPart& part, bool multi_part, size_t index, ExrCompression compression) {
    Imf::Header header(box_of(part.display_window), box_of(part.data_window), part.pixel_aspect,
                       Imath::V2f(part.screen_window_centre[0], part.screen_window_centre[1]), part.screen_window_width,
                       Imf::INCREASING_Y, compression_of(part, compression));
    for (const ExrChannel& channel : part.channels)
        header.channels().insert(
            channel.name, Imf::Channel(static_cast<Imf::PixelType>(channel.type), 1, 1, channel.perceptually_linear));
    for (const ExrAttribute& attribute : part.attributes)
        insert_attribute(header, attribute);
    if (multi_part || !part.name.empty())
        header.setName(part.name.empty() ? fmt::format("part{}", index) : part.name);
    if (multi_part)
        header.setType(Imf::SCANLINEIMAGE);
    return header;
}

// The frame buffer of a part, and the halves that it points to.
struct Buffers {
    Imf::FrameBuffer frame_buffer;
    std::vector<std::vector<half>> halves;
};

half to_half(float value) {
    if (std::isfinite(value))
        value = std::clamp(value, -65504.0f, 65504.0f);
    return half(value);
}

Buffers make_buffers(const ExrPart& part) {
    Buffers buffers;
    const Imath::Box2i window = box_of(part.data_window);
    for (const ExrChannel& channel : part.channels) {
        const void* memory = channel.values.data();
        if (channel.type == PixelType::uint32) {
            memory = channel.integers.data();
        } else if (channel.type == PixelType::half) {
            std::vector<half>& halves = buffers.halves.emplace_back(channel.values.size());
            std::transform(channel.values.begin(), channel.values.end(), halves.begin(), to_half);
            memory = halves.data();
        }
        buffers.frame_buffer.insert(channel.name,
                                    Imf::Slice::Make(static_cast<Imf::PixelType>(channel.type), memory, window));
    }
    return buffers;
}

// A mistake of the calling program, found before a file is created.
Result<void> check_image(const std::filesystem::path& path, const ExrImage& image) {
    auto wrong = [&](const std::string& what) {
        return Error{ErrorCode::invalid_argument, fmt::format("{}: cannot write: {}", path.string(), what)};
    };
    if (image.parts.empty())
        return wrong("the image has no parts");
    for (const ExrPart& part : image.parts) {
        if (part.width() < 1 || part.height() < 1 || part.channels.empty())
            return wrong(fmt::format("part '{}' has {}x{} pixels and {} channels", part.name, part.width(),
                                     part.height(), part.channels.size()));
        for (const ExrChannel& channel : part.channels) {
            const size_t size = channel.type == PixelType::uint32 ? channel.integers.size() : channel.values.size();
            if (size != part.pixel_count())
                return wrong(
                    fmt::format("channel '{}' has {} values for {} pixels", channel.name, size, part.pixel_count()));
        }
    }
    return {};
}

void write_pixels(Imf::OStream& stream, const ExrImage& image, const ExrWriteOptions& options) {
    use_exr_threads(options.threads);
    const bool multi_part = image.parts.size() > 1;
    std::vector<Imf::Header> headers;
    for (size_t i = 0; i < image.parts.size(); ++i)
        headers.push_back(make_header(image.parts[i], multi_part, i, options.compression));
    if (!multi_part) {
        const Buffers buffers = make_buffers(image.parts[0]);
        Imf::OutputFile output(stream, headers[0], options.threads);
        output.setFrameBuffer(buffers.frame_buffer);
        output.writePixels(static_cast<int>(image.parts[0].height()));
        return;
    }
    Imf::MultiPartOutputFile output(stream, headers.data(), static_cast<int>(headers.size()), false, options.threads);
    for (size_t i = 0; i < image.parts.size(); ++i) {
        const Buffers buffers = make_buffers(image.parts[i]);
        Imf::OutputPart part(output, static_cast<int>(i));
        part.setFrameBuffer(buffers.frame_buffer);
        part.writePixels(static_cast<int>(image.parts[i].height()));
    }
}

Result<void> write_file(const std::filesystem::path& path, const ExrImage& image, const ExrWriteOptions& options) {
    if (auto checked = check_image(path, image); !checked)
        return checked;
    auto file = AtomicFile::create(path, {options.no_clobber, options.sync});
    if (!file)
        return file.error();
    try {
        ExrOutputStream stream(*file, path.string().c_str());
        write_pixels(stream, image, options);
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& exception) {
        // OpenEXR reports a full disk as its own exception; the cause is the file's.
        if (file->failure() != 0)
            return file->failure_error();
        return Error{ErrorCode::input, fmt::format("{}: cannot write: {}", path.string(), one_line(exception.what()))};
    }
    return file->commit();
}

} // namespace

Result<void> write_exr(const std::filesystem::path& path, const ExrImage& image, const ExrWriteOptions& options) {
    try {
        return write_file(path, image, options);
    } catch (const std::bad_alloc&) {
        return Error{ErrorCode::out_of_memory, fmt::format("{}: out of memory", path.string())};
    } catch (const std::exception& exception) {
        return Error{ErrorCode::internal, fmt::format("{}: {}", path.string(), one_line(exception.what()))};
    } catch (...) {
        return Error{ErrorCode::internal, fmt::format("{}: unknown exception", path.string())};
    }
}

} // namespace sfumato::media
