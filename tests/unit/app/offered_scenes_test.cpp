#include "server/app/offered_scenes.h"

#include "server/base/error.h"
#include "tests/unit/uploads/upload_stream.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

namespace heliograph::TEST_FILE {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Key;

constexpr const char* TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

void write(const fs::path& path, const std::string& text) {
    fs::create_directories(path.parent_path());
    std::ofstream(path) << text;
}

// Scene files by their path within the folder, those of its folders too; nothing hidden, linked, too deep or of another kind.
TEST(OfferedScenes, AFolderIsListedByPath) {
    const test::UploadFolder folder;
    for (const char* path : {"b.obj", "a.GLB", "deep/er/c.gltf", ".hidden.obj", ".git/d.obj", "notes.txt", "1/2/3/4/5/e.obj"})
        write(folder.path / path, TRIANGLE);
    fs::create_symlink(folder.path / "b.obj", folder.path / "link.obj");
    fs::create_directory_symlink(folder.path / "deep", folder.path / "again");
    EXPECT_THAT(sceneFilesIn(folder.path.string()), ElementsAre(Key("a.GLB"), Key("b.obj"), Key("deep/er/c.gltf")));
    EXPECT_THROW(sceneFilesIn((folder.path / "none").string()), InputError);
    EXPECT_THROW(sceneFilesIn((folder.path / "b.obj").string()), InputError);
}

TEST(OfferedScenes, FilesOfTheFolderAreOpenedByTheirNameAndNothingElseIs) {
    const test::UploadFolder folder;
    write(folder.path / "in/b.obj", TRIANGLE);
    write(folder.path / "courtyard", "");
    ServeOptions options;
    options.scene = "cornell";
    options.scenes = folder.path.string();
    const OfferedScenes scenes(options);
    EXPECT_EQ(scenes.list().front().name, "cornell");
    EXPECT_EQ(std::ranges::count(scenes.list(), "in/b.obj", &SceneRecipe::name), 1);
    const Progress nobody;
    EXPECT_EQ(scenes.open("in/b.obj", nobody)->triangleCount(), 1u);
    EXPECT_FALSE(scenes.opensToo("in/../in/b.obj"));
    EXPECT_FALSE(scenes.opensToo((folder.path / "in/b.obj").string()));
}

// A look that an uploaded file does not have is refused, and the file stays; a file that is no scene goes.
TEST(OfferedScenes, AnUploadGoesOnlyWhereItIsNoScene) {
    const test::UploadFolder folder;
    ServeOptions options;
    options.scene = "cornell";
    options.uploads = folder.path.string();
    const OfferedScenes scenes(options);
    const auto bring = [&](const std::string& text) {
        const std::string stream = test::uploadStream({{"a.obj", text}}, "a.obj");
        const auto upload = scenes.uploads()->begin(stream.size());
        upload->take(stream);
        return upload->finish();
    };
    const Progress nobody;
    const std::string good = bring(TRIANGLE), bad = bring("f 1 2 x\n");
    EXPECT_TRUE(scenes.opensToo(good));
    EXPECT_THROW(scenes.open(good + "#none", nobody), InputError);
    EXPECT_EQ(scenes.open(good, nobody)->triangleCount(), 1u);
    EXPECT_THROW(scenes.open(bad, nobody), InputError);
    try {
        scenes.open(bad, nobody);
        ADD_FAILURE() << "it is still there";
    } catch (const InputError& error) {
        EXPECT_THAT(error.what(), HasSubstr("not here"));
        EXPECT_THAT(error.what(), ::testing::Not(HasSubstr(folder.path.string())));
    }
}

}  // namespace
}  // namespace heliograph::TEST_FILE
