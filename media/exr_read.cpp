// Pixels through OpenEXR, once the scan has found the file sound.
#include <algorithm>
#include <exception>
#include <mutex>
#include <new>
#include <utility>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfThreading.h>

#include <fmt/format.h>

#include "exr_file.h"
#include "exr_scan.h"
#include "exr_streams.h"
#include "file_io.h"

namespace sfumato::media {

void use_exr_threads(int threads) {
    static std::mutex mutex;
    const std::lock_guard lock(mutex);
    if (threads > 0 && Imf::globalThreadCount() < threads)
        Imf::setGlobalThreadCount(threads);
}

namespace {

// OpenEXR and the scan read the same bytes; a header that each understands in its own way is refused.
bool same_header(const Imf::Header& header, const ExrPart& part) {
    const Imath::Box2i window = header.dataWindow();
    if (Window{window.min.x, window.min.y, window.max.x, window.max.y} != part.data_window)
        return false;
    size_t count = 0;
    for (auto channel = header.channels().begin(); channel != header.channels().end(); ++channel, ++count) {
        const ExrChannel* scanned = part.find_channel(channel.name());
        if (!scanned || static_cast<int>(scanned->type) != static_cast<int>(channel.channel().type))
            return false;
    }
    return count == part.channels.size();
}

void read_part(Imf::MultiPartInputFile& file, int index, ExrPart& part) {
    Imf::FrameBuffer frame_buffer;
    const Imath::Box2i window(Imath::V2i(part.data_window.min_x, part.data_window.min_y),
                              Imath::V2i(part.data_window.max_x, part.data_window.max_y));
    for (ExrChannel& channel : part.channels) {
        void* memory = nullptr;
        if (channel.type == PixelType::uint32) {
            channel.integers.resize(part.pixel_count());
            memory = channel.integers.data();
        } else {
            channel.values.resize(part.pixel_count());
            memory = channel.values.data();
        }
        const Imf::PixelType type = channel.type == PixelType::uint32 ? Imf::UINT : Imf::FLOAT;
        frame_buffer.insert(channel.name, Imf::Slice::Make(type, memory, window));
    }
    Imf::InputPart input(file, index);
    input.setFrameBuffer(frame_buffer);
    input.readPixels(part.data_window.min_y, part.data_window.max_y);
}

Result<void> read_pixels(const InputFile& file, ExrImage& image, int threads) {
    use_exr_threads(threads);
    ExrInputStream stream(file);
    // No reconstruction of a missing chunk table: the scan has seen it.
    Imf::MultiPartInputFile input(stream, threads, false);
    if (static_cast<size_t>(input.parts()) != image.parts.size())
        return Error{ErrorCode::input,
                     fmt::format("{}: broken header: the number of parts is not clear", file.path().string())};
    for (size_t i = 0; i < image.parts.size(); ++i) {
        const int index = static_cast<int>(i);
        if (!same_header(input.header(index), image.parts[i]))
            return Error{ErrorCode::input, fmt::format("{}: broken header: windows or channels of part {} are stated "
                                                       "twice and differ",
                                                       file.path().string(), i)};
        read_part(input, index, image.parts[i]);
    }
    return {};
}

Result<ExrImage> read_file(const std::filesystem::path& path, const ExrReadOptions& options) {
    auto file = InputFile::open(path);
    if (!file)
        return file.error();
    auto scan = scan_exr(*file, options.limits);
    if (!scan)
        return scan.error();
    ExrImage image;
    image.path = path;
    image.parts = std::move(scan->parts);
    if (options.pixels)
        if (auto read = read_pixels(*file, image, options.threads); !read)
            return read.error();
    return image;
}

} // namespace

Result<ExrImage> read_exr(const std::filesystem::path& path, const ExrReadOptions& options) {
    try {
        return read_file(path, options);
    } catch (const std::bad_alloc&) {
        return Error{ErrorCode::out_of_memory, fmt::format("{}: out of memory", path.string())};
    } catch (const std::exception& exception) {
        return Error{ErrorCode::input, fmt::format("{}: broken: {}", path.string(), one_line(exception.what()))};
    } catch (...) {
        return Error{ErrorCode::input, fmt::format("{}: broken", path.string())};
    }
}

} // namespace sfumato::media
