#include "server/uploads/upload_store.h"

#include "server/base/error.h"
#include "tests/unit/uploads/upload_stream.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

namespace heliograph::TEST_FILE {
namespace {

using namespace std::chrono_literals;
using test::UploadFolder;
using test::uploadStream;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

const test::Files MODEL = {
    {"car/car.gltf", "{\"a\":1}"}, {"car/empty.bin", ""}, {"car/maps/paint.png", std::string(5000, 'p')}};

std::string read(const std::filesystem::path& path) {
    std::ostringstream text;
    text << std::ifstream(path, std::ios::binary).rdbuf();
    return text.str();
}

/// What it is refused with; the upload has gone then.
std::string refusal(UploadStore& store, const std::string& stream, size_t bytes) {
    try {
        const auto upload = store.begin(bytes);
        upload->take(stream);
        upload->finish();
    } catch (const InputError& error) {
        return error.what();
    }
    return "taken";
}
std::string refusal(UploadStore& store, const std::string& stream) { return refusal(store, stream, stream.size()); }

std::string brought(UploadStore& store, const std::string& stream,
                    UploadStore::Clock::time_point now = UploadStore::Clock::now()) {
    const auto upload = store.begin(stream.size(), now);
    upload->take(stream);
    return upload->finish();
}

TEST(UploadStore, KeepsTheFilesWhateverThePiecesTheyComeIn) {
    const std::string stream = uploadStream(MODEL, "car/car.gltf");
    for (size_t piece : {size_t(1), size_t(3), size_t(4096), stream.size()}) {
        UploadFolder folder;
        UploadStore store(folder.path, {});
        const auto upload = store.begin(stream.size());
        for (size_t at = 0; at < stream.size(); at += piece) upload->take(std::string_view(stream).substr(at, piece));
        const std::string name = upload->finish();
        EXPECT_TRUE(isUploadName(name)) << name;
        EXPECT_TRUE(name.ends_with("/car.gltf")) << name;
        const std::optional<std::filesystem::path> file = store.fileOf(name);
        ASSERT_TRUE(file.has_value());
        EXPECT_EQ(read(*file), "{\"a\":1}");
        EXPECT_EQ(read(file->parent_path() / "maps/paint.png"), std::string(5000, 'p'));
        EXPECT_TRUE(std::filesystem::exists(file->parent_path() / "empty.bin"));
        EXPECT_EQ(store.freeBytes(), store.limits().quota - stream.size());
    }
}

TEST(UploadStore, WhatIsRefusedOrBrokenOffLeavesNothing) {
    UploadFolder folder;
    UploadStore store(folder.path, {});
    const std::string good = uploadStream(MODEL, "car/car.gltf");
    EXPECT_THAT(refusal(store, good.substr(0, good.size() - 1), good.size()), HasSubstr("all of them"));
    EXPECT_THAT(refusal(store, good.substr(0, good.size() - 1)), HasSubstr("as many as the Content-Length says"));
    EXPECT_THAT(refusal(store, good + "x", good.size()), HasSubstr("more bytes"));
    EXPECT_THAT(refusal(store, good + "x"), HasSubstr("as many as the Content-Length says"));
    EXPECT_THAT(refusal(store, uploadStream({{"../../out.glb", "x"}}, "../../out.glb")), HasSubstr("a path within the upload"));
    EXPECT_THAT(refusal(store, std::string("\xff\xff\xff\x7f", 4) + "{}"), HasSubstr("at most 512 KiB"));
    EXPECT_THAT(refusal(store, std::string(8, '\0')), HasSubstr("an empty list of files"));
    EXPECT_THAT(refusal(store, ""), HasSubstr("all of them"));
    { store.begin(good.size())->take(std::string_view(good).substr(0, good.size() - 10)); }  // the line breaks
    EXPECT_THAT(folder.content(), IsEmpty());
    EXPECT_FALSE(std::filesystem::exists(folder.path.parent_path() / "out.glb"));
    EXPECT_EQ(store.freeBytes(), store.limits().quota) << "refused ones hold nothing of the quota";
}

TEST(UploadStore, AFullQuotaRefusesUntilAnUploadIsOld) {
    UploadFolder folder;
    UploadLimits limits;
    limits.quota = 3000;
    UploadStore store(folder.path, limits);
    const auto start = UploadStore::Clock::now();
    const auto stream = [](const char* name) { return uploadStream({{name, std::string(1200, 'x')}}, name); };
    const std::string first = brought(store, stream("a.glb"), start), second = brought(store, stream("b.glb"), start);
    EXPECT_THAT(refusal(store, stream("c.glb")), HasSubstr("room for uploads is full"));
    EXPECT_THAT(folder.content(), SizeIs(4)) << "two folders, a file in each";
    EXPECT_TRUE(store.fileOf(second, start + 2h).has_value());
    EXPECT_TRUE(store.begin(1200, start + 2h + 1s) != nullptr);
    EXPECT_THROW(store.fileOf(first), InputError) << "the one that nobody has opened went";
    EXPECT_TRUE(store.fileOf(second, start + 2h).has_value());
}

TEST(UploadStore, PromisedBytesAreHeldOfTheQuotaAndFewComeAtOnce) {
    UploadFolder folder;
    UploadLimits limits;
    limits.quota = 1000;
    UploadStore store(folder.path, limits);
    const auto a = store.begin(600);
    EXPECT_THROW(store.begin(600), InputError);
    std::vector<std::unique_ptr<Upload>> others;
    for (size_t i = 1; i < UploadStore::MOST_AT_ONCE; i++) others.push_back(store.begin(10));
    EXPECT_THROW(store.begin(10), InputError);
    others.pop_back();
    EXPECT_NO_THROW(others.push_back(store.begin(10)));
    EXPECT_THROW(store.begin(limits.bytes + MANIFEST_BYTES + 1), InputError);
}

TEST(UploadStore, OneAddressHoldsAFewOfThePlaces) {
    UploadFolder folder;
    UploadStore store(folder.path, {});
    const auto now = UploadStore::Clock::now();
    auto a = store.begin(10, now, "192.0.2.1");
    const auto b = store.begin(10, now, "192.0.2.1");
    EXPECT_THROW(store.begin(10, now, "192.0.2.1"), InputError);
    const auto other = store.begin(10, now, "192.0.2.2");
    a.reset();
    EXPECT_NO_THROW(a = store.begin(10, now, "192.0.2.1"));
    const auto nobody = store.begin(10, now);
    a.reset();
    EXPECT_NO_THROW(store.begin(10, now)) << "without an address nothing is counted";
}

TEST(UploadStore, NamesOfOthersAreNoFiles) {
    UploadFolder folder;
    UploadStore store(folder.path, {});
    for (const char* name :
         {"courtyard", "upload/", "upload/../../etc/passwd", "upload/0123456789abcdef0123456789ABCDEF/a.glb"})
        EXPECT_EQ(store.fileOf(name), std::nullopt) << name;
    EXPECT_THROW(store.fileOf("upload/" + std::string(32, 'a') + "/a.glb"), InputError);
}

TEST(UploadStore, NothingStaysWhenTheServerEndsOrBegins) {
    UploadFolder folder;
    const std::filesystem::path left = folder.path / std::string(32, 'b'), foreign = folder.path / "my models";
    std::filesystem::create_directories(left / "x");
    std::filesystem::create_directories(foreign);
    std::string name;
    {
        UploadStore store(folder.path, {});
        EXPECT_FALSE(std::filesystem::exists(left));
        name = brought(store, uploadStream(MODEL, "car/car.gltf"));
        const std::string other = brought(store, uploadStream(MODEL, "car/car.gltf"));
        store.forget(name);
        EXPECT_THROW(store.fileOf(name), InputError);
        EXPECT_TRUE(store.fileOf(other).has_value());
    }
    EXPECT_EQ(folder.content(), std::vector<std::string>{"my models"}) << "what is no upload is let alone";
    EXPECT_THROW(UploadStore(folder.path / "nowhere", {}), InputError);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
