#include "server/app/program.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>

namespace heliograph::TEST_FILE {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

struct Outcome {
    int code = 0;
    std::string out;
    std::string err;
};

std::string contents(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

class RenderBatch : public testing::Test {
protected:
    RenderBatch() : folder_(fs::temp_directory_path() / ("heliograph-batch-" + std::to_string(getpid()))) {
        fs::create_directories(folder_);
    }
    ~RenderBatch() override { fs::remove_all(folder_); }

    std::string file(const std::string& name) const { return (folder_ / name).string(); }
    /// A tiny picture of a scene with the path Round.
    static Outcome render(std::vector<std::string> arguments) {
        std::vector<const char*> argv{"heliograph", "render", "effects/small-mirror", "--size", "32x18", "--samples", "1",
                                      "--device",   "embree"};
        for (const std::string& argument : arguments) argv.push_back(argument.c_str());
        testing::internal::CaptureStdout();
        testing::internal::CaptureStderr();
        Outcome outcome;
        outcome.code = runProgram(static_cast<int>(argv.size()), argv.data());
        outcome.out = testing::internal::GetCapturedStdout();
        outcome.err = testing::internal::GetCapturedStderr();
        return outcome;
    }
    static void expectRefused(const std::vector<std::string>& arguments, const std::string& words) {
        const Outcome outcome = render(arguments);
        EXPECT_EQ(outcome.code, 2) << words;
        EXPECT_THAT(outcome.err, HasSubstr(words));
    }

    fs::path folder_;
};

TEST_F(RenderBatch, AFrameIsTheSameWhicheverOthersAreMade) {
    ASSERT_EQ(render({"--path", "Round", "--frames", "4:6", "--out", file("a.%04d.png")}).code, 0);
    ASSERT_EQ(render({"--path", "Round", "--frames", "5", "--out", file("b.%d.png")}).code, 0);
    EXPECT_FALSE(contents(file("a.0005.png")).empty());
    EXPECT_EQ(contents(file("a.0005.png")), contents(file("b.5.png")));
    EXPECT_NE(contents(file("a.0004.png")), contents(file("a.0006.png")));
    EXPECT_FALSE(fs::exists(file("a.0003.png")) || fs::exists(file("a.0007.png")));
}

TEST_F(RenderBatch, ResumeLeavesWhatIsThere) {
    std::ofstream(file("a.0001.png")) << "mine";
    const Outcome outcome = render({"--path", "Round", "--frames", "0:2", "--out", file("a.%04d.png"), "--resume", "--json"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(contents(file("a.0001.png")), "mine");
    const auto json = nlohmann::json::parse(outcome.out);
    EXPECT_EQ(json["skipped"], 1);
    ASSERT_EQ(json["frames"].size(), 2u);
    EXPECT_EQ(json["frames"][1]["frame"], 2);
    EXPECT_EQ(json["frames"][1]["file"], file("a.0002.png"));
    EXPECT_THAT(outcome.err, HasSubstr("frame 2 (2 of 2), "));
    EXPECT_THAT(outcome.err, HasSubstr(" left: "));
    // Without --resume the file is replaced.
    ASSERT_EQ(render({"--path", "Round", "--frames", "1", "--out", file("a.%04d.png")}).code, 0);
    EXPECT_NE(contents(file("a.0001.png")), "mine");
}

TEST_F(RenderBatch, NothingIsBuiltWhereAllIsThere) {
    std::ofstream(file("a.0.png")) << "mine";
    const Outcome outcome = render({"--path", "Round", "--frames", "0", "--out", file("a.%d.png"), "--resume"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_THAT(outcome.out, HasSubstr("0 rendered in 0 s, 1 were there"));
}

TEST_F(RenderBatch, StandardOutputHasThePictureAlone) {
    ASSERT_EQ(render({"--out", file("a.png")}).code, 0);
    const Outcome outcome = render({"--out", "-", "--json"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.out, contents(file("a.png")));
    EXPECT_THAT(outcome.err, HasSubstr("\"scene\": \"effects/small-mirror\""));
}

TEST_F(RenderBatch, AFormatCanBeNamed) {
    ASSERT_EQ(render({"--out", file("picture"), "--format", "jpg"}).code, 0);
    EXPECT_EQ(contents(file("picture")).substr(0, 2), "\xff\xd8");
    EXPECT_EQ(render({"--out", "-", "--format", "jpg"}).out, contents(file("picture")));
}

TEST_F(RenderBatch, ACameraCanBeTyped) {
    ASSERT_EQ(render({"--out", file("a.png"), "--camera", "-1,2,8:0,1,0:50"}).code, 0);
    ASSERT_EQ(render({"--out", file("b.png"), "--camera", "-1,2,8:0,1,0:30"}).code, 0);
    EXPECT_NE(contents(file("a.png")), contents(file("b.png")));
}

TEST_F(RenderBatch, RefusesWhatDoesNotGoTogether) {
    expectRefused({"--out", file("a.png"), "--frames", "0:1"}, "--frames: without --path");
    expectRefused({"--out", file("a.png"), "--resume"}, "--resume: without --path");
    expectRefused({"--out", "-", "--path", "Round", "--resume"}, "--resume: with --out -");
    expectRefused({"--out", file("a.png"), "--path", "Round"}, "%d or %04d in the name");
    expectRefused({"--out", file("a%d.png"), "--path", "Square"}, "--path: the scene has no 'Square'; allowed: Round");
    expectRefused({"--out", file("a%d.png"), "--path", "Round", "--fps", "0"}, "--fps: 0.000000; allowed: 0.01 to 1000");
    expectRefused({"--out", file("a%d.png"), "--path", "Round", "--previous-camera", "Front"},
                  "--previous-camera: with --path");
    expectRefused({"--out", file("a"), "--format", "bmp"}, "--format: unknown format 'bmp'");
    expectRefused({"--out", file("a.png"), "--camera", "0,0,0:1,1"}, "--camera: '0,0,0:1,1'; allowed: x,y,z:tx,ty,tz");
}

}  // namespace
}  // namespace heliograph::TEST_FILE
