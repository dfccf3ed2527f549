// Accessors: typed, strided, possibly sparse views of the buffers, with every bound checked before a byte is read.
#include "scene/gltf/load_parts.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace sfumato::scene::gltf {
namespace {

// 0 for what is no component type of glTF.
size_t component_size(int type) {
    switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
        return 4;
    default:
        return 0;
    }
}

// 0 for types that no attribute that is read here has.
size_t component_count(int type) {
    switch (type) {
    case TINYGLTF_TYPE_SCALAR:
        return 1;
    case TINYGLTF_TYPE_VEC2:
        return 2;
    case TINYGLTF_TYPE_VEC3:
        return 3;
    case TINYGLTF_TYPE_VEC4:
        return 4;
    case TINYGLTF_TYPE_MAT4:
        return 16;
    default:
        return 0;
    }
}

template <class T>
T loaded(const uint8_t* bytes) {
    T value;
    std::memcpy(&value, bytes, sizeof(T));
    return value;
}

double component(const uint8_t* bytes, int type, bool normalised) {
    switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE: {
        const double value = loaded<int8_t>(bytes);
        return normalised ? std::max(value / 127.0, -1.0) : value;
    }
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return *bytes / (normalised ? 255.0 : 1.0);
    case TINYGLTF_COMPONENT_TYPE_SHORT: {
        const double value = loaded<int16_t>(bytes);
        return normalised ? std::max(value / 32767.0, -1.0) : value;
    }
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return loaded<uint16_t>(bytes) / (normalised ? 65535.0 : 1.0);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
        return loaded<uint32_t>(bytes) / (normalised ? 4294967295.0 : 1.0);
    default:
        return static_cast<double>(loaded<float>(bytes));
    }
}

// Elements of one size at even distances within a buffer view.
struct Range {
    const uint8_t* first = nullptr;
    size_t stride = 0;
    const uint8_t* at(size_t index) const { return first + index * stride; }
};

Range checked_range(const Loader& loader, int view, uint64_t offset, uint64_t stride, uint64_t element, uint64_t count,
                    const std::string& what) {
    const auto bytes = view_bytes(loader, static_cast<uint32_t>(view));
    // None of the four exceeds 2^31, so that nothing overflows.
    require(count == 0 || (stride >= element && offset + stride * (count - 1) + element <= bytes.size()),
            what + " reaches beyond the " + std::to_string(bytes.size()) + " bytes of its " +
                place("bufferViews", static_cast<size_t>(view)));
    return {bytes.data() + (count == 0 ? 0 : offset), stride};
}

// Calls set(element, its bytes) for every element that is not zero by default, replaced ones last.
template <class Set>
void visit_elements(const Loader& loader, int index, Set set) {
    const tinygltf::Accessor& accessor = loader.file().accessors[static_cast<size_t>(index)];
    const std::string what = place("accessors", static_cast<size_t>(index));
    const size_t element = component_size(accessor.componentType) * component_count(accessor.type);
    if (accessor.bufferView >= 0) {
        const size_t stride = loader.file().bufferViews[static_cast<size_t>(accessor.bufferView)].byteStride;
        const Range range = checked_range(loader, accessor.bufferView, accessor.byteOffset,
                                          stride > 0 ? stride : element, element, accessor.count, what);
        for (size_t i = 0; i < accessor.count; ++i)
            set(i, range.at(i));
    }
    if (!accessor.sparse.isSparse)
        return;
    const auto& sparse = accessor.sparse;
    const int type = sparse.indices.componentType;
    require(type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE || type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
                type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT,
            what + " has sparse indices of component type " + std::to_string(type) + "; unsigned integers are allowed");
    const auto count = static_cast<uint64_t>(sparse.count);
    require(count <= accessor.count, what + " replaces more elements than it has");
    const size_t index_size = component_size(type);
    const Range indices =
        checked_range(loader, sparse.indices.bufferView, static_cast<uint64_t>(sparse.indices.byteOffset), index_size,
                      index_size, count, what + "'s sparse indices");
    const Range values =
        checked_range(loader, sparse.values.bufferView, static_cast<uint64_t>(sparse.values.byteOffset), element,
                      element, count, what + "'s sparse values");
    for (size_t i = 0; i < count; ++i) {
        const double target = component(indices.at(i), type, false);
        if (target >= static_cast<double>(accessor.count))
            fail(what + " replaces element " + std::to_string(target) + " of " + std::to_string(accessor.count));
        set(static_cast<size_t>(target), values.at(i));
    }
}

const tinygltf::Accessor& checked_accessor(const Loader& loader, int index, uint64_t limit) {
    const tinygltf::Accessor& accessor = loader.file().accessors[static_cast<size_t>(index)];
    const std::string what = place("accessors", static_cast<size_t>(index));
    require(component_size(accessor.componentType) > 0,
            what + " has the component type " + std::to_string(accessor.componentType) + ", which glTF does not know");
    require(accessor.count <= limit, what + " has " + std::to_string(accessor.count) + " elements; at most " +
                                         std::to_string(limit) + " are allowed here");
    return accessor;
}

} // namespace

std::span<const uint8_t> view_bytes(const Loader& loader, uint32_t view) {
    const tinygltf::BufferView& found = loader.file().bufferViews[view];
    const std::span<const uint8_t> buffer = loader.buffers[static_cast<size_t>(found.buffer)];
    return buffer.subspan(found.byteOffset, found.byteLength); // checked with the JSON
}

size_t accessor_count(const Loader& loader, int accessor) {
    return loader.file().accessors[static_cast<size_t>(accessor)].count;
}

Floats read_floats(const Loader& loader, int index, std::initializer_list<int> types, uint64_t limit) {
    const tinygltf::Accessor& accessor = checked_accessor(loader, index, limit);
    const std::string what = place("accessors", static_cast<size_t>(index));
    require(std::ranges::find(types, accessor.type) != types.end(),
            what + " has the wrong type for what it is used for");
    Floats result{accessor.count, component_count(accessor.type), {}};
    result.values.resize(result.count * result.components);
    const size_t size = component_size(accessor.componentType);
    visit_elements(loader, index, [&](size_t element, const uint8_t* bytes) {
        for (size_t k = 0; k < result.components; ++k) {
            const double value = component(bytes + k * size, accessor.componentType, accessor.normalized);
            if (!(std::abs(value) <= largest_number))
                fail(what + " has " + std::to_string(value) + " in element " + std::to_string(element) +
                     "; numbers up to 1e9 are allowed");
            result.values[element * result.components + k] = static_cast<float>(value);
        }
    });
    return result;
}

std::vector<uint32_t> read_integers(const Loader& loader, int index, int type, uint64_t limit) {
    const tinygltf::Accessor& accessor = checked_accessor(loader, index, limit);
    const std::string what = place("accessors", static_cast<size_t>(index));
    const bool is_unsigned = accessor.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
                             accessor.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
                             accessor.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
    require(accessor.type == type && is_unsigned, what + " has the wrong type for what it is used for");
    const size_t components = component_count(type), size = component_size(accessor.componentType);
    std::vector<uint32_t> result(accessor.count * components);
    visit_elements(loader, index, [&](size_t element, const uint8_t* bytes) {
        for (size_t k = 0; k < components; ++k)
            result[element * components + k] =
                static_cast<uint32_t>(component(bytes + k * size, accessor.componentType, false));
    });
    return result;
}

} // namespace sfumato::scene::gltf
