#pragma once
// A scene as bytes, cut into parts that can be checked one by one. Its name is the SHA-256 of the list of its parts' SHA-256, so
// whoever knows the name can tell a wrong list and a wrong part.

#include "server/pool/wire/digest.h"
#include "server/scene/scene.h"

#include <memory>
#include <span>
#include <vector>

namespace heliograph {

/// Bytes of a part; the last one may be shorter.
constexpr size_t PART_BYTES = size_t(1) << 18;

/// What a list says.
struct PartList {
    uint64_t bytes = 0;         // of the whole scene
    std::vector<Digest> parts;  // one for each PART_BYTES
};

std::vector<uint8_t> bytesOf(const PartList& list);
/// Throws PoolMessageError unless it is a list of that name.
PartList readPartList(std::span<const uint8_t> bytes, const Digest& name);

/// A scene to be handed out. Beside the scene itself it holds its small values and the list.
class SceneParts {
public:
    /// Reads all of the scene once, to name its parts.
    explicit SceneParts(std::shared_ptr<const Scene> scene);

    const Digest& name() const { return name_; }
    uint64_t bytes() const { return bytes_; }
    size_t count() const { return count_; }
    /// Throws PoolMessageError for a number that it does not have.
    std::vector<uint8_t> part(size_t index) const;
    const std::vector<uint8_t>& list() const { return list_; }

private:
    const std::shared_ptr<const Scene> scene_;
    std::vector<uint8_t> values_;                   // small values, then the arrays
    std::vector<std::span<const uint8_t>> pieces_;  // values_ and the scene's arrays
    uint64_t bytes_ = 0;
    size_t count_ = 0;
    std::vector<uint8_t> list_;
    Digest name_{};
};

/// The scene whose bytes these are: all that pictures depend on; names, cameras, paths and warnings stay with the head. Throws
/// PoolMessageError for bytes that are no scene, or where one of its arrays points out of another.
Scene sceneOf(std::span<const uint8_t> bytes);

}  // namespace heliograph
