#define TINYOBJLOADER_IMPLEMENTATION
#include "server/scene/load/obj_material.h"

#include "server/scene/load/obj_loader.h"

#include "server/base/error.h"
#include "server/scene/load/file_folder.h"
#include "server/scene/load/obj_normals.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <sstream>
#include <string_view>
#include <unordered_map>

namespace heliograph {

namespace {

constexpr uint64_t MOST_OBJ_BYTES = uint64_t(1) << 30;
constexpr uint64_t MOST_MTL_BYTES = uint64_t(16) << 20;
constexpr size_t LONGEST_LINE = 64 * 1024;  // bytes
constexpr size_t MOST_CORNERS = 255;        // of a face: the parser counts them in a byte
constexpr size_t MOST_EXPONENT_DIGITS = 6;

/// What the filter has seen.
struct Lines {
    std::string text;        // the lines that we read
    uint64_t ignored = 0;    // points, lines, curves and what else is not drawn
    bool smoothing = false;  // the file has "s" lines
};

bool startsWith(std::string_view line, std::string_view word) {
    return line.size() > word.size() && line.compare(0, word.size(), word) == 0 &&
           (line[word.size()] == ' ' || line[word.size()] == '\t');
}

size_t wordsIn(std::string_view line) {
    size_t words = 0;
    bool inWord = false;
    for (const char c : line) {
        const bool isSpace = c == ' ' || c == '\t';
        if (!isSpace && !inWord) words++;
        inWord = !isSpace;
    }
    return words;
}

/// Numbers with an exponent of so many digits are beyond what the parser counts in.
void checkExponents(std::string_view line, const std::string& where) {
    for (size_t at = line.find_first_not_of(" \t"); at != std::string_view::npos;) {
        const size_t end = std::min(line.find_first_of(" \t", at), line.size());
        const std::string_view word = line.substr(at, end - at);
        const size_t exponent = word.find_first_not_of("0123456789+-.");
        if (exponent != std::string_view::npos && (word[exponent] == 'e' || word[exponent] == 'E')) {
            const size_t first = std::min(word.find_first_not_of("+-", exponent + 1), word.size());
            const size_t digits = std::min(word.find_first_not_of("0123456789", first), word.size()) - first;
            if (digits > MOST_EXPONENT_DIGITS)
                throw InputError(where, "an exponent of " + std::to_string(digits) + " digits",
                                 "at most " + std::to_string(MOST_EXPONENT_DIGITS));
        }
        at = line.find_first_not_of(" \t", end);
    }
}

void checkLine(std::string_view line, const std::string& where) {
    if (line.size() > LONGEST_LINE || line.find('\0') != std::string_view::npos) {
        throw InputError(where, std::to_string(line.size()) + " bytes or a NUL character",
                         "text of at most " + std::to_string(LONGEST_LINE) + " bytes");
    }
    if (startsWith(line, "v") || startsWith(line, "vn") || startsWith(line, "vt")) checkExponents(line, where);
    if (startsWith(line, "f") && wordsIn(line) > MOST_CORNERS + 1) {
        throw InputError(where, "a face of " + std::to_string(wordsIn(line) - 1) + " corners",
                         "at most " + std::to_string(MOST_CORNERS));
    }
}

/// Keeps the lines that we draw. The parser also reads tags, whose counts it trusts: a line of ten bytes would make it
/// take gigabytes.
Lines filtered(std::span<const uint8_t> bytes, const std::string& file) {
    static constexpr std::string_view KEPT[] = {"v", "vn", "vt", "f", "usemtl", "mtllib", "s"};
    Lines lines;
    lines.text.reserve(bytes.size());
    const std::string_view all(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    size_t number = 0;
    for (size_t at = 0; at < all.size();) {
        size_t end = all.find_first_of("\r\n", at);
        if (end == std::string_view::npos) end = all.size();
        std::string_view line = all.substr(at, end - at);
        number++;
        at = end + (end + 1 < all.size() && all[end] == '\r' && all[end + 1] == '\n' ? 2 : 1);
        const size_t first = line.find_first_not_of(" \t");
        if (first == std::string_view::npos || line[first] == '#') continue;
        line.remove_prefix(first);
        const bool kept =
            std::any_of(std::begin(KEPT), std::end(KEPT), [&](std::string_view word) { return startsWith(line, word); });
        if (!kept) {
            if (!startsWith(line, "o") && !startsWith(line, "g")) lines.ignored++;
            continue;
        }
        checkLine(line, file + ": line " + std::to_string(number));
        if (startsWith(line, "s")) lines.smoothing = true;
        lines.text.append(line);
        lines.text.push_back('\n');
    }
    return lines;
}

void checkMaterials(const std::string& text, const std::string& file) {
    std::istringstream lines(text);
    std::string line;
    for (size_t number = 1; std::getline(lines, line); number++)
        checkExponents(line, file + ": line " + std::to_string(number));
}

/// Opens .mtl files beside the .obj alone.
class MtlReader : public tinyobj::MaterialReader {
public:
    MtlReader(const FileFolder& folder, std::string file, SceneBuilder& builder)
        : folder_(folder), file_(std::move(file)), builder_(builder) {}

    bool operator()(const std::string& name, std::vector<tinyobj::material_t>* materials, std::map<std::string, int>* map,
                    std::string* warning, std::string* error) override {
        std::string slashed = name;
        std::replace(slashed.begin(), slashed.end(), '\\', '/');
        std::filesystem::path path;
        try {
            path = folder_.resolve(slashed, file_ + ": mtllib");
        } catch (const InputError& fault) {
            if (std::string(fault.what()).find("does not exist") == std::string::npos) throw;
            builder_.warn("the material file '" + name + "' does not exist: materials are white");
            return false;
        }
        const std::vector<uint8_t> bytes = readFile(path, MOST_MTL_BYTES);
        const std::string text(bytes.begin(), bytes.end());
        checkMaterials(text, name);
        std::istringstream stream(text);
        tinyobj::LoadMtl(map, materials, &stream, warning, error);
        return true;
    }

private:
    const FileFolder& folder_;
    std::string file_;
    SceneBuilder& builder_;
};

/// A polygon's corners as triangles: the shorter diagonal of a quad, a fan for more.
void addPolygon(std::span<const tinyobj::index_t> corners, const std::vector<vec3>& positions,
                std::vector<std::array<tinyobj::index_t, 3>>& out) {
    if (corners.size() == 4) {
        const auto at = [&](size_t i) { return positions[static_cast<size_t>(corners[i].vertex_index)]; };
        const vec3 d02 = at(2) - at(0), d13 = at(3) - at(1);
        if (glm::dot(d13, d13) < glm::dot(d02, d02)) {
            out.push_back({corners[0], corners[1], corners[3]});
            out.push_back({corners[1], corners[2], corners[3]});
            return;
        }
    }
    for (size_t i = 1; i + 1 < corners.size(); i++) out.push_back({corners[0], corners[i], corners[i + 1]});
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

class ObjReader {
public:
    ObjReader(const std::filesystem::path& path, SceneBuilder& builder, const Progress& progress)
        : file_(path.string()), folder_(path), builder_(builder), progress_(progress) {
        report(progress_, "reading", 0.0);
        Lines lines = filtered(readFile(path, MOST_OBJ_BYTES), file_);
        smoothing_ = lines.smoothing;
        if (lines.ignored > 0) builder_.warn(std::to_string(lines.ignored) + " lines of kinds that are not drawn were ignored");
        MtlReader mtl(folder_, file_, builder_);
        std::istringstream stream(std::move(lines.text));
        std::string warning, error;
        if (!tinyobj::LoadObj(&attrib_, &shapes_, &materials_, &warning, &error, &stream, &mtl, false, false))
            throw InputError(file_, "the file cannot be parsed: " + error.substr(0, std::min(error.find('\n'), size_t(160))));
    }

    void read() {
        report(progress_, "reading", 0.6);
        for (size_t i = 0; i + 2 < attrib_.vertices.size(); i += 3)
            positions_.emplace_back(attrib_.vertices[i], attrib_.vertices[i + 1], attrib_.vertices[i + 2]);
        for (const tinyobj::shape_t& shape : shapes_) readFaces(shape.mesh);
        if (badFaces_ > 0)
            builder_.warn(std::to_string(badFaces_) + " faces were dropped: an index out of range or fewer than 3 corners");
        if (triangles_.empty() && badFaces_ == 0) builder_.warn("the file has no faces");
        if (positions_.empty() && triangles_.empty() && attrib_.normals.empty())
            throw InputError(file_, "no vertices", "an OBJ file");
        report(progress_, "reading", 0.8);
        std::vector<uint32_t> indices = addMaterials();
        MeshData mesh = buildMesh();
        for (int material : triangleMaterials_)
            mesh.materials.push_back(material >= 0 ? indices[static_cast<size_t>(material)] : indices.back());
        builder_.addInstance(builder_.addMesh(std::move(mesh)), mat4(1.0f));
    }

private:
    bool usable(const tinyobj::index_t& i) const {
        const auto below = [](int index, size_t count) { return index < 0 || static_cast<size_t>(index) < count; };
        return i.vertex_index >= 0 && below(i.vertex_index, positions_.size()) &&
               below(i.normal_index, attrib_.normals.size() / 3) && below(i.texcoord_index, attrib_.texcoords.size() / 2);
    }

    void readFaces(const tinyobj::mesh_t& mesh) {
        size_t at = 0;
        for (size_t face = 0; face < mesh.num_face_vertices.size(); face++) {
            const size_t count = mesh.num_face_vertices[face];
            if (at + count > mesh.indices.size()) break;  // a polygon of more than 255 corners, counted wrongly
            const std::span<const tinyobj::index_t> corners(mesh.indices.data() + at, count);
            at += count;
            if (count < 3 || !std::all_of(corners.begin(), corners.end(), [this](const auto& i) { return usable(i); })) {
                badFaces_++;
                continue;
            }
            addPolygon(corners, positions_, triangles_);
            triangleMaterials_.resize(triangles_.size(), mesh.material_ids[face]);
            groups_.resize(triangles_.size(), mesh.smoothing_group_ids[face]);
        }
    }

    /// The builder's index per material of the file, and last the one of faces without: white, as RayEngine draws them.
    std::vector<uint32_t> addMaterials() {
        ObjMaterials converter(folder_, file_, builder_);
        std::vector<uint32_t> indices;
        std::vector<bool> used(materials_.size(), false);
        for (int& material : triangleMaterials_) {
            if (material >= static_cast<int>(materials_.size())) material = -1;
            if (material >= 0) used[static_cast<size_t>(material)] = true;
        }
        for (size_t i = 0; i < materials_.size(); i++) indices.push_back(used[i] ? converter.add(materials_[i]) : 0);
        indices.push_back(0);
        return indices;
    }

    std::vector<vec3> madeNormals() const {
        const bool missing = std::any_of(triangles_.begin(), triangles_.end(), [](const auto& t) {
            return t[0].normal_index < 0 || t[1].normal_index < 0 || t[2].normal_index < 0;
        });
        if (!missing) return {};
        std::vector<uvec3> triangles;
        for (const auto& t : triangles_) triangles.emplace_back(t[0].vertex_index, t[1].vertex_index, t[2].vertex_index);
        return cornerNormals(positions_, triangles,
                             smoothing_ ? std::span<const uint32_t>(groups_) : std::span<const uint32_t>());
    }

    MeshData buildMesh() const {
        MeshData mesh;
        const std::vector<vec3> made = madeNormals();
        const bool uvs = !attrib_.texcoords.empty();
        const bool colors = attrib_.colors.size() == attrib_.vertices.size() && !attrib_.colors.empty();
        std::unordered_map<CornerKey, uint32_t, CornerHash> known;
        for (size_t i = 0; i < triangles_.size(); i++) {
            uvec3 triangle;
            for (int k = 0; k < 3; k++) {
                const tinyobj::index_t& corner = triangles_[i][static_cast<size_t>(k)];
                CornerKey key{corner.vertex_index, corner.texcoord_index, corner.normal_index, vec3(0.0f)};
                if (corner.normal_index < 0) key.made = made[i * 3 + static_cast<size_t>(k)];
                const auto [found, isNew] = known.try_emplace(key, static_cast<uint32_t>(mesh.positions.size()));
                triangle[k] = found->second;
                if (isNew) addVertex(mesh, key, uvs, colors);
            }
            mesh.indices.push_back(triangle);
        }
        return mesh;
    }

    void addVertex(MeshData& mesh, const CornerKey& key, bool uvs, bool colors) const {
        const auto three = [](const std::vector<tinyobj::real_t>& from, int i) {
            const size_t at = static_cast<size_t>(i) * 3;
            return vec3(from[at], from[at + 1], from[at + 2]);
        };
        mesh.positions.push_back(positions_[static_cast<size_t>(key.position)]);
        mesh.normals.push_back(key.normal >= 0 ? three(attrib_.normals, key.normal) : key.made);
        if (uvs) {
            const size_t at = static_cast<size_t>(std::max(key.uv, 0)) * 2;
            // OBJ counts v upwards from the lower edge of the image.
            mesh.uv0.push_back(key.uv >= 0 ? vec2(attrib_.texcoords[at], 1.0f - attrib_.texcoords[at + 1]) : vec2(0.0f));
        }
        if (colors) mesh.colors.emplace_back(three(attrib_.colors, key.position), 1.0f);
    }

    std::string file_;
    FileFolder folder_;
    SceneBuilder& builder_;
    const Progress& progress_;
    tinyobj::attrib_t attrib_;
    std::vector<tinyobj::shape_t> shapes_;
    std::vector<tinyobj::material_t> materials_;
    std::vector<vec3> positions_;
    std::vector<std::array<tinyobj::index_t, 3>> triangles_;
    std::vector<int> triangleMaterials_;  // -1: none
    std::vector<uint32_t> groups_;        // smoothing group per triangle
    uint64_t badFaces_ = 0;
    bool smoothing_ = false;
};

}  // namespace

void loadObj(const std::filesystem::path& path, SceneBuilder& builder, const Progress& progress) {
    ObjReader(path, builder, progress).read();
}

}  // namespace heliograph
