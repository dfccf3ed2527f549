// Channels and attributes of rendered frames.
#include "apps/cli/render_file.h"

#include "media/camera_file.h"

#include <cmath>
#include <cstring>

namespace sfumato::cli {

namespace {

using media::PixelType;

void add_channels(media::ExrPart& part, const RenderedPass& pass, const std::vector<std::string>& names,
                  PixelType type) {
    for (size_t c = 0; c < names.size() && c < pass.components; ++c) {
        std::vector<float> plane(part.pixel_count());
        for (size_t i = 0; i < plane.size(); ++i)
            plane[i] = pass.values[i * pass.components + c];
        part.set_channel(names[c], std::move(plane), type);
    }
}

void add_matrix(media::ExrPart& part, const char* name, const Matrix4& matrix) {
    // Columns of a matrix for column vectors are the rows of one for row vectors.
    media::ExrAttribute attribute{name, "m44f", std::vector<char>(sizeof(float) * 16)};
    std::memcpy(attribute.bytes.data(), matrix.data(), attribute.bytes.size());
    part.attributes.push_back(std::move(attribute));
}

// The name of a truth, which has that of an effect's result unless that is there as well.
std::string beside(const RenderedFrame& frame, const std::string& name) {
    return frame.passes.contains("AO") ? "truth." + name : name;
}

std::vector<std::string> of_vector(const std::string& name) {
    return {name + ".X", name + ".Y", name + ".Z"};
}

// The standard attributes: worldToCamera is left-handed, +Z forward; worldToNDC goes to 0…1, y down.
void add_camera(media::ExrPart& part, const Camera& camera) {
    Matrix4 to_camera = camera.world_to_view;
    for (size_t column = 0; column < 4; ++column)
        to_camera[column * 4 + 2] = -to_camera[column * 4 + 2];
    const Matrix4 to_unit = {0.5f, 0, 0, 0, 0, 0.5f, 0, 0, 0, 0, 1, 0, 0.5f, 0.5f, 0, 1};
    add_matrix(part, "worldToCamera", to_camera);
    add_matrix(part, "worldToNDC", media::multiply(to_unit, media::multiply(camera.projection, camera.world_to_view)));
}

void add_rate(media::ExrPart& part, double frames_per_second) {
    const auto numerator = static_cast<int32_t>(std::lround(frames_per_second * 1000.0));
    const uint32_t denominator = 1000;
    media::ExrAttribute attribute{"framesPerSecond", "rational", std::vector<char>(8)};
    std::memcpy(attribute.bytes.data(), &numerator, 4);
    std::memcpy(attribute.bytes.data() + 4, &denominator, 4);
    part.attributes.push_back(std::move(attribute));
}

} // namespace

media::ExrImage rendered_image(const RenderedFrame& frame, bool full_float) {
    media::ExrPart part;
    part.data_window = {0, 0, static_cast<int32_t>(frame.extent.width) - 1,
                        static_cast<int32_t>(frame.extent.height) - 1};
    part.display_window = part.data_window;
    const PixelType colour_type = full_float ? PixelType::float32 : PixelType::half;
    for (const auto& [name, pass] : frame.passes) {
        if (name == "colour")
            add_channels(part, pass, {"R", "G", "B", "A"}, colour_type);
        else if (name == "depth")
            add_channels(part, pass, {"Z"}, PixelType::float32);
        else if (name == "normal")
            add_channels(part, pass, {"N.X", "N.Y", "N.Z"}, PixelType::half);
        else if (name == "velocity")
            add_channels(part, pass, {"sfumato_velocity.X", "sfumato_velocity.Y"}, PixelType::float32);
        else if (name == "next_velocity")
            add_channels(part, pass, {"sfumato_velocity.Z", "sfumato_velocity.W"}, PixelType::float32);
        else if (!pass.channels.empty())
            add_channels(part, pass, pass.channels, PixelType::float32);
        else if (name == "true_visibility")
            add_channels(part, pass, {beside(frame, "AO")}, PixelType::float32);
        else if (name == "true_bent_normal")
            add_channels(part, pass, of_vector(beside(frame, "bent_normal")), PixelType::half);
        else if (pass.components == 1)
            add_channels(part, pass, {name}, colour_type);
        else
            add_channels(part, pass, {name + ".R", name + ".G", name + ".B"}, colour_type);
    }
    if (frame.passes.contains("velocity"))
        part.set_string_attribute("sfumato/velocity", "pixels a frame, +x right, +y down; X Y: current minus previous, "
                                                      "Z W: next minus current");
    if (frame.passes.contains("normal"))
        part.set_string_attribute("sfumato/normals", "view space, right-handed, +Z towards the camera");
    add_camera(part, frame.camera);
    add_rate(part, frame.frames_per_second);
    media::ExrImage image;
    image.parts.push_back(std::move(part));
    return image;
}

} // namespace sfumato::cli
