#include "server/uploads/upload_writer.h"

#include "server/uploads/upload_pace.h"
#include "tests/unit/uploads/upload_stream.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <future>

namespace heliograph::TEST_FILE {
namespace {

using test::UploadFolder;
using test::uploadStream;
using testing::HasSubstr;
using testing::IsEmpty;

std::string model(size_t bytes) { return uploadStream({{"a.glb", std::string(bytes, 'g')}}, "a.glb"); }

/// A writer whose first news holds it until `goOn`; the news are counted.
struct Held {
    std::promise<void> goOn;
    std::shared_future<void> gone = goOn.get_future().share();
    std::atomic<int> news{0};
    UploadFolder folder;
    UploadStore store{folder.path, {}};
    UploadWriter writer{[this] {
        news++;
        news.notify_all();
        gone.wait();
    }};

    std::unique_ptr<UploadWriter::Line> line(const std::string& stream) { return writer.add(store.begin(stream.size())); }
    void untilNews(int count) {
        for (int now = news; now < count; now = news) news.wait(now);
    }
};

TEST(UploadWriter, ReadsNoMoreThanItHasRoomForAndSaysWhenItHasAgain) {
    Held held;
    const auto refused = held.line("x");
    refused->finish();
    held.untilNews(1);  // and there the disk hangs
    const std::string stream = model(3 * UploadWriter::MOST_WAITING);
    const auto line = held.line(stream);
    const size_t piece = UploadWriter::MOST_WAITING / 2;
    EXPECT_TRUE(line->push(std::string_view(stream).substr(0, piece)));
    EXPECT_FALSE(line->push(std::string_view(stream).substr(piece, piece)));
    EXPECT_FALSE(line->hasRoom());
    held.goOn.set_value();
    held.untilNews(2);
    EXPECT_TRUE(line->hasRoom());
    line->push(std::string_view(stream).substr(2 * piece));
    line->finish();
    while (!line->end()) held.untilNews(held.news + 1);
    EXPECT_EQ(line->end()->status, 201u) << line->end()->said;
    EXPECT_EQ(std::filesystem::file_size(*held.store.fileOf(line->end()->said)), 3 * UploadWriter::MOST_WAITING);
}

TEST(UploadWriter, ARefusalComesBeforeAllIsThere) {
    Held held;
    held.goOn.set_value();
    const std::string stream = uploadStream({{"../a.glb", std::string(1000, 'x')}}, "../a.glb");
    const auto line = held.line(stream);
    line->push(std::string_view(stream).substr(0, stream.size() - 500));
    held.untilNews(1);
    ASSERT_TRUE(line->end().has_value());
    EXPECT_EQ(line->end()->status, 422u);
    EXPECT_THAT(line->end()->said, HasSubstr("a path within the upload"));
    EXPECT_EQ(held.store.freeBytes(), held.store.limits().quota) << "its place is free at once";
    EXPECT_TRUE(line->push("more")) << "is dropped";
}

TEST(UploadWriter, WhatIsGivenUpLeavesNothing) {
    UploadFolder folder;
    UploadStore store(folder.path, {});
    {
        UploadWriter writer([] {});
        const std::string stream = model(200'000);
        for (int i = 0; i < 3; i++) {
            const auto line = writer.add(store.begin(stream.size()));
            line->push(std::string_view(stream).substr(0, 100'000));
        }
    }
    EXPECT_THAT(folder.content(), IsEmpty());
    EXPECT_EQ(store.freeBytes(), store.limits().quota);
}

TEST(UploadPace, ABurstBuysNoTimeAndWaitsOfTheServerDoNotCount) {
    UploadLimits limits;
    limits.rate = 1000;
    limits.window = 10.0;
    UploadPace pace;
    pace.restart(100.0, 0);
    EXPECT_FALSE(pace.tooSlow(109.9, 0, limits));
    EXPECT_FALSE(pace.tooSlow(110.0, 1'000'000, limits));
    EXPECT_FALSE(pace.tooSlow(119.0, 1'000'001, limits));
    EXPECT_TRUE(pace.tooSlow(120.0, 1'009'999, limits));
    EXPECT_FALSE(pace.tooSlow(120.0, 1'010'000, limits));
    pace.restart(500.0, 1'010'000);
    EXPECT_FALSE(pace.tooSlow(509.0, 1'010'000, limits));
    EXPECT_TRUE(pace.tooSlow(510.0, 1'010'000, limits));
    limits.rate = 0;
    EXPECT_FALSE(pace.tooSlow(900.0, 1'010'000, limits));
}

}  // namespace
}  // namespace heliograph::TEST_FILE
