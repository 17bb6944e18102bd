#include "server/images/image_module.h"

#include "server/base/error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace heliograph::TEST_FILE {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

std::string refusalOf(const std::vector<fs::path>& paths) {
    try {
        loadImageModule(paths);
        return "loaded";
    } catch (const InputError& error) {
        return error.what();
    }
}

const fs::path TESTS = fs::read_symlink("/proc/self/exe").parent_path();

TEST(ImageModule, IsFoundBesideTheProgram) {
    EXPECT_EQ(imageModulePaths().front(), TESTS / "heliograph-images.so");
    EXPECT_EQ(imageModulePaths().back(), TESTS.parent_path() / "lib/heliograph/heliograph-images.so");
    EXPECT_EQ(imageModule().version, IMAGE_MODULE_VERSION);
    EXPECT_EQ(&loadImageModule({"/nowhere/a.so", TESTS / "heliograph-images.so"}), &imageModule());
}

TEST(ImageModule, AVariableNamesItsFileAndNoOther) {
    ASSERT_EQ(setenv("HELIOGRAPH_IMAGE_MODULE", "/elsewhere/module.so", 1), 0);
    EXPECT_THAT(imageModulePaths(), ::testing::ElementsAre(fs::path("/elsewhere/module.so")));
    unsetenv("HELIOGRAPH_IMAGE_MODULE");
    EXPECT_EQ(imageModulePaths().size(), 2u);
}

TEST(ImageModule, AMissingOneIsNamedWithAllPlaces) {
    const std::string refusal = refusalOf({"/nowhere/a.so", "/nowhere/b.so"});
    EXPECT_THAT(refusal, HasSubstr("not found as /nowhere/a.so nor as /nowhere/b.so"));
    EXPECT_THAT(refusal, HasSubstr("HELIOGRAPH_IMAGE_MODULE"));
}

TEST(ImageModule, WhatIsNoModuleOrOfAnotherVersionIsRefused) {
    const std::string version = std::to_string(IMAGE_MODULE_VERSION + 1);
    EXPECT_THAT(refusalOf({TESTS / "other-images.so"}), HasSubstr("other-images.so has version " + version + "; allowed"));
    EXPECT_THAT(refusalOf({"/lib/x86_64-linux-gnu/libm.so.6"}), HasSubstr("has version 0"));
    const fs::path text = fs::path(::testing::TempDir()) / "no-module.so";
    std::ofstream(text) << "not a library";
    EXPECT_THAT(refusalOf({text}), HasSubstr("cannot be loaded: " + text.string()));
    fs::remove(text);
}

TEST(ImageModule, SaysWhyAPictureCannotBeRead) {
    const std::string bytes("\x76\x2f\x31\x01 no more", 12);
    ImageFile file{reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size(), "openexr"};
    ImageHeader header{};
    char message[IMAGE_MESSAGE_BYTES] = "";
    EXPECT_EQ(imageModule().readHeader(&file, &header, message), 0);
    EXPECT_STRNE(message, "");
    file.reader = "no such format";
    EXPECT_EQ(imageModule().readHeader(&file, &header, message), 0);
    EXPECT_THAT(message, HasSubstr("no such format"));
}

TEST(ImageModule, GivesBackWhatItWrote) {
    const std::vector<float> pixels{0.5f, 1e-6f, 70000.0f, 9, -1.0f, 0.0f, 3.25f, 9};
    std::vector<uint8_t> bytes;
    char message[IMAGE_MESSAGE_BYTES] = "";
    const auto take = [](void* to, const uint8_t* from, size_t size) {
        static_cast<std::vector<uint8_t>*>(to)->assign(from, from + size);
    };
    ASSERT_EQ(imageModule().writeExr(pixels.data(), 2, 1, take, &bytes, message), 1) << message;
    const ImageFile file{bytes.data(), bytes.size(), "openexr"};
    ImageHeader header{};
    ASSERT_EQ(imageModule().readHeader(&file, &header, message), 1) << message;
    EXPECT_EQ(header.width, 2);
    EXPECT_EQ(header.height, 1);
    EXPECT_EQ(header.channels, 3);
    EXPECT_EQ(header.flat, 1);
    std::vector<float> read(6);
    ASSERT_EQ(imageModule().readPixels(&file, &header, 3, read.data(), message), 1) << message;
    EXPECT_THAT(read, ::testing::ElementsAre(0.5f, 1e-6f, 70000.0f, -1.0f, 0.0f, 3.25f));
    header.height = 2;  // as if another file had been checked
    EXPECT_EQ(imageModule().readPixels(&file, &header, 3, read.data(), message), 0);
    EXPECT_STREQ(message, "its header is another one now");
}

}  // namespace
}  // namespace heliograph::TEST_FILE
