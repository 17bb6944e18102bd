#include "server/base/mailbox.h"

#include <gtest/gtest.h>

#include <memory>
#include <thread>

namespace heliograph::TEST_FILE {
namespace {

TEST(Mailbox, TheNewestReplacesWhatNobodyFetched) {
    Mailbox<int> box;
    EXPECT_FALSE(box.take().has_value());
    EXPECT_FALSE(box.put(1));
    EXPECT_TRUE(box.put(2));
    EXPECT_TRUE(box.hasMessage());
    EXPECT_EQ(box.take(), 2);
    EXPECT_FALSE(box.hasMessage());
    EXPECT_FALSE(box.put(3)) << "2 was fetched";
}

TEST(Mailbox, CarriesWhatCanOnlyBeMoved) {
    Mailbox<std::unique_ptr<int>> box;
    box.put(std::make_unique<int>(5));
    EXPECT_EQ(**box.wait(), 5);
}

TEST(Mailbox, ClosingWakesTheOneWhoWaits) {
    Mailbox<int> box;
    std::jthread waiter([&] { EXPECT_FALSE(box.wait().has_value()); });
    box.close();
    waiter.join();
    EXPECT_TRUE(box.closed());
    box.put(1);
    EXPECT_FALSE(box.take().has_value()) << "put after close is dropped";
}

TEST(Mailbox, WhatLiesThereWhenItClosesIsStillDelivered) {
    Mailbox<int> box;
    box.put(9);
    box.close();
    EXPECT_EQ(box.wait(), 9);
    EXPECT_FALSE(box.wait().has_value());
}

TEST(Mailbox, AReaderSeesTheLastOfManyMessages) {
    Mailbox<int> box;
    int last = -1;
    std::jthread reader([&] {
        while (auto message = box.wait()) {
            EXPECT_GT(*message, last);
            last = *message;
        }
    });
    for (int i = 0; i <= 10000; i++) box.put(i);
    box.close();
    reader.join();
    EXPECT_EQ(last, 10000);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
