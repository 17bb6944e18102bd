#include "server/scene/load/gltf_accessor.h"

#include "server/base/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace heliograph {

namespace {

/// Bytes of a component, 0 for a type that glTF 2.0 has not.
size_t bytesOfComponent(int type) {
    switch (type) {
        case TINYGLTF_COMPONENT_TYPE_BYTE:
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: return 1;
        case TINYGLTF_COMPONENT_TYPE_SHORT:
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: return 2;
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
        case TINYGLTF_COMPONENT_TYPE_FLOAT: return 4;
        default: return 0;
    }
}

int componentsOf(int type) {
    switch (type) {
        case TINYGLTF_TYPE_SCALAR: return 1;
        case TINYGLTF_TYPE_VEC2: return 2;
        case TINYGLTF_TYPE_VEC3: return 3;
        case TINYGLTF_TYPE_VEC4:
        case TINYGLTF_TYPE_MAT2: return 4;
        case TINYGLTF_TYPE_MAT3: return 9;
        default: return 16;
    }
}

int rowsOf(int type) {
    switch (type) {
        case TINYGLTF_TYPE_MAT2: return 2;
        case TINYGLTF_TYPE_MAT3: return 3;
        case TINYGLTF_TYPE_MAT4: return 4;
        default: return 0;
    }
}

/// Matrix columns start at multiples of 4 bytes.
size_t columnStrideOf(int type, size_t componentBytes) { return (rowsOf(type) * componentBytes + 3) / 4 * 4; }

size_t elementBytes(int type, size_t componentBytes) {
    return rowsOf(type) ? rowsOf(type) * columnStrideOf(type, componentBytes) : componentsOf(type) * componentBytes;
}

template <typename T>
T load(const uint8_t* bytes) {
    T value;
    std::memcpy(&value, bytes, sizeof(T));
    return value;
}

float asFloat(const uint8_t* bytes, int type, bool normalized) {
    switch (type) {
        case TINYGLTF_COMPONENT_TYPE_FLOAT: return load<float>(bytes);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: return normalized ? *bytes / 255.0f : *bytes;
        case TINYGLTF_COMPONENT_TYPE_BYTE: {
            const float value = load<int8_t>(bytes);
            return normalized ? std::max(value / 127.0f, -1.0f) : value;
        }
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: {
            const float value = load<uint16_t>(bytes);
            return normalized ? value / 65535.0f : value;
        }
        case TINYGLTF_COMPONENT_TYPE_SHORT: {
            const float value = load<int16_t>(bytes);
            return normalized ? std::max(value / 32767.0f, -1.0f) : value;
        }
        default: return static_cast<float>(load<uint32_t>(bytes));
    }
}

uint32_t asIndex(const uint8_t* bytes, int type) {
    switch (type) {
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: return *bytes;
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: return load<uint16_t>(bytes);
        default: return load<uint32_t>(bytes);
    }
}

/// `count` elements of `size` bytes, `stride` apart, from `offset`, must end inside `available` bytes.
void checkFit(uint64_t count, uint64_t size, uint64_t stride, uint64_t offset, uint64_t available, const std::string& where) {
    if (count == 0) return;
    const uint64_t room = offset <= available ? available - offset : 0;
    if (size > room || (count - 1) > (room - size) / stride) {
        throw InputError(
            where,
            std::to_string(count) + " elements of " + std::to_string(size) + " bytes from byte " + std::to_string(offset),
            "at most " + std::to_string(available) + " bytes, the buffer view's length");
    }
}

void checkAccessor(GltfDocument& document, size_t i) {
    const tinygltf::Accessor& accessor = document.model.accessors[i];
    const std::string pointer = "/accessors/" + std::to_string(i);
    const std::string where = document.at(pointer);
    const size_t component = bytesOfComponent(accessor.componentType);
    if (component == 0)
        throw InputError(where + "/componentType", std::to_string(accessor.componentType), "5120 to 5123, 5125, 5126");
    const uint64_t size = elementBytes(accessor.type, component);
    if (accessor.count > (uint64_t(1) << 32))
        throw InputError(where + "/count", std::to_string(accessor.count), "at most 4294967296");
    if (accessor.normalized && component == 4)
        document.warnings.push_back(pointer + "/normalized means nothing for this component type");
    if (accessor.bufferView >= 0) {
        const tinygltf::BufferView& view = document.model.bufferViews[static_cast<size_t>(accessor.bufferView)];
        const uint64_t stride = view.byteStride ? view.byteStride : size;
        if (stride < size)
            throw InputError(where, "elements of " + std::to_string(size) + " bytes, " + std::to_string(stride) + " apart",
                             "a stride of the element's size or more");
        checkFit(accessor.count, size, stride, accessor.byteOffset, view.byteLength, where);
        if ((accessor.byteOffset + view.byteOffset) % component != 0)
            document.warnings.push_back(pointer + " is not aligned to its components");
    }
    if (!accessor.sparse.isSparse) return;
    const auto& sparse = accessor.sparse;
    const size_t indexBytes = bytesOfComponent(sparse.indices.componentType);
    const bool unsignedType = sparse.indices.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
                              sparse.indices.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
                              sparse.indices.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
    if (!unsignedType)
        throw InputError(where + "/sparse/indices/componentType", std::to_string(sparse.indices.componentType),
                         "5121, 5123 or 5125");
    if (sparse.count < 1 || static_cast<uint64_t>(sparse.count) > accessor.count) {
        throw InputError(where + "/sparse/count", std::to_string(sparse.count),
                         "1 to the accessor's count of " + std::to_string(accessor.count));
    }
    checkFit(sparse.count, indexBytes, indexBytes, sparse.indices.byteOffset, document.view(sparse.indices.bufferView).size(),
             where + "/sparse/indices");
    checkFit(sparse.count, size, size, sparse.values.byteOffset, document.view(sparse.values.bufferView).size(),
             where + "/sparse/values");
}

/// Warns where the declared min and max, in stored units, are not those of the elements.
void checkBounds(GltfDocument& document, int index) {
    const tinygltf::Accessor& raw = document.model.accessors[static_cast<size_t>(index)];
    const GltfAccessor reader(document, index);
    const int count = reader.components();
    std::array<float, 16> low, high, value{};
    low.fill(INFINITY);
    high.fill(-INFINITY);
    for (size_t i = 0; i < raw.count; i++) {
        reader.readStored(i, value.data());
        for (int c = 0; c < count; c++) {
            low[c] = std::min(low[c], value[c]);
            high[c] = std::max(high[c], value[c]);
        }
    }
    for (int c = 0; c < count; c++) {
        const float wantedLow = static_cast<float>(raw.minValues[c]), wantedHigh = static_cast<float>(raw.maxValues[c]);
        if (low[c] == wantedLow && high[c] == wantedHigh) continue;
        document.warnings.push_back("/accessors/" + std::to_string(index) + ": min or max is not that of its elements");
        return;
    }
}

}  // namespace

void checkAccessors(GltfDocument& document) {
    for (size_t i = 0; i < document.model.accessors.size(); i++) checkAccessor(document, i);
    // Accessors may overlap: what is looked at stays in proportion to the file.
    uint64_t components = 0;
    for (size_t i = 0; i < document.model.accessors.size(); i++) {
        const tinygltf::Accessor& accessor = document.model.accessors[i];
        const size_t count = static_cast<size_t>(componentsOf(accessor.type));
        if (accessor.bufferView < 0 || accessor.minValues.size() != count || accessor.maxValues.size() != count) continue;
        if (document.inexactViews.count(accessor.bufferView)) continue;
        components += accessor.count * count;
        if (components > 1'000'000 + 4 * document.sourceBytes) return;
        checkBounds(document, static_cast<int>(i));
    }
}

GltfAccessor::GltfAccessor(const GltfDocument& document, int index)
    : accessor_(document.model.accessors.at(static_cast<size_t>(index))) {
    components_ = componentsOf(accessor_.type);
    componentBytes_ = bytesOfComponent(accessor_.componentType);
    const size_t size = elementBytes(accessor_.type, componentBytes_);
    stride_ = size;
    if (rowsOf(accessor_.type)) columnStride_ = columnStrideOf(accessor_.type, componentBytes_);
    if (accessor_.bufferView >= 0) {
        const size_t declared = document.model.bufferViews[static_cast<size_t>(accessor_.bufferView)].byteStride;
        if (declared) stride_ = declared;
        base_ = document.view(accessor_.bufferView).subspan(accessor_.byteOffset);
    }
    if (!accessor_.sparse.isSparse) return;
    const auto& sparse = accessor_.sparse;
    const ByteSpan at = document.view(sparse.indices.bufferView).subspan(static_cast<size_t>(sparse.indices.byteOffset));
    const size_t bytes = bytesOfComponent(sparse.indices.componentType);
    for (size_t i = 0; i < static_cast<size_t>(sparse.count); i++) {
        const uint32_t value = asIndex(&at[i * bytes], sparse.indices.componentType);
        const std::string where = document.at("/accessors/" + std::to_string(index) + "/sparse/indices");
        if (value >= accessor_.count)
            throw InputError(where, "index " + std::to_string(value),
                             "below the accessor's count of " + std::to_string(accessor_.count));
        if (!sparseAt_.empty() && value <= sparseAt_.back())
            throw InputError(where, "index " + std::to_string(value) + " after " + std::to_string(sparseAt_.back()),
                             "growing indices");
        sparseAt_.push_back(value);
    }
    sparseValues_ = document.view(sparse.values.bufferView).subspan(static_cast<size_t>(sparse.values.byteOffset));
}

bool GltfAccessor::isMatrix() const { return columnStride_ != 0; }

const uint8_t* GltfAccessor::element(size_t index) const {
    if (!sparseAt_.empty()) {
        const auto found = std::lower_bound(sparseAt_.begin(), sparseAt_.end(), index);
        if (found != sparseAt_.end() && *found == index)
            return &sparseValues_[static_cast<size_t>(found - sparseAt_.begin()) *
                                  elementBytes(accessor_.type, componentBytes_)];
    }
    return base_.empty() ? nullptr : &base_[index * stride_];
}

void GltfAccessor::readFloats(size_t index, int wanted, bool alwaysNormalized, float* out) const {
    read(index, std::min(wanted, components_), accessor_.normalized || alwaysNormalized, out);
}

void GltfAccessor::readStored(size_t index, float* out) const { read(index, components_, false, out); }

void GltfAccessor::read(size_t index, int count, bool normalized, float* out) const {
    const uint8_t* bytes = element(index);
    const int rows = rowsOf(accessor_.type);
    for (int c = 0; c < count; c++) {
        const size_t offset = rows ? c / rows * columnStride_ + c % rows * componentBytes_ : c * componentBytes_;
        out[c] = bytes ? asFloat(bytes + offset, accessor_.componentType, normalized) : 0.0f;
    }
}

uint32_t GltfAccessor::readIndex(size_t index) const {
    const uint8_t* bytes = element(index);
    return bytes ? asIndex(bytes, accessor_.componentType) : 0;
}

}  // namespace heliograph
