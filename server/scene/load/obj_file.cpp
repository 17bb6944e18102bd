#include "server/scene/load/obj_file.h"

#include "server/base/error.h"

#include <algorithm>
#include <charconv>
#include <limits>
#include <unordered_map>

namespace heliograph {

namespace {

constexpr size_t MOST_ELEMENTS = std::numeric_limits<int>::max();  // vertices, coordinates or normals

class ObjParser {
public:
    ObjParser(std::span<const uint8_t> bytes, const std::string& file, const Progress& progress)
        : lines_(bytes, file), progress_(progress) {}

    ObjFile parse() {
        while (std::optional<std::string_view> line = lines_.next()) {
            if (lines_.number() >= reportAt_) {
                report(progress_, "reading", 0.6 * lines_.share());
                reportAt_ = lines_.number() + 100'000;
            }
            std::string_view rest = *line;
            const std::string_view key = nextWord(rest);
            take(key, rest);
        }
        obj_.polygonsGivenUp = cutter_.givenUp();
        return std::move(obj_);
    }

private:
    void take(std::string_view key, std::string_view rest) {
        if (key == "v") addPosition(rest);
        else if (key == "vt") addUv(rest);
        else if (key == "vn") addNormal(rest);
        else if (key == "f" || key == "fo") addFace(rest);
        else if (key == "usemtl") useMaterial(trimmed(rest));
        else if (key == "mtllib") obj_.libraries.emplace_back(trimmed(rest));
        else if (key == "s") setGroup(trimmed(rest));
        else if (key != "g" && key != "o") note(obj_.kinds[std::string(key.substr(0, 20))]);
    }

    void note(ObjFile::Count& count) const {
        if (count.lines++ == 0) count.first = lines_.number();
    }

    void checkCount(size_t count) const {
        if (count >= MOST_ELEMENTS) throw InputError(lines_.where(), "another vertex", "at most " + std::to_string(count));
    }

    /// x y z, with a weight (which is not used) or a colour behind, or both.
    void addPosition(std::string_view rest) {
        checkCount(obj_.positions.size());
        std::array<double, 7> n;
        bool whole = true;
        const size_t count = numbersIn(rest, n, &whole);
        if (!whole) note(obj_.oddNumbers);
        if (count < 3) {
            note(obj_.badNumbers);
            obj_.positions.emplace_back(std::numeric_limits<double>::quiet_NaN());
        } else {
            obj_.positions.emplace_back(n[0], n[1], n[2]);
        }
        if (count >= 6) {
            obj_.colors.resize(obj_.positions.size() - 1, vec3(1.0f));
            obj_.colors.emplace_back(n[count - 3], n[count - 2], n[count - 1]);
        } else if (!obj_.colors.empty()) {
            obj_.colors.emplace_back(1.0f);
        }
    }

    void addUv(std::string_view rest) {
        checkCount(obj_.uvs.size());
        std::array<double, 2> n{0.0, 0.0};
        if (numbersIn(rest, n) == 0) note(obj_.badNumbers);
        obj_.uvs.emplace_back(n[0], n[1]);
    }

    void addNormal(std::string_view rest) {
        checkCount(obj_.normals.size());
        std::array<double, 3> n{0.0, 0.0, 0.0};
        if (numbersIn(rest, n) < 3) note(obj_.badNumbers);
        obj_.normals.emplace_back(n[0], n[1], n[2]);
    }

    void setGroup(std::string_view word) {
        obj_.smoothing = true;
        group_ = 0;
        std::from_chars(word.data(), word.data() + word.size(), group_);
    }

    void useMaterial(std::string_view name) {
        material_ = -1;
        if (name.empty()) return;
        const auto [found, isNew] = known_.try_emplace(std::string(name), static_cast<int>(obj_.materials.size()));
        if (isNew) obj_.materials.emplace_back(name);
        material_ = found->second;
    }

    /// Counted from 1, or from the end of what there is by now where it is negative. False: no such element.
    static bool resolve(std::string_view text, size_t count, int& index) {
        int64_t number = 0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
        if (error != std::errc() || end != text.data() + text.size()) return false;
        if (number < 0) number += static_cast<int64_t>(count) + 1;
        if (number < 1 || number > static_cast<int64_t>(count)) return false;
        index = static_cast<int>(number - 1);
        return true;
    }

    /// "3", "3/1", "3//2" or "3/1/2".
    bool cornerIn(std::string_view word, ObjCorner& corner) const {
        std::array<std::string_view, 3> parts;
        for (std::string_view& part : parts) {
            const auto slash = static_cast<size_t>(std::ranges::find(word, '/') - word.begin());
            part = word.substr(0, slash);
            word.remove_prefix(std::min(slash + 1, word.size()));
        }
        return word.empty() && resolve(parts[0], obj_.positions.size(), corner.position) &&
               (parts[1].empty() || resolve(parts[1], obj_.uvs.size(), corner.uv)) &&
               (parts[2].empty() || resolve(parts[2], obj_.normals.size(), corner.normal));
    }

    void addFace(std::string_view rest) {
        corners_.clear();
        at_.clear();
        for (std::string_view word = nextWord(rest); !word.empty() && word[0] != '#'; word = nextWord(rest)) {
            ObjCorner& corner = corners_.emplace_back();
            if (!cornerIn(word, corner)) return note(obj_.badFaces);
            at_.push_back(obj_.positions[static_cast<size_t>(corner.position)]);
        }
        if (corners_.size() < 3) return note(obj_.badFaces);
        for (const uvec3& t : cutter_.cut(at_))
            obj_.triangles.push_back({{corners_[t.x], corners_[t.y], corners_[t.z]}, material_, group_});
    }

    ObjLines lines_;
    const Progress& progress_;
    ObjFile obj_;
    PolygonCutter cutter_;
    std::unordered_map<std::string, int> known_;  // materials
    std::vector<ObjCorner> corners_;              // of the face in work
    std::vector<glm::dvec3> at_;
    uint64_t reportAt_ = 0;
    int material_ = -1;
    uint32_t group_ = 0;
};

}  // namespace

ObjFile parseObj(std::span<const uint8_t> bytes, const std::string& file, const Progress& progress) {
    return ObjParser(bytes, file, progress).parse();
}

}  // namespace heliograph
