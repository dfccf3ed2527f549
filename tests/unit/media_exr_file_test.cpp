// EXR files: what goes in comes out, and broken files are errors of one line.
#include "media/exr_file.h"

#include <array>
#include <cmath>
#include <csignal>
#include <cstring>
#include <functional>
#include <limits>
#include <sys/resource.h>

#include "media_test_support.h"

namespace sfumato::media {
namespace {

using test::TemporaryDirectory;

std::vector<char> bytes_of_float(float value) {
    std::vector<char> bytes(4);
    std::memcpy(bytes.data(), &value, 4);
    return bytes;
}

ExrPart make_part(const std::string& prefix, Window window) {
    ExrPart part;
    part.data_window = window;
    part.display_window = {0, 0, 19, 9};
    const size_t count = part.pixel_count();
    std::vector<float> red(count), depth(count);
    std::vector<uint32_t> id(count);
    for (size_t i = 0; i < count; ++i) {
        red[i] = static_cast<float>(i % 64) / 64.0f; // exact in half
        depth[i] = 1e10f + static_cast<float>(i) * 0.1f;
        id[i] = 0xfffffff0u + static_cast<uint32_t>(i % 15); // not exact in float
    }
    part.set_channel(prefix + "R", red);
    part.set_channel(prefix + "Z", depth, PixelType::float32);
    part.channels.push_back({prefix + "id", PixelType::uint32, false, {}, id});
    return part;
}

ExrImage make_image() {
    ExrImage image;
    image.parts.push_back(make_part("", {-3, -2, 8, 7}));
    return image;
}

void expect_same(const ExrPart& a, const ExrPart& b) {
    EXPECT_EQ(a.data_window, b.data_window);
    EXPECT_EQ(a.display_window, b.display_window);
    EXPECT_EQ(a.pixel_aspect, b.pixel_aspect);
    EXPECT_EQ(a.screen_window_centre, b.screen_window_centre);
    EXPECT_EQ(a.screen_window_width, b.screen_window_width);
    ASSERT_EQ(a.channels.size(), b.channels.size());
    for (const ExrChannel& channel : a.channels) {
        const ExrChannel* other = b.find_channel(channel.name);
        ASSERT_TRUE(other) << channel.name;
        EXPECT_EQ(channel.type, other->type) << channel.name;
        EXPECT_EQ(channel.perceptually_linear, other->perceptually_linear) << channel.name;
        EXPECT_EQ(channel.values, other->values) << channel.name;
        EXPECT_EQ(channel.integers, other->integers) << channel.name;
    }
    for (const ExrAttribute& attribute : a.attributes) {
        const ExrAttribute* other = b.find_attribute(attribute.name);
        ASSERT_TRUE(other) << attribute.name;
        EXPECT_EQ(attribute, *other) << attribute.name;
    }
    EXPECT_EQ(a.attributes.size(), b.attributes.size());
}

ExrImage read_back(const std::filesystem::path& path) {
    auto image = read_exr(path);
    EXPECT_TRUE(image) << image.error().message;
    return image ? *image : ExrImage{};
}

// The error of a file that must not be read; empty if it was.
std::string error_of(const std::filesystem::path& path, const ExrReadOptions& options = {}) {
    auto image = read_exr(path, options);
    if (image)
        return {};
    EXPECT_EQ(image.error().message.find('\n'), std::string::npos);
    EXPECT_TRUE(image.error().message.starts_with(path.string())) << image.error().message;
    return image.error().message;
}

TEST(MediaExr, RoundTripKeepsChannelsAttributesAndWindows) {
    TemporaryDirectory directory;
    ExrImage image = make_image();
    ExrPart& part = image.parts[0];
    part.pixel_aspect = 1.5f;
    part.screen_window_centre = {0.25f, -0.5f};
    part.screen_window_width = 2.0f;
    part.channels[0].perceptually_linear = true;
    part.set_string_attribute("comment", "two\nlines");
    part.attributes.push_back({"dwaCompressionLevel", "float", bytes_of_float(30.0f)});
    part.attributes.push_back({"sampleCount", "int", {5, 0, 0, 0}});
    part.attributes.push_back({"made.up", "someStudiosType", {1, 2, 3, 0, -1}});
    part.attributes.push_back({"chromaticities", "chromaticities", std::vector<char>(32, 0)});
    part.attributes.push_back({"empty", "string", {}});
    ASSERT_TRUE(write_exr(directory / "a.exr", image));
    const ExrImage back = read_back(directory / "a.exr");
    ASSERT_EQ(back.parts.size(), 1u);
    expect_same(part, back.parts[0]);
    EXPECT_EQ(back.parts[0].compression, "zip");
    EXPECT_EQ(back.parts[0].string_attribute("comment"), "two\nlines");
    EXPECT_EQ(back.parts[0].number_attribute("sampleCount"), 5.0);
    EXPECT_EQ(back.parts[0].number_attribute("dwaCompressionLevel"), 30.0);
    EXPECT_FALSE(back.parts[0].number_attribute("comment"));
}

TEST(MediaExr, EveryLosslessCompressionRoundTrips) {
    TemporaryDirectory directory;
    const ExrImage image = make_image();
    for (const auto compression : {ExrCompression::none, ExrCompression::rle, ExrCompression::zips, ExrCompression::zip,
                                   ExrCompression::piz, ExrCompression::keep}) {
        ExrWriteOptions options;
        options.compression = compression;
        options.threads = 2;
        ASSERT_TRUE(write_exr(directory / "a.exr", image, options));
        expect_same(image.parts[0], read_back(directory / "a.exr").parts[0]);
    }
}

TEST(MediaExr, SeveralPartsRoundTrip) {
    TemporaryDirectory directory;
    ExrImage image;
    image.parts.push_back(make_part("", {0, 0, 19, 9}));
    image.parts.push_back(make_part("inner.", {5, 5, 7, 6}));
    image.parts.push_back(make_part("outer.", {-10, -10, 40, 40}));
    for (size_t i = 0; i < 3; ++i) {
        image.parts[i].name = "part " + std::to_string(i);
        image.parts[i].attributes.push_back({"chromaticities", "chromaticities", std::vector<char>(32, 0)});
        image.parts[i].set_string_attribute("view", "left");
    }
    auto written = write_exr(directory / "a.exr", image);
    ASSERT_TRUE(written) << written.error().message;
    const ExrImage back = read_back(directory / "a.exr");
    ASSERT_EQ(back.parts.size(), 3u);
    for (size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(back.parts[i].name, image.parts[i].name);
        expect_same(image.parts[i], back.parts[i]);
    }
}

TEST(MediaExr, HalfIsClampedAndSpecialValuesStay) {
    TemporaryDirectory directory;
    const float infinity = std::numeric_limits<float>::infinity();
    ExrImage image;
    image.parts.emplace_back();
    image.parts[0].data_window = image.parts[0].display_window = {0, 0, 4, 0};
    image.parts[0].set_channel("R", {1e10f, -1e10f, infinity, std::nanf(""), -0.0f});
    ASSERT_TRUE(write_exr(directory / "a.exr", image));
    const std::vector<float> values = read_back(directory / "a.exr").parts[0].channels[0].values;
    EXPECT_EQ(values[0], 65504.0f);
    EXPECT_EQ(values[1], -65504.0f);
    EXPECT_EQ(values[2], infinity);
    EXPECT_TRUE(std::isnan(values[3]));
    EXPECT_TRUE(std::signbit(values[4]));
}

TEST(MediaExr, HeadersAloneHaveNoPixels) {
    TemporaryDirectory directory;
    ASSERT_TRUE(write_exr(directory / "a.exr", make_image()));
    ExrReadOptions options;
    options.pixels = false;
    auto image = read_exr(directory / "a.exr", options);
    ASSERT_TRUE(image);
    EXPECT_EQ(image->parts[0].channels.size(), 3u);
    EXPECT_TRUE(image->parts[0].channels[0].values.empty());
}

TEST(MediaExr, SetChannelReplacesOrInsertsInOrder) {
    ExrPart part = make_part("", {0, 0, 1, 0});
    part.set_channel("R", {1, 2});
    part.set_channel("A", {3, 4}, PixelType::float32);
    EXPECT_EQ(part.channels[0].name, "A");
    EXPECT_EQ(part.channels.size(), 4u);
    EXPECT_EQ(part.find_channel("R")->values, (std::vector<float>{1, 2}));
}

// A tiled file made by hand: one float channel of 5x3 pixels that hold 10 y + x, tiles of 4x2, no compression.
std::vector<char> make_tiled_file(bool mipmaps) {
    std::vector<char> bytes;
    auto put = [&bytes](const auto& value) {
        const char* begin = reinterpret_cast<const char*>(&value);
        bytes.insert(bytes.end(), begin, begin + sizeof(value));
    };
    auto put_text = [&bytes](const std::string& text) {
        bytes.insert(bytes.end(), text.c_str(), text.c_str() + text.size() + 1);
    };
    auto put_attribute = [&](const std::string& name, const std::string& type, int32_t size) {
        put_text(name);
        put_text(type);
        put(size);
    };
    put(std::array<uint32_t, 2>{20000630, 0x202});
    put_attribute("channels", "chlist", 19);
    put_text("R");
    put(std::array<int32_t, 4>{2, 0, 1, 1});
    bytes.push_back(0);
    put_attribute("compression", "compression", 1);
    bytes.push_back(0);
    for (const char* window : {"dataWindow", "displayWindow"}) {
        put_attribute(window, "box2i", 16);
        put(std::array<int32_t, 4>{0, 0, 4, 2});
    }
    put_attribute("lineOrder", "lineOrder", 1);
    bytes.push_back(0);
    put_attribute("pixelAspectRatio", "float", 4);
    put(1.0f);
    put_attribute("screenWindowCenter", "v2f", 8);
    put(std::array<float, 2>{0.0f, 0.0f});
    put_attribute("screenWindowWidth", "float", 4);
    put(1.0f);
    put_attribute("tiles", "tiledesc", 9);
    put(std::array<int32_t, 2>{4, 2});
    bytes.push_back(mipmaps ? 1 : 0);
    bytes.push_back(0);
    // Levels of 5x3, 2x1 and 1x1 pixels.
    struct Tile {
        int32_t x, y, level, width, height;
    };
    std::vector<Tile> tiles = {{0, 0, 0, 4, 2}, {1, 0, 0, 1, 2}, {0, 1, 0, 4, 1}, {1, 1, 0, 1, 1}};
    if (mipmaps)
        tiles.insert(tiles.end(), {{0, 0, 1, 2, 1}, {0, 0, 2, 1, 1}});
    uint64_t offset = bytes.size() + tiles.size() * 8;
    for (const Tile& tile : tiles) {
        put(offset);
        offset += static_cast<uint64_t>(20 + tile.width * tile.height * 4);
    }
    for (const Tile& tile : tiles) {
        put(std::array<int32_t, 5>{tile.x, tile.y, tile.level, tile.level, tile.width * tile.height * 4});
        for (int y = 0; y < tile.height; ++y)
            for (int x = 0; x < tile.width; ++x)
                put(static_cast<float>(10 * (tile.y * 2 + y) + tile.x * 4 + x));
    }
    return bytes;
}

TEST(MediaExr, TilesAreReadAtFullResolution) {
    TemporaryDirectory directory;
    for (const bool mipmaps : {false, true}) {
        std::vector<char> bytes = make_tiled_file(mipmaps);
        test::write_bytes(directory / "tiled.exr", bytes);
        const ExrImage image = read_back(directory / "tiled.exr");
        ASSERT_EQ(image.parts.size(), 1u);
        EXPECT_EQ(image.parts[0].type, "tiledimage");
        EXPECT_EQ(image.parts[0].channels[0].values,
                  (std::vector<float>{0, 1, 2, 3, 4, 10, 11, 12, 13, 14, 20, 21, 22, 23, 24}));
        ASSERT_TRUE(write_exr(directory / "lines.exr", image));
        const ExrImage lines = read_back(directory / "lines.exr");
        EXPECT_EQ(lines.parts[0].type, "scanlineimage");
        EXPECT_EQ(lines.parts[0].channels[0].values, image.parts[0].channels[0].values);
        bytes.pop_back();
        test::write_bytes(directory / "tiled.exr", bytes);
        auto cut = read_exr(directory / "tiled.exr");
        ASSERT_FALSE(cut);
        EXPECT_NE(cut.error().message.find(mipmaps ? "5 of 6" : "3 of 4"), std::string::npos) << cut.error().message;
    }
}

// ------------------------------------------------------------------------------------------- broken files

TEST(MediaExrBroken, EveryTruncationIsAnError) {
    TemporaryDirectory directory;
    for (const bool several : {false, true}) {
        ExrImage image = make_image();
        if (several) {
            image.parts.push_back(make_part("b.", {0, 0, 5, 5}));
            image.parts[0].name = "a";
            image.parts[1].name = "b";
        }
        ASSERT_TRUE(write_exr(directory / "whole.exr", image));
        const std::vector<char> whole = test::read_bytes(directory / "whole.exr");
        for (size_t length = 0; length < whole.size(); ++length) {
            test::write_bytes(directory / "cut.exr", {whole.begin(), whole.begin() + static_cast<ptrdiff_t>(length)});
            const std::string error = error_of(directory / "cut.exr");
            ASSERT_NE(error, "") << length << " of " << whole.size();
            if (length >= 8) {
                ASSERT_NE(error.find("truncated"), std::string::npos) << length << ": " << error;
            }
        }
    }
}

TEST(MediaExrBroken, BitFlipsNeverCrash) {
    TemporaryDirectory directory;
    ExrImage image = make_image();
    image.parts[0].set_string_attribute("comment", "text");
    image.parts[0].attributes.push_back({"v", "stringvector", {1, 0, 0, 0, 'a'}});
    for (const auto compression : {ExrCompression::none, ExrCompression::zip, ExrCompression::piz}) {
        ExrWriteOptions options;
        options.compression = compression;
        options.sync = false;
        ASSERT_TRUE(write_exr(directory / "whole.exr", image, options));
        const std::vector<char> whole = test::read_bytes(directory / "whole.exr");
        size_t errors = 0;
        for (size_t bit = 0; bit < whole.size() * 8; bit += 3) {
            std::vector<char> broken = whole;
            broken[bit / 8] = static_cast<char>(broken[bit / 8] ^ (1 << (bit % 8)));
            test::write_bytes(directory / "broken.exr", broken);
            errors += read_exr(directory / "broken.exr") ? 0 : 1;
        }
        EXPECT_GT(errors, 100u);
    }
}

// Writes a small file and changes the bytes that follow an attribute's name, type and size.
std::filesystem::path patched(const TemporaryDirectory& directory, const std::string& marker,
                              const std::function<void(char*)>& change) {
    EXPECT_TRUE(write_exr(directory / "base.exr", make_image()));
    std::vector<char> bytes = test::read_bytes(directory / "base.exr");
    const std::string text(bytes.begin(), bytes.end());
    const size_t at = text.find(marker);
    EXPECT_NE(at, std::string::npos);
    change(bytes.data() + at + marker.size());
    test::write_bytes(directory / "patched.exr", bytes);
    return directory / "patched.exr";
}

void put_window(char* value, int32_t width, int32_t height) {
    const int32_t corners[4] = {0, 0, width - 1, height - 1};
    std::memcpy(value + 4, corners, 16); // after the attribute's size
}

const std::string data_window_marker = std::string("dataWindow\0box2i\0", 17);

TEST(MediaExrBroken, HugeHeadersNameSizeAndLimit) {
    TemporaryDirectory directory;
    const auto path = patched(directory, data_window_marker, [](char* value) { put_window(value, 65536, 65536); });
    const std::string error = error_of(path);
    EXPECT_NE(error.find("65536x65536"), std::string::npos) << error;
    EXPECT_NE(error.find("limit of 536 megapixels"), std::string::npos) << error;
    for (const auto& [width, height] :
         {std::pair{std::numeric_limits<int32_t>::max(), 1}, {1, 2000000}, {0, 5}, {-5, 5}})
        EXPECT_NE(error_of(patched(directory, data_window_marker,
                                   [w = width, h = height](char* value) { put_window(value, w, h); })),
                  "");
    // Corners whose difference does not fit in 32 bits.
    const auto wrapped = patched(directory, data_window_marker, [](char* value) {
        const int32_t corners[4] = {std::numeric_limits<int32_t>::min(), 0, std::numeric_limits<int32_t>::max(), 0};
        std::memcpy(value + 4, corners, 16);
    });
    EXPECT_NE(error_of(wrapped).find("4294967296x1"), std::string::npos);
}

TEST(MediaExrBroken, AHeaderCannotPromiseMoreThanTheFileHolds) {
    TemporaryDirectory directory;
    const auto path = patched(directory, data_window_marker, [](char* value) { put_window(value, 20000, 20000); });
    const std::string error = error_of(path);
    EXPECT_NE(error.find("promises 20000x20000"), std::string::npos) << error;
}

TEST(MediaExrBroken, LimitsAreTheCallers) {
    TemporaryDirectory directory;
    ASSERT_TRUE(write_exr(directory / "a.exr", make_image()));
    ExrReadOptions options;
    options.limits.max_pixels = 119;
    EXPECT_NE(error_of(directory / "a.exr", options), "");
    options.limits.max_pixels = 120;
    EXPECT_EQ(error_of(directory / "a.exr", options), "");
    options.limits.max_channels = 2;
    EXPECT_NE(error_of(directory / "a.exr", options), "");
    options.limits.max_channels = 3;
    options.limits.max_memory = 120 * 3 * 4 - 1;
    EXPECT_NE(error_of(directory / "a.exr", options), "");
    options.limits.max_memory = 120 * 3 * 4;
    options.limits.max_header = 100;
    EXPECT_NE(error_of(directory / "a.exr", options).find("limit of 100 bytes"), std::string::npos);
}

TEST(MediaExrBroken, SubSampledDeepAndUnknownAreNamed) {
    TemporaryDirectory directory;
    const auto sampled = patched(directory, std::string("R\0", 2), [](char* value) { value[8] = 2; });
    EXPECT_NE(error_of(sampled).find("sub-sampled 2x1"), std::string::npos);
    ASSERT_TRUE(write_exr(directory / "a.exr", make_image()));
    std::vector<char> bytes = test::read_bytes(directory / "a.exr");
    bytes[5] = 0x08; // the flag of deep data
    test::write_bytes(directory / "deep.exr", bytes);
    EXPECT_NE(error_of(directory / "deep.exr").find("deep"), std::string::npos);
    test::write_bytes(directory / "text.exr", {'h', 'e', 'l', 'l', 'o', ' ', 'w', 'o', 'r', 'l', 'd'});
    EXPECT_NE(error_of(directory / "text.exr").find("not an OpenEXR file"), std::string::npos);
    test::write_bytes(directory / "empty.exr", {});
    EXPECT_NE(error_of(directory / "empty.exr").find("truncated"), std::string::npos);
    EXPECT_NE(error_of(directory / "missing.exr").find("No such file"), std::string::npos);
    EXPECT_NE(error_of(directory.path()), "");
}

// ------------------------------------------------------------------------------------------ atomic writing

TEST(MediaExrWrite, NoClobberKeepsTheOldFile) {
    TemporaryDirectory directory;
    test::write_bytes(directory / "a.exr", {'o', 'l', 'd'});
    ExrWriteOptions options;
    options.no_clobber = true;
    auto written = write_exr(directory / "a.exr", make_image(), options);
    ASSERT_FALSE(written);
    EXPECT_NE(written.error().message.find("exists already"), std::string::npos);
    EXPECT_EQ(test::read_bytes(directory / "a.exr").size(), 3u);
    EXPECT_EQ(directory.file_count(), 1u);
    EXPECT_TRUE(write_exr(directory / "b.exr", make_image(), options));
    EXPECT_EQ(directory.file_count(), 2u);
    EXPECT_TRUE(write_exr(directory / "a.exr", make_image()));
    expect_same(make_image().parts[0], read_back(directory / "a.exr").parts[0]);
}

TEST(MediaExrWrite, FailuresNameTheCauseAndLeaveNothing) {
    TemporaryDirectory directory;
    auto missing = write_exr(directory / "no/such/a.exr", make_image());
    ASSERT_FALSE(missing);
    EXPECT_NE(missing.error().message.find("No such file or directory"), std::string::npos);
    std::filesystem::create_directory(directory / "folder.exr");
    auto folder = write_exr(directory / "folder.exr", make_image());
    ASSERT_FALSE(folder);
    EXPECT_NE(folder.error().message.find("Is a directory"), std::string::npos);
    EXPECT_FALSE(write_exr("/dev/full", make_image()));
    ExrImage wrong = make_image();
    wrong.parts[0].channels[0].values.pop_back();
    auto mistake = write_exr(directory / "wrong.exr", wrong);
    ASSERT_FALSE(mistake);
    EXPECT_EQ(mistake.error().code, ErrorCode::invalid_argument);
    EXPECT_EQ(directory.file_count(), 1u);
}

TEST(MediaExrWrite, AFullDiskLeavesTheOldFileAndNoTemporary) {
    TemporaryDirectory directory;
    test::write_bytes(directory / "a.exr", {'o', 'l', 'd'});
    ExrImage image;
    image.parts.emplace_back();
    image.parts[0].data_window = image.parts[0].display_window = {0, 0, 255, 255};
    image.parts[0].set_channel("R", std::vector<float>(65536, 1.0f), PixelType::float32);
    ExrWriteOptions options;
    options.compression = ExrCompression::none;
    // A limit on file size fails as a full disk does, after a part is written.
    rlimit before = {};
    ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
    const auto handler = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit small = {100'000, before.rlim_max};
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
    auto written = write_exr(directory / "a.exr", image, options);
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
    std::signal(SIGXFSZ, handler);
    ASSERT_FALSE(written);
    EXPECT_NE(written.error().message.find("File too large"), std::string::npos) << written.error().message;
    EXPECT_EQ(test::read_bytes(directory / "a.exr").size(), 3u);
    EXPECT_EQ(directory.file_count(), 1u);
}

TEST(MediaExrWrite, LinksAreFollowed) {
    TemporaryDirectory directory;
    test::write_bytes(directory / "real.exr", {'o', 'l', 'd'});
    std::filesystem::create_symlink("real.exr", directory / "link.exr");
    ASSERT_TRUE(write_exr(directory / "link.exr", make_image()));
    EXPECT_TRUE(std::filesystem::is_symlink(directory / "link.exr"));
    expect_same(make_image().parts[0], read_back(directory / "real.exr").parts[0]);
}

TEST(MediaExr, RenderedFrameRoundTrips) {
    SKIP_WITHOUT_KINETIC();
    TemporaryDirectory directory;
    const ExrImage image = read_back(test::kinetic_folder() / "kinetic.0006.exr");
    ASSERT_EQ(image.parts.size(), 1u);
    EXPECT_EQ(image.parts[0].width(), 960);
    EXPECT_EQ(image.parts[0].channels.size(), 15u);
    EXPECT_TRUE(image.parts[0].string_attribute("BlenderMultiChannel"));
    ASSERT_TRUE(write_exr(directory / "a.exr", image));
    expect_same(image.parts[0], read_back(directory / "a.exr").parts[0]);
}

} // namespace
} // namespace sfumato::media
