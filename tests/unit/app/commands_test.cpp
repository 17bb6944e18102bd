#include "server/app/inspect_command.h"
#include "server/app/program.h"
#include "server/app/render_command.h"
#include "server/base/error.h"
#include "tests/support/test_scenes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace heliograph::TEST_FILE {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;
using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;

struct Outcome {
    int code = 0;
    std::string out;
    std::string err;
};

Outcome run(const std::vector<std::string>& arguments) {
    std::vector<const char*> argv{"heliograph"};
    for (const std::string& argument : arguments) argv.push_back(argument.c_str());
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    Outcome outcome;
    outcome.code = runProgram(static_cast<int>(argv.size()), argv.data());
    outcome.out = testing::internal::GetCapturedStdout();
    outcome.err = testing::internal::GetCapturedStderr();
    return outcome;
}

/// Refused with exit code 2 and one line on stderr that has all the parts.
void expectRefused(const std::vector<std::string>& arguments, const std::vector<std::string>& parts) {
    Outcome outcome = run(arguments);
    SCOPED_TRACE(testing::PrintToString(arguments));
    EXPECT_EQ(outcome.code, 2);
    EXPECT_EQ(outcome.out, "");
    EXPECT_THAT(outcome.err, StartsWith("heliograph: "));
    EXPECT_THAT(outcome.err, EndsWith("\n"));
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1);
    for (const std::string& part : parts) EXPECT_THAT(outcome.err, HasSubstr(part));
}

std::vector<std::string> keys(const ordered_json& json) {
    std::vector<std::string> names;
    for (const auto& [name, value] : json.items()) names.push_back(name);
    return names;
}

class CommandsTest : public testing::Test {
protected:
    void SetUp() override {
        std::string test = testing::UnitTest::GetInstance()->current_test_info()->name();
        folder_ = fs::path(testing::TempDir()) / ("heliograph_commands_" + test);
        fs::remove_all(folder_);
        fs::create_directories(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }
    std::string file(const std::string& name) const { return (folder_ / name).string(); }
    static std::string content(const std::string& path) {
        std::ifstream in(path, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    /// Renders the cornell box, small, with further arguments; returns the file's bytes.
    std::string rendered(const std::string& name, const std::vector<std::string>& more) {
        std::vector<std::string> arguments{"render", "cornell", "--out", file(name), "--size", "50x34", "--samples", "2"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        Outcome outcome = run(arguments);
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        return content(file(name));
    }

    fs::path folder_;
};

TEST_F(CommandsTest, HelpIsNoError) {
    for (const std::vector<std::string>& arguments : {std::vector<std::string>{"--help"},
                                                      {"render", "--help"},
                                                      {"inspect", "--help"},
                                                      {"bench", "--help"},
                                                      {"bench", "frames", "--help"},
                                                      {"bench", "devices", "--help"},
                                                      {"bench", "schedule", "--help"},
                                                      {"bench", "effects", "--help"},
                                                      {"serve", "--help"}}) {
        Outcome outcome = run(arguments);
        EXPECT_EQ(outcome.code, 0);
        EXPECT_THAT(outcome.out, HasSubstr("xample")) << arguments.front();
        EXPECT_EQ(outcome.err, "");
    }
    EXPECT_THAT(run({"render", "--help"}).out, HasSubstr("maxReflections (1; 0 to 31 bounces)"));
    EXPECT_THAT(run({"--version"}).out, StartsWith("heliograph "));
}

TEST_F(CommandsTest, BadArgumentsAreOneLineAndExitCodeTwo) {
    expectRefused({}, {"command line: ", "; allowed: see heliograph --help"});
    expectRefused({"dance"}, {"command line: ", "dance"});
    expectRefused({"render"}, {"command line: ", "; allowed: see heliograph render --help"});
    expectRefused({"render", "cornell", "--out", file("a.png"), "--colour"}, {"command line: ", "--colour"});
    expectRefused({"render", "cornell", "--out", file("a.png"), "--samples", "many"}, {"command line: ", "--samples"});
    expectRefused({"bench", "frames"}, {"command line: ", "see heliograph bench frames --help"});
}

TEST_F(CommandsTest, BadValuesAreRefusedBeforeAnyWork) {
    auto render = [&](const std::vector<std::string>& more, const std::vector<std::string>& parts) {
        std::vector<std::string> arguments{"render", "cornell"};
        bool named = std::find(more.begin(), more.end(), "--out") != more.end();
        if (!named) arguments.insert(arguments.end(), {"--out", file("a.png")});
        arguments.insert(arguments.end(), more.begin(), more.end());
        expectRefused(arguments, parts);
    };
    render({"--size", "1280"}, {"--size: '1280'; allowed: WIDTHxHEIGHT"});
    render({"--size", "0x10"}, {"--size: '0x10'"});
    render({"--size", "8x8x8"}, {"--size: '8x8x8'"});
    render({"--size", "-5x5"}, {"--size: '-5x5'"});
    render({"--size", "99999999999x5"}, {"--size: '99999999999x5'"});
    render({"--size", "100000x100000"}, {"at most 33177600 pixels"});
    render({"--samples", "0"}, {"setting samples: 0; allowed: a whole number from 1 to 65536"});
    render({"--samples", "-1"}, {"setting samples: -1"});
    render({"--set", "glitter=1"}, {"setting: unknown name \"glitter\""});
    render({"--set", "maxReflections=99"}, {"setting maxReflections: 99"});
    render({"--device", "abacus"}, {"setting device: \"abacus\"; allowed: one of auto embree vulkan"});
    render({"--out", file("a.bmp")}, {"a.bmp: unknown format 'bmp'; allowed: a name that ends in .png, .exr or .jpg"});
    render({"--out", file("none/a.png")}, {"its folder does not exist"});
    EXPECT_TRUE(fs::is_empty(folder_));
    expectRefused({"bench", "frames", "cornell", "--frames", "0"}, {"--frames: 0; allowed: 1 to 100000"});
    expectRefused({"bench", "devices", "cornell", "--repetitions", "-2"}, {"--repetitions: -2"});
    expectRefused({"bench", "frames", "cornell", "--csv", file("none/a.csv")}, {"--csv", "its folder does not exist"});
}

TEST_F(CommandsTest, UnknownScenesAndCamerasAreNamed) {
    expectRefused({"inspect", "atlantis"}, {"atlantis"});
    expectRefused({"inspect", file("missing.glb")}, {"missing.glb"});
    expectRefused({"render", "cornell", "--out", file("a.png"), "--camera", "backstage"},
                  {"--camera: the scene has no 'backstage'; allowed: "});
    expectRefused({"render", "cornell", "--out", file("a.png"), "--previous-camera", "backstage"},
                  {"--previous-camera: the scene has no 'backstage'; allowed: Front, "});
    EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(CommandsTest, RenderTellsWhatItDid) {
    Outcome outcome = run({"render", "cornell", "--out", file("a.png"), "--size", "50x34", "--samples", "2", "--json"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    ordered_json json = ordered_json::parse(outcome.out);
    EXPECT_EQ(keys(json), (std::vector<std::string>{"scene", "device", "width", "height", "samples", "exposure", "effects",
                                                    "ms", "rays", "tiles", "nonfinite_samples"}));
    EXPECT_EQ(keys(json["ms"]), (std::vector<std::string>{"load", "build", "render"}));
    EXPECT_EQ(json["scene"], "cornell");
    EXPECT_EQ(json["width"], 50);
    EXPECT_EQ(json["height"], 34);
    EXPECT_EQ(json["samples"], 2);
    EXPECT_EQ(json["rays"]["primary"], 50 * 34 * 2);
    EXPECT_EQ(json["tiles"]["embree"], 2 * 2 * 2);
    EXPECT_EQ(json["nonfinite_samples"], 0);
    EXPECT_THAT(content(file("a.png")), StartsWith("\x89PNG"));
}

TEST_F(CommandsTest, RenderWritesTheSameFileForAnyThreadsAndTiles) {
    const std::string expected = rendered("a.png", {"--set", "embreeThreads=1"});
    EXPECT_GT(expected.size(), 500u);
    EXPECT_TRUE(rendered("b.png", {"--set", "embreeThreads=2"}) == expected);
    EXPECT_TRUE(rendered("c.png", {"--set", "tileWidth=8", "--set", "tileHeight=8"}) == expected);
    EXPECT_TRUE(rendered("d.png", {"--set", "tileWidth=64", "--set", "tileHeight=64"}) == expected);
    EXPECT_TRUE(rendered("e.png", {"--set", "tiles=off"}) == expected);
    EXPECT_FALSE(rendered("f.png", {"--set", "exposure=1"}) == expected);
}

TEST_F(CommandsTest, RenderWritesTheFormatOfTheName) {
    EXPECT_THAT(rendered("a.jpg", {}), StartsWith("\xff\xd8\xff"));
    EXPECT_THAT(rendered("a.exr", {}), StartsWith("\x76\x2f\x31\x01"));
    EXPECT_TRUE(rendered("b.exr", {"--set", "exposure=3"}) == content(file("a.exr"))) << "the film knows no exposure";
    EXPECT_NE(content(file("a.exr")).find("1970:01:01"), std::string::npos) << "a clock in the file";
}

TEST_F(CommandsTest, RenderScaleMakesThePictureSmaller) {
    Outcome outcome = run({"render", "cornell", "--out", file("a.png"), "--size", "64x32", "--samples", "1", "--json", "--set",
                           "renderScale=0.5"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(ordered_json::parse(outcome.out)["width"], 32);
}

TEST_F(CommandsTest, BenchesAnswerInJson) {
    Outcome frames = run({"bench", "frames", "cornell", "--size", "32x24", "--frames", "3", "--json", "--csv", file("a.csv")});
    ASSERT_EQ(frames.code, 0) << frames.err;
    ordered_json json = ordered_json::parse(frames.out);
    EXPECT_EQ(keys(json), (std::vector<std::string>{"scene", "device", "width", "height", "frames", "ms_mean", "ms_median",
                                                    "ms_p95", "fps_mean", "fps_min", "mrays_per_s", "rays"}));
    EXPECT_EQ(json["frames"], 3);
    EXPECT_EQ(json["rays"]["primary"], 3 * 32 * 24);
    std::string csv = content(file("a.csv"));
    EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 4);
    Outcome devices = run({"bench", "devices", "cornell", "--size", "32x24", "--repetitions", "2", "--json"});
    ASSERT_EQ(devices.code, 0) << devices.err;
    json = ordered_json::parse(devices.out);
    EXPECT_GT(json["frame"]["embree"]["ms"].get<double>(), 0.0);
    EXPECT_EQ(json["frame"]["embree"]["rays"]["primary"], 32 * 24);
    EXPECT_GT(json["raw"]["embree"]["primary"].get<double>(), 0.0);
    EXPECT_GT(json["frame"]["embree"]["overhead_ratio"].get<double>(), 0.0);
    Outcome schedule = run({"bench", "schedule", "--scene", "cornell", "--size", "64x48", "--frames", "2", "--json"});
    ASSERT_EQ(schedule.code, 0) << schedule.err;
    json = ordered_json::parse(schedule.out);
    EXPECT_EQ(keys(json), (std::vector<std::string>{"scenarios", "decision_us"}));
    const ordered_json& scenario = json["scenarios"][0];
    EXPECT_EQ(keys(scenario), (std::vector<std::string>{"name", "devices", "bound_ms", "policies"}));
    EXPECT_EQ(keys(scenario["policies"]),
              (std::vector<std::string>{"ours", "equal_split", "proportional_split", "rayengine", "shared_counter"}));
    for (const auto& [name, policy] : scenario["policies"].items()) EXPECT_GE(policy["ratio"].get<double>(), 1.0) << name;
}

TEST_F(CommandsTest, BenchEffectsHasARowPerEffectAndEqualRaysWhereNoneIsCalledFor) {
    Outcome outcome =
        run({"bench", "effects", "cornell", "--size", "48x32", "--repetitions", "1", "--device", "embree", "--json"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    ordered_json json = ordered_json::parse(outcome.out);
    EXPECT_EQ(json["time"], "core");
    EXPECT_EQ(json["width"], 48);
    uint64_t least = 0;
    for (const ordered_json& row : json["rows"]) {
        const uint64_t on = row["rays_on"].get<uint64_t>(), off = row["rays_off"].get<uint64_t>();
        if (!row["called_for"].get<bool>() && row["because"] != "the viewer chooses") {
            EXPECT_EQ(row["by_kind"]["on"], row["by_kind"]["off"]) << row["effect"];
        }
        if (row["effect"] == "ambientOcclusion") {
            EXPECT_EQ(row["by_kind"]["off"]["ambient_occlusion"], 0);
            EXPECT_GT(row["by_kind"]["on"]["ambient_occlusion"], 0);
        }
        if (row["effect"] == "reflections" || row["effect"] == "refractions") {
            EXPECT_GT(on, off) << row["effect"];
        }
        least = std::max(least, off);
    }
    EXPECT_GT(least, 48u * 32u);
    EXPECT_THAT(run({"bench", "effects", "cornell", "--size", "48x32", "--repetitions", "1"}).out,
                HasSubstr("not called for: no environment image"));
}

TEST_F(CommandsTest, BenchEffectsChecksThatWhatIsAllowedAndNotNeededChangesNothing) {
    Outcome outcome = run({"bench", "effects", "cornell", "--check", "--size", "48x32", "--repetitions", "1", "--device",
                           "embree", "--limit", "100", "--json"});
    ASSERT_EQ(outcome.code, 0) << outcome.out << outcome.err;
    ordered_json json = ordered_json::parse(outcome.out);
    EXPECT_EQ(json["identical"], true);
    EXPECT_THAT(json["switched_off"].get<std::vector<std::string>>(), testing::Contains("environment"));
    EXPECT_EQ(json["by_kind"]["allowed"], json["by_kind"]["called_for"]);
}

TEST_F(CommandsTest, BenchEffectsRefusesBadArguments) {
    expectRefused({"bench", "effects", "cornell", "--repetitions", "0"}, {"--repetitions: 0; allowed: 1 to 100000"});
    expectRefused({"bench", "effects", "cornell", "--samples", "0"}, {"--samples: 0; allowed: 1 to 4096"});
    expectRefused({"bench", "effects", "cornell", "--limit", "0"}, {"--limit: ", "allowed: percent"});
    expectRefused({"bench", "effects", "cornell", "--check", "--against", "x"}, {"--against", "one of them"});
    Outcome outcome = run({"bench", "effects", "cornell", "--against", file("none")});
    EXPECT_EQ(outcome.code, 1);
    EXPECT_THAT(outcome.err, HasSubstr("heliograph: "));
}

TEST_F(CommandsTest, InspectAnswersInJsonAndForPeople) {
    Outcome outcome = run({"inspect", "cornell", "--json"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(keys(ordered_json::parse(outcome.out)),
              (std::vector<std::string>{"scene", "triangles", "shapes", "instances", "materials", "lights", "textures", "bytes",
                                        "variants", "variant", "extensions", "effects", "warnings", "ms"}));
    EXPECT_THAT(run({"inspect", "cornell"}).out, HasSubstr("calls for\n  shadows"));
}

TEST(Inspection, CountsWhatIsUsed) {
    SceneBuilder builder = test::litBuilder();
    builder.addMaterial(SceneBuilder::defaultMaterial(), "unused");
    uint32_t red = builder.addMaterial(SceneBuilder::defaultMaterial(), "red");
    uint32_t mesh = builder.addMesh(test::square(red));
    for (int i = 0; i < 3; i++) {
        mat4 toWorld(1.0f);
        toWorld[3] = vec4(static_cast<float>(3 * i), 0.0f, 0.0f, 1.0f);
        builder.addInstance(mesh, toWorld);
    }
    builder.warn("something was left out");
    auto scene = builder.finish();
    ordered_json json = inspection(*scene, "mine", 12.5);
    EXPECT_EQ(json["scene"], "mine");
    EXPECT_EQ(json["triangles"], 6);
    EXPECT_EQ(json["instances"], 3);
    EXPECT_EQ(json["materials"], 1);
    EXPECT_EQ(json["lights"], 1);
    EXPECT_EQ(json["textures"], 0);
    EXPECT_EQ(json["bytes"], scene->bytes());
    EXPECT_EQ(json["effects"][0]["name"], "shadows");
    EXPECT_EQ(json["effects"][0]["called_for"], true);
    EXPECT_EQ(json["effects"][0]["setting"], "shadows");
    EXPECT_EQ(json["effects"][0]["simulated"], true);
    EXPECT_EQ(json["warnings"], ordered_json(scene->warnings));
    EXPECT_EQ(json["ms"]["load"], 12.5);
    EXPECT_GE(json["ms"]["effects"].get<double>(), 0.0);
}

TEST_F(CommandsTest, ServePrintsItsConfiguration) {
    const Outcome printed =
        run({"serve", "cornell", "--print-config", "--max-viewers", "7", "--insecure", "--set", "samples=3"});
    EXPECT_EQ(printed.code, 0);
    EXPECT_THAT(printed.out, HasSubstr("scene = \"cornell\"  # SCENE\n"));
    EXPECT_THAT(printed.out, HasSubstr("max-viewers = 7  # --max-viewers\n"));
    EXPECT_THAT(printed.out, HasSubstr("insecure = true  # --insecure\n"));
    EXPECT_THAT(printed.out, HasSubstr("samples = \"3\"  # --set\n"));
    // An option with a value takes one word, so that SCENE may come after it.
    const Outcome behind = run({"serve", "--print-config", "--max-viewers", "7", "--listen", "127.0.0.1:0", "--set",
                                "samples=3", "--set", "maxReflections=1", "cornell"});
    EXPECT_EQ(behind.code, 0) << behind.err;
    EXPECT_THAT(behind.out, HasSubstr("scene = \"cornell\"  # SCENE\n"));
    EXPECT_THAT(behind.out, HasSubstr("maxReflections = \"1\"  # --set\n"));
    EXPECT_THAT(run({"serve", "--print-config", "--insecure=false"}).out, HasSubstr("insecure = false"));
    expectRefused({"serve", "--max-viewers", "0"}, {"--max-viewers: \"0\"; allowed: a whole number from 1 to 1000"});
    expectRefused({"serve", "--config", "/"}, {"/: is a folder"});
    expectRefused({"serve", "--log", "loud"}, {"--log-level: ", "loud", "trace, debug, info"});
}

TEST_F(CommandsTest, DoctorSaysWhatWouldFail) {
    const std::string client = std::filesystem::temp_directory_path() / ("heliograph-doctor-" + std::to_string(getpid()));
    const std::vector<std::string> good = {"doctor",   "cornell", "--listen",  "127.0.0.1:0",
                                           "--client", client,    "--devices", "embree"};
    Outcome without = run(good);
    EXPECT_EQ(without.code, 1) << "no page there";
    EXPECT_THAT(without.out, HasSubstr("\n! page "));
    fs::create_directories(client);
    std::ofstream(client + "/index.html") << "hello";
    Outcome with = run(good);
    EXPECT_EQ(with.code, 0) << with.out;
    EXPECT_THAT(with.out, HasSubstr("shading built for x86-64-v"));
    std::vector<std::string> bad = good;
    bad.insert(bad.end(), {"--json", "--max-viewers", "0"});
    Outcome refused = run(bad);
    EXPECT_EQ(refused.code, 1);
    const auto json = ordered_json::parse(refused.out);
    EXPECT_EQ(json["serves"], false);
    EXPECT_EQ(json["findings"][0]["about"], "configuration");
    EXPECT_EQ(json["findings"][0]["state"], "bad");
    fs::remove_all(client);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
