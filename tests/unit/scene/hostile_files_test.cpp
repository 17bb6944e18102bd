// Files that mean harm: all are refused, or repaired with a warning that says what was wrong; none crashes or takes
// long.

#include "server/base/error.h"
#include "server/scene/load/scene_source.h"
#include "tests/unit/scene/scene_files.h"
#include "tests/support/places.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/resource.h>

#include <algorithm>
#include <ctime>
#include <iostream>

namespace heliograph::TEST_FILE {
namespace {

using namespace testing_files;

const fs::path INVALID = sharedScenes() / "invalid";
constexpr double MOST_SECONDS = 5.0;  // of processor time
constexpr long MOST_MEBIBYTES = 1024;

long peakMebibytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss / 1024;
}

/// What became of one file.
struct Verdict {
    bool accepted = false;
    std::vector<std::string> warnings;  // without those that any file gets
    double seconds = 0.0;               // of processor time, so that a busy machine changes nothing
};

Verdict judge(const std::string& file) {
    Verdict verdict;
    const std::clock_t begin = std::clock();
    try {
        const auto scene = openScene(file);
        verdict.accepted = true;
        for (const std::string& warning : scene->warnings) {
            if (warning.find("headlight") == std::string::npos && warning != "the scene has no triangles")
                verdict.warnings.push_back(warning);
        }
        for (const vec4& p : scene->positions) EXPECT_TRUE(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
        for (const uvec4& t : scene->triangles) EXPECT_LT(std::max({t.x, t.y, t.z}), scene->attributes.size());
    } catch (const InputError& error) {
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    }
    verdict.seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    return verdict;
}

/// Errors that the specification's validator found in the file.
std::vector<std::string> reportedErrors(const fs::path& file) {
    std::ifstream report(file.string() + ".report.json");
    std::vector<std::string> errors;
    if (!report) return errors;
    const nlohmann::json json = nlohmann::json::parse(report);
    for (const nlohmann::json& message : json["issues"]["messages"]) {
        if (message["severity"] == 0) errors.push_back(message["code"]);
    }
    return errors;
}

TEST(HostileFiles, AreRefusedOrRepairedWithAWarning) {
    if (!fs::exists(INVALID)) {
        std::cout << "the shared scenes are missing: " << INVALID << std::endl;
        GTEST_SKIP() << "no " << INVALID;
    }
    size_t accepted = 0, refused = 0, reports = 0;
    double slowest = 0.0;
    std::vector<fs::path> files;
    for (const auto& entry : fs::recursive_directory_iterator(INVALID)) {
        const std::string extension = entry.path().extension().string();
        if (entry.is_regular_file() && extension != ".json") files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
    ASSERT_GT(files.size(), 200u);
    for (const fs::path& file : files) {
        SCOPED_TRACE(file.string());
        const Verdict verdict = judge(file.string());
        (verdict.accepted ? accepted : refused)++;
        slowest = std::max(slowest, verdict.seconds);
        const std::vector<std::string> errors = reportedErrors(file);
        reports += errors.empty() ? 0 : 1;
        EXPECT_TRUE(!verdict.accepted || errors.empty() || !verdict.warnings.empty())
            << "accepted without a word although: " << ::testing::PrintToString(errors);
    }
    std::cout << files.size() << " files: " << accepted << " accepted, " << refused << " refused; " << reports
              << " have errors by the validator; slowest " << slowest << " s, peak " << peakMebibytes() << " MiB" << std::endl;
    EXPECT_GT(reports, 100u);
    EXPECT_LT(slowest, MOST_SECONDS);
    EXPECT_LT(peakMebibytes(), MOST_MEBIBYTES);
}

/// A box with indices, normals, texture coordinates, a material with an embedded image and a node transform.
std::string boxGlb() {
    std::string positions, normals, indices;
    for (int face = 0; face < 6; face++) {
        const int axis = face / 2;
        const float sign = face % 2 ? 1.0f : -1.0f;
        for (int corner = 0; corner < 4; corner++) {
            float p[3], n[3] = {0, 0, 0};
            p[axis] = sign * 0.5f;
            p[(axis + 1) % 3] = corner & 1 ? 0.5f : -0.5f;
            p[(axis + 2) % 3] = corner & 2 ? 0.5f : -0.5f;
            n[axis] = sign;
            positions += bytesOf({p[0], p[1], p[2]});
            normals += bytesOf({n[0], n[1], n[2]});
        }
        const uint16_t b = static_cast<uint16_t>(face * 4);
        indices += bytesOf<uint16_t>({b, uint16_t(b + 1), uint16_t(b + 2), uint16_t(b + 2), uint16_t(b + 1), uint16_t(b + 3)});
    }
    const std::string json =
        R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"children":[1],"matrix":[1,0,0,0,0,0,-1,0,0,1,0,0,0,0,0,1]},{"mesh":0}],)"
        R"("meshes":[{"primitives":[{"attributes":{"NORMAL":1,"POSITION":2},"indices":0,"mode":4,"material":0}]}],"accessors":[)"
        R"({"bufferView":0,"byteOffset":0,"componentType":5123,"count":36,"max":[23],"min":[0],"type":"SCALAR"},)"
        R"({"bufferView":1,"byteOffset":0,"componentType":5126,"count":24,"max":[1,1,1],"min":[-1,-1,-1],"type":"VEC3"},)"
        R"({"bufferView":1,"byteOffset":288,"componentType":5126,"count":24,"max":[0.5,0.5,0.5],"min":[-0.5,-0.5,-0.5],"type":"VEC3"}],)"
        R"("materials":[{"pbrMetallicRoughness":{"baseColorFactor":[0.8,0,0,1],"metallicFactor":0},"name":"Red"}],)"
        R"("bufferViews":[{"buffer":0,"byteOffset":576,"byteLength":72,"target":34963},{"buffer":0,"byteOffset":0,"byteLength":576,"byteStride":12,"target":34962}],)"
        R"("buffers":[{"byteLength":648}]})";
    return glb(json, normals + positions + indices);
}

TEST(HostileFiles, ByteMutationsOfABoxDoNoHarm) {
    const ScratchFolder folder;
    const std::string box = boxGlb();
    ASSERT_EQ(openScene(folder.write("box.glb", box))->triangleCount(), 12u);
    std::mt19937 random(20240229);
    size_t accepted = 0, refused = 0;
    double slowest = 0.0;
    constexpr int MUTATIONS = 1000;
    for (int i = 0; i < MUTATIONS; i++) {
        std::string mutant = box;
        const uint32_t kind = random() % 8;
        const size_t changes = 1 + random() % 6;
        for (size_t k = 0; k < changes; k++) {
            const size_t at = random() % mutant.size();
            if (kind < 4) mutant[at] = static_cast<char>(random());
            else if (kind < 6) mutant[at] = "0123456789-e.[]{}\",:"[random() % 20];  // keeps the JSON near valid
            else if (kind == 6) mutant.erase(at, 1 + random() % 8);
            else mutant.insert(at, 1 + random() % 4, "90[{\""[random() % 5]);
        }
        SCOPED_TRACE("mutation " + std::to_string(i));
        const Verdict verdict = judge(folder.write("mutant.glb", mutant));
        (verdict.accepted ? accepted : refused)++;
        slowest = std::max(slowest, verdict.seconds);
    }
    std::cout << MUTATIONS << " mutations: " << accepted << " accepted, " << refused << " refused; slowest " << slowest
              << " s, peak " << peakMebibytes() << " MiB" << std::endl;
    EXPECT_GT(accepted, 0u);
    EXPECT_GT(refused, 0u);
    EXPECT_LT(slowest, MOST_SECONDS);
    EXPECT_LT(peakMebibytes(), MOST_MEBIBYTES);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
