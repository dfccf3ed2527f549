// Materials and the textures that they use. A vertex has one pair of texture coordinates, so that all textures of a
// material must be mapped alike; those that are not are left out with a warning.
#include "scene/gltf/load_parts.h"

#include <algorithm>
#include <cmath>

namespace sfumato::scene::gltf {
namespace {

// One texture of a material, whichever of tinygltf's three types it had.
struct Slot {
    int index = -1;
    TextureMapping mapping;
};

double number_of(const tinygltf::Value& object, const char* name, double otherwise) {
    return object.Has(name) ? object.Get(name).GetNumberAsDouble() : otherwise;
}

double element_of(const tinygltf::Value& object, const char* name, int index, double otherwise) {
    return object.Has(name) ? object.Get(name).Get(index).GetNumberAsDouble() : otherwise;
}

// KHR_texture_transform: scale, then rotation, then offset.
std::array<double, 6> transform_of(const tinygltf::Value& extension) {
    const double x = element_of(extension, "scale", 0, 1.0), y = element_of(extension, "scale", 1, 1.0);
    const double angle = number_of(extension, "rotation", 0.0), c = std::cos(angle), s = std::sin(angle);
    return {c * x,  s * y, element_of(extension, "offset", 0, 0.0),
            -s * x, c * y, element_of(extension, "offset", 1, 0.0)};
}

template <class Info>
Slot slot_of(const Info& info) {
    Slot slot{info.index, {.set = info.texCoord}};
    const auto found = info.extensions.find("KHR_texture_transform");
    if (slot.index < 0 || found == info.extensions.end())
        return slot;
    slot.mapping.transform = transform_of(found->second);
    slot.mapping.set = static_cast<int>(number_of(found->second, "texCoord", slot.mapping.set));
    return slot;
}

const Bytes& image_bytes(Loader& loader, size_t image, const std::string& what) {
    Bytes& bytes = loader.image_bytes[image];
    if (bytes.empty())
        bytes = loader.files.read(loader.document.images[image].uri, what);
    return bytes;
}

void set_sampler(Loader& loader, int sampler, Texture& texture) {
    if (sampler < 0)
        return;
    const tinygltf::Sampler& source = loader.file().samplers[static_cast<size_t>(sampler)];
    texture.repeats_u = source.wrapS != TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE;
    texture.repeats_v = source.wrapT != TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE;
    texture.is_nearest = source.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST;
    if (source.wrapS == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT || source.wrapT == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT)
        loader.warn("Textures that repeat mirrored are repeated without.");
}

uint32_t texture_of(Loader& loader, int index, bool is_srgb) {
    if (index < 0)
        return none;
    const tinygltf::Texture& source = loader.file().textures[static_cast<size_t>(index)];
    if (source.source < 0) {
        loader.warn("The image of " + place("textures", static_cast<size_t>(index)) +
                    " is in a format that is not supported; it is left out.");
        return none;
    }
    const auto key = std::tuple(source.source, source.sampler, is_srgb);
    if (const auto found = loader.textures.find(key); found != loader.textures.end())
        return found->second;
    const auto image = static_cast<size_t>(source.source);
    const std::string what = place("images", image);
    const uint32_t view = loader.document.images[image].view;
    const std::span<const uint8_t> bytes =
        view != none ? view_bytes(loader, view) : std::span<const uint8_t>(image_bytes(loader, image, what));
    Pixels pixels = decode_image(bytes, loader.limits, loader.pixels_left, what);
    Texture texture{pixels.width, pixels.height, std::move(pixels.rgba), is_srgb};
    set_sampler(loader, source.sampler, texture);
    loader.model.textures.push_back(std::move(texture));
    const auto result = static_cast<uint32_t>(loader.model.textures.size() - 1);
    loader.textures.emplace(key, result);
    return result;
}

float share(double value) {
    return static_cast<float>(std::clamp(value, 0.0, 1.0));
}

void set_textures(Loader& loader, const tinygltf::Material& source, const std::string& where, ModelMaterial& material) {
    Slot slots[4] = {slot_of(source.pbrMetallicRoughness.baseColorTexture), slot_of(source.normalTexture),
                     slot_of(source.pbrMetallicRoughness.metallicRoughnessTexture), slot_of(source.emissiveTexture)};
    const auto first = std::ranges::find_if(slots, [](const Slot& slot) { return slot.index >= 0; });
    const TextureMapping mapping = first == std::end(slots) ? TextureMapping{} : first->mapping;
    for (Slot& slot : slots)
        if (slot.index >= 0 && slot.mapping != mapping) {
            slot.index = -1;
            loader.warn("A texture of " + where + " is mapped unlike its first one; it is left out.");
        }
    loader.mappings.push_back(mapping);
    material.base_colour_texture = texture_of(loader, slots[0].index, true);
    material.normal_texture = texture_of(loader, slots[1].index, false);
    material.metallic_roughness_texture = texture_of(loader, slots[2].index, false);
    material.emission_texture = texture_of(loader, slots[3].index, true);
    if (source.occlusionTexture.index >= 0)
        loader.warn("Occlusion textures are not shown: occlusion is computed.");
}

ModelMaterial material_of(Loader& loader, const tinygltf::Material& source, size_t index) {
    ModelMaterial material;
    material.name = source.name;
    const std::string where = place("materials", index);
    const tinygltf::PbrMetallicRoughness& pbr = source.pbrMetallicRoughness;
    for (size_t i = 0; i < 4 && i < pbr.baseColorFactor.size(); ++i)
        material.base_colour[i] = share(pbr.baseColorFactor[i]);
    double strength = 1.0;
    if (const auto found = source.extensions.find("KHR_materials_emissive_strength"); found != source.extensions.end())
        strength = number_of(found->second, "emissiveStrength", 1.0);
    for (size_t i = 0; i < 3 && i < source.emissiveFactor.size(); ++i)
        material.emission[i] = static_cast<float>(std::max(source.emissiveFactor[i] * strength, 0.0));
    material.metallic = share(pbr.metallicFactor);
    material.roughness = share(pbr.roughnessFactor);
    material.alpha_cutoff = static_cast<float>(source.alphaCutoff);
    material.normal_scale = static_cast<float>(source.normalTexture.scale);
    if (source.alphaMode == "MASK")
        material.alpha_mode = AlphaMode::mask;
    else if (source.alphaMode == "BLEND")
        material.alpha_mode = AlphaMode::blend;
    else
        require(source.alphaMode == "OPAQUE", where + " has the alpha mode '" + source.alphaMode.substr(0, 40) +
                                                  "'; OPAQUE, MASK and BLEND are known");
    material.double_sided = source.doubleSided;
    material.unlit = source.extensions.contains("KHR_materials_unlit");
    set_textures(loader, source, where, material);
    return material;
}

} // namespace

void load_materials(Loader& loader) {
    for (size_t i = 0; i < loader.file().materials.size(); ++i)
        loader.model.materials.push_back(material_of(loader, loader.file().materials[i], i));
    if (loader.model.materials.empty())
        default_material(loader);
}

uint32_t default_material(Loader& loader) {
    if (loader.default_material == none) {
        loader.default_material = static_cast<uint32_t>(loader.model.materials.size());
        loader.model.materials.emplace_back();
        loader.mappings.emplace_back();
    }
    return loader.default_material;
}

} // namespace sfumato::scene::gltf
