#include "server/base/error.h"
#include "server/scene/load/scene_source.h"
#include "tests/support/compressed_files.h"
#include "tests/support/random.h"
#include "tests/unit/scene/scene_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <glm/geometric.hpp>

namespace heliograph::TEST_FILE {
namespace {

using namespace testing_files;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

std::shared_ptr<const Scene> openBytes(const std::string& bytes) {
    const ScratchFolder folder;
    return openScene(folder.write("scene.glb", bytes));
}

/// The message with which a file is refused; fails if it is not.
std::string refusal(const std::string& bytes) {
    const ScratchFolder folder;
    try {
        openScene(folder.write("scene.glb", bytes));
    } catch (const InputError& error) {
        EXPECT_THAT(error.what(), Not(HasSubstr("\n")));
        return error.what();
    }
    ADD_FAILURE() << "not refused";
    return {};
}

double areaOf(const Scene& scene) {
    double area = 0.0;
    for (const uvec4& t : scene.triangles) {
        const vec3 a(scene.positions[t.x]), b(scene.positions[t.y]), c(scene.positions[t.z]);
        area += 0.5 * glm::length(glm::cross(b - a, c - a));
    }
    return area;
}

/// The grid again, in whatever order its vertices and triangles come: each vertex lies on the wave with its normal and uv.
void expectWave(const Scene& scene, const WavyGrid& grid, float place, float turn, float uv) {
    ASSERT_EQ(scene.triangleCount(), grid.indices.size() / 3);
    for (size_t i = 0; i < scene.attributes.size(); i++) {
        const vec3 p(scene.positions[i]);
        const VertexAttributes& vertex = scene.attributes[i];
        ASSERT_NEAR(p.y, std::sin(7 * p.x) * std::cos(5 * p.z) / 8, place);
        ASSERT_NEAR(vertex.u0, p.x, uv);
        ASSERT_NEAR(vertex.v0, p.z, uv);
        const vec3 slope(-7.0f * std::cos(7 * p.x) * std::cos(5 * p.z) / 8, 1.0f,
                         5.0f * std::sin(7 * p.x) * std::sin(5 * p.z) / 8);
        ASSERT_GT(glm::dot(glm::normalize(slope), vec3(vertex.normal)), 1.0f - turn);
    }
    EXPECT_NEAR(areaOf(scene), areaOf(*openBytes(plainGlb(grid))), 2e-3);
    for (const std::string& warning : scene.warnings) EXPECT_THAT(warning, HasSubstr("studio")) << warning;
}

TEST(DracoGeometry, IsWhatWasEncoded) {
    const WavyGrid grid(24);
    for (const bool sequential : {false, true}) {
        SCOPED_TRACE(sequential);
        expectWave(*openBytes(dracoGlb(grid, dracoBytes(grid, sequential), grid.vertices())), grid, 1e-3f, 1e-3f, 1e-3f);
    }
}

TEST(DracoGeometry, CountsOfTheDataAreTold) {
    const WavyGrid grid(8);
    const auto scene = openBytes(dracoGlb(grid, dracoBytes(grid, false), grid.vertices() + 5));
    EXPECT_EQ(scene->triangleCount(), 128u);
    EXPECT_THAT(scene->warnings, Contains(HasSubstr("says 86 elements, the data has 81")));
}

TEST(DracoGeometry, EveryTruncationIsRefusedInOneLine) {
    const WavyGrid grid(6);
    for (const bool sequential : {false, true}) {
        const std::string whole = dracoBytes(grid, sequential);
        for (size_t length = 1; length < whole.size(); length++)
            EXPECT_THAT(
                refusal(dracoGlb(grid, std::string_view(whole).substr(0, length), grid.vertices())),
                AllOf(HasSubstr("/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression: "), HasSubstr("allowed: ")))
                << length << " of " << whole.size();
    }
}

TEST(DracoGeometry, ClaimsAreCheckedBeforeMemoryIsTaken) {
    const WavyGrid grid(6);
    const std::string many("\xff\xff\xff\xff\x03", 5);  // 1,073,741,823 as Draco writes it
    // Sequential: triangles and points stand behind the header of 11 bytes; edgebreaker: kind of walk, points, triangles.
    std::string sequential = dracoBytes(grid, true), edgebreaker = dracoBytes(grid, false);
    EXPECT_THAT(refusal(dracoGlb(grid, sequential.replace(11, 1, many), 49)),
                HasSubstr("1073741823 triangles are out of proportion"));
    EXPECT_THAT(refusal(dracoGlb(grid, edgebreaker.replace(13, 1, many), 49)),
                HasSubstr("1073741823 triangles are out of proportion"));
    sequential = dracoBytes(grid, true), edgebreaker = dracoBytes(grid, false);
    EXPECT_THAT(refusal(dracoGlb(grid, sequential.replace(12, 1, many), 49)), HasSubstr("1073741823 points for 72 triangles"));
    EXPECT_THAT(refusal(dracoGlb(grid, edgebreaker.replace(12, 1, many), 49)), HasSubstr("1073741823 points for 72 triangles"));
    edgebreaker = dracoBytes(grid, false);
    edgebreaker[14] = char(200);
    EXPECT_THAT(refusal(dracoGlb(grid, edgebreaker, 49)), HasSubstr("200 attributes with seams"));
    // Many primitives may not decode the same bytes again and again.
    const WavyGrid large(300);
    std::string bomb = dracoGlb(large, dracoBytes(large, false), large.vertices());
    const std::string head = R"("primitives":[)", end = "]}],\"accessors\"";
    const size_t from = bomb.find(head) + head.size(), to = bomb.find(end);
    const std::string primitive = bomb.substr(from, to - from);
    std::string json = bomb.substr(20, bomb.find("BIN") - 24);
    std::string all = primitive;
    for (int i = 0; i < 40; i++) all += "," + primitive;
    json.replace(json.find(head) + head.size(), primitive.size(), all);
    EXPECT_THAT(refusal(glb(json, bomb.substr(bomb.find("BIN") + 4))), HasSubstr("180000 triangles are out of proportion"));
}

TEST(DracoGeometry, WrongReferencesAreRefused) {
    const WavyGrid grid(4);
    const std::string good = dracoGlb(grid);
    const auto changed = [&](const std::string& from, const std::string& to) {
        std::string bytes = good;
        bytes.replace(bytes.find(from), from.size(), to);
        return refusal(bytes);
    };
    const std::string attributes = R"("attributes":{"POSITION":0,"NORMAL":1,"TEXCOORD_0":2}}}})";
    EXPECT_THAT(changed(attributes, R"("attributes":{"POSITION":0,"NORMAL":1,"TEXCOORD_0":9}}}})"),
                HasSubstr("no attribute of id 9"));
    EXPECT_THAT(changed(attributes, R"("attributes":{"POSITION":0,"NORMAL":1,"TEXCOORD_5":2}}}})"),
                HasSubstr("no such attribute"));
    EXPECT_THAT(changed(attributes, R"("attributes":{"POSITION":"","NORMAL":1,"TEXCOORD_":2}}}})"),
                HasSubstr("an integer of 0 or more"));
    EXPECT_THAT(changed(R"({"bufferView":0,)", R"({"bufferView":7,)"), HasSubstr("an index below 1 (bufferViews)"));
}

TEST(DracoGeometry, DamagedBytesHarmNothing) {
    const WavyGrid grid(6);
    for (const bool sequential : {false, true}) {
        const std::string whole = dracoBytes(grid, sequential);
        uint32_t state = 7;
        for (int i = 0; i < 800; i++) {
            std::string bytes = whole;
            for (int k = 0; k < 1 + i % 3; k++) {
                state = state * 1664525u + 1013904223u;
                bytes[11 + (state >> 8) % (bytes.size() - 11)] = static_cast<char>(state >> 3);
            }
            try {
                openBytes(dracoGlb(grid, bytes, grid.vertices()));
            } catch (const InputError&) {}
        }
    }
}

TEST(MeshoptGeometry, IsWhatWasEncoded) {
    const WavyGrid grid(24);
    for (const bool triangles : {false, true}) {
        SCOPED_TRACE(triangles);
        const auto exact = openBytes(meshoptGlb(grid, MeshoptKind::exact, triangles));
        // The codec of triangles may turn their corners.
        if (!triangles) {
            EXPECT_EQ(exact->contentHash, openBytes(plainGlb(grid))->contentHash);
        }
        expectWave(*exact, grid, 1e-6f, 1e-6f, 1e-6f);
        expectWave(*openBytes(meshoptGlb(grid, MeshoptKind::filtered, triangles)), grid, 1e-3f, 1e-3f, 1e-3f);
    }
}

TEST(MeshoptGeometry, WhatCannotBeIsRefused) {
    const WavyGrid grid(6);
    const auto changed = [&](const std::string& from, const std::string& to) {
        return refusal(meshoptGlb(grid, MeshoptKind::exact, true, {{from, to}}));
    };
    EXPECT_THAT(changed(R"("mode":"ATTRIBUTES")", R"("mode":"SCALARS")"),
                HasSubstr("'SCALARS'; allowed: ATTRIBUTES, TRIANGLES"));
    EXPECT_THAT(changed(R"("filter":"NONE")", R"("filter":"QUATERNION")"), HasSubstr("12; allowed: 8 for quaternion"));
    EXPECT_THAT(changed(R"("filter":"NONE")", R"("filter":"COLOR")"), HasSubstr("'COLOR'; allowed: NONE"));
    EXPECT_THAT(changed(R"("count":49)", R"("count":50)"), HasSubstr("the buffer view's byteLength of 588"));
    EXPECT_THAT(changed(R"("count":49)", R"("count":-1)"), HasSubstr("/count: -1"));
    EXPECT_THAT(changed(R"({"buffer":0,)", R"({"buffer":1,)"), HasSubstr("at most byte 0"));
    EXPECT_THAT(changed(R"({"buffer":0,)", R"({)"), HasSubstr("property 'buffer' is missing"));
    EXPECT_THAT(changed(R"("byteStride":12,"count")", R"("byteStride":14,"count")"), HasSubstr("a multiple of 4"));
    // Sizes that the bytes cannot hold are refused before memory is taken.
    const std::string huge = refusal(
        meshoptGlb(grid, MeshoptKind::exact, true,
                   {{R"("byteLength":588)", R"("byteLength":12000000000)"}, {R"("count":49)", R"("count":1000000000)"}}));
    EXPECT_THAT(huge, AllOf(HasSubstr("/count: 1000000000; allowed: at most "), HasSubstr("compressed bytes")));
    // A view of the plain buffer that is not compressed has nothing to read.
    EXPECT_THAT(changed(R"(EXT_meshopt_compression)", R"(EXT_other)"),
                HasSubstr("/bufferViews/0: bytes 0 to 588; allowed: at most byte 0"));
}

TEST(MeshoptGeometry, TruncatedOrDamagedBytesHarmNothing) {
    const WavyGrid grid(6);
    const std::string whole = meshoptGlb(grid, MeshoptKind::filtered, true);
    const size_t from = whole.find("BIN") + 4;
    uint32_t state = 3;
    for (int i = 0; i < 800; i++) {
        std::string bytes = whole;
        for (int k = 0; k < 1 + i % 3; k++) {
            state = state * 1664525u + 1013904223u;
            bytes[from + (state >> 8) % (bytes.size() - from)] = static_cast<char>(state >> 3);
        }
        try {
            openBytes(bytes);
        } catch (const InputError&) {}
    }
    const std::string key = R"("byteLength":)";
    const std::string json = meshoptGlb(grid, MeshoptKind::exact, true);
    const size_t at = json.find(key, json.find(R"({"buffer":0,)")) + key.size();
    const size_t length = std::stoul(json.substr(at));
    for (size_t cut = 1; cut < length; cut += 7)
        EXPECT_THAT(refusal(meshoptGlb(grid, MeshoptKind::exact, true,
                                       {{key + std::to_string(length), key + std::to_string(length - cut)}})),
                    HasSubstr("EXT_meshopt_compression"));
}

}  // namespace
}  // namespace heliograph::TEST_FILE
