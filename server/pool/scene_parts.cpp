#include "server/pool/scene_parts.h"

#include "server/pool/wire/bytes.h"
#include "server/pool/scene_arrays.h"

namespace heliograph {

namespace {

constexpr uint32_t SCENE_MAGIC = 0x43534c48;      // "HLSC"
constexpr uint32_t FROM_FILE = 1, IN_STUDIO = 2;  // what a scene is, beside its arrays
/// Scenes above are not taken: 256 GiB.
constexpr uint64_t MOST_SCENE_BYTES = uint64_t(1) << 38;

std::span<const uint8_t> asBytes(const void* data, size_t size) { return {static_cast<const uint8_t*>(data), size}; }

void write(ByteWriter& writer, const Bounds& bounds) {
    for (vec3 corner : {bounds.low, bounds.high}) writer.raw(&corner, sizeof corner);
}

template <typename T>
void copyTo(ByteReader& reader, T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    std::memcpy(&value, reader.raw(sizeof value).data(), sizeof value);
}

Bounds readBounds(ByteReader& reader) {
    Bounds bounds;
    copyTo(reader, bounds.low);
    copyTo(reader, bounds.high);
    return bounds;
}

}  // namespace

std::vector<uint8_t> bytesOf(const PartList& list) {
    ByteWriter writer;
    writer.put(list.bytes);
    for (const Digest& part : list.parts) writer.raw(part.data(), part.size());
    return writer.take();
}

PartList readPartList(std::span<const uint8_t> bytes, const Digest& name) {
    if (digestOf(bytes) != name) throw PoolMessageError("is not the list of parts that was asked for");
    ByteReader reader(bytes);
    PartList list;
    list.bytes = reader.get<uint64_t>();
    if (list.bytes > MOST_SCENE_BYTES) throw PoolMessageError("is the list of too large a scene");
    list.parts.resize(reader.left() / sizeof(Digest));
    for (Digest& part : list.parts) copyTo(reader, part);
    reader.end();
    if (list.parts.size() != (list.bytes + PART_BYTES - 1) / PART_BYTES)
        throw PoolMessageError("lists other parts than its scene has");
    return list;
}

SceneParts::SceneParts(std::shared_ptr<const Scene> scene) : scene_(std::move(scene)) {
    ByteWriter writer;
    writer.put(SCENE_MAGIC);
    writer.text(scene_->name);
    write(writer, scene_->bounds);
    writer.put(scene_->farthestSurface);
    writer.put(scene_->nestedBodies);
    writer.put(static_cast<uint32_t>(scene_->bodyBounds.size()));
    for (const Bounds& bounds : scene_->bodyBounds) write(writer, bounds);
    writer.put(scene_->aoRadius);
    writer.put(scene_->exposure);
    writer.put(static_cast<uint32_t>((scene_->fromFile ? FROM_FILE : 0u) | (scene_->inStudio ? IN_STUDIO : 0u)));
    writer.put(scene_->contentHash);
    writer.raw(&scene_->environment, sizeof(Environment));
    forSceneArrays(*scene_, [&](const auto& array) { writer.put(static_cast<uint64_t>(array.size())); });
    values_ = writer.take();
    pieces_.emplace_back(values_);
    forSceneArrays(*scene_,
                   [&](const auto& array) { pieces_.push_back(asBytes(array.data(), array.size() * sizeof(array[0]))); });
    for (const auto& piece : pieces_) bytes_ += piece.size();
    count_ = static_cast<size_t>((bytes_ + PART_BYTES - 1) / PART_BYTES);
    PartList list{bytes_, {}};
    for (size_t i = 0; i < count_; i++) list.parts.push_back(digestOf(part(i)));
    list_ = bytesOf(list);
    name_ = digestOf(list_);
}

std::vector<uint8_t> SceneParts::part(size_t index) const {
    if (index >= count_) throw PoolMessageError("asks for a part that its scene does not have");
    uint64_t begin = static_cast<uint64_t>(index) * PART_BYTES;  // within what is left of the pieces
    size_t left = std::min<uint64_t>(PART_BYTES, bytes_ - begin);
    std::vector<uint8_t> bytes;
    bytes.reserve(left);
    for (const auto& piece : pieces_) {
        if (begin >= piece.size()) {
            begin -= piece.size();
            continue;
        }
        const std::span<const uint8_t> taken = piece.subspan(begin, std::min(left, piece.size() - static_cast<size_t>(begin)));
        bytes.insert(bytes.end(), taken.begin(), taken.end());
        left -= taken.size();
        begin = 0;
        if (left == 0) break;
    }
    return bytes;
}

Scene sceneOf(std::span<const uint8_t> bytes) {
    ByteReader reader(bytes);
    if (reader.get<uint32_t>() != SCENE_MAGIC) throw PoolMessageError("is no scene");
    Scene scene;
    scene.name = reader.text();
    scene.bounds = readBounds(reader);
    scene.farthestSurface = reader.get<float>();
    scene.nestedBodies = reader.get<uint32_t>();
    scene.bodyBounds.resize(reader.count(sizeof(Bounds)));
    for (Bounds& bounds : scene.bodyBounds) bounds = readBounds(reader);
    scene.aoRadius = reader.get<float>();
    scene.exposure = reader.get<float>();
    const auto flags = reader.get<uint32_t>();
    scene.fromFile = (flags & FROM_FILE) != 0;
    scene.inStudio = (flags & IN_STUDIO) != 0;
    scene.contentHash = reader.get<uint64_t>();
    copyTo(reader, scene.environment);
    std::vector<uint64_t> sizes;
    forSceneArrays(scene, [&](auto&) { sizes.push_back(reader.get<uint64_t>()); });
    auto size = sizes.begin();
    forSceneArrays(scene, [&](auto& array) {
        const size_t each = sizeof(array[0]);
        if (*size > reader.left() / each) throw PoolMessageError("is a scene that ends too soon");
        const std::span<const uint8_t> taken = reader.raw(static_cast<size_t>(*size++) * each);
        array.resize(taken.size() / each);
        if (!taken.empty()) std::memcpy(array.data(), taken.data(), taken.size());
    });
    reader.end();
    checkSceneArrays(scene);
    scene.materialNames.resize(scene.materials.size());  // for people: they stay with the head
    return scene;
}

}  // namespace heliograph
