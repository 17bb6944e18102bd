#pragma once
// Typed reading of glTF accessors: every component type, normalised integers, strides, sparse overlays. Private to
// server/scene.

#include "server/scene/load/gltf_document.h"

#include <cstdint>

namespace heliograph {

/// Checks every accessor of the document against its buffer views, in 64 bits. Throws InputError.
void checkAccessors(GltfDocument& document);

/// Reads elements of one accessor.
class GltfAccessor {
public:
    /// `accessor` must be an index of the document. `where`: for messages.
    GltfAccessor(const GltfDocument& document, int accessor);

    size_t count() const { return accessor_.count; }
    int components() const { return components_; }
    int componentType() const { return accessor_.componentType; }
    bool normalized() const { return accessor_.normalized; }
    bool isMatrix() const;

    /// Writes min(components(), wanted) components of element `index` as float. Integers are scaled to [0, 1] or [-1,
    /// 1] if the accessor is normalised or `alwaysNormalized`.
    void readFloats(size_t index, int wanted, bool alwaysNormalized, float* out) const;
    /// All components of element `index` as stored: integers are not scaled.
    void readStored(size_t index, float* out) const;
    /// Element `index` of an unsigned integer scalar accessor.
    uint32_t readIndex(size_t index) const;

private:
    const uint8_t* element(size_t index) const;
    void read(size_t index, int count, bool normalized, float* out) const;

    const tinygltf::Accessor& accessor_;
    int components_ = 0;
    size_t componentBytes_ = 0;
    size_t stride_ = 0;
    size_t columnStride_ = 0;         // bytes from one matrix column to the next; 0: no matrix
    ByteSpan base_;                   // first element at 0; empty: zeros
    std::vector<uint32_t> sparseAt_;  // ascending
    ByteSpan sparseValues_;
};

}  // namespace heliograph
