#include "tests/support/compressed_files.h"

#include "tests/unit/scene/scene_files.h"

#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace heliograph::testing_files {

namespace {

template <typename T>
std::string raw(const std::vector<T>& values) {
    return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

std::string number(size_t value) { return std::to_string(value); }

/// A GLB of one mesh: `primitive` is JSON, `views` stand one after another in the binary chunk.
std::string meshGlb(const std::string& primitive, const std::string& accessors, const std::vector<std::string>& views,
                    const std::string& viewsJson, const std::string& buffers, const std::string& extensions) {
    std::string binary;
    for (const std::string& view : views) binary += view + std::string((4 - view.size() % 4) % 4, '\0');
    const std::string names =
        extensions.empty() ? "" : R"(,"extensionsUsed":[)" + extensions + R"(],"extensionsRequired":[)" + extensions + "]";
    return glb(
        R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[)" +
            primitive + R"(]}],"accessors":[)" + accessors + R"(],"bufferViews":[)" + viewsJson +
            R"(],"buffers":[{"byteLength":)" + number(binary.size()) + "}" + buffers + "]" + names + "}",
        binary);
}

std::string accessor(int view, int type, size_t count, const char* kind, const std::string& more = {}) {
    return R"({)" + (view < 0 ? std::string() : R"("bufferView":)" + std::to_string(view) + ",") + R"("componentType":)" +
           std::to_string(type) + R"(,"count":)" + number(count) + R"(,"type":")" + kind + "\"" + more + "}";
}

/// JSON of the smallest and largest position.
std::string boundsOf(const WavyGrid& grid) {
    std::string low, high;
    for (size_t c = 0; c < 3; c++) {
        float from = INFINITY, to = -INFINITY;
        for (size_t i = c; i < grid.positions.size(); i += 3)
            from = std::min(from, grid.positions[i]), to = std::max(to, grid.positions[i]);
        char text[64];
        std::snprintf(text, sizeof(text), "%s%.9g", c ? "," : "", double(from));
        low += text;
        std::snprintf(text, sizeof(text), "%s%.9g", c ? "," : "", double(to));
        high += text;
    }
    return R"(,"min":[)" + low + R"(],"max":[)" + high + "]";
}

const std::string ATTRIBUTES = R"("attributes":{"POSITION":0,"NORMAL":1,"TEXCOORD_0":2},"indices":3)";

int addAttribute(draco::Mesh& mesh, draco::GeometryAttribute::Type type, int components, const std::vector<float>& values) {
    draco::GeometryAttribute attribute;
    attribute.Init(type, nullptr, static_cast<uint8_t>(components), draco::DT_FLOAT32, false, 4 * components, 0);
    const uint32_t count = static_cast<uint32_t>(values.size()) / static_cast<uint32_t>(components);
    const int id = mesh.AddAttribute(attribute, true, count);
    for (uint32_t i = 0; i < count; i++)
        mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(i), &values[i * static_cast<uint32_t>(components)]);
    return id;
}

/// One compressed view: its JSON, its bytes and where they go.
std::string meshoptView(size_t plainAt, size_t count, size_t stride, const std::string& bytes, size_t at,
                        const std::string& mode, const std::string& filter) {
    const bool vertices = mode == "ATTRIBUTES";
    return R"({"buffer":1,"byteOffset":)" + number(plainAt) + R"(,"byteLength":)" + number(count * stride) +
           (vertices ? R"(,"byteStride":)" + number(stride) : "") +
           R"(,"extensions":{"EXT_meshopt_compression":{"buffer":0,"byteOffset":)" + number(at) + R"(,"byteLength":)" +
           number(bytes.size()) + R"(,"byteStride":)" + number(stride) + R"(,"count":)" + number(count) + R"(,"mode":")" +
           mode + R"(","filter":")" + filter + R"("}}})";
}

std::string encodedVertices(const std::string& vertices, size_t count) {
    const size_t stride = vertices.size() / count;
    std::string out(meshopt_encodeVertexBufferBound(count, stride), '\0');
    out.resize(
        meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char*>(out.data()), out.size(), vertices.data(), count, stride));
    return out;
}

std::string encodedIndices(const WavyGrid& grid, bool triangles) {
    const size_t count = grid.indices.size();
    meshopt_encodeIndexVersion(1);
    std::string out(triangles ? meshopt_encodeIndexBufferBound(count, grid.vertices())
                              : meshopt_encodeIndexSequenceBound(count, grid.vertices()),
                    '\0');
    auto* const to = reinterpret_cast<unsigned char*>(out.data());
    out.resize(triangles ? meshopt_encodeIndexBuffer(to, out.size(), grid.indices.data(), count)
                         : meshopt_encodeIndexSequence(to, out.size(), grid.indices.data(), count));
    return out;
}

std::vector<float> padded(const std::vector<float>& values, size_t components) {
    std::vector<float> out;
    for (size_t i = 0; i < values.size(); i += components) {
        out.insert(out.end(), values.begin() + long(i), values.begin() + long(i + components));
        out.resize((out.size() + 3) / 4 * 4, 0.0f);
    }
    return out;
}

}  // namespace

WavyGrid::WavyGrid(uint32_t n) {
    for (uint32_t j = 0; j <= n; j++) {
        for (uint32_t i = 0; i <= n; i++) {
            const float x = float(i) / float(n), z = float(j) / float(n);
            const float dx = 7.0f * std::cos(7 * x) * std::cos(5 * z) / 8, dz = -5.0f * std::sin(7 * x) * std::sin(5 * z) / 8;
            const float length = std::sqrt(dx * dx + 1 + dz * dz);
            positions.insert(positions.end(), {x, std::sin(7 * x) * std::cos(5 * z) / 8, z});
            normals.insert(normals.end(), {-dx / length, 1 / length, -dz / length});
            uvs.insert(uvs.end(), {x, z});
            if (i == n || j == n) continue;
            const uint32_t a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
            indices.insert(indices.end(), {a, c, b, b, c, d});
        }
    }
}

std::string plainGlb(const WavyGrid& grid) {
    const std::vector<std::string> views = {raw(grid.positions), raw(grid.normals), raw(grid.uvs), raw(grid.indices)};
    std::string json;
    size_t at = 0;
    for (const std::string& view : views) {
        json += std::string(at ? "," : "") + R"({"buffer":0,"byteOffset":)" + number(at) + R"(,"byteLength":)" +
                number(view.size()) + "}";
        at += view.size();
    }
    const std::string accessors =
        accessor(0, 5126, grid.vertices(), "VEC3", boundsOf(grid)) + "," + accessor(1, 5126, grid.vertices(), "VEC3") + "," +
        accessor(2, 5126, grid.vertices(), "VEC2") + "," + accessor(3, 5125, grid.indices.size(), "SCALAR");
    return meshGlb("{" + ATTRIBUTES + "}", accessors, views, json, "", "");
}

std::string dracoBytes(const WavyGrid& grid, bool sequential) {
    draco::Mesh mesh;
    mesh.set_num_points(static_cast<uint32_t>(grid.vertices()));
    mesh.SetNumFaces(grid.indices.size() / 3);
    for (uint32_t i = 0; i < mesh.num_faces(); i++) {
        draco::Mesh::Face face;
        for (size_t k = 0; k < 3; k++) face[k] = draco::PointIndex(grid.indices[i * 3 + k]);
        mesh.SetFace(draco::FaceIndex(i), face);
    }
    draco::ExpertEncoder encoder(mesh);
    encoder.SetAttributeQuantization(addAttribute(mesh, draco::GeometryAttribute::POSITION, 3, grid.positions), 14);
    encoder.SetAttributeQuantization(addAttribute(mesh, draco::GeometryAttribute::NORMAL, 3, grid.normals), 10);
    encoder.SetAttributeQuantization(addAttribute(mesh, draco::GeometryAttribute::TEX_COORD, 2, grid.uvs), 12);
    encoder.SetEncodingMethod(sequential ? draco::MESH_SEQUENTIAL_ENCODING : draco::MESH_EDGEBREAKER_ENCODING);
    draco::EncoderBuffer out;
    const draco::Status status = encoder.EncodeToBuffer(&out);
    if (!status.ok()) throw std::runtime_error(status.error_msg_string());
    return {out.data(), out.size()};
}

std::string dracoGlb(const WavyGrid& grid, std::string_view draco, size_t count) {
    const std::string accessors = accessor(-1, 5126, count, "VEC3", boundsOf(grid)) + "," + accessor(-1, 5126, count, "VEC3") +
                                  "," + accessor(-1, 5126, count, "VEC2") + "," +
                                  accessor(-1, 5125, grid.indices.size(), "SCALAR");
    const std::string primitive = "{" + ATTRIBUTES +
                                  R"(,"extensions":{"KHR_draco_mesh_compression":{"bufferView":0,)"
                                  R"("attributes":{"POSITION":0,"NORMAL":1,"TEXCOORD_0":2}}}})";
    return meshGlb(primitive, accessors, {std::string(draco)}, R"({"buffer":0,"byteLength":)" + number(draco.size()) + "}", "",
                   R"("KHR_draco_mesh_compression")");
}

std::string dracoGlb(const WavyGrid& grid) { return dracoGlb(grid, dracoBytes(grid, false), grid.vertices()); }

std::string meshoptGlb(const WavyGrid& grid, MeshoptKind kind, bool triangles,
                       const std::vector<std::pair<std::string, std::string>>& changes) {
    const size_t count = grid.vertices();
    const bool filtered = kind == MeshoptKind::filtered;
    std::string stored[3] = {raw(grid.positions), raw(grid.normals), raw(grid.uvs)};
    const char* filters[3] = {"NONE", "NONE", "NONE"};
    if (filtered) {
        filters[0] = "EXPONENTIAL";
        filters[1] = "OCTAHEDRAL";
        meshopt_encodeFilterExp(stored[0].data(), count, 12, 16, grid.positions.data());
        stored[1].resize(count * 4);
        meshopt_encodeFilterOct(stored[1].data(), count, 4, 8, padded(grid.normals, 3).data());
        std::vector<uint16_t> shorts;
        for (const float uv : grid.uvs) shorts.push_back(static_cast<uint16_t>(std::lround(uv * 65535.0f)));
        stored[2] = raw(shorts);
    }
    std::vector<std::string> views;
    std::string json;
    size_t plainAt = 0, at = 0;
    const auto add = [&](const std::string& bytes, size_t elements, size_t stride, const char* mode, const char* filter) {
        std::string view = meshoptView(plainAt, elements, stride, bytes, at, mode, filter);
        for (const auto& [from, to] : changes) {
            if (const size_t found = view.find(from); views.empty() && found != std::string::npos)
                view.replace(found, from.size(), to);
        }
        json += (views.empty() ? "" : ",") + view;
        plainAt += elements * stride;
        at += (bytes.size() + 3) / 4 * 4;
        views.push_back(bytes);
    };
    for (int i = 0; i < 3; i++)
        add(encodedVertices(stored[i], count), count, stored[i].size() / count, "ATTRIBUTES", filters[i]);
    add(encodedIndices(grid, triangles), grid.indices.size(), 4, triangles ? "TRIANGLES" : "INDICES", "NONE");
    const std::string accessors =
        accessor(0, 5126, count, "VEC3", boundsOf(grid)) + "," +
        (filtered ? accessor(1, 5120, count, "VEC3", R"(,"normalized":true)") : accessor(1, 5126, count, "VEC3")) + "," +
        (filtered ? accessor(2, 5123, count, "VEC2", R"(,"normalized":true)") : accessor(2, 5126, count, "VEC2")) + "," +
        accessor(3, 5125, grid.indices.size(), "SCALAR");
    return meshGlb("{" + ATTRIBUTES + "}", accessors, views, json,
                   R"(,{"byteLength":)" + number(plainAt) + R"(,"extensions":{"EXT_meshopt_compression":{"fallback":true}}})",
                   filtered ? R"("EXT_meshopt_compression","KHR_mesh_quantization")" : R"("EXT_meshopt_compression")");
}

}  // namespace heliograph::testing_files
