#include "tests/gltf/gltf_builder.h"

#include <cstring>
#include <iterator>
#include <unistd.h>

namespace sfumato::test {

void GltfTest::SetUp() {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ =
        std::filesystem::temp_directory_path() / ("sfumato_gltf_" + std::to_string(getpid()) + "_" + info->name());
    std::filesystem::create_directories(folder_);
}

void GltfTest::TearDown() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
}

std::filesystem::path GltfTest::write(const std::string& name, const Bytes& bytes) const {
    std::filesystem::create_directories((folder_ / name).parent_path());
    std::ofstream file(folder_ / name, std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    return folder_ / name;
}

std::filesystem::path GltfTest::write(const std::string& name, const std::string& text) const {
    return write(name, Bytes(text.begin(), text.end()));
}

scene::Model GltfTest::load(const std::filesystem::path& path) const {
    auto model = scene::load_model(path);
    if (!model)
        throw std::runtime_error(model.error().message);
    return std::move(model).value();
}

std::string GltfTest::refusal(const std::filesystem::path& path, const scene::LoadLimits& limits) const {
    const auto model = scene::load_model(path, limits);
    if (model)
        return "";
    std::string message = model.error().message;
    EXPECT_EQ(model.error().code, ErrorCode::input) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    EXPECT_TRUE(message.starts_with(path.string() + ": ")) << message;
    return message.substr(std::min(message.size(), path.string().size() + 2));
}

std::filesystem::path sample_model(const std::string& name) {
    const std::filesystem::path path = std::filesystem::path(SFUMATO_SOURCE_DIR) / "../shared/data/gltf" / name;
    return std::filesystem::exists(path) ? path : std::filesystem::path();
}

Bytes read_file(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return Bytes{std::istreambuf_iterator<char>(file), {}};
}

std::string base64(const Bytes& bytes) {
    constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string result;
    for (size_t i = 0; i < bytes.size(); i += 3) {
        uint32_t bits = 0;
        for (size_t k = 0; k < 3; ++k)
            bits = bits << 8 | (i + k < bytes.size() ? bytes[i + k] : 0u);
        for (size_t k = 0; k < 4; ++k)
            result += i + k <= bytes.size() ? digits[bits >> (18 - 6 * k) & 63u] : '=';
    }
    return result;
}

Bytes png() {
    return {0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44, 0x52,
            0x00, 0x00, 0x00, 0x02, 0x00, 0x00, 0x00, 0x02, 0x08, 0x06, 0x00, 0x00, 0x00, 0x72, 0xb6, 0x0d,
            0x24, 0x00, 0x00, 0x00, 0x13, 0x49, 0x44, 0x41, 0x54, 0x78, 0x9c, 0x63, 0xf8, 0xcf, 0xc0, 0xf0,
            0x1f, 0x0c, 0x81, 0x34, 0x08, 0x34, 0x00, 0x00, 0x49, 0x49, 0x09, 0x78, 0x28, 0xa0, 0xdb, 0x77,
            0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};
}

Json& GltfBuilder::add_square() {
    const size_t positions = accessor<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, "VEC3");
    const size_t indices = accessor<uint16_t>({0, 1, 2, 0, 2, 3}, "SCALAR");
    const size_t mesh = root["meshes"].is_array() ? root["meshes"].size() : 0;
    root["nodes"].push_back({{"mesh", mesh}});
    root["meshes"].push_back({{"primitives", {{{"attributes", {{"POSITION", positions}}}, {"indices", indices}}}}});
    return root["meshes"].back()["primitives"][0];
}

Bytes GltfBuilder::glb() const {
    Json with_buffer = root;
    with_buffer["buffers"] = {{{"byteLength", binary.size()}}};
    std::string json = with_buffer.dump();
    json.resize((json.size() + 3) / 4 * 4, ' ');
    Bytes padded = binary;
    padded.resize((padded.size() + 3) / 4 * 4);
    Bytes result;
    const auto word = [&](size_t value) {
        for (size_t k = 0; k < 4; ++k)
            result.push_back(static_cast<uint8_t>(value >> (8 * k) & 255u));
    };
    word(0x46546c67);
    word(2);
    word(12 + 8 + json.size() + 8 + padded.size());
    word(json.size());
    word(0x4e4f534a);
    result.insert(result.end(), json.begin(), json.end());
    word(padded.size());
    word(0x004e4942);
    result.insert(result.end(), padded.begin(), padded.end());
    return result;
}

std::string GltfBuilder::gltf(const std::string& buffer_uri) const {
    Json with_buffer = root;
    with_buffer["buffers"] = {{{"byteLength", binary.size()}, {"uri", buffer_uri}}};
    return with_buffer.dump();
}

std::string GltfBuilder::embedded() const {
    return gltf("data:application/octet-stream;base64," + base64(binary));
}

} // namespace sfumato::test
