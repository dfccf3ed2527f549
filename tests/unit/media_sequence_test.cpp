// Frame ranges, patterns and discovery.
#include "media/sequence.h"

#include "media_test_support.h"

namespace sfumato::media {
namespace {

std::vector<int> frames(const std::string& text) {
    auto parsed = parse_frame_range(text);
    EXPECT_TRUE(parsed) << parsed.error().message;
    return parsed ? *parsed : std::vector<int>{};
}

FramePattern pattern(const std::string& text) {
    auto parsed = FramePattern::parse(text);
    EXPECT_TRUE(parsed) << parsed.error().message;
    return parsed ? *parsed : FramePattern{};
}

TEST(MediaSequence, RangesExpandInTheOrderWritten) {
    EXPECT_EQ(frames("7"), (std::vector<int>{7}));
    EXPECT_EQ(frames("1-4"), (std::vector<int>{1, 2, 3, 4}));
    EXPECT_EQ(frames("1-2,10-15x2"), (std::vector<int>{1, 2, 10, 12, 14}));
    EXPECT_EQ(frames("5-1x2"), (std::vector<int>{5, 3, 1}));
    EXPECT_EQ(frames("-3--1"), (std::vector<int>{-3, -2, -1}));
    EXPECT_EQ(frames("-1-1"), (std::vector<int>{-1, 0, 1}));
    EXPECT_EQ(frames(" 1 , 2 "), (std::vector<int>{1, 2}));
    EXPECT_EQ(frames("1-3,2-4"), (std::vector<int>{1, 2, 3, 4}));
    EXPECT_EQ(frames("1-1000000").size(), max_frames);
    EXPECT_EQ(frames("-2147483647-2147483647x4294967").size(), 1001u) << "the widest range";
}

TEST(MediaSequence, BadRangesAreErrors) {
    for (const char* text :
         {"",       ",",   "1,",    "a",   "1-",   "-",         "--1",         "1-2x",        "1-2x0",
          "1-2x-1", "1x2", "1-2-3", "1.5", "0x10", "1-1000001", "99999999999", "-2147483648", "1-99999999999999999999",
          "+1",     "1 2"}) {
        auto parsed = parse_frame_range(text);
        ASSERT_FALSE(parsed) << text;
        EXPECT_EQ(parsed.error().code, ErrorCode::invalid_argument);
    }
}

TEST(MediaSequence, FramesPrintShort) {
    EXPECT_EQ(format_frames({1, 2, 3, 7, 10, 12, 14}), "1-3,7,10-14x2");
    EXPECT_EQ(format_frames({5}), "5");
    EXPECT_EQ(format_frames({1, 5}), "1,5");
    EXPECT_EQ(format_frames({-3, -2, -1}), "-3--1");
    EXPECT_EQ(format_frames({}), "");
    for (const char* text : {"1-3,7,10-14x2", "9-1", "-5-5x5"})
        EXPECT_EQ(frames(format_frames(frames(text))), frames(text));
}

TEST(MediaSequence, PatternsNameFiles) {
    EXPECT_EQ(pattern("a/shot.####.exr").path_of(7), "a/shot.0007.exr");
    EXPECT_EQ(pattern("shot.%04d.exr").path_of(12345), "shot.12345.exr");
    EXPECT_EQ(pattern("shot.%d.exr").path_of(7), "shot.7.exr");
    EXPECT_EQ(pattern("shot.@.exr").path_of(70), "shot.70.exr");
    EXPECT_EQ(pattern("shot_#.exr").path_of(7), "shot_7.exr");
    EXPECT_EQ(pattern("s.####.exr").path_of(-5), "s.-005.exr");
    EXPECT_EQ(pattern("100%%.#.exr").path_of(1), "100%.1.exr");
    EXPECT_EQ(pattern("plain.0006.exr").path_of(3), "plain.0006.exr");
    EXPECT_FALSE(pattern("plain.exr").is_sequence());
    for (const char* bad : {"", "folder/", "a.#.#.exr", "a.%s.exr", "a.%", "a.%200d.exr", "a.%99999999999d.exr"})
        EXPECT_FALSE(FramePattern::parse(bad)) << bad;
}

TEST(MediaSequence, FileNamesGiveFramesBack) {
    const FramePattern padded = pattern("x/shot.####.exr");
    EXPECT_EQ(padded.frame_of("shot.0007.exr"), 7);
    EXPECT_EQ(padded.frame_of("shot.12345.exr"), 12345);
    EXPECT_EQ(padded.frame_of("shot.-005.exr"), -5);
    for (const char* other : {"shot.7.exr", "shot.00007.exr", "shot..exr", "shot.00a7.exr", "Shot.0007.exr",
                              "shot.0007.exr.tmp", "shot.99999999999.exr"})
        EXPECT_FALSE(padded.frame_of(other)) << other;
}

TEST(MediaSequence, FilesAreFoundAndHolesNamed) {
    test::TemporaryDirectory directory;
    for (const char* name : {"s.0010.exr", "s.0002.exr", "s.0003.exr", "s.-001.exr", "t.0004.exr", "s.0005.png"})
        test::write_bytes(directory / name, {'x'});
    const FramePattern s = pattern((directory / "s.####.exr").string());
    auto all = find_frames(s);
    ASSERT_TRUE(all);
    ASSERT_EQ(all->size(), 4u);
    EXPECT_EQ(all->front().frame, -1);
    EXPECT_EQ(all->back().path, directory / "s.0010.exr");
    auto some = find_frames(s, "3-2");
    ASSERT_TRUE(some);
    EXPECT_EQ((*some)[0].frame, 3);
    auto holes = find_frames(s, "2-10");
    ASSERT_FALSE(holes);
    EXPECT_EQ(holes.error().code, ErrorCode::input);
    EXPECT_NE(holes.error().message.find("6 of 9 frames missing: 4-9"), std::string::npos) << holes.error().message;
    EXPECT_FALSE(find_frames(pattern((directory / "none.#.exr").string())));
    EXPECT_FALSE(find_frames(pattern((directory / "no/folder.#.exr").string())));
}

TEST(MediaSequence, OneFileIsAFrameWithTheNumberOfItsName) {
    test::TemporaryDirectory directory;
    test::write_bytes(directory / "s.0010.exr", {'x'});
    const FramePattern one = pattern((directory / "s.0010.exr").string());
    auto found = find_frames(one);
    ASSERT_TRUE(found);
    EXPECT_EQ((*found)[0].frame, 10);
    EXPECT_FALSE(find_frames(one, "1-2"));
    EXPECT_FALSE(output_frames(one, {1, 2}));
    ASSERT_TRUE(output_frames(pattern("o.##.exr"), {1, 2}));
    EXPECT_EQ((*output_frames(pattern("o.##.exr"), {1, 2}))[1].path, "o.02.exr");
}

} // namespace
} // namespace sfumato::media
