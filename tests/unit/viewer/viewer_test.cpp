#include "server/viewer/viewer.h"

#include "server/base/error.h"
#include "server/encode/video_encoder.h"
#include "server/images/picture_reader.h"

#include "tests/support/until.h"
#include <gtest/gtest.h>

#include <atomic>

namespace heliograph::TEST_FILE {
namespace {

using namespace std::chrono_literals;

/// Keeps the headers of what is sent; counts events.
struct Seat : ViewerSocket, ViewerListener {
    void sendText(std::string) override {}
    /// As the socket's thread tells it.
    void write(FrameKind kind) { viewer.written(kind, 0.0, 0.0); }
    std::optional<uint32_t> sendPicture(OutgoingPicture picture) override {
        blocked.wait(true);
        std::lock_guard lock(mutex);
        headers.push_back(readFrameHeader(std::span(picture.bytes).subspan(SOCKET_HEADROOM)));
        messages.emplace_back(picture.bytes.begin() + SOCKET_HEADROOM, picture.bytes.end());
        return std::exchange(replaced, std::nullopt);
    }
    void close(CloseCode, const std::string&) override {}
    void drained() override {
        std::lock_guard lock(mutex);
        drains++;
        changed.notify_all();
    }
    void encodingFailed(const std::string& what) override {
        std::lock_guard lock(mutex);
        failures.push_back(what);
    }
    std::vector<FrameHeader> sent() {
        std::lock_guard lock(mutex);
        return headers;
    }
    size_t failed() {
        std::lock_guard lock(mutex);
        return failures.size();
    }
    bool untilDrained(int count) {
        std::unique_lock lock(mutex);
        return changed.wait_for(lock, 30s, [&] { return drains >= count; });
    }

    std::atomic<bool> blocked{false};  // the socket
    std::mutex mutex;
    std::condition_variable changed;
    std::vector<FrameHeader> headers;
    std::vector<std::vector<uint8_t>> messages;
    std::vector<std::string> failures;
    std::optional<uint32_t> replaced;  // by the next frame
    int drains = 0;
    Metrics metrics;
    // Without ownership: the seat is the socket too.
    Viewer viewer{1, std::shared_ptr<ViewerSocket>(std::shared_ptr<ViewerSocket>(), this), metrics, *this};
};

/// A frame of a view, with something to see in it.
FinishedFrame frameOf(uvec2 size, uint32_t generation) {
    auto film = std::make_shared<Film>();
    film->reset(size, generation);
    for (const Tile& tile : film->tilesFor(0, 1, uvec2(64, 64))) {
        TileResult result;
        result.tile = tile;
        for (uint32_t i = 0; i < tile.size.x * tile.size.y; i++) {
            const float value = static_cast<float>(i * 2654435761u >> 24) / 255.0f;
            result.radianceSum.push_back(vec4(value, 0.5f * value, 1.0f - value, value * value));
        }
        EXPECT_TRUE(film->add(result));
    }
    FinishedFrame frame;
    frame.film = film;
    frame.size = size;
    frame.view.resolution = size;
    frame.view.inputId = 7;
    frame.generation = generation;
    frame.samples = 1;
    return frame;
}

TEST(Viewer, TwoLookAtOneViewEachAtTheirOwnQualityAndCredit) {
    Seat sharp, coarse;
    sharp.viewer.setQuality(95);
    coarse.viewer.setQuality(20);
    for (uint32_t generation : {1u, 2u}) {
        const FinishedFrame frame = frameOf(uvec2(256, 128), generation);
        for (Seat* seat : {&sharp, &coarse}) {
            ASSERT_EQ(seat->viewer.readiness(), Readiness::ready);
            seat->viewer.take(frame);
        }
        for (Seat* seat : {&sharp, &coarse}) ASSERT_TRUE(seat->untilDrained(static_cast<int>(generation)));
        const FrameHeader &a = sharp.headers.back(), &b = coarse.headers.back();
        EXPECT_EQ(a.generation, generation);
        EXPECT_EQ(b.generation, generation);
        EXPECT_EQ(a.inputId, 7u);
        EXPECT_EQ(a.quality, 95);
        EXPECT_EQ(b.quality, 20);
        EXPECT_GT(a.payloadBytes, 2 * b.payloadBytes);
    }
    sharp.viewer.acknowledge({1, std::nullopt});
    EXPECT_EQ(sharp.viewer.readiness(), Readiness::ready);
    EXPECT_EQ(coarse.viewer.readiness(), Readiness::noCredit) << "it has acknowledged nothing";
    EXPECT_EQ(sharp.drains, 3) << "an acknowledgement is room too";
}

TEST(Viewer, WhatIsNeverShownTakesNoCredit) {
    Seat seat;
    seat.viewer.take(frameOf(uvec2(70'000, 1), 1));  // wider than any JPEG
    ASSERT_TRUE(seat.untilDrained(1));
    ASSERT_EQ(seat.failures.size(), 1u);
    for (int drains : {2, 3}) {
        seat.replaced = drains == 3 ? std::optional(2u) : std::nullopt;
        seat.viewer.take(frameOf(uvec2(16, 16), 2));
        ASSERT_TRUE(seat.untilDrained(drains));
    }
    EXPECT_EQ(seat.viewer.readiness(), Readiness::ready) << "of three, one is on its way";
    EXPECT_FALSE(seat.viewer.closeIfStalled(Viewer::Clock::now() + 9s));
    EXPECT_TRUE(seat.viewer.closeIfStalled(Viewer::Clock::now() + 11s));
}

/// The last frame of a view at rest.
FinishedFrame lastFrameOf(uvec2 size) {
    FinishedFrame frame = frameOf(size, 1);
    frame.final = true;
    return frame;
}

/// Takes what a viewer has for it, acknowledging each, until nothing more comes. `frames`: how many were sent before.
void takeAll(Seat& seat, size_t frames) {
    for (bool more = true; more;) {
        const std::vector<FrameHeader> sent = seat.sent();
        seat.write(sent.back().kind);
        for (size_t i = frames; i < sent.size(); i++) seat.viewer.acknowledge({sent[i].frameId, std::nullopt});
        more = seat.viewer.refine();
        if (more) {
            ASSERT_TRUE(test::until([&] { return seat.sent().size() > sent.size(); }));
        }
    }
}

TEST(Viewer, AtRestThePartsMakeThePictureExact) {
    Seat seat;
    seat.viewer.setClient({true, true});
    const FinishedFrame last = lastFrameOf(uvec2(400, 300));
    seat.viewer.take(last);
    ASSERT_TRUE(test::until([&] { return seat.viewer.readiness() == Readiness::ready && !seat.sent().empty(); }));
    seat.viewer.refine();
    EXPECT_EQ(seat.messages.size(), 1u) << "a part would replace the frame that waits in the socket";
    takeAll(seat, 0);
    ASSERT_GE(seat.messages.size(), 3u);
    PictureMaker maker;
    FrameHeader header;
    header.codec = FrameCodec::png;
    const EncodedFrame whole = maker.make(last, header);
    std::vector<uint8_t> wanted(400 * 300 * 4), found(wanted.size());
    readPng(std::span(whole.picture.bytes).subspan(SOCKET_HEADROOM + FRAME_HEADER_BYTES), wanted);
    uint32_t row = 0;
    for (size_t i = 1; i < seat.messages.size(); i++) {
        const std::vector<uint8_t>& bytes = seat.messages[i];
        EXPECT_EQ(seat.headers[i].kind, FrameKind::part);
        EXPECT_EQ(seat.headers[i].size, uvec2(400, 300)) << "of the whole";
        EXPECT_EQ(seat.headers[i].inputId, 7u);
        const uint32_t first = bytes[66] | bytes[67] << 8, rows = bytes[70] | bytes[71] << 8;
        EXPECT_EQ(first, row);
        EXPECT_EQ(bytes[68] | bytes[69] << 8, 400);
        readPng(std::span(bytes).subspan(72), std::span(found).subspan(size_t(400) * 4 * row, size_t(400) * 4 * rows));
        row += rows;
    }
    EXPECT_EQ(row, 300u);
    EXPECT_EQ(found, wanted);
}

TEST(Viewer, ANewerPictureEndsThePartsOfTheLastOne) {
    Seat seat;
    seat.viewer.setClient({true, true});
    seat.viewer.take(lastFrameOf(uvec2(400, 300)));
    ASSERT_TRUE(test::until([&] { return seat.viewer.readiness() == Readiness::ready && !seat.sent().empty(); }));
    seat.write(FrameKind::frame);
    seat.viewer.refine();
    ASSERT_TRUE(test::until([&] { return seat.sent().size() == 2; }));
    for (uint32_t id : {1u, 2u}) seat.viewer.acknowledge({id, std::nullopt});
    seat.viewer.take(frameOf(uvec2(400, 300), 2));
    ASSERT_TRUE(test::until([&] { return seat.sent().size() == 3; }));
    takeAll(seat, 2);
    ASSERT_EQ(seat.headers.size(), 3u);
    EXPECT_EQ(seat.headers[1].kind, FrameKind::part);
    EXPECT_EQ(seat.headers[2].kind, FrameKind::frame);
}

TEST(Viewer, PartsAreForWhoAsksForThemWhereTheViewIsToBecomeExact) {
    for (const bool asks : {false, true}) {
        Seat seat;
        seat.viewer.setClient({true, asks});
        FinishedFrame last = lastFrameOf(uvec2(64, 64));
        last.view.settings.exactAtRest = !asks;
        seat.viewer.take(last);
        ASSERT_TRUE(test::until([&] { return seat.viewer.readiness() == Readiness::ready && !seat.sent().empty(); }));
        takeAll(seat, 0);
        EXPECT_EQ(seat.messages.size(), 1u) << asks;
    }
}

TEST(Viewer, WhoSeesNothingIsSentNothing) {
    Seat seat;
    EXPECT_EQ(seat.viewer.readiness(), Readiness::ready);
    seat.viewer.setClient({false, true});
    EXPECT_EQ(seat.viewer.readiness(), Readiness::stalled);
    EXPECT_FALSE(seat.viewer.visible());
    EXPECT_FALSE(seat.viewer.closeIfStalled(Viewer::Clock::now() + 1h));
    const int drains = seat.drains;
    seat.viewer.setClient({true, true});
    EXPECT_EQ(seat.viewer.readiness(), Readiness::ready);
    EXPECT_EQ(seat.drains, drains + 1) << "it may take the newest now";
}

TEST(Viewer, AsManyFramesAreUnderWayAsTheLineHolds) {
    Seat seat;
    seat.viewer.pinged(0.3);  // six frames of 50 ms, one more, and one for each four
    for (int frames = 1; frames <= 8; frames++) {
        ASSERT_EQ(seat.viewer.readiness(), Readiness::ready) << frames;
        seat.viewer.take(frameOf(uvec2(16, 16), 1));
        ASSERT_TRUE(seat.untilDrained(frames));
    }
    EXPECT_EQ(seat.viewer.readiness(), Readiness::noCredit);
    for (uint32_t id = 1; id <= 7; id++) seat.viewer.acknowledge({id, std::nullopt});
    EXPECT_EQ(seat.viewer.readiness(), Readiness::ready);
}

TEST(Viewer, PicturesThatQueueBecomeCoarserUnlessTheViewForbidsIt) {
    Seat seat;
    seat.viewer.pinged(0.0);
    FinishedFrame frame = frameOf(uvec2(64, 64), 1);
    frame.view.moving = true;
    uint32_t id = 0;
    auto queues = [&] {
        seat.viewer.take(frame);
        ASSERT_TRUE(seat.untilDrained(static_cast<int>(2 * id + 1)));
        std::this_thread::sleep_for(65ms);
        seat.viewer.acknowledge({++id, std::nullopt, 0.0});
    };
    for (int i = 0; i < 6; i++) queues();
    EXPECT_EQ(seat.headers.front().quality, 80);
    EXPECT_LT(seat.headers.back().quality, 80);
    EXPECT_EQ(seat.viewer.coarser(), 0u) << "first the quality";
    while (seat.viewer.coarser() == 0 && id < 60) queues();
    EXPECT_GT(seat.viewer.coarser(), 0u);
    const ViewerStats stats = seat.viewer.takeStats(1.0, {});
    EXPECT_GT(stats.line.lineDelay, 0.06);
    EXPECT_EQ(stats.line.viewerDelay, 0.0);
    EXPECT_EQ(stats.line.quality, qualityAt(stats.line.level, 80));
    frame.view.settings.adaptiveQuality = false;
    queues();
    EXPECT_EQ(seat.headers.back().quality, 80);
    EXPECT_EQ(seat.viewer.coarser(), 0u);
}

/// One after the other, as they are taken; each is written and acknowledged before the next.
struct Taker {
    Seat& seat;
    size_t count = seat.sent().size();
    FrameHeader take(FinishedFrame frame) {
        seat.viewer.take(std::move(frame));
        count++;
        EXPECT_TRUE(test::until([&] { return seat.sent().size() == count && seat.viewer.readiness() != Readiness::busy; }));
        return seat.sent().back();
    }
    FrameHeader shown(FinishedFrame frame, bool undecodable = false) {
        const FrameHeader header = take(std::move(frame));
        seat.write(FrameKind::frame);
        seat.viewer.acknowledge({header.frameId, std::nullopt, 0.0, undecodable});
        return header;
    }
};

/// Of a view that is to be a video.
FinishedFrame videoFrameOf(uvec2 size, uint32_t generation, CodecSetting codec = CodecSetting::vp9) {
    FinishedFrame frame = frameOf(size, generation);
    frame.view.moving = true;
    frame.view.settings.codec = static_cast<uint32_t>(codec);
    return frame;
}

TEST(Viewer, AVideoIsForWhoDecodesItWhileTheViewChanges) {
    Seat seat;
    Taker taker{seat};
    const uvec2 size(64, 48);
    EXPECT_EQ(taker.shown(videoFrameOf(size, 1)).codec, FrameCodec::jpeg) << "it has not said that it can";
    seat.viewer.setClient({true, false, true});
    const FrameHeader first = taker.shown(videoFrameOf(size, 2)), second = taker.shown(videoFrameOf(size, 3));
    EXPECT_EQ(first.codec, FrameCodec::vp9);
    EXPECT_EQ(first.flags, FRAME_MOVING | FRAME_KEY);
    EXPECT_EQ(first.quality, 80);
    EXPECT_EQ(second.codec, FrameCodec::vp9);
    EXPECT_EQ(second.flags, FRAME_MOVING) << "it builds on the one before";
    EXPECT_EQ(seat.viewer.takeStats(1.0, {}).line.codec, FrameCodec::vp9);
    FinishedFrame last = videoFrameOf(size, 4);
    last.view.moving = false;
    EXPECT_EQ(taker.shown(last).codec, FrameCodec::vp9) << "more samples come";
    last.final = true;
    EXPECT_EQ(taker.shown(last).codec, FrameCodec::jpeg);
    EXPECT_EQ(taker.shown(videoFrameOf(size, 5)).flags, FRAME_MOVING) << "the decoder has the last one of the video still";
    EXPECT_EQ(taker.shown(videoFrameOf(uvec2(32, 32), 6)).flags, FRAME_MOVING | FRAME_KEY) << "another size";
    FinishedFrame still = videoFrameOf(size, 7);
    still.view.settings.codec = static_cast<uint32_t>(CodecSetting::jpeg);
    EXPECT_EQ(taker.shown(still).codec, FrameCodec::jpeg);
    EXPECT_EQ(taker.shown(videoFrameOf(uvec2(32, 32), 8)).flags, FRAME_MOVING | FRAME_KEY) << "a new video";
}

TEST(Viewer, AVideoThatIsNotBuiltComesAsJpeg) {
    Seat seat;
    Taker taker{seat};
    seat.viewer.setClient({true, false, true, true});
    const uvec2 size(64, 48);
    const FrameHeader first = taker.shown(videoFrameOf(size, 1, CodecSetting::h264));
    if (!videoBuilt(VideoCodec::h264)) {
        EXPECT_EQ(first.codec, FrameCodec::jpeg);
        return;
    }
    EXPECT_EQ(first.codec, FrameCodec::h264);
    EXPECT_EQ(first.flags, FRAME_MOVING | FRAME_KEY);
    EXPECT_EQ(taker.shown(videoFrameOf(size, 2, CodecSetting::h264)).flags, FRAME_MOVING);
    EXPECT_EQ(seat.viewer.takeStats(1.0, {}).line.codec, FrameCodec::h264);
    const FrameHeader other = taker.shown(videoFrameOf(size, 3));
    EXPECT_EQ(other.codec, FrameCodec::vp9);
    EXPECT_EQ(other.flags, FRAME_MOVING | FRAME_KEY) << "another video begins";
    EXPECT_EQ(taker.shown(videoFrameOf(size, 4, CodecSetting::h264)).flags, FRAME_MOVING | FRAME_KEY);
    seat.viewer.setClient({true, false, true, false});
    EXPECT_EQ(taker.shown(videoFrameOf(size, 5, CodecSetting::h264)).codec, FrameCodec::jpeg);
}

TEST(Viewer, AVideoThatCannotBeDecodedBeginsAnewOnce) {
    Seat seat;
    seat.viewer.setClient({true, false, true});
    seat.viewer.pinged(0.3);  // several are on their way
    Taker taker{seat};
    std::vector<uint32_t> ids;
    for (uint32_t i = 1; i <= 4; i++) {
        ids.push_back(taker.take(videoFrameOf(uvec2(64, 48), i)).frameId);
        seat.write(FrameKind::frame);
    }
    seat.viewer.acknowledge({ids[0], std::nullopt, 0.0, true});
    EXPECT_EQ(taker.shown(videoFrameOf(uvec2(64, 48), 5)).flags, FRAME_MOVING | FRAME_KEY);
    for (size_t i : {1u, 2u, 3u}) seat.viewer.acknowledge({ids[i], std::nullopt, 0.0, true});
    EXPECT_EQ(taker.shown(videoFrameOf(uvec2(64, 48), 6)).flags, FRAME_MOVING) << "those before the key are told of already";
}

TEST(Viewer, NoPictureOfAVideoIsReplacedInTheSocket) {
    Seat seat;
    seat.viewer.setClient({true, false, true});
    seat.viewer.pinged(0.3);
    Taker taker{seat};
    taker.take(videoFrameOf(uvec2(64, 48), 1));
    EXPECT_EQ(seat.viewer.readiness(), Readiness::noCredit) << "it waits there; the next one would build on it";
    const int drains = seat.drains;
    seat.write(FrameKind::frame);
    EXPECT_EQ(seat.drains, drains + 1) << "there is room now";
    EXPECT_EQ(seat.viewer.readiness(), Readiness::ready);
    seat.viewer.take(videoFrameOf(uvec2(70'000, 1), 2));  // more than can be coded
    ASSERT_TRUE(test::until([&] { return seat.failed() == 1 && seat.viewer.readiness() == Readiness::ready; }));
    EXPECT_EQ(taker.take(videoFrameOf(uvec2(64, 48), 3)).flags, FRAME_MOVING | FRAME_KEY);
}

TEST(Viewer, ASlowLineMakesAVideoOfJpegAndLosesNoQualityAtFirst) {
    Seat seat;
    seat.viewer.setClient({true, false, true});
    seat.viewer.pinged(0.0);
    Taker taker{seat};
    FinishedFrame frame = frameOf(uvec2(64, 64), 1);
    frame.view.moving = true;
    FrameHeader header;
    for (int i = 0; i < 40 && header.codec == FrameCodec::jpeg; i++) {
        header = taker.take(frame);
        seat.write(FrameKind::frame);
        std::this_thread::sleep_for(65ms);
        seat.viewer.acknowledge({header.frameId, std::nullopt, 0.0});
    }
    EXPECT_EQ(header.codec, FrameCodec::vp9);
    EXPECT_EQ(header.quality, 80) << "what the ladder learnt was of JPEG";
    EXPECT_EQ(seat.viewer.coarser(), 0u);
}

TEST(Viewer, ASlowLineLowersTheQualityOfACodecThatWasAskedFor) {
    for (const CodecSetting codec : {CodecSetting::jpeg, CodecSetting::vp9}) {
        Seat seat;
        seat.viewer.setClient({true, false, true});
        seat.viewer.pinged(0.0);
        Taker taker{seat};
        FrameHeader header;
        for (uint32_t i = 1; i < 60 && header.quality != qualityAt(2, 80); i++) {
            header = taker.take(videoFrameOf(uvec2(64, 64), i, codec));
            seat.write(FrameKind::frame);
            std::this_thread::sleep_for(65ms);
            seat.viewer.acknowledge({header.frameId, std::nullopt, 0.0});
        }
        EXPECT_EQ(header.quality, qualityAt(2, 80)) << "step by step, as nothing else can be chosen";
    }
}

TEST(Viewer, WhatItsThreadIsAtCanBeNamed) {
    Seat seat;
    EXPECT_FALSE(seat.viewer.stage());
    seat.blocked = true;
    seat.viewer.take(frameOf(uvec2(16, 16), 1));
    std::optional<RunningStage> stage;
    EXPECT_TRUE(test::until([&] { return (stage = seat.viewer.stage()).has_value(); }));
    seat.blocked = false;
    seat.blocked.notify_all();
    ASSERT_TRUE(stage);
    EXPECT_EQ(stage->viewer, 1u);
    EXPECT_EQ(stage->name, "encode");
    ASSERT_TRUE(seat.untilDrained(1));
    EXPECT_TRUE(test::until([&] { return !seat.viewer.stage(); }));
}

TEST(Viewer, OnePictureAtATimeAndNoneThatWasGivenUp) {
    Seat seat;
    FinishedFrame frame = frameOf(uvec2(16, 16), 1);
    frame.picture = seat.viewer.orderPicture(PictureFormat::png);
    EXPECT_THROW(seat.viewer.orderPicture(PictureFormat::exr), InputError);
    EXPECT_TRUE(seat.viewer.dropPicture());
    EXPECT_FALSE(seat.viewer.dropPicture());
    const PictureOrder next = seat.viewer.orderPicture(PictureFormat::exr);
    seat.viewer.take(frame);  // the one that was given up comes late
    ASSERT_TRUE(seat.untilDrained(1));
    EXPECT_TRUE(seat.headers.empty());
    frame.picture = next;
    seat.viewer.take(frame);
    ASSERT_TRUE(seat.untilDrained(2));
    ASSERT_EQ(seat.headers.size(), 1u);
    EXPECT_EQ(seat.headers[0].codec, FrameCodec::exr);
    EXPECT_EQ(seat.viewer.readiness(), Readiness::ready) << "pictures need no credit";
    EXPECT_FALSE(seat.viewer.dropPicture()) << "it was sent";
}

}  // namespace
}  // namespace heliograph::TEST_FILE
