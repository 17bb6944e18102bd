#include "server/scene/load/mtl_file.h"

#include "server/scene/load/obj_text.h"

#include <algorithm>
#include <array>

namespace heliograph {

namespace {

constexpr size_t MOST_NOT_READ = 12;  // names; a list that nobody reads to its end helps nobody

std::string lower(std::string_view text) {
    std::string result(text);
    std::ranges::transform(result, result.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return result;
}

/// Values that stand between a map's option and what follows.
size_t valuesOf(std::string_view option) {
    if (option == "-s" || option == "-o" || option == "-t") return 3;
    if (option == "-mm") return 2;
    static constexpr std::array ONE{"-bm", "-boost", "-texres", "-clamp", "-blendu", "-blendv", "-cc", "-imfchan", "-type"};
    return std::ranges::find(ONE, option) != ONE.end() ? 1 : 0;
}

class MtlParser {
public:
    MtlParser(std::span<const uint8_t> bytes, const std::string& file) : lines_(bytes, file) {}

    MtlFile parse() {
        while (const std::optional<std::string_view> line = lines_.next()) {
            std::string_view rest = *line;
            const std::string_view key = nextWord(rest);
            if (key == "newmtl") mtl_.materials.push_back({.name = std::string(trimmed(rest))});
            else if (!mtl_.materials.empty()) take(key, rest, mtl_.materials.back());
        }
        return std::move(mtl_);
    }

private:
    void leaveOut(std::string_view what) {
        if (mtl_.notRead.size() < MOST_NOT_READ) mtl_.notRead.emplace(what.substr(0, 40));
    }

    void take(std::string_view key, std::string_view rest, MtlMaterial& to) {
        static constexpr std::array MAPS{"map_kd", "map_ks", "map_ke", "map_d", "map_bump", "bump", "norm"};
        const std::string word = lower(key);
        if (word == "kd") setColor(key, rest, to.diffuse);
        else if (word == "ks") setColor(key, rest, to.specular);
        else if (word == "ke") setColor(key, rest, to.emission);
        else if (word == "tf") setColor(key, rest, to.filter);
        else if (word == "ns") setNumber(key, rest, to.exponent);
        else if (word == "ni") setNumber(key, rest, to.index);
        else if (word == "pr") setNumber(key, rest, to.roughness);
        else if (word == "pm") setNumber(key, rest, to.metallic);
        else if (word == "d" || word == "tr") setDissolve(word, rest, to);
        else if (word == "ir") setNumber(key, rest, to.mirror.emplace(0.0f));
        else if (word == "illum") setModel(rest, to);
        else if (std::ranges::find(MAPS, word) != MAPS.end()) setMap(key, rest, to.maps[word == "map_bump" ? "bump" : word]);
        else if (word != "ka" && word != "map_ka") leaveOut(key);  // the surroundings' light has its own colour here
    }

    /// One number stands for three.
    void setColor(std::string_view key, std::string_view rest, std::optional<vec3>& color) {
        std::array<double, 3> n;
        const size_t count = numbersIn(rest, n);
        if (count == 0) return leaveOut(std::string(key) + " " + std::string(trimmed(rest)));  // a spectrum or XYZ
        color = count == 3 ? vec3(n[0], n[1], n[2]) : vec3(static_cast<float>(n[0]));
    }

    void setNumber(std::string_view key, std::string_view rest, float& value) {
        std::array<double, 1> n;
        if (numbersIn(rest, n) == 0) return leaveOut(key);
        value = static_cast<float>(n[0]);
    }

    /// d wins over Tr, which says the contrary, wherever they stand.
    void setDissolve(const std::string& key, std::string_view rest, MtlMaterial& to) {
        std::string_view after = rest;
        if (nextWord(after) == "-halo") {  // thinner where it is seen face on: not drawn so
            leaveOut("d -halo");
            rest = after;
        }
        std::array<double, 1> n;
        if (numbersIn(rest, n) == 0) return leaveOut(key);
        const bool isDissolve = key == "d";
        if (!isDissolve && dissolved_ == mtl_.materials.size()) return;
        if (isDissolve) dissolved_ = mtl_.materials.size();
        to.dissolve = static_cast<float>(isDissolve ? n[0] : 1.0 - n[0]);
    }

    static void setModel(std::string_view rest, MtlMaterial& to) {
        std::array<double, 1> n;
        if (numbersIn(rest, n) == 1 && n[0] >= 0.0 && n[0] <= 20.0) to.model = static_cast<int>(n[0]);
    }

    /// Options, then the file's name to the end of the line, blanks in it included.
    void setMap(std::string_view key, std::string_view rest, MtlMap& map) {
        map = {};
        for (std::string_view after = trimmed(rest); after.starts_with('-'); after = trimmed(rest)) {
            const std::string option = lower(nextWord(after));
            const size_t most = valuesOf(option);
            if (most == 0) break;  // a name that begins so
            setOption(option, after, most, map);
            rest = after;
        }
        const std::string_view name = unquoted(trimmed(rest));
        map.file = name;
        if (name.empty()) leaveOut(std::string(key) + " without a name");
    }

    void setOption(const std::string& option, std::string_view& rest, size_t most, MtlMap& map) {
        std::array<double, 3> n;
        const size_t count = numbersIn(rest, std::span(n).first(most));
        for (size_t i = 0; i < std::max<size_t>(count, most == 1 ? 1 : 0); i++) {
            const std::string_view value = nextWord(rest);
            if (option == "-clamp") map.clamp = value == "on";
            if (option == "-imfchan" || option == "-type" || option == "-boost") leaveOut(option);
        }
        const auto at = [&](size_t i, double otherwise) { return static_cast<float>(i < count ? n[i] : otherwise); };
        if (option == "-s") map.scale = vec2(at(0, 1.0), at(1, count == 1 ? n[0] : 1.0));
        if (option == "-o") map.offset = vec2(at(0, 0.0), at(1, 0.0));
        if (option == "-bm") map.bump = at(0, 1.0);
        if (option == "-t" || option == "-mm") leaveOut(option);
    }

    ObjLines lines_;
    MtlFile mtl_;
    size_t dissolved_ = 0;  // number of the last material with a "d"
};

}  // namespace

MtlFile parseMtl(std::span<const uint8_t> bytes, const std::string& file) { return MtlParser(bytes, file).parse(); }

}  // namespace heliograph
