#include "server/scene/load/obj_loader.h"

#include "server/base/error.h"
#include "server/base/text.h"
#include "server/scene/load/far_origin.h"
#include "server/scene/load/file_folder.h"
#include "server/scene/load/obj_file.h"
#include "server/scene/load/obj_material.h"
#include "server/scene/load/obj_normals.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <unordered_map>

namespace heliograph {

namespace {

using glm::dvec3;

constexpr uint64_t MOST_OBJ_BYTES = uint64_t(1) << 30;
constexpr uint64_t MOST_MTL_BYTES = uint64_t(16) << 20;
constexpr size_t MOST_NAMED = 5;  // in a warning

std::string counted(const ObjFile::Count& count, const std::string& what) {
    return std::to_string(count.lines) + " " + what + " (the first in line " + std::to_string(count.first) + ")";
}

/// Position, texture coordinate and normal of a corner.
struct CornerKey {
    int position;
    int uv;
    int normal;  // of the file, or -1
    vec3 made;   // the normal that was computed where normal is -1
    bool operator==(const CornerKey&) const = default;
};

struct CornerHash {
    size_t operator()(const CornerKey& key) const {
        std::array<uint32_t, 6> words{uint32_t(key.position), uint32_t(key.uv), uint32_t(key.normal)};
        std::memcpy(&words[3], &key.made, 12);
        uint64_t hash = 0x9e3779b97f4a7c15ull;
        for (uint32_t word : words) {
            hash = (hash ^ word) * 0xff51afd7ed558ccdull;
            hash ^= hash >> 32;
        }
        return hash;
    }
};

dvec3 originOf(const ObjFile& obj) {
    FarBox box;
    for (const ObjTriangle& triangle : obj.triangles) {
        for (const ObjCorner& corner : triangle.corners) box.add(obj.positions[static_cast<size_t>(corner.position)]);
    }
    return originOf(box);
}

class ObjReader {
public:
    ObjReader(const std::filesystem::path& path, SceneBuilder& builder, const Progress& progress)
        : file_(path.string()), folder_(path), builder_(builder), progress_(progress) {
        report(progress_, "reading", 0.0);
        obj_ = parseObj(readFile(path, MOST_OBJ_BYTES), file_, progress_);
    }

    void read() {
        tell();
        if (obj_.positions.empty() && obj_.normals.empty()) throw InputError(file_, "no vertices", "an OBJ file");
        if (obj_.triangles.empty() && obj_.badFaces.lines > 0)
            throw InputError(file_ + ": line " + std::to_string(obj_.badFaces.first),
                             "a face with an index out of range or fewer than 3 corners, as all others",
                             "indices of vertices before it, from 1");
        report(progress_, "reading", 0.6);
        place();
        for (const std::string& names : obj_.libraries) readLibraries(names);
        report(progress_, "reading", 0.8);
        const std::vector<uint32_t> indices = addMaterials();
        MeshData mesh = buildMesh();
        mesh.materials.reserve(obj_.triangles.size());
        for (const ObjTriangle& t : obj_.triangles)
            mesh.materials.push_back(t.material >= 0 ? indices[static_cast<size_t>(t.material)] : 0);
        builder_.addInstance(builder_.addMesh(std::move(mesh)), mat4(1.0f));
    }

private:
    void tell() {
        for (const auto& [kind, count] : obj_.kinds) builder_.warn(counted(count, "lines '" + kind + "' are not drawn"));
        if (obj_.badNumbers.lines > 0) builder_.warn(counted(obj_.badNumbers, "vertices have too few numbers"));
        if (obj_.oddNumbers.lines > 0) builder_.warn(counted(obj_.oddNumbers, "vertices have something behind a number"));
        if (obj_.badFaces.lines > 0)
            builder_.warn(counted(obj_.badFaces, "faces were dropped: an index out of range or fewer than 3 corners"));
        if (obj_.polygonsGivenUp > 0)
            builder_.warn(std::to_string(obj_.polygonsGivenUp) + " concave polygons are too large to be cut rightly");
        if (obj_.triangles.empty() && obj_.badFaces.lines == 0) builder_.warn("the file has no faces");
    }

    /// Rounds the positions to floats, about an origin of their own where they are far from 0.
    void place() {
        const dvec3 origin = originOf(obj_);
        if (origin != dvec3(0.0)) builder_.warn(movedBy(origin));
        positions_.reserve(obj_.positions.size());
        for (const dvec3& position : obj_.positions) positions_.emplace_back(position - origin);
    }

    bool readLibrary(const std::string& name) {
        std::filesystem::path path;
        const std::string inFolder = pathFrom({}, name);
        try {
            path = folder_.resolve(inFolder, file_ + ": mtllib");
        } catch (const InputError&) {
            return false;
        }
        MtlFile mtl = parseMtl(readFile(path, MOST_MTL_BYTES), name);
        if (!mtl.notRead.empty())
            builder_.warn(name +
                          ": not drawn: " + joined(std::vector<std::string>(mtl.notRead.begin(), mtl.notRead.end()), ", "));
        for (MtlMaterial& material : mtl.materials) {
            material.folder = std::filesystem::path(inFolder).parent_path().string();
            std::string key = material.name;
            const std::string bare(beforeComment(key));
            if (!bare.empty()) library_.try_emplace(bare, material);
            if (!library_.try_emplace(std::move(key), std::move(material)).second) twice_.push_back(material.name);
        }
        return true;
    }

    /// One name, or several with blanks between, each of which may have blanks in it: the longest that is there.
    void readLibraries(const std::string& names) {
        std::string_view rest = names;
        while (!(rest = trimmed(rest)).empty()) {
            size_t end = rest.size();
            if (const size_t close = rest.find('"', 1); rest.front() == '"' && close != std::string_view::npos) end = close + 1;
            while (!readLibrary(std::string(unquoted(trimmed(rest.substr(0, end)))))) {
                const size_t blank = rest.find_last_of(" \t", end - 1);
                if (blank == std::string_view::npos || blank == 0) {
                    end = 0;
                    break;
                }
                end = blank;
            }
            if (end == 0) {  // none begins here
                const size_t next = names.find(".mtl ") == std::string::npos ? rest.size() : rest.find_first_of(" \t");
                end = std::min(next, rest.size());
                builder_.warn("the material file '" + std::string(rest.substr(0, end)) +
                              "' is not in the scene's folder: its materials are white");
            }
            rest.remove_prefix(end);
        }
    }

    /// The builder's index per material that faces ask for; one that no library has is white, as RayEngine draws it.
    std::vector<uint32_t> addMaterials() {
        std::vector<bool> used(obj_.materials.size(), false);
        for (const ObjTriangle& t : obj_.triangles) {
            if (t.material >= 0) used[static_cast<size_t>(t.material)] = true;
        }
        ObjMaterials converter(folder_, file_, builder_);
        std::vector<uint32_t> indices(obj_.materials.size(), 0);
        std::vector<std::string> missing;
        for (size_t i = 0; i < indices.size(); i++) {
            if (!used[i]) continue;
            auto found = library_.find(obj_.materials[i]);
            if (found == library_.end()) found = library_.find(std::string(beforeComment(obj_.materials[i])));
            if (found != library_.end()) indices[i] = converter.add(found->second);
            else missing.push_back(obj_.materials[i]);
        }
        warnOf(missing, " materials are in no material file and white: ");
        warnOf(twice_, " materials stand twice, the first of each is drawn: ");
        return indices;
    }

    void warnOf(const std::vector<std::string>& names, const std::string& what) {
        if (names.empty()) return;
        const size_t shown = std::min(names.size(), MOST_NAMED);
        builder_.warn(std::to_string(names.size()) + what + "'" + joined(std::span(names).first(shown), "', '") +
                      (shown < names.size() ? "' ..." : "'"));
    }

    std::vector<vec3> madeNormals() const {
        const bool missing = std::ranges::any_of(obj_.triangles, [](const ObjTriangle& t) {
            return t.corners[0].normal < 0 || t.corners[1].normal < 0 || t.corners[2].normal < 0;
        });
        if (!missing) return {};
        std::vector<uvec3> triangles;
        std::vector<uint32_t> groups;
        for (const ObjTriangle& t : obj_.triangles) {
            triangles.emplace_back(t.corners[0].position, t.corners[1].position, t.corners[2].position);
            if (obj_.smoothing) groups.push_back(t.group);
        }
        return cornerNormals(positions_, triangles, groups);
    }

    MeshData buildMesh() const {
        MeshData mesh;
        const std::vector<vec3> made = madeNormals();
        std::unordered_map<CornerKey, uint32_t, CornerHash> known;
        known.reserve(positions_.size());
        mesh.indices.reserve(obj_.triangles.size());
        for (size_t i = 0; i < obj_.triangles.size(); i++) {
            uvec3 triangle;
            for (int k = 0; k < 3; k++) {
                const ObjCorner& corner = obj_.triangles[i].corners[static_cast<size_t>(k)];
                CornerKey key{corner.position, corner.uv, corner.normal, vec3(0.0f)};
                if (corner.normal < 0) key.made = made[i * 3 + static_cast<size_t>(k)];
                const auto [found, isNew] = known.try_emplace(key, static_cast<uint32_t>(mesh.positions.size()));
                triangle[k] = found->second;
                if (isNew) addVertex(mesh, key);
            }
            mesh.indices.push_back(triangle);
        }
        return mesh;
    }

    void addVertex(MeshData& mesh, const CornerKey& key) const {
        const auto position = static_cast<size_t>(key.position);
        mesh.positions.push_back(positions_[position]);
        mesh.normals.push_back(key.normal >= 0 ? obj_.normals[static_cast<size_t>(key.normal)] : key.made);
        if (!obj_.uvs.empty()) {
            const vec2 uv = key.uv >= 0 ? obj_.uvs[static_cast<size_t>(key.uv)] : vec2(0.0f, 1.0f);
            mesh.uv0.emplace_back(uv.x, 1.0f - uv.y);  // OBJ counts v upwards from the lower edge of the image
        }
        if (!obj_.colors.empty()) mesh.colors.emplace_back(obj_.colors[position], 1.0f);
    }

    std::string file_;
    FileFolder folder_;
    SceneBuilder& builder_;
    const Progress& progress_;
    ObjFile obj_;
    std::vector<vec3> positions_;
    std::unordered_map<std::string, MtlMaterial> library_;
    std::vector<std::string> twice_;  // names of materials that a file before, or the same one, had
};

}  // namespace

void loadObj(const std::filesystem::path& path, SceneBuilder& builder, const Progress& progress) {
    ObjReader(path, builder, progress).read();
}

}  // namespace heliograph
