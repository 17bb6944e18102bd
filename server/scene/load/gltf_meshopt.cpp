#include "server/scene/load/gltf_meshopt.h"

#include "server/base/error.h"
#include "server/scene/load/file_folder.h"

#include <meshoptimizer.h>
#include <tbb/parallel_for.h>

#include <algorithm>

namespace heliograph {

using nlohmann::json;

namespace {

constexpr const char* MESHOPT = "EXT_meshopt_compression";
constexpr uint64_t FREE_BYTES = uint64_t(16) << 20;
// Attributes: two bits of header stand for 16 bytes of one kind at the least (Kapoulkine, EXT_meshopt_compression, appendix A).
constexpr uint64_t BYTES_PER_BYTE = 64;

using Mode = MeshoptView::Mode;
using Filter = MeshoptView::Filter;

struct ModeRow {
    const char* name;
    Mode mode;
    uint64_t perByte;  // most elements that one compressed byte can stand for
};
constexpr ModeRow MODES[] = {
    {"ATTRIBUTES", Mode::attributes, 64}, {"TRIANGLES", Mode::triangles, 3}, {"INDICES", Mode::indices, 1}};

struct FilterRow {
    const char* name;
    Filter filter;
};
constexpr FilterRow FILTERS[] = {{"NONE", Filter::none},
                                 {"OCTAHEDRAL", Filter::octahedral},
                                 {"QUATERNION", Filter::quaternion},
                                 {"EXPONENTIAL", Filter::exponential}};

/// One buffer view's extension, being checked.
class ViewCheck {
public:
    ViewCheck(const json& view, size_t index, const GltfDocument& document)
        : view_(view), extension_(view["extensions"][MESHOPT]), document_(document) {
        to_.view = index;
        to_.where = document.at("/bufferViews/" + std::to_string(index) + "/extensions/" + MESHOPT);
    }

    MeshoptView checked() {
        setBytes();
        to_.count = whole("count");
        to_.stride = whole("byteStride");
        const uint64_t perByte = setMode();
        setFilter();
        const uint64_t length = view_["byteLength"].get<uint64_t>();
        if (to_.count > (uint64_t(1) << 32) || to_.stride > 256 || to_.count * to_.stride != length)
            refuse("", std::to_string(to_.count) + " elements of " + std::to_string(to_.stride) + " bytes",
                   "the buffer view's byteLength of " + std::to_string(length));
        if (view_.contains("byteStride") && view_["byteStride"].get<uint64_t>() != to_.stride)
            refuse("/byteStride", std::to_string(to_.stride), "the buffer view's " + view_["byteStride"].dump());
        // For attributes a byte of each kind in turn: an element of `stride` bytes costs at least stride / 64.
        const uint64_t most = to_.bytes.size() * perByte / (to_.mode == Mode::attributes ? to_.stride : 1);
        if (to_.count > most)
            refuse("/count", std::to_string(to_.count),
                   "at most " + std::to_string(most) + " for " + std::to_string(to_.bytes.size()) + " compressed bytes");
        return to_;
    }

private:
    [[noreturn]] void refuse(const std::string& property, const std::string& found, const std::string& allowed) const {
        throw InputError(to_.where + property, found, allowed);
    }

    uint64_t whole(const char* name) const {
        if (!extension_.contains(name)) refuse("", std::string("property '") + name + "' is missing", "an integer");
        return extension_[name].get<uint64_t>();
    }

    void setBytes() {
        const ByteSpan buffer = document_.buffers[whole("buffer")];
        const uint64_t offset = extension_.contains("byteOffset") ? whole("byteOffset") : 0, length = whole("byteLength");
        if (offset > buffer.size() || length > buffer.size() - offset)
            refuse("", "bytes " + std::to_string(offset) + " to " + std::to_string(offset + length),
                   "at most byte " + std::to_string(buffer.size()) + ", the end of the buffer's data");
        to_.bytes = buffer.subspan(offset, length);
    }

    std::string word(const char* name, const char* otherwise) const {
        return extension_.contains(name) ? extension_[name].get<std::string>().substr(0, 40) : otherwise;
    }

    uint64_t setMode() {
        const std::string name = word("mode", "");
        const auto row = std::find_if(std::begin(MODES), std::end(MODES), [&](const ModeRow& r) { return name == r.name; });
        if (row == std::end(MODES)) refuse("/mode", "'" + name + "'", "ATTRIBUTES, TRIANGLES or INDICES");
        to_.mode = row->mode;
        const bool index = to_.mode != Mode::attributes;
        if (index ? to_.stride != 2 && to_.stride != 4 : to_.stride < 4 || to_.stride % 4 != 0)
            refuse("/byteStride", std::to_string(to_.stride), index ? "2 or 4" : "a multiple of 4, at most 256");
        if (to_.mode == Mode::triangles && to_.count % 3 != 0) refuse("/count", std::to_string(to_.count), "a multiple of 3");
        return row->perByte;
    }

    void setFilter() {
        const std::string name = word("filter", "NONE");
        const auto row =
            std::find_if(std::begin(FILTERS), std::end(FILTERS), [&](const FilterRow& r) { return name == r.name; });
        if (row == std::end(FILTERS)) refuse("/filter", "'" + name + "'", "NONE, OCTAHEDRAL, QUATERNION or EXPONENTIAL");
        to_.filter = row->filter;
        if (to_.filter != Filter::none && to_.mode != Mode::attributes)
            refuse("/filter", name, "NONE for indices and triangles");
        if (to_.filter == Filter::octahedral && to_.stride != 4 && to_.stride != 8)
            refuse("/byteStride", std::to_string(to_.stride), "4 or 8 for octahedral");
        if (to_.filter == Filter::quaternion && to_.stride != 8)
            refuse("/byteStride", std::to_string(to_.stride), "8 for quaternion");
    }

    const json& view_;
    const json& extension_;
    const GltfDocument& document_;
    MeshoptView to_;
};

std::vector<uint8_t> decoded(const MeshoptView& view) {
    std::vector<uint8_t> out(view.count * view.stride);
    int fault = 0;
    switch (view.mode) {
        case Mode::attributes:
            fault = meshopt_decodeVertexBuffer(out.data(), view.count, view.stride, view.bytes.data(), view.bytes.size());
            break;
        case Mode::triangles:
            fault = meshopt_decodeIndexBuffer(out.data(), view.count, view.stride, view.bytes.data(), view.bytes.size());
            break;
        case Mode::indices:
            fault = meshopt_decodeIndexSequence(out.data(), view.count, view.stride, view.bytes.data(), view.bytes.size());
            break;
    }
    if (fault != 0)
        throw InputError(view.where, std::to_string(view.bytes.size()) + " bytes that cannot be decoded",
                         "what meshoptimizer made of " + std::to_string(view.count) + " elements");
    switch (view.filter) {
        case Filter::none: break;
        case Filter::octahedral: meshopt_decodeFilterOct(out.data(), view.count, view.stride); break;
        case Filter::quaternion: meshopt_decodeFilterQuat(out.data(), view.count, view.stride); break;
        case Filter::exponential: meshopt_decodeFilterExp(out.data(), view.count, view.stride); break;
    }
    return out;
}

bool hasExtension(const json& value) { return value.contains("extensions") && value["extensions"].contains(MESHOPT); }

}  // namespace

bool isFallbackBuffer(const json& buffer) {
    if (!hasExtension(buffer)) return false;
    const json& extension = buffer["extensions"][MESHOPT];
    return extension.contains("fallback") && extension["fallback"].get<bool>();
}

bool isMeshoptView(const json& view) { return hasExtension(view); }

std::vector<MeshoptView> meshoptViewsOf(const json& root, const GltfDocument& document) {
    std::vector<MeshoptView> views;
    if (!root.contains("bufferViews")) return views;
    const uint64_t most = std::min(2 * MOST_FILE_BYTES, FREE_BYTES + BYTES_PER_BYTE * document.sourceBytes);
    uint64_t bytes = 0;
    size_t i = 0;
    for (const json& view : root["bufferViews"]) {
        const size_t index = i++;
        if (!isMeshoptView(view)) continue;
        views.push_back(ViewCheck(view, index, document).checked());
        bytes += views.back().count * views.back().stride;
        if (bytes > most)
            throw InputError(views.back().where, std::to_string(bytes) + " bytes so far once decoded",
                             "at most " + std::to_string(most) + " for a file of this size");
    }
    return views;
}

void decodeMeshoptViews(std::span<const MeshoptView> views, GltfDocument& document) {
    std::vector<std::vector<uint8_t>> bytes(views.size());
    tbb::parallel_for(size_t(0), views.size(), [&](size_t i) { bytes[i] = decoded(views[i]); });
    for (size_t i = 0; i < views.size(); i++) {
        const auto added = document.model.bufferViews[static_cast<size_t>(document.addDecoded(std::move(bytes[i])))];
        tinygltf::BufferView& view = document.model.bufferViews[views[i].view];
        view.buffer = added.buffer;
        view.byteOffset = 0;
        if (views[i].filter == Filter::exponential) document.inexactViews.insert(static_cast<int>(views[i].view));
    }
}

}  // namespace heliograph
