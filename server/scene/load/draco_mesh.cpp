#include "server/scene/load/draco_mesh.h"

#include <draco/compression/config/decoder_options.h>
#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/core/varint_decoding.h>
#include <draco/mesh/mesh.h>

#include <tbb/parallel_for.h>

#include <cstring>
#include <stdexcept>
#include <string>

namespace heliograph {

namespace {

constexpr uint16_t SINCE_2_0 = 2 << 8, SINCE_2_2 = 2 << 8 | 2;
constexpr int64_t MOST_BYTES_PER_POINT = 256;   // of all attributes; a vertex of glTF has about 60
constexpr uint8_t MOST_SEAMED_ATTRIBUTES = 16;  // each has a table of corners of its own

/// How much a mesh claims to hold.
struct Claim {
    uint32_t faces = 0, points = 0;
    uint8_t seamed = 0;                // attributes with seams of their own
    uint32_t symbols = 0, splits = 0;  // of edgebreaker's walk
};

/// The first values of the connectivity, as libdraco reads them (draco/compression/mesh/*_decoder*.cc of 1.5).
bool readClaim(draco::DecoderBuffer data, uint16_t version, bool edgebreaker, Claim& claim) {
    const auto whole = [&](uint32_t& value, uint16_t varintSince) {
        return version < varintSince ? data.Decode(&value) : draco::DecodeVarint(&value, &data);
    };
    if (!edgebreaker) return whole(claim.faces, SINCE_2_2) && whole(claim.points, SINCE_2_2);
    uint32_t newVertices = 0;  // the kind of traversal, which stands before, was read by InitializeDecoder
    if (version < SINCE_2_2 && !whole(newVertices, SINCE_2_0)) return false;
    return whole(claim.points, SINCE_2_0) && whole(claim.faces, SINCE_2_0) && data.Decode(&claim.seamed) &&
           whole(claim.symbols, SINCE_2_0) && whole(claim.splits, SINCE_2_0);
}

/// One of libdraco's decoders, which asks before memory is taken: libdraco takes it for whatever counts the data claims.
template <typename Decoder, bool EDGEBREAKER>
class GuardedDecoder : public Decoder {
public:
    explicit GuardedDecoder(DracoBudget& budget) : budget_(budget) {}
    const std::string& fault() const { return fault_; }

protected:
    bool DecodeGeometryData() override {
        Claim claim;
        if (!readClaim(*this->buffer(), this->bitstream_version(), EDGEBREAKER, claim)) return stop("the data is cut off");
        if (claim.points > uint64_t(claim.faces) * 3)
            return stop(std::to_string(claim.points) + " points for " + std::to_string(claim.faces) + " triangles");
        if (claim.symbols > claim.faces || claim.splits > claim.symbols)
            return stop(std::to_string(claim.symbols) + " symbols, " + std::to_string(claim.splits) + " of them splits, for " +
                        std::to_string(claim.faces) + " triangles");
        if (claim.seamed > MOST_SEAMED_ATTRIBUTES)
            return stop(std::to_string(claim.seamed) + " attributes with seams; at most " +
                        std::to_string(MOST_SEAMED_ATTRIBUTES));
        if (budget_.fetch_sub(claim.faces) < int64_t(claim.faces))
            return stop(std::to_string(claim.faces) + " triangles are out of proportion to the file");
        return Decoder::DecodeGeometryData();
    }

    /// The attributes' kinds are known here, their values are not yet read.
    bool DecodeAllAttributes() override {
        int64_t bytes = 0;
        for (int i = 0; i < this->point_cloud()->num_attributes(); i++)
            bytes += this->point_cloud()->attribute(i)->byte_stride();
        if (bytes > MOST_BYTES_PER_POINT)
            return stop(std::to_string(bytes) + " bytes of attributes a point; at most " +
                        std::to_string(MOST_BYTES_PER_POINT));
        return Decoder::DecodeAllAttributes();
    }

private:
    bool stop(const std::string& fault) {
        fault_ = fault;
        return false;
    }

    DracoBudget& budget_;
    std::string fault_;
};

template <typename Decoder, bool EDGEBREAKER>
void run(std::span<const uint8_t> bytes, draco::Mesh& mesh, DracoBudget& budget) {
    draco::DecoderBuffer data;
    data.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    GuardedDecoder<Decoder, EDGEBREAKER> decoder(budget);
    const draco::DecoderOptions options;
    const draco::Status status = decoder.Decode(options, &data, &mesh);
    if (status.ok()) return;
    throw std::runtime_error(decoder.fault().empty() ? status.error_msg_string().substr(0, 160) : decoder.fault());
}

void decode(std::span<const uint8_t> bytes, draco::Mesh& mesh, DracoBudget& budget) {
    draco::DecoderBuffer data;
    data.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    draco::DracoHeader header;
    const draco::Status status = draco::PointCloudDecoder::DecodeHeader(&data, &header);
    if (!status.ok()) throw std::runtime_error(status.error_msg_string().substr(0, 160));
    if (header.encoder_type != draco::TRIANGULAR_MESH) throw std::runtime_error("no mesh of triangles");
    if (header.encoder_method == draco::MESH_EDGEBREAKER_ENCODING)
        run<draco::MeshEdgebreakerDecoder, true>(bytes, mesh, budget);
    else if (header.encoder_method == draco::MESH_SEQUENTIAL_ENCODING)
        run<draco::MeshSequentialDecoder, false>(bytes, mesh, budget);
    else throw std::runtime_error("unknown method " + std::to_string(header.encoder_method));
}

/// One kind of glTF's components: its type there and here.
struct ComponentKind {
    int type;
    draco::DataType stored;
    size_t bytes;
};
constexpr ComponentKind KINDS[] = {
    {5120, draco::DT_INT8, 1},   {5121, draco::DT_UINT8, 1},  {5122, draco::DT_INT16, 2},
    {5123, draco::DT_UINT16, 2}, {5125, draco::DT_UINT32, 4}, {5126, draco::DT_FLOAT32, 4},
};

const ComponentKind& kindOf(int componentType) {
    for (const ComponentKind& kind : KINDS) {
        if (kind.type == componentType) return kind;
    }
    throw std::runtime_error("component type " + std::to_string(componentType));
}

bool convert(const draco::PointAttribute& from, draco::AttributeValueIndex value, const ComponentKind& kind, int components,
             uint8_t* out) {
    const auto to = [&]<typename T>(T) { return from.ConvertValue<T>(value, int8_t(components), reinterpret_cast<T*>(out)); };
    switch (kind.stored) {
        case draco::DT_INT8: return to(int8_t());
        case draco::DT_UINT8: return to(uint8_t());
        case draco::DT_INT16: return to(int16_t());
        case draco::DT_UINT16: return to(uint16_t());
        case draco::DT_UINT32: return to(uint32_t());
        default: return to(float());
    }
}

std::vector<uint8_t> valuesOf(const draco::Mesh& mesh, const DracoAttribute& wanted) {
    const draco::PointAttribute* from = mesh.GetAttributeByUniqueId(wanted.id);
    if (!from) throw std::runtime_error("no attribute of id " + std::to_string(wanted.id));
    const ComponentKind& kind = kindOf(wanted.componentType);
    const size_t element = kind.bytes * static_cast<size_t>(wanted.components);
    const bool same = from->data_type() == kind.stored && from->num_components() == wanted.components;
    std::vector<uint8_t> values(mesh.num_points() * element);
    for (uint32_t i = 0; i < mesh.num_points(); i++) {
        const draco::AttributeValueIndex at = from->mapped_index(draco::PointIndex(i));
        if (at.value() >= from->size())
            throw std::runtime_error("a point has no value of attribute " + std::to_string(wanted.id));
        uint8_t* out = &values[i * element];
        if (same) std::memcpy(out, from->GetAddress(at), element);
        else if (!convert(*from, at, kind, wanted.components, out))
            throw std::runtime_error("attribute " + std::to_string(wanted.id) + " does not fit its accessor");
    }
    return values;
}

}  // namespace

DracoMesh decodeDraco(std::span<const uint8_t> bytes, std::span<const DracoAttribute> wanted, DracoBudget& budget) {
    draco::Mesh mesh;
    decode(bytes, mesh, budget);
    DracoMesh result;
    result.points = mesh.num_points();
    result.indices.reserve(size_t(mesh.num_faces()) * 3);
    for (uint32_t i = 0; i < mesh.num_faces(); i++) {
        for (const draco::PointIndex& corner : mesh.face(draco::FaceIndex(i))) {
            if (corner.value() >= result.points)
                throw std::runtime_error("triangle " + std::to_string(i) + " has corner " + std::to_string(corner.value()) +
                                         " of " + std::to_string(result.points));
            result.indices.push_back(corner.value());
        }
    }
    result.attributes.resize(wanted.size());
    tbb::parallel_for(size_t(0), wanted.size(), [&](size_t i) { result.attributes[i] = valuesOf(mesh, wanted[i]); });
    return result;
}

}  // namespace heliograph
