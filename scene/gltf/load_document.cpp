// From JSON to tinygltf's structures. tinygltf believes what it reads: it recurses as deep as the file nests, casts
// numbers without looking, and leaves indices as they are. So all of that is checked before, by a table of what stands
// where.
#include "scene/gltf/load_parts.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>

namespace sfumato::scene::gltf {
namespace {

using Json = nlohmann::json;

constexpr size_t deepest_nesting = 64;

// What the loader understands; other extensions are left out of what tinygltf reads.
constexpr std::string_view known_extensions[] = {"KHR_lights_punctual", "KHR_materials_emissive_strength",
                                                 "KHR_materials_unlit", "KHR_mesh_quantization",
                                                 "KHR_texture_transform"};

struct Advice {
    std::string_view extension, advice;
};
constexpr Advice advices[] = {
    {"KHR_draco_mesh_compression", "decompress its meshes, for instance with 'gltf-transform copy'"},
    {"EXT_meshopt_compression", "decompress its meshes, for instance with 'gltf-transform copy'"},
    {"KHR_meshopt_compression", "decompress its meshes, for instance with 'gltf-transform copy'"},
    {"KHR_texture_basisu", "convert its textures to PNG, for instance with 'gltf-transform ktxdecompress'"},
    {"EXT_texture_webp", "convert its textures to PNG, for instance with 'gltf-transform png'"},
    {"EXT_texture_avif", "convert its textures to PNG, for instance with 'gltf-transform png'"},
    {"KHR_materials_pbrSpecularGlossiness", "convert it, for instance with 'gltf-transform metalrough'"},
    {"EXT_mesh_gpu_instancing", "export it with plain nodes"},
};

bool is_known(std::string_view extension) {
    return std::ranges::find(known_extensions, extension) != std::end(known_extensions);
}

// Before the parser allocates: how deep the text nests and how many values it has at most.
void check_size(std::string_view text, const LoadLimits& limits) {
    size_t depth = 0;
    uint64_t values = 0;
    bool in_text = false;
    for (size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (in_text) {
            if (c == '\\')
                ++i;
            else if (c == '"')
                in_text = false;
            continue;
        }
        in_text = c == '"';
        if (c == '{' || c == '[') {
            ++depth;
            ++values;
            if (depth > deepest_nesting)
                fail("the JSON nests deeper than " + std::to_string(deepest_nesting));
        } else if ((c == '}' || c == ']') && depth > 0) {
            --depth;
        } else if (c == ',') {
            ++values;
        }
        if (values > limits.json_values)
            fail("the JSON has more than " + std::to_string(limits.json_values) + " values");
    }
}

enum class Kind { object, text, boolean, count, number, numbers, index };

// Where something stands, what it must be, for an index the array that it counts in, for numbers how many (0: any). In
// a path, [] means every element, * every member; what ends in ! must be there if what it stands in is.
struct Rule {
    std::string_view path;
    Kind kind;
    std::string_view target = {};
    size_t size = 0;
};

constexpr Rule rules[] = {
    {"asset!", Kind::object},
    {"asset.version!", Kind::text},
    {"extensions", Kind::object},
    {"buffers[]", Kind::object},
    {"buffers[].uri", Kind::text},
    {"buffers[].byteLength!", Kind::count},
    {"bufferViews[]", Kind::object},
    {"bufferViews[].buffer!", Kind::index, "buffers"},
    {"bufferViews[].byteOffset", Kind::count},
    {"bufferViews[].byteLength!", Kind::count},
    {"bufferViews[].byteStride", Kind::count},
    {"accessors[]", Kind::object},
    {"accessors[].bufferView", Kind::index, "bufferViews"},
    {"accessors[].byteOffset", Kind::count},
    {"accessors[].componentType!", Kind::count},
    {"accessors[].count!", Kind::count},
    {"accessors[].type!", Kind::text},
    {"accessors[].normalized", Kind::boolean},
    {"accessors[].sparse", Kind::object},
    {"accessors[].sparse.count!", Kind::count},
    {"accessors[].sparse.indices!", Kind::object},
    {"accessors[].sparse.indices.bufferView!", Kind::index, "bufferViews"},
    {"accessors[].sparse.indices.byteOffset", Kind::count},
    {"accessors[].sparse.indices.componentType!", Kind::count},
    {"accessors[].sparse.values!", Kind::object},
    {"accessors[].sparse.values.bufferView!", Kind::index, "bufferViews"},
    {"accessors[].sparse.values.byteOffset", Kind::count},
    {"images[]", Kind::object},
    {"images[].uri", Kind::text},
    {"images[].bufferView", Kind::index, "bufferViews"},
    {"samplers[]", Kind::object},
    {"samplers[].magFilter", Kind::count},
    {"samplers[].minFilter", Kind::count},
    {"samplers[].wrapS", Kind::count},
    {"samplers[].wrapT", Kind::count},
    {"textures[]", Kind::object},
    {"textures[].source", Kind::index, "images"},
    {"textures[].sampler", Kind::index, "samplers"},
    {"materials[]", Kind::object},
    {"materials[].name", Kind::text},
    {"materials[].pbrMetallicRoughness", Kind::object},
    {"materials[].pbrMetallicRoughness.baseColorFactor", Kind::numbers, "", 4},
    {"materials[].pbrMetallicRoughness.metallicFactor", Kind::number},
    {"materials[].pbrMetallicRoughness.roughnessFactor", Kind::number},
    {"materials[].normalTexture.scale", Kind::number},
    {"materials[].emissiveFactor", Kind::numbers, "", 3},
    {"materials[].alphaMode", Kind::text},
    {"materials[].alphaCutoff", Kind::number},
    {"materials[].doubleSided", Kind::boolean},
    {"materials[].extensions", Kind::object},
    {"materials[].extensions.*", Kind::object},
    {"materials[].extensions.KHR_materials_emissive_strength.emissiveStrength", Kind::number},
    {"meshes[]", Kind::object},
    {"meshes[].name", Kind::text},
    {"meshes[].weights", Kind::numbers},
    {"meshes[].primitives[]", Kind::object},
    {"meshes[].primitives[].mode", Kind::count},
    {"meshes[].primitives[].indices", Kind::index, "accessors"},
    {"meshes[].primitives[].material", Kind::index, "materials"},
    {"meshes[].primitives[].attributes!", Kind::object},
    {"meshes[].primitives[].attributes.*", Kind::index, "accessors"},
    {"meshes[].primitives[].targets[]", Kind::object},
    {"meshes[].primitives[].targets[].*", Kind::index, "accessors"},
    {"nodes[]", Kind::object},
    {"nodes[].name", Kind::text},
    {"nodes[].children[]", Kind::index, "nodes"},
    {"nodes[].mesh", Kind::index, "meshes"},
    {"nodes[].skin", Kind::index, "skins"},
    {"nodes[].camera", Kind::index, "cameras"},
    {"nodes[].translation", Kind::numbers, "", 3},
    {"nodes[].rotation", Kind::numbers, "", 4},
    {"nodes[].scale", Kind::numbers, "", 3},
    {"nodes[].matrix", Kind::numbers, "", 16},
    {"nodes[].weights", Kind::numbers},
    {"nodes[].extensions", Kind::object},
    {"nodes[].extensions.KHR_lights_punctual.light!", Kind::index, "/extensions/KHR_lights_punctual/lights"},
    {"scenes[]", Kind::object},
    {"scenes[].nodes[]", Kind::index, "nodes"},
    {"scene", Kind::index, "scenes"},
    {"skins[]", Kind::object},
    {"skins[].inverseBindMatrices", Kind::index, "accessors"},
    {"skins[].joints[]", Kind::index, "nodes"},
    {"animations[]", Kind::object},
    {"animations[].name", Kind::text},
    {"animations[].channels[]", Kind::object},
    {"animations[].channels[].sampler!", Kind::count},
    {"animations[].channels[].target!", Kind::object},
    {"animations[].channels[].target.node", Kind::index, "nodes"},
    {"animations[].channels[].target.path!", Kind::text},
    {"animations[].samplers[]", Kind::object},
    {"animations[].samplers[].input!", Kind::index, "accessors"},
    {"animations[].samplers[].output!", Kind::index, "accessors"},
    {"animations[].samplers[].interpolation", Kind::text},
    {"cameras[]", Kind::object},
    {"cameras[].name", Kind::text},
    {"cameras[].type!", Kind::text},
    {"cameras[].perspective", Kind::object},
    {"cameras[].perspective.yfov!", Kind::number},
    {"cameras[].perspective.znear!", Kind::number},
    {"cameras[].perspective.zfar", Kind::number},
    {"cameras[].perspective.aspectRatio", Kind::number},
    {"cameras[].orthographic", Kind::object},
    {"cameras[].orthographic.xmag!", Kind::number},
    {"cameras[].orthographic.ymag!", Kind::number},
    {"cameras[].orthographic.znear!", Kind::number},
    {"cameras[].orthographic.zfar!", Kind::number},
    {"extensions.KHR_lights_punctual.lights[]", Kind::object},
    {"extensions.KHR_lights_punctual.lights[].type!", Kind::text},
    {"extensions.KHR_lights_punctual.lights[].color", Kind::numbers, "", 3},
    {"extensions.KHR_lights_punctual.lights[].intensity", Kind::number},
    {"extensions.KHR_lights_punctual.lights[].range", Kind::number},
    {"extensions.KHR_lights_punctual.lights[].spot", Kind::object},
    {"extensions.KHR_lights_punctual.lights[].spot.innerConeAngle", Kind::number},
    {"extensions.KHR_lights_punctual.lights[].spot.outerConeAngle", Kind::number},
};

// The same rules hold for each of these, below `materials[]`.
constexpr std::string_view texture_slots[] = {
    "materials[].pbrMetallicRoughness.baseColorTexture", "materials[].pbrMetallicRoughness.metallicRoughnessTexture",
    "materials[].normalTexture", "materials[].occlusionTexture", "materials[].emissiveTexture"};
constexpr Rule slot_rules[] = {
    {"", Kind::object},
    {".index!", Kind::index, "textures"},
    {".texCoord", Kind::count},
    {".extensions", Kind::object},
    {".extensions.KHR_texture_transform", Kind::object},
    {".extensions.KHR_texture_transform.offset", Kind::numbers, "", 2},
    {".extensions.KHR_texture_transform.scale", Kind::numbers, "", 2},
    {".extensions.KHR_texture_transform.rotation", Kind::number},
    {".extensions.KHR_texture_transform.texCoord", Kind::count},
};

using Visit = std::function<void(const Json&, const std::string& where)>;

// Calls `visit` for everything that a path means, whose way from the root is `where`.
void walk(const Json& value, std::string_view path, const std::string& where, const Visit& visit) {
    if (path.empty())
        return visit(value, where);
    const size_t dot = path.find('.');
    std::string_view token = path.substr(0, dot);
    const std::string_view rest = dot == std::string_view::npos ? "" : path.substr(dot + 1);
    const bool each = token.ends_with("[]"), needed = token.ends_with('!');
    token.remove_suffix(each ? 2 : needed ? 1 : 0);
    require(value.is_object(), (where.empty() ? "the JSON" : where) + " is not an object");
    const std::string prefix = where.empty() ? "" : where + ".";
    if (token == "*") {
        for (const auto& [key, member] : value.items())
            walk(member, rest, prefix + key.substr(0, 60), visit);
        return;
    }
    const std::string name(token);
    const auto found = value.find(name);
    if (found == value.end())
        return require(!needed, prefix + name + " is missing");
    if (!each)
        return walk(*found, rest, prefix + name, visit);
    require(found->is_array(), prefix + name + " is not an array");
    for (size_t i = 0; i < found->size(); ++i)
        walk((*found)[i], rest, prefix + place(name, i), visit);
}

std::string shown(const Json& value) {
    const std::string text = value.dump(-1, ' ', true, Json::error_handler_t::replace);
    return text.size() > 40 ? text.substr(0, 40) + "…" : text;
}

// A whole number up to 2^31 - 1, which also may be written as 3.0.
std::optional<uint64_t> whole_number(const Json& value) {
    if (!value.is_number())
        return {};
    const double number = value.get<double>();
    if (!(number >= 0.0 && number <= 2147483647.0) || number != std::floor(number))
        return {};
    return static_cast<uint64_t>(number);
}

bool is_number(const Json& value) {
    return value.is_number() && std::abs(value.get<double>()) <= largest_number;
}

void check(const Rule& rule, size_t target_size, const Json& value, const std::string& where) {
    const auto must = [&](bool holds, const std::string& what) {
        require(holds, where + " is " + shown(value) + "; it must be " + what);
    };
    switch (rule.kind) {
    case Kind::object:
        return must(value.is_object(), "an object");
    case Kind::text:
        return must(value.is_string(), "a string");
    case Kind::boolean:
        return must(value.is_boolean(), "true or false");
    case Kind::count:
        return must(whole_number(value).has_value(), "a whole number below 2^31");
    case Kind::number:
        return must(is_number(value), "a number of at most 1e9");
    case Kind::numbers:
        must(value.is_array() && (rule.size == 0 || value.size() == rule.size) && std::ranges::all_of(value, is_number),
             rule.size == 0 ? "an array of numbers" : std::to_string(rule.size) + " numbers of at most 1e9");
        return;
    case Kind::index: {
        const auto index = whole_number(value);
        must(index && *index < target_size, "an index into the " + std::to_string(target_size) + " " +
                                                std::string(rule.target.substr(rule.target.find_last_of('/') + 1)));
        return;
    }
    }
}

void check_rule(const Json& root, const Rule& rule) {
    size_t target_size = 0;
    if (rule.kind == Kind::index) {
        const std::string pointer(rule.target.starts_with('/') ? rule.target : "/" + std::string(rule.target));
        const Json::json_pointer target(pointer);
        if (root.contains(target) && root.at(target).is_array())
            target_size = root.at(target).size();
    }
    walk(root, rule.path, "",
         [&](const Json& value, const std::string& where) { check(rule, target_size, value, where); });
}

// tinygltf casts numbers, and some of its readers want integers written as such.
void make_whole(Json& value) {
    if (value.is_number_float()) {
        if (const auto number = whole_number(value))
            value = *number;
        return;
    }
    if (value.is_structured())
        for (Json& member : value)
            make_whole(member);
}

// Extras, and what belongs to unknown extensions.
void strip(Json& value) {
    if (value.is_object()) {
        value.erase("extras");
        if (const auto found = value.find("extensions"); found != value.end() && found->is_object())
            for (auto member = found->begin(); member != found->end();)
                member = is_known(member.key()) ? std::next(member) : found->erase(member);
    }
    if (value.is_structured())
        for (Json& member : value)
            strip(member);
}

std::vector<std::string> texts(const Json& root, const char* name) {
    std::vector<std::string> result;
    const auto found = root.find(name);
    if (found == root.end())
        return result;
    require(found->is_array(), std::string(name) + " is not an array");
    for (const Json& value : *found) {
        require(value.is_string(), std::string(name) + " has " + shown(value) + " in it; strings are allowed");
        result.push_back(value.get<std::string>().substr(0, 100));
    }
    return result;
}

void check_extensions(const Json& root, std::vector<std::string>& warnings) {
    for (const std::string& name : texts(root, "extensionsRequired"))
        if (!is_known(name)) {
            const auto* advice = std::ranges::find(advices, name, &Advice::extension);
            fail("the model requires the extension " + name + ", which is not supported; " +
                 std::string(advice != std::end(advices) ? advice->advice : "export it without"));
        }
    for (const std::string& name : texts(root, "extensionsUsed"))
        if (!is_known(name))
            warnings.push_back("The extension " + name + " is not supported; what it adds is not shown.");
}

void check_version(const Json& root) {
    const std::string version = root["asset"]["version"].get<std::string>();
    require(version.starts_with("2."), "the model is glTF " + version.substr(0, 20) + "; only 2.x is known");
}

void check_channels(const Json& root) {
    const auto animations = root.find("animations");
    for (size_t i = 0; animations != root.end() && i < animations->size(); ++i) {
        const Json& animation = (*animations)[i];
        const auto channels = animation.find("channels"), samplers = animation.find("samplers");
        const size_t count = samplers != animation.end() ? samplers->size() : 0;
        for (size_t k = 0; channels != animation.end() && k < channels->size(); ++k)
            check({{}, Kind::index, "samplers"}, count, (*channels)[k]["sampler"],
                  place("animations", i) + "." + place("channels", k) + ".sampler");
    }
}

uint64_t whole(const Json& object, const char* name) {
    const auto found = object.find(name);
    return found == object.end() ? 0 : *whole_number(*found);
}

std::string text(const Json& object, const char* name) {
    const auto found = object.find(name);
    return found == object.end() ? "" : found->get<std::string>();
}

const Json& elements(const Json& root, const char* name) {
    static const Json nothing = Json::array();
    const auto found = root.find(name);
    return found == root.end() ? nothing : *found;
}

void collect_sources(const Json& root, Document& document) {
    for (const Json& buffer : elements(root, "buffers")) {
        const bool embedded = !buffer.contains("uri");
        require(!embedded || document.buffer_sources.empty(),
                place("buffers", document.buffer_sources.size()) + " has no uri");
        document.buffer_sources.push_back({text(buffer, "uri"), embedded, whole(buffer, "byteLength")});
    }
    size_t index = 0;
    for (const Json& view : elements(root, "bufferViews")) {
        const uint64_t size = document.buffer_sources[whole(view, "buffer")].size;
        require(whole(view, "byteOffset") + whole(view, "byteLength") <= size,
                place("bufferViews", index++) + " reaches beyond the " + std::to_string(size) + " bytes of its buffer");
    }
    for (const Json& image : elements(root, "images")) {
        const bool embedded = image.contains("bufferView");
        document.images.push_back(
            {text(image, "uri"), embedded ? static_cast<uint32_t>(whole(image, "bufferView")) : none});
    }
}

void check_rules(const Json& root) {
    for (const Rule& rule : rules)
        check_rule(root, rule);
    for (const std::string_view slot : texture_slots)
        for (const Rule& rule : slot_rules) {
            const std::string path = std::string(slot) + std::string(rule.path);
            check_rule(root, {path, rule.kind, rule.target, rule.size});
        }
}

} // namespace

Document parse_document(std::string_view json, const LoadLimits& limits) {
    if (json.starts_with("\xef\xbb\xbf"))
        json.remove_prefix(3);
    check_size(json, limits);
    Json root = Json::parse(json, nullptr, false);
    require(!root.is_discarded(), "the JSON is broken, or this is no glTF file");
    require(root.is_object(), "the JSON is not an object");
    Document document;
    check_extensions(root, document.warnings);
    strip(root);
    check_rules(root);
    check_version(root);
    check_channels(root);
    make_whole(root);
    collect_sources(root, document);
    root.erase("buffers");
    root.erase("images");
    const std::string checked = root.dump(-1, ' ', false, Json::error_handler_t::replace);
    root = {};
    std::string error, warning;
    tinygltf::TinyGLTF reader;
    require(checked.size() <= std::numeric_limits<unsigned>::max(), "the JSON is too large");
    const bool read = reader.LoadASCIIFromString(&document.file, &error, &warning, checked.c_str(),
                                                 static_cast<unsigned>(checked.size()), "", tinygltf::NO_REQUIRE);
    require(read, "the JSON is not glTF 2.0: " + error.substr(0, 300));
    return document;
}

} // namespace sfumato::scene::gltf
