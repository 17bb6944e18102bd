#include "server/scene/load/gltf_rules.h"

#include "server/base/text.h"
#include "server/base/error.h"
#include "server/scene/load/gltf_extensions.h"
#include "server/scene/load/gltf_rule_table.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace heliograph {

using nlohmann::json;

namespace {

/// How many elements each array may have: with it, a small file cannot make the parsed structures fill the memory.
struct ArrayLimit {
    const char* array;
    size_t most;
};
constexpr ArrayLimit ARRAY_LIMITS[] = {
    {"nodes", 262144},   {"meshes", 131072},    {"materials", 16384},    {"textures", 65536}, {"images", 16384},
    {"samplers", 65536}, {"accessors", 262144}, {"bufferViews", 262144}, {"buffers", 16384},  {"cameras", 65536},
    {"scenes", 65536},   {"skins", 65536},      {"animations", 65536},
};
constexpr size_t MOST_PRIMITIVES = 262144;
constexpr size_t MOST_LIGHTS = 65536;

class Checker {
public:
    Checker(const json& root, const std::string& file, std::vector<std::string>& warnings)
        : root_(root), file_(file), warnings_(warnings) {}

    void check() {
        if (!root_.is_object()) refuse("/", shownJson(root_), "an object");
        checkSizes();
        const JsonRules rules(
            gltfRuleTable(), root_,
            [this](const std::string& at, const std::string& found, const std::string& allowed) { refuse(at, found, allowed); },
            [this](const std::string& at, const std::string& found, const std::string&) { warn(at + ": " + found); });
        rules.check("root", root_, "");
        checkVersion();
        checkExtensionLists();
        checkHierarchy();
        checkNodes();
        checkData();
        checkPlaces(root_, "", 0);
    }

private:
    [[noreturn]] void refuse(const std::string& at, const std::string& found, const std::string& allowed) const {
        throw InputError(file_ + ": " + (at.empty() ? "/" : at), found, allowed);
    }
    void warn(const std::string& text) { warnings_.push_back(text); }

    const json& arrayOf(const char* name) const {
        static const json nothing = json::array();
        const auto found = root_.find(name);
        return found != root_.end() && found->is_array() ? *found : nothing;
    }

    void checkSizes() const {
        const auto limit = [this](const std::string& at, size_t size, size_t most) {
            if (size > most) refuse(at, std::to_string(size) + " elements", "at most " + std::to_string(most));
        };
        for (const ArrayLimit& row : ARRAY_LIMITS) limit(std::string("/") + row.array, arrayOf(row.array).size(), row.most);
        size_t primitives = 0;
        for (const json& mesh : arrayOf("meshes")) {
            if (mesh.is_object() && mesh.contains("primitives")) primitives += mesh["primitives"].size();
        }
        limit("/meshes", primitives, MOST_PRIMITIVES);
        const json::json_pointer lights("/extensions/KHR_lights_punctual/lights");
        if (root_.contains(lights)) limit(lights.to_string(), root_[lights].size(), MOST_LIGHTS);
    }

    void checkVersion() const {
        const auto numbers = [this](const std::string& at, const std::string& version) {
            int major = -1, minor = -1, length = 0;
            if (version.size() > 16 || std::sscanf(version.c_str(), "%4d.%4d%n", &major, &minor, &length) != 2 ||
                size_t(length) != version.size() || major < 0 || minor < 0) {
                refuse(at, "'" + version.substr(0, 40) + "'", "a version such as 2.0");
            }
            return std::pair(major, minor);
        };
        const json& asset = root_["asset"];
        const auto version = numbers("/asset/version", asset["version"]);
        if (version.first != 2) refuse("/asset/version", asset["version"].get<std::string>(), "2.x");
        if (!asset.contains("minVersion")) return;
        if (numbers("/asset/minVersion", asset["minVersion"]) > std::min(version, std::pair(2, 0)))
            refuse("/asset/minVersion", asset["minVersion"].get<std::string>(), "2.0");
    }

    std::set<std::string> extensionList(const char* name) {
        std::set<std::string> names;
        const auto list = root_.find(name);
        if (list == root_.end()) return names;
        if (!list->is_array()) refuse(std::string("/") + name, shownJson(*list), "an array");
        for (const json& entry : *list) {
            if (!entry.is_string()) refuse(std::string("/") + name, shownJson(entry), "a string");
            if (!names.insert(entry.get<std::string>()).second)
                warn(std::string("/") + name + " lists '" + entry.get<std::string>() + "' twice");
        }
        return names;
    }

    void checkExtensionLists() {
        used_ = extensionList("extensionsUsed");
        const std::set<std::string> required = extensionList("extensionsRequired");
        for (const std::string& name : required) {
            if (!knowsGltfExtension(name))
                refuse("/extensionsRequired", "extension '" + name + "', which is not read: " + whyNotRead(name), supported());
            if (!used_.count(name)) warn("/extensionsRequired names '" + name + "', /extensionsUsed does not");
        }
        for (const std::string& name : used_) {
            if (!knowsGltfExtension(name)) warn("extension '" + name + "' is not read: " + whyNotRead(name));
        }
        if (used_.count("KHR_mesh_quantization") && !required.count("KHR_mesh_quantization"))
            warn("extension 'KHR_mesh_quantization' should be in /extensionsRequired");
    }

    static std::string supported() {
        std::vector<std::string> names;
        for (const GltfExtension& row : gltfExtensions())
            if (row.read) names.push_back(row.name);
        return joined(names, ", ", [](const std::string& name) { return name; });
    }

    /// Every node has one parent at most and no node is below itself; scenes name roots only.
    void checkHierarchy() const {
        const json& nodes = arrayOf("nodes");
        std::vector<size_t> parent(nodes.size(), nodes.size());
        for (size_t i = 0; i < nodes.size(); i++) {
            if (!nodes[i].contains("children")) continue;
            for (const json& child : nodes[i]["children"]) {
                size_t& of = parent[child.get<size_t>()];
                if (of != nodes.size())
                    refuse("/nodes/" + std::to_string(i) + "/children", "node " + child.dump() + " has two parents",
                           "one parent");
                of = i;
            }
        }
        std::vector<bool> rooted(nodes.size(), false);
        for (size_t i = 0; i < nodes.size(); i++) {
            size_t steps = 0, at = i;
            while (at != nodes.size() && !rooted[at]) {
                if (++steps > nodes.size()) refuse("/nodes/" + std::to_string(i), "the node is below itself", "a tree");
                at = parent[at];
            }
            for (at = i; at != nodes.size() && !rooted[at]; at = parent[at]) rooted[at] = true;
        }
        const json& scenes = arrayOf("scenes");
        for (size_t s = 0; s < scenes.size(); s++) {
            if (!scenes[s].contains("nodes")) continue;
            std::set<size_t> seen;
            for (const json& node : scenes[s]["nodes"]) {
                const std::string at = "/scenes/" + std::to_string(s) + "/nodes";
                if (parent[node.get<size_t>()] != nodes.size())
                    refuse(at, "node " + node.dump() + " is below another", "root nodes");
                if (!seen.insert(node.get<size_t>()).second) refuse(at, "node " + node.dump() + " twice", "each node once");
            }
        }
    }

    void checkNodes() {
        const json& nodes = arrayOf("nodes");
        for (size_t i = 0; i < nodes.size(); i++) {
            const json& node = nodes[i];
            const std::string at = "/nodes/" + std::to_string(i);
            if (node.contains("matrix") &&
                (node.contains("rotation") || node.contains("scale") || node.contains("translation")))
                warn(at + " has a matrix and translation, rotation or scale: the matrix is used");
            if (!node.contains("mesh") && (node.contains("skin") || node.contains("weights")))
                warn(at + " has a skin or weights but no mesh: ignored");
        }
    }

    void checkData() {
        const json& views = arrayOf("bufferViews");
        for (size_t i = 0; i < views.size(); i++) {
            if (!views[i].contains("byteStride")) continue;
            const std::string at = "/bufferViews/" + std::to_string(i) + "/byteStride";
            const double stride = views[i]["byteStride"].get<double>();
            if (std::fmod(stride, 4.0) != 0.0) refuse(at, views[i]["byteStride"].dump(), "a multiple of 4");
            if (stride > views[i]["byteLength"].get<double>()) warn(at + " is more than byteLength");
            if (views[i].value("target", 34962) != 34962) warn(at + " is meant for vertex data only");
        }
        const json& accessors = arrayOf("accessors");
        for (size_t i = 0; i < accessors.size(); i++) {
            if (accessors[i].contains("byteOffset") && !accessors[i].contains("bufferView"))
                warn("/accessors/" + std::to_string(i) + " has a byteOffset but no bufferView: all zero");
        }
        const json& cameras = arrayOf("cameras");
        for (size_t i = 0; i < cameras.size(); i++) {
            if (!cameras[i].contains("perspective") || !cameras[i]["perspective"].contains("zfar")) continue;
            const json& lens = cameras[i]["perspective"];
            if (lens["zfar"].get<double>() <= lens["znear"].get<double>())
                warn("/cameras/" + std::to_string(i) + ": zfar is not beyond znear; both are ignored");
        }
        const json& images = arrayOf("images");
        for (size_t i = 0; i < images.size(); i++) {
            if (images[i].contains("uri") == images[i].contains("bufferView"))
                warn("/images/" + std::to_string(i) + " needs either uri or bufferView: not drawn");
        }
    }

    /// Warns about extensions that are not declared or hang where they mean nothing.
    void checkPlaces(const json& value, const std::string& at, int depth) {
        if (value.is_array()) {
            size_t i = 0;
            for (const json& element : value) {
                if (element.is_structured()) checkPlaces(element, at + "/" + std::to_string(i), depth + 1);
                i++;
            }
        }
        if (!value.is_object()) return;
        for (const auto& [key, child] : value.items()) {
            if (key == "extras" || !child.is_structured()) continue;
            if (key == "extensions") checkNames(child, at);
            checkPlaces(child, at + "/" + key, depth + 1);
        }
    }

    void checkNames(const json& extensions, const std::string& at) {
        if (!extensions.is_object()) return;
        const bool insideArray = std::count(at.begin(), at.end(), '/') == 2;  // "/materials/3"
        for (const auto& [name, extension] : extensions.items()) {
            if (name == "KHR_texture_transform" && insideArray)
                warn(at + "/extensions/" + name + ": not expected here, ignored");
            if (!used_.count(name)) warn(at + "/extensions/" + name + ": the extension is not declared in /extensionsUsed");
            const GltfExtension* row = gltfExtension(name);
            if (!row || !row->read || !*row->on || at.empty()) continue;
            if (!insideArray || at.rfind(std::string("/") + row->on + "/", 0) != 0)
                warn(at + "/extensions/" + name + ": not expected here, ignored");
        }
    }

    const json& root_;
    const std::string& file_;
    std::vector<std::string>& warnings_;
    std::set<std::string> used_;
};

}  // namespace

bool knowsGltfExtension(const std::string& name) {
    const GltfExtension* row = gltfExtension(name);
    return row && row->read;
}

void checkGltfJson(const json& root, const std::string& file, std::vector<std::string>& warnings) {
    Checker(root, file, warnings).check();
}

}  // namespace heliograph
