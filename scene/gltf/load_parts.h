// What the parts of the glTF loader share. Inside of the loader a fault is an exception; load_model catches them all.
#pragma once

#include "scene/gltf/model.h"

// Files and images are read under the loader's own limits.
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#include <tiny_gltf.h>

#include <filesystem>
#include <map>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

namespace sfumato::scene::gltf {

using Bytes = std::vector<uint8_t>;

class LoadFailure : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

[[noreturn]] inline void fail(const std::string& message) {
    throw LoadFailure(message);
}

// For what is not asked often: `message` is put together each time.
inline void require(bool holds, const std::string& message) {
    if (!holds)
        fail(message);
}

// "accessors[3]"
inline std::string place(std::string_view array, size_t index) {
    return std::string(array) + "[" + std::to_string(index) + "]";
}

// Lengths and factors in a file are at most this large, so that products of a few of them stay finite in float.
inline constexpr double largest_number = 1e9;

// The files that belong to a model. Only those in the folder of the .gltf or below it are read.
class Files {
  public:
    Files(const std::filesystem::path& path, uint64_t limit);
    const Bytes& main() const { return main_; }
    // `uri` as it stands in the file: data:…;base64,… or a relative path with percent signs. `what` is for errors.
    Bytes read(const std::string& uri, const std::string& what);

  private:
    Bytes read_file(const std::filesystem::path& path, const std::string& what);
    std::filesystem::path folder_;
    uint64_t left_;
    Bytes main_;
};

struct Container {
    std::string_view json;
    std::span<const uint8_t> binary; // the .glb's own buffer, may be empty
};

Container open_container(std::span<const uint8_t> bytes);

struct ImageSource {
    std::string uri;
    uint32_t view = none; // in place of the uri
};

struct BufferSource {
    std::string uri;
    bool is_embedded = false; // in the .glb
    uint64_t size = 0;
};

// What is left to do after the JSON is known to be sound. All indices in `file` are in range or -1.
struct Document {
    tinygltf::Model file; // without buffers and images
    std::vector<BufferSource> buffer_sources;
    std::vector<ImageSource> images;
    std::vector<std::string> warnings;
};

// Checks the JSON: syntax, types, indices, required extensions; then tinygltf reads it.
Document parse_document(std::string_view json, const LoadLimits& limits);

struct Pixels {
    uint32_t width = 0, height = 0;
    std::vector<uint8_t> rgba;
};

// PNG or JPEG. `pixels_left` is lowered by the image's size.
Pixels decode_image(std::span<const uint8_t> bytes, const LoadLimits& limits, uint64_t& pixels_left,
                    const std::string& what);

// How a material's textures are mapped: all of its slots alike, and baked into the vertices.
struct TextureMapping {
    int set = 0; // of texture coordinates
    // u' = [0] u + [1] v + [2], v' = [3] u + [4] v + [5]
    std::array<double, 6> transform = {1, 0, 0, 0, 1, 0};
    bool operator==(const TextureMapping&) const = default;
};

// The state of one load.
struct Loader {
    Files files;
    LoadLimits limits;
    Document document;
    std::vector<Bytes> buffers;
    std::vector<Bytes> image_bytes;
    Model model;
    std::vector<TextureMapping> mappings;                    // of each material
    std::map<std::tuple<int, int, bool>, uint32_t> textures; // image, sampler, sRGB: index into Model::textures
    std::vector<uint32_t> node_of;                           // the file's nodes in Model::nodes
    uint32_t default_material = none;
    uint64_t pixels_left = 0, vertices_left = 0, target_vertices_left = 0, indices_left = 0, key_values_left = 0;

    const tinygltf::Model& file() const { return document.file; }
    void warn(const std::string& sentence); // once
};

// Lowers `left` by count · factor or fails.
void take(uint64_t& left, uint64_t count, uint64_t factor, const std::string& what);

std::span<const uint8_t> view_bytes(const Loader& loader, uint32_t view);

// All elements of an accessor, `components` floats each; normalised integers as 0…1 or -1…1, finite numbers of at most
// largest_number only. One of the types must be that of the accessor.
struct Floats {
    size_t count = 0, components = 0;
    std::vector<float> values;
    const float* at(size_t index) const { return values.data() + index * components; }
};
Floats read_floats(const Loader& loader, int accessor, std::initializer_list<int> types, uint64_t limit);
// Likewise of unsigned integers, not normalised.
std::vector<uint32_t> read_integers(const Loader& loader, int accessor, int type, uint64_t limit);
size_t accessor_count(const Loader& loader, int accessor);

void load_materials(Loader& loader);
uint32_t default_material(Loader& loader); // of what has none
void load_meshes(Loader& loader);
void load_nodes(Loader& loader);
void load_skins(Loader& loader); // after the nodes and meshes
void load_animations(Loader& loader);
void load_cameras_and_lights(Loader& loader);

// Geometry that a file leaves out.
void make_flat_normals(MeshPart& part, uint64_t& vertices_left, uint64_t& target_vertices_left);
void mend_normals(MeshPart& part); // where the file's own are zero
void make_tangents(MeshPart& part);

} // namespace sfumato::scene::gltf
