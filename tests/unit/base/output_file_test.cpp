#include "server/base/output_file.h"

#include "server/base/error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

namespace heliograph::TEST_FILE {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class OutputFileTest : public testing::Test {
protected:
    void SetUp() override {
        std::string test = testing::UnitTest::GetInstance()->current_test_info()->name();
        folder_ = fs::path(testing::TempDir()) / ("heliograph_output_" + test);
        fs::remove_all(folder_);
        fs::create_directories(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }

    static std::string content(const fs::path& file) {
        std::ifstream in(file, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    static void write(const OutputFile& file, const std::string& text) {
        file.write({reinterpret_cast<const uint8_t*>(text.data()), text.size()});
    }
    std::string refusal(const fs::path& path) {
        try {
            OutputFile("--out", path.string());
        } catch (const InputError& error) {
            return error.what();
        }
        return "nothing was refused";
    }

    fs::path folder_;
};

TEST_F(OutputFileTest, IsWrittenWholeAndReplacesTheOldOne) {
    OutputFile file("--out", (folder_ / "a.png").string());
    EXPECT_TRUE(fs::is_empty(folder_)) << "the check leaves nothing behind";
    write(file, "first");
    write(file, std::string("se\0cond", 7));
    EXPECT_EQ(content(folder_ / "a.png"), std::string("se\0cond", 7));
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1);
}

TEST_F(OutputFileTest, ExtensionIsTheLastOneInSmallLetters) {
    EXPECT_EQ(OutputFile("--out", (folder_ / "a.b.PNG").string()).extension(), "png");
    EXPECT_EQ(OutputFile("--out", (folder_ / "plain").string()).extension(), "");
}

TEST_F(OutputFileTest, WhatCannotBeWrittenIsRefusedBeforehand) {
    EXPECT_THAT(refusal(folder_ / "missing" / "a.png"), HasSubstr("its folder does not exist; allowed: a file in a folder"));
    EXPECT_THAT(refusal(folder_), HasSubstr("not the name of a file"));
    EXPECT_THAT(refusal(""), HasSubstr("not the name of a file"));
    std::ofstream(folder_ / "file") << "x";
    EXPECT_THAT(refusal(folder_ / "file" / "a.png"), HasSubstr("its folder does not exist"));
}

TEST_F(OutputFileTest, AFullDiskIsAFailureThatNamesTheFile) {
    if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
    OutputFile file("--out", "/dev/full");
    try {
        write(file, "something");
        FAIL() << "the loss went unnoticed";
    } catch (const std::runtime_error& error) {
        EXPECT_THAT(error.what(), HasSubstr("/dev/full: cannot be written: "));
    }
}

}  // namespace
}  // namespace heliograph::TEST_FILE
