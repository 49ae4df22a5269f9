// SPDX-License-Identifier: Apache-2.0
#include "framework/io/gltf_accessor.hpp"

#include <glm/glm.hpp>
#include <tiny_gltf.h>

#include <algorithm>
#include <cstring>

namespace ockham {
namespace {

template <class T>
T load(const std::byte* from) {
    T value;
    std::memcpy(&value, from, sizeof value);
    return value;
}

/// glTF 2.0, 3.6.2.2: integers are normalised if the accessor says so.
float load_float(const std::byte* from, int type, bool normalized) {
    switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE: {
        const auto value = static_cast<float>(load<std::int8_t>(from));
        return normalized ? std::max(value / 127.0f, -1.0f) : value;
    }
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: {
        const auto value = static_cast<float>(load<std::uint8_t>(from));
        return normalized ? value / 255.0f : value;
    }
    case TINYGLTF_COMPONENT_TYPE_SHORT: {
        const auto value = static_cast<float>(load<std::int16_t>(from));
        return normalized ? std::max(value / 32767.0f, -1.0f) : value;
    }
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: {
        const auto value = static_cast<float>(load<std::uint16_t>(from));
        return normalized ? value / 65535.0f : value;
    }
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
        return static_cast<float>(load<std::uint32_t>(from));
    default:
        return load<float>(from);
    }
}

std::uint32_t load_index(const std::byte* from, int type) {
    switch (type) {
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return load<std::uint8_t>(from);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return load<std::uint16_t>(from);
    default:
        return load<std::uint32_t>(from);
    }
}

} // namespace

const tinygltf::Accessor& GltfAccessorReader::accessor(int index) const {
    if (file_.unknown_accessors[index]) {
        findings_.fatal("accessors[{}] is read, but its type is unknown", index);
    }
    return model_.accessors[index];
}

bool GltfAccessorReader::all_zero(int index) const {
    const tinygltf::Accessor& source = accessor(index);
    return source.bufferView == file_.zeros_view && !source.sparse.isSparse;
}

bool GltfAccessorReader::has_data(int index) const {
    const tinygltf::Accessor& source = accessor(index);
    if (!view_has_data(source.bufferView)) return false;
    if (!source.sparse.isSparse) return true;
    return view_has_data(source.sparse.indices.bufferView) &&
           view_has_data(source.sparse.values.bufferView);
}

template <class Take>
void GltfAccessorReader::visit(int index, Take take) const {
    const tinygltf::Accessor& source = accessor(index);
    const auto element_bytes =
        static_cast<std::size_t>(tinygltf::GetComponentSizeInBytes(source.componentType) *
                                 tinygltf::GetNumComponentsInType(source.type));
    if (source.bufferView != file_.zeros_view) {
        const std::byte* data = view(source.bufferView).data() + source.byteOffset;
        const std::size_t given = model_.bufferViews[source.bufferView].byteStride;
        const std::size_t stride = given != 0 ? given : element_bytes;
        for (std::size_t i = 0; i < source.count; ++i) take(i, data + i * stride);
    }
    if (!source.sparse.isSparse) return;
    const auto& sparse = source.sparse;
    const std::byte* indices = view(sparse.indices.bufferView).data() + sparse.indices.byteOffset;
    const std::byte* values = view(sparse.values.bufferView).data() + sparse.values.byteOffset;
    const auto index_bytes = tinygltf::GetComponentSizeInBytes(sparse.indices.componentType);
    for (int i = 0; i < sparse.count; ++i) {
        const std::uint32_t element =
            load_index(indices + std::ptrdiff_t{i} * index_bytes, sparse.indices.componentType);
        if (element >= source.count) {
            findings_.fatal(
                "accessors[{}].sparse: index {} is {}, but the accessor has {} elements", index, i,
                element, source.count);
        }
        take(element, values + static_cast<std::size_t>(i) * element_bytes);
    }
}

template <class Vector>
std::vector<Vector> GltfAccessorReader::floats(int index) const {
    const tinygltf::Accessor& source = accessor(index);
    std::vector<Vector> result(source.count, Vector(0.0f));
    const auto component_bytes = tinygltf::GetComponentSizeInBytes(source.componentType);
    visit(index, [&](std::size_t element, const std::byte* data) {
        for (int i = 0; i < Vector::length(); ++i) {
            result[element][i] =
                load_float(data + i * component_bytes, source.componentType, source.normalized);
        }
    });
    return result;
}

std::vector<std::uint32_t> GltfAccessorReader::integers(int index) const {
    const tinygltf::Accessor& source = accessor(index);
    std::vector<std::uint32_t> result(source.count, 0);
    visit(index, [&](std::size_t element, const std::byte* data) {
        result[element] = load_index(data, source.componentType);
    });
    return result;
}

std::span<const std::byte> GltfAccessorReader::view(int index) const {
    const tinygltf::BufferView& source = model_.bufferViews[index];
    if (!view_has_data(index)) return {};
    return std::span(file_.buffers[source.buffer]).subspan(source.byteOffset, source.byteLength);
}

bool GltfAccessorReader::view_has_data(int index) const {
    return index == file_.zeros_view || !file_.buffers[model_.bufferViews[index].buffer].empty();
}

template std::vector<glm::vec2> GltfAccessorReader::floats<glm::vec2>(int) const;
template std::vector<glm::vec3> GltfAccessorReader::floats<glm::vec3>(int) const;
template std::vector<glm::vec4> GltfAccessorReader::floats<glm::vec4>(int) const;

} // namespace ockham
