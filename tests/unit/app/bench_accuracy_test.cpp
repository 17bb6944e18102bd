#include "server/app/program.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace heliograph::TEST_FILE {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

struct Outcome {
    int code = 0;
    std::string out, err;
};

Outcome accuracy(std::vector<std::string> more) {
    std::vector<std::string> arguments{"heliograph", "bench", "accuracy", "cornell", "--device", "embree", "--size", "40x24"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    std::vector<const char*> argv;
    for (const std::string& argument : arguments) argv.push_back(argument.c_str());
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    Outcome outcome;
    outcome.code = runProgram(static_cast<int>(argv.size()), argv.data());
    outcome.out = testing::internal::GetCapturedStdout();
    outcome.err = testing::internal::GetCapturedStderr();
    return outcome;
}

json measured(std::vector<std::string> more) {
    more.insert(more.end(), {"--json", "--budget", "1", "--repetitions", "1", "--reference", "32", "--set", "samples=2"});
    const Outcome outcome = accuracy(more);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return json::parse(outcome.out);
}

TEST(BenchAccuracy, TurnsEveryKnobThatCanMatterAndSaysWhyNotTheOthers) {
    const json result = measured({});
    EXPECT_EQ(result["scene"], "cornell");
    EXPECT_EQ(result["reference"]["samples"], 32);
    EXPECT_GT(result["reference"]["rmse"], 0.0);
    std::vector<std::string> turned, others;
    for (const json& row : result["rows"]) {
        turned.push_back(row["knob"]);
        EXPECT_GT(row["ms_median"], 0.0) << row["knob"];
        EXPECT_GE(row["repetitions"], 1) << row["knob"];
    }
    for (const json& knob : result["not_turned"]) {
        others.push_back(knob["knob"]);
        EXPECT_NE(knob["why"], "");
    }
    EXPECT_THAT(turned,
                testing::IsSupersetOf({"samples", "renderScale", "maxRefractions", "contributionThreshold", "jpegQuality"}));
    EXPECT_THAT(others, testing::IsSupersetOf({"fog", "aoSamples", "automaticScale"}));
    std::vector<double> times, errors;
    for (const json& row : result["pareto"]) {
        times.push_back(result["rows"][row.get<size_t>()]["ms_median"]);
        errors.push_back(result["rows"][row.get<size_t>()]["rmse"]);
    }
    EXPECT_FALSE(times.empty());
    EXPECT_TRUE(std::ranges::is_sorted(times));
    EXPECT_TRUE(std::ranges::is_sorted(errors, std::greater()));
}

TEST(BenchAccuracy, GoesOnFromItsFile) {
    const fs::path folder = fs::path(testing::TempDir()) / "heliograph_bench_accuracy";
    fs::remove_all(folder);
    fs::create_directories(folder);
    const std::string file = folder / "state.json";
    const json first = measured({"--resume", file});
    const json second = measured({"--resume", file});
    // What is there is not measured again: times are the very same.
    ASSERT_GE(second["rows"].size(), first["rows"].size());
    EXPECT_EQ(second["reference"], first["reference"]);
    for (size_t i = 0; i < first["rows"].size(); i++) {
        EXPECT_EQ(second["rows"][i]["knob"], first["rows"][i]["knob"]);
        EXPECT_EQ(second["rows"][i]["repetitions"], first["rows"][i]["repetitions"]);
        if (first["rows"][i]["knob"] != "jpegQuality") {
            EXPECT_EQ(second["rows"][i]["rmse"], first["rows"][i]["rmse"]);
        }
    }
    const Outcome other = accuracy({"--resume", file, "--set", "samples=3"});
    EXPECT_EQ(other.code, 2);
    EXPECT_THAT(other.err, HasSubstr("does not belong to this scene, view, size, device and settings"));
    std::ofstream(file) << "no JSON";
    EXPECT_EQ(accuracy({"--resume", file}).code, 2);
    fs::remove_all(folder);
}

TEST(BenchAccuracy, RefusesWhatIsOutOfRange) {
    const std::vector<std::pair<std::vector<std::string>, std::string>> bad = {
        {{"--budget", "0"}, "allowed: 1 to 604800 seconds"},
        {{"--budget", "nan"}, "allowed: 1 to 604800 seconds"},
        {{"--repetitions", "0"}, "allowed: 1 to 100"},
        {{"--reference", "31"}, "allowed: 0, or 32 to 1048576 samples"},
        {{"--view", "nowhere"}, "the scene has no 'nowhere'"},
        {{"--path", "--view", "front"}, "--path: together with --view"},
        {{"--csv", "/no/such/folder/x.csv"}, "/no/such/folder"},
    };
    for (const auto& [arguments, part] : bad) {
        const Outcome outcome = accuracy(arguments);
        EXPECT_EQ(outcome.code, 2) << part;
        EXPECT_THAT(outcome.err, HasSubstr(part));
        EXPECT_EQ(outcome.out, "");
    }
}

}  // namespace
}  // namespace heliograph::TEST_FILE
