#include "server/net/connection.h"

#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

struct Peer : ViewerPeer {
    void receive(std::string_view text) override { texts.emplace_back(text); }
    void written(FrameKind kind, double wait, double write) override {
        kinds.push_back(kind);
        waits.push_back(wait);
        writes.push_back(write);
    }
    std::vector<std::string> texts;
    std::vector<FrameKind> kinds;
    std::vector<double> waits, writes;
};

struct Stage {
    int wakes = 0;
    Connection connection{[this] { wakes++; }};
    std::shared_ptr<Peer> peer = std::make_shared<Peer>();
    std::chrono::steady_clock::time_point now = std::chrono::steady_clock::now();
    Stage() { connection.peer = peer; }

    std::string nextText() {
        auto piece = connection.nextPiece(now);
        if (!piece || !piece->text) return "(none)";
        return std::string(piece->bytes.begin(), piece->bytes.end());
    }
};

OutgoingPicture picture(FrameKind kind, uint32_t id, size_t payload, std::chrono::steady_clock::time_point encoded = {}) {
    OutgoingPicture p;
    p.kind = kind;
    p.frameId = id;
    p.encoded = encoded;
    p.bytes.assign(SOCKET_HEADROOM + FRAME_HEADER_BYTES + payload, 0);
    FrameHeader header;
    header.kind = kind;
    header.frameId = id;
    header.payloadBytes = static_cast<uint32_t>(payload);
    writeFrameHeader(header, std::span(p.bytes).subspan<SOCKET_HEADROOM, FRAME_HEADER_BYTES>());
    for (size_t i = 0; i < payload; i++) p.bytes[SOCKET_HEADROOM + FRAME_HEADER_BYTES + i] = static_cast<uint8_t>(i * 7);
    return p;
}

TEST(Connection, TextGoesBeforeFramesAndFramesBeforePictures) {
    Stage s;
    s.connection.sendPicture(picture(FrameKind::picture, 1, 10));
    s.connection.sendPicture(picture(FrameKind::frame, 2, 10));
    s.connection.sendText("a");
    s.connection.sendText("b");
    EXPECT_EQ(s.wakes, 4);
    EXPECT_EQ(s.nextText(), "a");
    EXPECT_EQ(s.nextText(), "b");
    EXPECT_EQ(readFrameHeader(s.connection.nextPiece(s.now)->bytes).frameId, 2u);
    s.connection.pieceWritten(0.5);
    EXPECT_EQ(readFrameHeader(s.connection.nextPiece(s.now)->bytes).frameId, 1u);
    EXPECT_TRUE(s.connection.hasOutput());
    s.connection.pieceWritten(0.25);
    EXPECT_FALSE(s.connection.hasOutput());
    EXPECT_FALSE(s.connection.nextPiece(s.now));
    EXPECT_EQ(s.peer->kinds, (std::vector{FrameKind::frame, FrameKind::picture}));
    EXPECT_EQ(s.peer->writes, (std::vector{0.5, 0.25}));
}

TEST(Connection, ANewerFrameReplacesOneThatHasNotBegun) {
    Stage s;
    EXPECT_FALSE(s.connection.sendPicture(picture(FrameKind::frame, 1, 10)));
    EXPECT_EQ(s.connection.sendPicture(picture(FrameKind::frame, 2, 10)), 1u);
    EXPECT_EQ(readFrameHeader(s.connection.nextPiece(s.now)->bytes).frameId, 2u);
    EXPECT_FALSE(s.connection.sendPicture(picture(FrameKind::frame, 3, 10)));  // 2 is on its way
}

TEST(Connection, LargePicturesGoInPiecesThatNothingInterrupts) {
    Stage s;
    OutgoingPicture big = picture(FrameKind::picture, 9, 600'000);
    const std::vector<uint8_t> original(big.bytes.begin() + SOCKET_HEADROOM, big.bytes.end());
    s.connection.sendPicture(std::move(big));
    std::vector<uint8_t> received;
    int pieces = 0;
    for (bool last = false; !last; pieces++) {
        auto piece = s.connection.nextPiece(s.now);
        ASSERT_TRUE(piece);
        EXPECT_FALSE(piece->text);
        EXPECT_EQ(piece->first, pieces == 0);
        received.insert(received.end(), piece->bytes.begin(), piece->bytes.end());
        // The transport writes its own header before the bytes.
        std::fill(piece->bytes.data() - SOCKET_HEADROOM, piece->bytes.data(), 0xee);
        last = piece->last;
        s.connection.sendText("meanwhile");
        EXPECT_TRUE(s.peer->kinds.empty());
        s.connection.pieceWritten(0.125);
    }
    EXPECT_EQ(pieces, 3);
    std::copy_n(original.begin() + 52, 4, received.begin() + 52);  // the queue time was stamped
    EXPECT_EQ(received, original);
    EXPECT_EQ(s.peer->writes, std::vector{0.375});
    EXPECT_EQ(s.nextText(), "meanwhile");
}

TEST(Connection, StampsTheTimeBetweenEncodedAndWritten) {
    Stage s;
    s.connection.sendPicture(picture(FrameKind::frame, 1, 4, s.now - std::chrono::microseconds(1500)));
    EXPECT_EQ(readFrameHeader(s.connection.nextPiece(s.now)->bytes).sendMicros, 1500u);
    s.connection.pieceWritten(0.0);
    ASSERT_EQ(s.peer->waits.size(), 1u);
    EXPECT_NEAR(s.peer->waits[0], 0.0015, 1e-9);
}

TEST(Connection, ClosesAfterTheTextIsOut) {
    Stage s;
    s.connection.sendText("last words");
    s.connection.sendPicture(picture(FrameKind::frame, 1, 4));
    s.connection.close(CloseCode::stalled, "why");
    s.connection.sendText("too late");
    EXPECT_FALSE(s.connection.closing());
    EXPECT_EQ(s.nextText(), "last words");
    EXPECT_EQ(s.connection.closing()->code, CloseCode::stalled);
    EXPECT_EQ(s.connection.closing()->reason, "why");
    EXPECT_FALSE(s.connection.nextPiece(s.now));
}

TEST(Connection, AViewerThatReadsNothingIsClosed) {
    Stage s;
    for (int i = 0; i < 5; i++) s.connection.sendText(std::string(1 << 20, 'x'));
    while (s.connection.nextPiece(s.now)) {}
    EXPECT_EQ(s.connection.closing()->code, CloseCode::stalled);
}

TEST(Connection, PutsMessagesTogether) {
    Stage s;
    EXPECT_FALSE(s.connection.receive("{\"a\"", false, false, 0.0));
    EXPECT_FALSE(s.connection.receive(":1}", false, true, 0.0));
    EXPECT_FALSE(s.connection.receive("{}", false, true, 0.0));
    EXPECT_EQ(s.peer->texts, (std::vector<std::string>{"{\"a\":1}", "{}"}));
}

TEST(Connection, RefusesBinaryAndTooLongMessages) {
    Stage s;
    EXPECT_EQ(s.connection.receive("x", true, true, 0.0), CloseCode::unsupportedData);
    EXPECT_FALSE(s.connection.receive(std::string(MESSAGE_LIMIT, 'x'), false, true, 0.0));
    EXPECT_FALSE(s.connection.receive(std::string(MESSAGE_LIMIT, 'x'), false, false, 0.0));
    EXPECT_EQ(s.connection.receive("x", false, true, 0.0), CloseCode::messageTooBig);
    EXPECT_EQ(s.peer->texts.size(), 1u);
}

TEST(Connection, RefusesFloods) {
    Stage s;
    int taken = 0;
    while (!s.connection.receive("{}", false, true, 1.0)) taken++;
    EXPECT_EQ(taken, 2000);
    EXPECT_FALSE(s.connection.receive("{}", false, true, 1.1));  // the bucket has filled a little
    Stage bytes;
    int messages = 0;
    while (!bytes.connection.receive(std::string(MESSAGE_LIMIT, 'x'), false, true, 1.0)) messages++;
    EXPECT_EQ(messages, 64);
}

TEST(Connection, AfterDisconnectNothingIsKept) {
    Stage s;
    s.connection.sendText("a");
    s.connection.disconnect();
    s.connection.sendText("b");
    s.connection.sendPicture(picture(FrameKind::frame, 1, 4));
    s.connection.close(CloseCode::normal, "");
    EXPECT_FALSE(s.connection.hasOutput());
}

}  // namespace
}  // namespace heliograph::TEST_FILE
