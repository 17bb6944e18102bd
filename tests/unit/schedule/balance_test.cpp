#include "server/schedule/balance.h"
#include "server/schedule/frame_balance.h"
#include "server/schedule/rate_book.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>

namespace heliograph::TEST_FILE {
namespace {

BalanceDevice device(const std::string& name, double rate, uint32_t workers = 1, double batchSeconds = 0.0) {
    BalanceDevice d;
    d.name = name;
    d.hardware = name;
    d.rate = rate;
    d.workers = workers;
    d.batchSeconds = batchSeconds;
    d.spread = 0.02;
    return d;
}

TEST(Balance, TheBoundCountsOneFixedCostAndOneRoundTripADevice) {
    std::vector<BalanceDevice> devices{device("a", 10.0)};
    devices[0].batchSeconds = 1.0;
    devices[0].roundTrip = 2.0;
    EXPECT_DOUBLE_EQ(fractionalEnd(devices, 100.0), 13.0);
    devices.push_back(device("b", 30.0));
    // 30 T + 10 (T - 3) = 100
    EXPECT_DOUBLE_EQ(fractionalEnd(devices, 100.0), 3.25);
    // Too late to help: b alone is done before a's first batch could be back.
    EXPECT_DOUBLE_EQ(fractionalEnd(devices, 60.0), 2.0);
    EXPECT_EQ(fractionalEnd({}, 1.0), std::numeric_limits<double>::infinity());
}

TEST(Balance, OfDevicesOnTheSameHardwareOnlyTheFastestWorks) {
    std::vector<BalanceDevice> devices{device("embree", 5.0, 2), device("vulkan:0", 3.0)};
    devices[0].hardware = devices[1].hardware = "cpu";
    std::vector<DevicePart> parts = chooseParts(devices, 100.0);
    EXPECT_EQ(parts[0].part, Part::works);
    EXPECT_EQ(parts[1].part, Part::parked);
    EXPECT_EQ(parts[1].reason, "shares its processors with embree, which is 3.3 times as fast on them");
    devices[1].forced = true;
    EXPECT_EQ(chooseParts(devices, 100.0)[1].part, Part::works);
}

TEST(Balance, AGainUnderThreePercentIsNotWorthIt) {
    std::vector<BalanceDevice> devices{device("gpu", 1000.0), device("cpu", 2.0, 10)};
    std::vector<DevicePart> parts = chooseParts(devices, 1000.0);
    EXPECT_EQ(parts[1].part, Part::parked);
    EXPECT_EQ(parts[1].reason, "all others together would gain 2.0 % over gpu alone, under 3 %");
    devices[1].workers = 20;
    EXPECT_EQ(chooseParts(devices, 1000.0)[1].part, Part::works);
}

TEST(Balance, ADeviceThatCannotDeliverInTimeIsParked) {
    std::vector<BalanceDevice> devices{device("gpu", 1000.0), device("near", 500.0), device("far", 500.0)};
    devices[2].roundTrip = 0.1;
    std::vector<DevicePart> parts = chooseParts(devices, 15.0);
    EXPECT_EQ(parts[1].part, Part::works);
    EXPECT_EQ(parts[2].part, Part::parked);
    EXPECT_EQ(parts[2].reason, "a batch takes 100.00 ms beside the work, and the frame is done in 10.00 ms");
    EXPECT_EQ(chooseParts(devices, 1500.0)[2].part, Part::works);
}

TEST(Balance, ManyWeakDevicesTogetherAreNotATail) {
    std::vector<BalanceDevice> devices;
    for (int i = 0; i < 1000; i++) devices.push_back(device("node", 1.0));
    for (BalanceDevice& d : devices) d.hardware.clear();
    for (const DevicePart& part : chooseParts(devices, 1e6)) EXPECT_EQ(part.part, Part::works);
    devices.push_back(device("weak", 0.09));
    std::vector<DevicePart> parts = chooseParts(devices, 1e6);
    EXPECT_EQ(parts.back().part, Part::parked);
    EXPECT_EQ(parts.back().reason, "would make 0.01 % of the frame");
}

TEST(Balance, WhatIsNotKnownIsMeasuredAndMeasuredAgain) {
    std::vector<BalanceDevice> devices{device("gpu", 1000.0), device("cpu", 0.0), device("slow", 1.0)};
    EXPECT_EQ(chooseParts(devices, 1e3)[1].part, Part::probes);
    EXPECT_EQ(chooseParts(devices, 1e3)[2].part, Part::parked);
    devices[2].age = 2.0 * REMEASURE_SECONDS;
    DevicePart again = chooseParts(devices, 1e3)[2];
    EXPECT_EQ(again.part, Part::probes);
    EXPECT_EQ(again.reason.rfind("parked, measured again: all others", 0), 0u) << again.reason;
    // Measuring it would take processors away from one that is known.
    devices[1].hardware = "gpu";
    EXPECT_EQ(chooseParts(devices, 1e3)[1].reason, "shares its processors with gpu, which goes first");
}

TEST(Balance, WhoeverIsParkedHasAReason) {
    for (uint32_t seed = 0; seed < 500; seed++) {
        std::vector<BalanceDevice> devices;
        uint32_t state = seed * 747796405u + 2891336453u;
        auto random = [&] { return ((state = state * 1664525u + 1013904223u) >> 8) * 0x1p-24; };
        const int count = 1 + static_cast<int>(7 * random());
        for (int i = 0; i < count; i++) {
            const double rate = random() < 0.1 ? 0.0 : std::pow(10.0, 4.0 * random());
            devices.push_back(device("d" + std::to_string(i), rate, 1, 0.01 * random()));
            devices.back().hardware = std::to_string(static_cast<int>(4 * random()));
            devices.back().roundTrip = 0.01 * random();
        }
        size_t working = 0;
        for (const DevicePart& part : chooseParts(devices, 1e3)) {
            EXPECT_TRUE(part.part != Part::parked || !part.reason.empty());
            if (part.part != Part::parked) working++;
        }
        EXPECT_GT(working, 0u) << seed;
    }
}

TEST(Balance, HoldsBackWhatPredictionsMayBeWrongBy) {
    BatchQuestion question{10.0, 2.0, 0.05, 0.1, 0.01, 0.0};
    BatchAnswer answer = batchCost(question);
    EXPECT_FALSE(answer.last);
    EXPECT_DOUBLE_EQ(answer.cost, 2.0 * (10.0 - 3.0 * 0.05 * 10.0));
    question.batchSeconds = 1.0;  // what would be held back, 1.5 s, is not worth another second
    answer = batchCost(question);
    EXPECT_TRUE(answer.last);
    EXPECT_DOUBLE_EQ(answer.cost, 20.0);
    question = {10.0, 2.0, 5.0, 0.1, 0.01, 0.0};  // nothing is known: half, as in factoring
    EXPECT_DOUBLE_EQ(batchCost(question).cost, 10.0);
    EXPECT_EQ(batchCost({-1.0, 2.0, 0.1, 0.1, 0.1, 0.0}).cost, 0.0);
}

TEST(Balance, CheapCellsGoLastDearestFirst) {
    std::vector<uint32_t> order{3, 0, 4, 1, 2};
    const std::vector<float> costs{1.0f, 50.0f, 2.0f, 40.0f, 7.0f};
    cheapestLast(order, costs, 0.1);
    EXPECT_EQ(order, (std::vector<uint32_t>{3, 1, 4, 2, 0}));
}

TEST(RateBook, LearnsFromStampsByEffects) {
    RateBook book;
    EXPECT_EQ(book.rate("gpu", {1}).rate, 0.0);
    book.note("gpu", {1}, {100.0, 0.0, 0.6, 0.61}, 0.1);
    EXPECT_EQ(book.rate("gpu", {1}).rate, 0.0) << "counts from the end of the frame on";
    book.endFrame(7.0);
    EXPECT_DOUBLE_EQ(book.rate("gpu", {1}).rate, 200.0);
    EXPECT_EQ(book.rate("gpu", {1}).learnedAt, 7.0);
    EXPECT_EQ(book.rate("gpu", {2}).rate, 0.0);
    EXPECT_EQ(book.rate("cpu", {1}).rate, 0.0);
    book.forget("cpu");
    EXPECT_DOUBLE_EQ(book.rate("gpu", {1}).rate, 200.0);
    book.forget();
    EXPECT_EQ(book.rate("gpu", {1}).rate, 0.0);
}

TEST(RateBook, NoiseIsSmoothedAndAChangeIsBelievedInTwoFrames) {
    RateBook book;
    auto frame = [&](double seconds) {
        book.note("gpu", {}, {100.0, 1.0, seconds, seconds}, 0.0);
        book.endFrame(0.0);
        return book.rate("gpu", {}).rate;
    };
    frame(1.0);
    EXPECT_NEAR(frame(1.1), 97.0, 0.5);
    frame(6.0);  // the clock fell
    EXPECT_NEAR(frame(6.0), 100.0 / 6.0, 2.5);
}

TEST(RateBook, AStampThatCannotBeTrueIsReplacedByWhatWasSeen) {
    const double lies[] = {0.0, -1.0, 0.01, 50.0, std::numeric_limits<double>::quiet_NaN(), HUGE_VAL};
    for (double lie : lies) {
        RateBook book;
        book.note("gpu", {}, {100.0, 0.0, lie, 2.0}, 0.0);
        book.endFrame(0.0);
        EXPECT_DOUBLE_EQ(book.rate("gpu", {}).rate, 50.0) << lie;
        EXPECT_EQ(book.distrusted("gpu"), 1u);
    }
}

TEST(ReadyTable, AgreesWithTheExactAnswer) {
    ReadyTable table;
    table.reset(100.0, 10.0);
    table.add(2.0, 101.0);
    table.add(3.0, 104.0);
    table.add(50.0, 120.0);  // beyond the slots
    EXPECT_DOUBLE_EQ(table.end(4.0, 100.0), 103.0);
    EXPECT_DOUBLE_EQ(table.end(16.0, 100.0), 106.0);
    EXPECT_DOUBLE_EQ(table.end(16.0, 105.0), 105.0 + 16.0 / 5.0) << "what is past can't be used";
    table.remove(2.0, 101.0);
    EXPECT_DOUBLE_EQ(table.end(4.0, 100.0), 104.0 + 4.0 / 3.0);
    table.remove(3.0, 104.0);
    table.remove(50.0, 120.0);
    EXPECT_EQ(table.end(1.0, 100.0), std::numeric_limits<double>::infinity());
}

/// A frame of equal cells on the given devices.
FrameBalance frameOf(const std::vector<BalanceDevice>& devices, uint32_t cells) {
    FrameBalance balance;
    std::vector<float> costs(cells, 1.0f);
    std::vector<uint32_t> order(cells);
    std::iota(order.begin(), order.end(), 0u);
    balance.begin(devices, std::vector<DevicePart>(devices.size()), costs, 0.0, order, 0.0);
    return balance;
}

uint32_t size(const FrameBalance::Batch& batch) { return batch.last - batch.first; }

TEST(FrameBalance, OneBatchForAllWhenAnotherWouldCostTooMuch) {
    FrameBalance balance = frameOf({device("gpu", 1000.0, 1, 0.5)}, 1000);
    auto batch = balance.next(0, 0.0);
    ASSERT_TRUE(batch);
    EXPECT_EQ(size(*batch), 1000u);
    EXPECT_DOUBLE_EQ(batch->due, 1.5);
    EXPECT_FALSE(balance.next(0, 0.0));
}

TEST(FrameBalance, SlowOnesAskFirstAndNobodyPassesTheEnd) {
    FrameBalance balance = frameOf({device("fast", 900.0, 1, 0.5), device("slow", 100.0, 1, 0.5)}, 1000);
    EXPECT_EQ(balance.askOrder()[0], 1u);
    auto slow = balance.next(1, 0.0);
    auto fast = balance.next(0, 0.0);
    ASSERT_TRUE(slow && fast);
    EXPECT_NEAR(size(*slow), 100u, 1u);
    EXPECT_EQ(size(*slow) + size(*fast), 1000u);
    EXPECT_NEAR(slow->due, fast->due, 0.02);
}

TEST(FrameBalance, NothingStartsThatWouldEndAfterTheRest) {
    FrameBalance balance = frameOf({device("fast", 100.0), device("slow", 1.0)}, 10);
    EXPECT_FALSE(balance.next(1, 0.0)) << "a cell takes it ten times as long as the other takes for all";
    EXPECT_TRUE(balance.next(0, 0.0));
}

TEST(FrameBalance, AnOverdueBatchGoesToWhoIsThere) {
    FrameBalance balance = frameOf({device("a", 1000.0, 1, 0.05), device("b", 1000.0, 1, 0.05)}, 100);
    auto first = balance.next(0, 0.0);
    auto second = balance.next(1, 0.0);
    ASSERT_TRUE(first && second);
    for (uint32_t cell : balance.cells(*second)) EXPECT_TRUE(balance.deliver(cell));
    EXPECT_FALSE(balance.finish(second->id, second->due));
    EXPECT_FALSE(balance.next(1, second->due));
    const double alarm = balance.nextOverdue();
    EXPECT_GT(alarm, first->due + 0.09) << "as long as making it again takes";
    EXPECT_LT(alarm, first->due + 0.11);
    EXPECT_FALSE(balance.checkOverdue(alarm - 0.001));
    EXPECT_TRUE(balance.checkOverdue(alarm));
    EXPECT_FALSE(balance.next(0, alarm)) << "it owes a batch";
    auto again = balance.next(1, alarm);
    ASSERT_TRUE(again);
    EXPECT_EQ(size(*again), size(*first));
    // Both answer; each cell counts once.
    uint32_t counted = 0;
    for (const auto& batch : {*first, *again}) {
        for (uint32_t cell : balance.cells(batch)) counted += balance.deliver(cell);
        EXPECT_FALSE(balance.finish(batch.id, alarm + 1.0));
    }
    EXPECT_EQ(counted, size(*first));
    EXPECT_TRUE(balance.done());
}

TEST(FrameBalance, WhenAllAreLostTheParkedStepIn) {
    std::vector<BalanceDevice> devices{device("gpu", 1000.0), device("cpu", 1.0)};
    std::vector<DevicePart> parts = chooseParts(devices, 100.0);
    ASSERT_EQ(parts[1].part, Part::parked);
    std::vector<float> costs(100, 1.0f);
    std::vector<uint32_t> order(100);
    std::iota(order.begin(), order.end(), 0u);
    FrameBalance balance;
    balance.begin(devices, parts, costs, 0.0, order, 0.0);
    ASSERT_TRUE(balance.next(0, 0.0));
    EXPECT_FALSE(balance.next(1, 0.0));
    EXPECT_TRUE(balance.lose(0));
    EXPECT_TRUE(balance.next(1, 0.1));
    EXPECT_FALSE(balance.hopeless());
    balance.lose(1);
    EXPECT_TRUE(balance.hopeless());
}

TEST(FrameBalance, CellsThatADeviceLeavesOutGoBack) {
    FrameBalance balance = frameOf({device("a", 100.0, 1, 5.0)}, 10);
    auto batch = balance.next(0, 0.0);
    ASSERT_TRUE(batch);
    for (uint32_t cell = 0; cell < 9; cell++) balance.deliver(cell);
    EXPECT_TRUE(balance.finish(batch->id, batch->due));
    auto rest = balance.next(0, batch->due);
    ASSERT_TRUE(rest);
    EXPECT_EQ(balance.cells(*rest)[0], 9u);
    EXPECT_EQ(size(*rest), 1u);
}

// By hand: each device has its own part of the order, whatever the other could still do.
TEST(FrameBalance, ADeviceGetsNoCellBeyondItsRange) {
    const std::vector<BalanceDevice> devices{device("cpu", 1.0, 2), device("gpu", 1000.0)};
    const std::vector<DevicePart> parts{{Part::works, "", {0, 30}}, {Part::works, "", {30, 100}}};
    const std::vector<float> costs(100, 1.0f);
    std::vector<uint32_t> order(100);
    std::iota(order.rbegin(), order.rend(), 0u);
    FrameBalance balance;
    balance.begin(devices, parts, costs, 0.0, order, 0.0);
    std::vector<std::vector<uint32_t>> given(2);
    double now = 0.0;
    while (!balance.done() && now < 1e3) {
        now += 1.0;
        for (uint32_t worker : balance.askOrder()) {
            while (const auto batch = balance.next(worker, now)) {
                for (uint32_t cell : balance.cells(*batch)) {
                    given[balance.deviceOf(worker)].push_back(cell);
                    EXPECT_TRUE(balance.deliver(cell));
                }
                balance.finish(batch->id, now);
            }
        }
    }
    EXPECT_TRUE(balance.done());
    EXPECT_EQ(given[0].size(), 30u);
    EXPECT_EQ(given[1].size(), 70u);
    for (uint32_t cell : given[0]) EXPECT_GE(cell, 70u);
}

TEST(FrameBalance, ALostRangeDoesNotStopTheOther) {
    const std::vector<BalanceDevice> devices{device("cpu", 10.0), device("gpu", 10.0)};
    const std::vector<DevicePart> parts{{Part::works, "", {0, 5}}, {Part::works, "", {5, 10}}};
    const std::vector<float> costs(10, 1.0f);
    std::vector<uint32_t> order(10);
    std::iota(order.begin(), order.end(), 0u);
    FrameBalance balance;
    balance.begin(devices, parts, costs, 0.0, order, 0.0);
    balance.lose(1);
    EXPECT_FALSE(balance.hopeless());
    EXPECT_FALSE(balance.stuck());
    while (const auto batch = balance.next(0, 0.0)) {
        for (uint32_t cell : balance.cells(*batch)) balance.deliver(cell);
        balance.finish(batch->id, 0.1);
    }
    EXPECT_EQ(balance.undelivered(), 5u);
    EXPECT_TRUE(balance.hopeless());
    EXPECT_TRUE(balance.stuck());
}

}  // namespace
}  // namespace heliograph::TEST_FILE
