#include "server/scene/load/gltf_draco.h"

#include "server/base/error.h"
#include "server/scene/load/draco_mesh.h"
#include "server/scene/load/gltf_textures.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace heliograph {

namespace {

constexpr const char* DRACO = "KHR_draco_mesh_compression";
constexpr uint64_t FREE_TRIANGLES = 250'000;
constexpr uint64_t TRIANGLES_PER_BYTE = 4;

/// One primitive to decode.
struct Job {
    tinygltf::Primitive* primitive = nullptr;
    std::string pointer;
    int view = -1;
    std::vector<std::string> names;  // of the attributes
    std::vector<DracoAttribute> wanted;
    DracoMesh mesh;
    std::string fault;
};

/// Reads what the extensions say and puts what was decoded into the document.
class DracoReader {
public:
    explicit DracoReader(GltfDocument& document) : document_(document), model_(document.model) {}

    void read() {
        for (size_t m = 0; m < model_.meshes.size(); m++) {
            std::vector<tinygltf::Primitive>& primitives = model_.meshes[m].primitives;
            for (size_t p = 0; p < primitives.size(); p++)
                collect(primitives[p], "/meshes/" + std::to_string(m) + "/primitives/" + std::to_string(p));
        }
        DracoBudget budget(static_cast<int64_t>(FREE_TRIANGLES + TRIANGLES_PER_BYTE * document_.sourceBytes));
        tbb::parallel_for(size_t(0), jobs_.size(), [&](size_t i) {
            Job& job = jobs_[i];
            try {
                job.mesh = decodeDraco(document_.view(job.view), job.wanted, budget);
            } catch (const std::runtime_error& error) {
                job.fault = error.what();
            }
        });
        for (Job& job : jobs_) place(job);
    }

private:
    bool isPlain(int accessor) const { return model_.accessors[static_cast<size_t>(accessor)].bufferView >= 0; }

    void collect(tinygltf::Primitive& primitive, const std::string& pointer) {
        const auto found = primitive.extensions.find(DRACO);
        if (found == primitive.extensions.end()) return;
        const tinygltf::Value& attributes = found->second.Get("attributes");
        Job job;
        job.primitive = &primitive;
        job.pointer = document_.at(pointer + "/extensions/" + DRACO);
        job.view = static_cast<int>(numberOf(found->second, "bufferView", -1.0));
        bool plain = primitive.indices >= 0 && isPlain(primitive.indices);
        for (const std::string& name : attributes.Keys()) {
            const double id = numberOf(attributes, name.c_str(), -1.0);
            const auto accessor = primitive.attributes.find(name);
            if (!(id >= 0.0 && id <= 4294967295.0) || std::floor(id) != id)
                throw InputError(job.pointer + "/attributes/" + name.substr(0, 40), "no id", "an integer of 0 or more");
            if (accessor == primitive.attributes.end())
                throw InputError(job.pointer + "/attributes/" + name.substr(0, 40), "the primitive has no such attribute",
                                 "names of the primitive's attributes");
            plain = plain && isPlain(accessor->second);
            const tinygltf::Accessor& to = model_.accessors[static_cast<size_t>(accessor->second)];
            const int components = tinygltf::GetNumComponentsInType(static_cast<uint32_t>(to.type));
            if (components < 1 || components > 4)
                throw InputError(job.pointer + "/attributes/" + name.substr(0, 40), "elements of " + std::to_string(components),
                                 "1 to 4 components");
            job.names.push_back(name);
            job.wanted.push_back({static_cast<uint32_t>(id), to.componentType, components});
        }
        if (plain) return;
        if (primitive.mode >= 0 && primitive.mode != TINYGLTF_MODE_TRIANGLES && primitive.mode != TINYGLTF_MODE_TRIANGLE_STRIP)
            throw InputError(job.pointer, "a primitive of mode " + std::to_string(primitive.mode), "4 or 5");
        jobs_.push_back(std::move(job));
    }

    void place(Job& job) {
        if (!job.fault.empty()) throw InputError(job.pointer, job.fault, "a mesh that Draco compressed");
        tinygltf::Primitive& primitive = *job.primitive;
        std::vector<uint8_t> corners(job.mesh.indices.size() * 4);
        std::copy_n(reinterpret_cast<const uint8_t*>(job.mesh.indices.data()), corners.size(), corners.data());
        tinygltf::Accessor indices;
        indices.componentType = TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
        indices.type = TINYGLTF_TYPE_SCALAR;
        const size_t cornerCount = job.mesh.indices.size();
        if (primitive.indices >= 0 && model_.accessors[static_cast<size_t>(primitive.indices)].count != cornerCount)
            otherCount(job, primitive.indices, cornerCount);
        primitive.indices = add(indices, cornerCount, std::move(corners));
        primitive.mode = TINYGLTF_MODE_TRIANGLES;
        for (size_t i = 0; i < job.names.size(); i++) {
            int& attribute = primitive.attributes[job.names[i]];
            const tinygltf::Accessor declared = model_.accessors[static_cast<size_t>(attribute)];
            if (declared.count != job.mesh.points) otherCount(job, attribute, job.mesh.points);
            attribute = add(declared, job.mesh.points, std::move(job.mesh.attributes[i]));
        }
        job.mesh = {};
    }

    void otherCount(const Job& job, int accessor, size_t count) {
        document_.warnings.push_back(job.pointer + ": accessor " + std::to_string(accessor) + " says " +
                                     std::to_string(model_.accessors[static_cast<size_t>(accessor)].count) +
                                     " elements, the data has " + std::to_string(count));
    }

    /// An accessor like `like` over `bytes`.
    int add(tinygltf::Accessor like, size_t count, std::vector<uint8_t>&& bytes) {
        like.bufferView = document_.addDecoded(std::move(bytes));
        document_.inexactViews.insert(like.bufferView);
        like.byteOffset = 0;
        like.count = count;
        like.sparse.isSparse = false;
        model_.accessors.push_back(std::move(like));
        return static_cast<int>(model_.accessors.size() - 1);
    }

    GltfDocument& document_;
    tinygltf::Model& model_;
    std::vector<Job> jobs_;
};

}  // namespace

void dropCompressedIndices(nlohmann::json& root) {
    if (!root.contains("meshes")) return;
    for (nlohmann::json& mesh : root["meshes"]) {
        for (nlohmann::json& primitive : mesh["primitives"]) {
            if (!primitive.contains("indices") || !primitive.contains("extensions") || !primitive["extensions"].contains(DRACO))
                continue;
            if (!root["accessors"][primitive["indices"].get<size_t>()].contains("bufferView")) primitive.erase("indices");
        }
    }
}

void decodeDracoGeometry(GltfDocument& document) { DracoReader(document).read(); }

}  // namespace heliograph
