// Small glTF files for tests, put together piece by piece.
#pragma once

#include "scene/gltf/model.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace sfumato::test {

using Json = nlohmann::json;
using Bytes = std::vector<uint8_t>;

// A folder of its own for each test, gone at its end.
class GltfTest : public testing::Test {
  protected:
    void SetUp() override;
    void TearDown() override;
    std::filesystem::path write(const std::string& name, const Bytes& bytes) const;
    std::filesystem::path write(const std::string& name, const std::string& text) const;

    scene::Model load(const std::filesystem::path& path) const; // fails the test if it is refused
    // The message without the path, or "" if the file loads. One line.
    std::string refusal(const std::filesystem::path& path, const scene::LoadLimits& limits = {}) const;

    std::filesystem::path folder_;
};

// The project's sample models, or nothing if this checkout has none beside it.
std::filesystem::path sample_model(const std::string& name);

Bytes read_file(const std::filesystem::path& path);
std::string base64(const Bytes& bytes);
Bytes png(); // 2 × 2 pixels: red, green, blue, white with alpha 128

class GltfBuilder {
  public:
    Json root = {{"asset", {{"version", "2.0"}}}};
    Bytes binary;

    template <class T>
    size_t view(const std::vector<T>& values) {
        while (binary.size() % 4 != 0)
            binary.push_back(0);
        const size_t size = values.size() * sizeof(T), offset = binary.size();
        const auto* first = reinterpret_cast<const uint8_t*>(values.data());
        binary.insert(binary.end(), first, first + size);
        root["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", offset}, {"byteLength", size}});
        return root["bufferViews"].size() - 1;
    }

    template <class T>
    size_t accessor(const std::vector<T>& values, const std::string& type, bool normalised = false) {
        const size_t components = type == "SCALAR" ? 1 : type == "MAT4" ? 16 : static_cast<size_t>(type[3] - '0');
        Json result = {{"bufferView", view(values)},
                       {"componentType", component_type(T{})},
                       {"count", values.size() / components},
                       {"type", type}};
        if (normalised)
            result["normalized"] = true;
        root["accessors"].push_back(std::move(result));
        return root["accessors"].size() - 1;
    }

    // A unit square in the plane z = 0, and a node that shows it. Returns its primitive.
    Json& add_square();

    Bytes glb() const;
    std::string gltf(const std::string& buffer_uri) const;
    std::string embedded() const; // with a data URI

  private:
    static int component_type(float) { return 5126; }
    static int component_type(uint32_t) { return 5125; }
    static int component_type(uint16_t) { return 5123; }
    static int component_type(int16_t) { return 5122; }
    static int component_type(uint8_t) { return 5121; }
    static int component_type(int8_t) { return 5120; }
};

} // namespace sfumato::test
