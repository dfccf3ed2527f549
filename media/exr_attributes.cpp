// Look-up and change of the attributes and channels of a part.
#include <algorithm>
#include <utility>

#include "exr_file.h"
#include "exr_scan.h"

namespace sfumato::media {

const ExrChannel* ExrPart::find_channel(std::string_view channel_name) const {
    for (const ExrChannel& channel : channels)
        if (channel.name == channel_name)
            return &channel;
    return nullptr;
}

const ExrAttribute* ExrPart::find_attribute(std::string_view attribute_name) const {
    for (const ExrAttribute& attribute : attributes)
        if (attribute.name == attribute_name)
            return &attribute;
    return nullptr;
}

std::optional<std::string> ExrPart::string_attribute(std::string_view attribute_name) const {
    const ExrAttribute* attribute = find_attribute(attribute_name);
    if (!attribute || attribute->type != "string")
        return std::nullopt;
    return std::string(attribute->bytes.begin(), attribute->bytes.end());
}

std::optional<double> ExrPart::number_attribute(std::string_view attribute_name) const {
    const ExrAttribute* attribute = find_attribute(attribute_name);
    if (!attribute)
        return std::nullopt;
    const std::vector<char>& bytes = attribute->bytes;
    if (attribute->type == "float" && bytes.size() == 4)
        return double{load_f32(bytes.data())};
    if (attribute->type == "int" && bytes.size() == 4)
        return double{static_cast<double>(load_i32(bytes.data()))};
    if (attribute->type == "double" && bytes.size() == 8)
        return load_f64(bytes.data());
    return std::nullopt;
}

std::optional<std::array<double, 16>> ExrPart::matrix_attribute(std::string_view attribute_name) const {
    const ExrAttribute* attribute = find_attribute(attribute_name);
    if (!attribute)
        return std::nullopt;
    const std::vector<char>& bytes = attribute->bytes;
    const bool single = attribute->type == "m44f" && bytes.size() == 64;
    if (!single && (attribute->type != "m44d" || bytes.size() != 128))
        return std::nullopt;
    std::array<double, 16> matrix = {};
    for (size_t i = 0; i < 16; ++i)
        matrix[i] = single ? double{load_f32(&bytes[i * 4])} : load_f64(&bytes[i * 8]);
    return matrix;
}

void ExrPart::set_string_attribute(std::string_view attribute_name, std::string_view value) {
    ExrAttribute attribute{std::string(attribute_name), "string", {value.begin(), value.end()}};
    for (ExrAttribute& existing : attributes) {
        if (existing.name == attribute_name) {
            existing = std::move(attribute);
            return;
        }
    }
    attributes.push_back(std::move(attribute));
}

void ExrPart::set_channel(std::string_view channel_name, std::vector<float> values, PixelType pixel_type) {
    auto place =
        std::find_if(channels.begin(), channels.end(), [&](const ExrChannel& c) { return c.name == channel_name; });
    if (place == channels.end()) {
        // The file's own order is alphabetical.
        place =
            std::find_if(channels.begin(), channels.end(), [&](const ExrChannel& c) { return c.name > channel_name; });
        place = channels.insert(place, ExrChannel{});
        place->name = channel_name;
    }
    place->type = pixel_type;
    place->values = std::move(values);
    place->integers.clear();
}

} // namespace sfumato::media
