// The small parts of the core: matrices, formats, results, and the reader of SPIR-V.
#include "core/formats.h"
#include "core/matrix.h"
#include "gpu/spirv.h"
#include "sfumato/sfumato.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

namespace sfumato {
namespace {

Matrix4 random_affine(std::mt19937& random) {
    std::uniform_real_distribution<float> value(-3.0f, 3.0f);
    Matrix4 m = identity_matrix;
    for (size_t column = 0; column < 4; ++column)
        for (size_t row = 0; row < 3; ++row)
            m[column * 4 + row] = value(random);
    return m;
}

TEST(Matrix, product_is_column_major) {
    Matrix4 move = identity_matrix, scale = identity_matrix;
    move[12] = 5.0f; // translation along x
    scale[0] = 2.0f;
    EXPECT_EQ(multiply(scale, move)[12], 10.0f); // moved first, then scaled
    EXPECT_EQ(multiply(move, scale)[12], 5.0f);
    EXPECT_EQ(multiply(identity_matrix, move), move);
    EXPECT_EQ(multiply(move, identity_matrix), move);
}

TEST(Matrix, inverse_of_affine_matrices) {
    std::mt19937 random(3);
    for (int i = 0; i < 200; ++i) {
        const Matrix4 m = random_affine(random);
        const double determinant = double{m[0]} * (double{m[5]} * m[10] - double{m[9]} * m[6]) -
                                   double{m[4]} * (double{m[1]} * m[10] - double{m[9]} * m[2]) +
                                   double{m[8]} * (double{m[1]} * m[6] - double{m[5]} * m[2]);
        if (std::abs(determinant) < 0.5)
            continue;
        const Matrix4 product = multiply(m, inverse(m));
        for (size_t k = 0; k < 16; ++k)
            EXPECT_NEAR(product[k], identity_matrix[k], 2e-4f) << i;
    }
}

TEST(Matrix, without_inverse_gives_identity) {
    Matrix4 flat = identity_matrix;
    flat[5] = 0.0f;
    EXPECT_EQ(inverse(flat), identity_matrix);
    flat[5] = NAN;
    EXPECT_EQ(inverse(flat), identity_matrix);
}

// A point of the jittered projection lands `jitter` pixels away from where the unjittered one puts it.
TEST(Matrix, jitter_is_taken_out_in_pixels) {
    const Extent extent{200, 100};
    Camera camera;
    camera.projection = {1.5f, 0, 0, 0, 0, -2.0f, 0, 0, 0.1f, 0.2f, 0, -1, 0, 0, 0.1f, 0};
    const Matrix4 plain = camera.projection;
    camera.jitter = {0.25f, -0.4f};
    const auto place = [&](const Matrix4& m, size_t axis) {
        const float point[4] = {0.3f, 0.7f, -4.0f, 1.0f};
        float clip = 0.0f, w = 0.0f;
        for (size_t k = 0; k < 4; ++k) {
            clip += m[k * 4 + axis] * point[k];
            w += m[k * 4 + 3] * point[k];
        }
        return 0.5f * clip / w * static_cast<float>(axis == 0 ? extent.width : extent.height);
    };
    // Jitter as a renderer adds it: a shift of clip space by 2 jitter / size.
    for (size_t k = 0; k < 4; ++k) {
        camera.projection[k * 4] += 2.0f * camera.jitter[0] / 200.0f * plain[k * 4 + 3];
        camera.projection[k * 4 + 1] += 2.0f * camera.jitter[1] / 100.0f * plain[k * 4 + 3];
    }
    EXPECT_NEAR(place(camera.projection, 0) - place(plain, 0), 0.25f, 1e-4f);
    EXPECT_NEAR(place(camera.projection, 1) - place(plain, 1), -0.4f, 1e-4f);
    const Matrix4 restored = unjittered_projection(camera, extent);
    for (size_t k = 0; k < 16; ++k)
        EXPECT_NEAR(restored[k], plain[k], 1e-6f);
}

TEST(Formats, table_is_consistent) {
    EXPECT_EQ(find_format(VK_FORMAT_UNDEFINED), nullptr);
    EXPECT_EQ(find_format(VK_FORMAT_R64_SFLOAT), nullptr);
    std::set<std::string> names;
    for (int value = 0; value < 200; ++value) {
        const FormatInfo* info = find_format(static_cast<VkFormat>(value));
        if (!info)
            continue;
        EXPECT_EQ(info->format, value);
        EXPECT_TRUE(names.insert(info->name).second) << info->name;
        EXPECT_TRUE(info->components >= 1 && info->components <= 4) << info->name;
        const std::string name = info->name;
        const bool signed_name = name.find("SFLOAT") != std::string::npos || name.find("SNORM") != std::string::npos;
        EXPECT_EQ(info->is_signed, signed_name) << name;
        EXPECT_EQ(info->is_depth, name.find('D') == 0 || name.find("X8_D24") == 0) << name;
        uint32_t channels = 0;
        for (const char c : name.substr(0, name.find('_')))
            channels += c == 'R' || c == 'G' || c == 'B' || c == 'A';
        EXPECT_TRUE(info->is_depth || info->components == channels) << name;
    }
    EXPECT_GE(names.size(), 20u);
}

TEST(Result, holds_a_value_or_an_error) {
    Result<std::string> good = std::string("value");
    ASSERT_TRUE(good);
    EXPECT_EQ(*good, "value");
    EXPECT_EQ(good->size(), 5u);
    const std::string moved = std::move(good).value();
    EXPECT_EQ(moved, "value");
    const Result<std::string> bad = Error{ErrorCode::input, "broken"};
    ASSERT_FALSE(bad);
    EXPECT_EQ(bad.error().code, ErrorCode::input);
    EXPECT_EQ(bad.error().message, "broken");
    EXPECT_TRUE(Result<void>());
    EXPECT_FALSE(Result<void>(Error{ErrorCode::internal, ""}));
    // A value type that an Error could convert to still is the right one.
    EXPECT_TRUE(Result<std::unique_ptr<int>>(std::make_unique<int>(3)));
}

TEST(Requirements, ask_for_no_extension) {
    const Requirements needs = requirements();
    EXPECT_EQ(needs.api_version, VK_API_VERSION_1_1);
    EXPECT_TRUE(needs.extensions.empty());
    EXPECT_EQ(needs.queue_flags, VkQueueFlags{VK_QUEUE_COMPUTE_BIT});
}

TEST(Spirv, broken_code_is_an_error) {
    const uint32_t magic = 0x07230203;
    const std::vector<std::vector<uint32_t>> broken = {
        {},
        {magic},
        {0, 0, 0, 0, 0, 0},
        {magic, 0x10300, 0, 0xffffffff, 0},    // more ids than memory
        {magic, 0x10300, 0, 8, 0, 0},          // an instruction of no words
        {magic, 0x10300, 0, 8, 0, 0x00090047}, // longer than the code
    };
    for (const auto& code : broken) {
        const auto shader = reflect_shader({"test/broken", code});
        ASSERT_FALSE(shader);
        EXPECT_NE(shader.error().message.find("test/broken"), std::string::npos);
    }
    // Words that make no sense are read without harm.
    std::mt19937 random(11);
    for (int round = 0; round < 2000; ++round) {
        std::vector<uint32_t> code = {magic, 0x10300, 0, 64, 0};
        for (int i = 0; i < 40; ++i)
            code.push_back(static_cast<uint32_t>(random() % 3 ? (1 + random() % 6) << 16 | random() % 80 : random()));
        (void)reflect_shader({"test/random", code});
    }
}

} // namespace
} // namespace sfumato
