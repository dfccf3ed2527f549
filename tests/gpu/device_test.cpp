// The programs' own device: choice, upload and read-back in every format, several devices, frames in flight.
#include "apps/common/device.h"
#include "apps/common/pixels.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

namespace sfumato::apps {
namespace {

std::unique_ptr<Device> make_device() {
    auto device = Device::create({.device = "", .validation = true, .labels = true});
    EXPECT_TRUE(device) << (device ? "" : device.error().message);
    return device ? std::move(*device) : nullptr;
}

TEST(Pixels, HalvesRoundTripAndRoundToNearestEven) {
    for (uint32_t bits = 0; bits < 65536; ++bits) {
        const float value = float_from_half(static_cast<uint16_t>(bits));
        if (!std::isnan(value)) {
            ASSERT_EQ(half_from_float(value), bits);
        }
    }
    EXPECT_EQ(half_from_float(1.0f), 0x3c00);
    EXPECT_EQ(half_from_float(1.0f + 0x1p-11f), 0x3c00);     // tie, to even
    EXPECT_EQ(half_from_float(1.0f + 3 * 0x1p-11f), 0x3c02); // tie, to even
    EXPECT_EQ(half_from_float(1.0f + 0x1p-11f + 0x1p-20f), 0x3c01);
    EXPECT_EQ(half_from_float(0x1p-25f), 0x0000);
    EXPECT_EQ(half_from_float(0x1.8p-25f), 0x0001);
    EXPECT_EQ(half_from_float(65519.0f), 0x7bff);
    EXPECT_EQ(half_from_float(65520.0f), 0x7c00);
    EXPECT_EQ(half_from_float(-std::numeric_limits<float>::infinity()), 0xfc00);
    EXPECT_TRUE(std::isnan(float_from_half(half_from_float(std::numeric_limits<float>::quiet_NaN()))));
}

TEST(Device, ListsDevicesAndRefusesUnknownOnes) {
    const auto devices = list_devices();
    ASSERT_TRUE(devices) << devices.error().message;
    ASSERT_FALSE(devices->empty());
    EXPECT_FALSE(devices->front().name.empty());
    const auto unknown = Device::create({.device = "no such device"});
    ASSERT_FALSE(unknown);
    EXPECT_EQ(unknown.error().code, ErrorCode::unsupported);
    EXPECT_NE(unknown.error().message.find(devices->front().name), std::string::npos) << unknown.error().message;
    EXPECT_TRUE(Device::create({.device = "0"}));
    EXPECT_TRUE(Device::create({.device = devices->front().name.substr(0, 4)}));
}

TEST(Device, UploadsAndReadsBackEveryFormat) {
    const auto device = make_device();
    ASSERT_TRUE(device);
    const Extent extent{7, 3};
    std::vector<float> values(7 * 3 * 3);
    for (size_t i = 0; i < values.size(); ++i)
        values[i] = static_cast<float>(i) / 64.0f;
    for (const VkFormat format : {VK_FORMAT_R8_UNORM, VK_FORMAT_R8G8_UNORM, VK_FORMAT_R8G8B8A8_UNORM,
                                  VK_FORMAT_R16_SFLOAT, VK_FORMAT_R16G16_SFLOAT, VK_FORMAT_R16G16B16A16_SFLOAT,
                                  VK_FORMAT_R32_SFLOAT, VK_FORMAT_R32G32_SFLOAT, VK_FORMAT_R32G32B32A32_SFLOAT}) {
        auto image = device->create_image(format, extent);
        ASSERT_TRUE(image) << image.error().message;
        const auto empty = device->readback(*image);
        ASSERT_TRUE(empty);
        for (const float value : *empty)
            EXPECT_EQ(value, 0.0f);
        ASSERT_TRUE(device->upload(*image, values, 3));
        const auto back = device->readback(*image);
        ASSERT_TRUE(back);
        const size_t components = find_pixel_format(format)->components;
        ASSERT_EQ(back->size(), 21 * components);
        for (size_t i = 0; i < back->size(); ++i) {
            const size_t channel = i % components;
            EXPECT_NEAR((*back)[i], channel == 3 ? 1.0f : values[i / components * 3 + channel], 0.002f);
        }
        const auto bytes = device->readback_bytes(*image);
        ASSERT_TRUE(bytes);
        ASSERT_TRUE(device->upload_bytes(*image, *bytes));
        EXPECT_EQ(*device->readback(*image), *back);
        EXPECT_FALSE(device->upload(*image, values, 2));
        EXPECT_FALSE(device->upload_bytes(*image, std::span(*bytes).first(1)));
    }
    EXPECT_TRUE(device->validation_messages().empty());
}

TEST(Device, RefusesImagesThatCannotBe) {
    const auto device = make_device();
    ASSERT_TRUE(device);
    EXPECT_FALSE(device->create_image(VK_FORMAT_R32_SFLOAT, {0, 4}));
    EXPECT_FALSE(device->create_image(VK_FORMAT_R32_SFLOAT, {1u << 20, 4}));
    EXPECT_FALSE(device->create_image(VK_FORMAT_UNDEFINED, {4, 4}));
    EXPECT_FALSE(device->upload(HostImage{}, {}, 1));
    EXPECT_TRUE(device->validation_messages().empty());
}

TEST(Device, KeepsFramesInFlightOnTwoDevicesAtOnce) {
    const auto first = make_device(), second = make_device();
    ASSERT_TRUE(first && second);
    for (Device* device : {first.get(), second.get()}) {
        auto image = device->create_image(VK_FORMAT_R32_SFLOAT, {4, 4});
        auto buffer = device->create_buffer(64);
        auto result = device->create_buffer(64);
        ASSERT_TRUE(image && buffer && result);
        std::fill(buffer->bytes().begin(), buffer->bytes().end(), std::byte{0x3f});
        Commands flights[2];
        for (Commands& commands : flights) {
            auto made = device->create_commands();
            ASSERT_TRUE(made);
            commands = std::move(*made);
            ASSERT_TRUE(device->begin(commands));
            device->record_upload(commands.buffer(), *buffer, *image);
            device->record_readback(commands.buffer(), *image, *result);
            ASSERT_TRUE(device->submit(commands));
            EXPECT_TRUE(commands.pending());
        }
        for (Commands& commands : flights)
            ASSERT_TRUE(device->wait(commands));
        EXPECT_EQ(result->bytes()[63], std::byte{0x3f});
        EXPECT_TRUE(device->validation_messages().empty());
    }
}

} // namespace
} // namespace sfumato::apps
