// What the viewer renders while a camera is moved by hand, on the device.
#include "apps/viewer/picture_renderer.h"
#include "scene/vec3.h"

#include <cmath>
#include <gtest/gtest.h>

namespace sfumato::viewer {
namespace {

class ViewerPicture : public testing::Test {
  protected:
    void SetUp() override {
        apps::DeviceOptions options;
        options.validation = true;
        auto device = apps::Device::create(options);
        ASSERT_TRUE(device) << device.error().message;
        device_ = std::move(*device);
        const auto chosen = choose_scene({.scene = "still"});
        ASSERT_TRUE(chosen);
        auto renderer = PictureRenderer::create(*device_, chosen->open);
        ASSERT_TRUE(renderer) << renderer.error().message;
        renderer_ = std::move(*renderer);
        request_.extent = {96, 54};
        request_.frame = 12;
        request_.viewpoint = scene::View{{0.5, 1.5, 6}, {0, -0.1, -1}, {0, 1, 0}, 45.0};
        request_.viewpoint_text = "here";
    }

    void TearDown() override {
        renderer_.reset();
        if (device_) {
            for (const std::string& message : device_->validation_messages())
                ADD_FAILURE() << message;
        }
    }

    std::vector<float> read(const char* id) {
        auto values = renderer_->read(id);
        EXPECT_TRUE(values);
        return values ? *values : std::vector<float>{};
    }

    std::unique_ptr<apps::Device> device_;
    std::unique_ptr<PictureRenderer> renderer_;
    PictureRequest request_;
};

TEST_F(ViewerPicture, a_moved_camera_has_the_velocities_of_its_way) {
    ASSERT_TRUE(renderer_->settle(request_));
    for (const float value : read("velocity"))
        ASSERT_EQ(value, 0.0f); // it stands still
    // A step to the right: everything moves to the left by the step over its depth.
    constexpr double step = 0.3;
    const scene::View before = *request_.viewpoint;
    request_.viewpoint->eye.x += step;
    ASSERT_TRUE(renderer_->follow(request_, before, false));
    const auto velocity = read("velocity"), next = read("next_velocity"), depth = read("depth");
    const double focal = request_.extent.height / 2.0 / std::tan(scene::radians(before.view_angle) / 2.0);
    size_t seen = 0;
    for (size_t i = 0; i < depth.size(); ++i) {
        const double z = static_cast<double>(depth[i]);
        const double expected = z > 1e9 ? 0.0 : -focal * step / z;
        ASSERT_NEAR(static_cast<double>(velocity[i * 2]), expected, 2e-3 * std::abs(expected) + 1e-3) << i;
        ASSERT_NEAR(static_cast<double>(velocity[i * 2 + 1]), 0.0, 1e-3) << i;
        ASSERT_NEAR(static_cast<double>(next[i * 2]), expected, 2e-3 * std::abs(expected) + 1e-3) << i;
        seen += z < 1e9 ? 1 : 0;
    }
    EXPECT_GT(seen, depth.size() / 2);
    // After a cut nothing has moved.
    ASSERT_TRUE(renderer_->follow(request_, before, true));
    for (const float value : read("velocity"))
        ASSERT_EQ(value, 0.0f);
}

TEST_F(ViewerPicture, a_frozen_picture_stays) {
    ASSERT_TRUE(renderer_->settle(request_));
    const auto before = read("result");
    ASSERT_TRUE(renderer_->freeze());
    request_.viewpoint->eye.x += 1.0;
    ASSERT_TRUE(renderer_->settle(request_));
    EXPECT_NE(read("result"), before);
    EXPECT_EQ(read("frozen"), before);
    EXPECT_FALSE(renderer_->times().empty() && device_->timestamps());
}

} // namespace
} // namespace sfumato::viewer
