#include "server/render/turns.h"
#include "tests/support/until.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <string>
#include <thread>
#include <vector>

namespace heliograph::TEST_FILE {
namespace {

/// Waits until somebody waits for a turn.
void untilContended(const Turns& turns) {
    EXPECT_TRUE(test::until([&] { return turns.contended(); }));
}

TEST(Turns, OneAtATime) {
    Turns turns;
    int inside = 0, worst = 0;
    std::vector<std::jthread> users;
    for (int u = 0; u < 4; u++) {
        users.emplace_back([&] {
            Turns::Account account;
            for (int i = 0; i < 50; i++) {
                auto turn = turns.take(account, {});
                worst = std::max(worst, ++inside);
                std::this_thread::yield();
                inside--;
            }
        });
    }
    users.clear();
    EXPECT_EQ(worst, 1);
}

TEST(Turns, WhoHasTheTurnAndForHowLong) {
    double now = 10.0;
    Turns turns([&] { return now; });
    Turns::Account first, second;
    EXPECT_FALSE(turns.held(first));
    {
        auto turn = turns.take(first, {});
        now = 33.0;
        EXPECT_EQ(turns.held(first), 23.0);
        EXPECT_FALSE(turns.held(second));
    }
    EXPECT_FALSE(turns.held(first));
}

TEST(Turns, AWaiterLeavesWhenAsked) {
    Turns turns;
    Turns::Account first, second;
    auto turn = turns.take(first, {});
    std::stop_source stop;
    bool got = true;
    std::jthread waiter([&] { got = turns.take(second, stop.get_token()).has_value(); });
    untilContended(turns);
    stop.request_stop();
    waiter.join();
    EXPECT_FALSE(got);
    EXPECT_FALSE(turns.contended());
}

TEST(Turns, AStoppedUserGetsNoTurn) {
    Turns turns;
    Turns::Account account;
    std::stop_source stop;
    stop.request_stop();
    // Nobody else is there: a turn may be had, but then it must be free again afterwards.
    { auto turn = turns.take(account, stop.get_token()); }
    EXPECT_TRUE(turns.take(account, {}).has_value());
}

TEST(Turns, AnEndedTurnWakesTheNextAloneAndNotEverybody) {
    constexpr size_t USERS = 40;
    Turns turns;
    Turns::Account holder;
    std::optional<Turns::Turn> held;
    held.emplace(std::move(*turns.take(holder, {})));
    std::vector<Turns::Account> accounts(USERS);
    std::vector<std::jthread> users;
    for (Turns::Account& account : accounts) users.emplace_back([&] { auto turn = turns.take(account, {}); });
    EXPECT_TRUE(test::until([&] { return turns.waiting() == USERS; }));
    held.reset();
    users.clear();
    // Each looks when it comes and when it is called (a spurious wake-up may come on top); in a crowd that wakes as a whole
    // it would be USERS * USERS / 2.
    EXPECT_LT(turns.wakeUps(), 1 + 4 * USERS);
}

/// A clock that stands until it is moved.
struct Clock {
    std::atomic<double> seconds{0.0};
    std::function<double()> reader() {
        return [this] { return seconds.load(); };
    }
};

/// Takes a turn of that length.
void use(Turns& turns, Turns::Account& account, Clock& clock, double seconds) {
    auto turn = turns.take(account, {});
    clock.seconds = clock.seconds + seconds;
}

/// Lets two users wait behind a third, `first` earlier, and returns the order in which they are served.
std::string orderOf(Turns& turns, Turns::Account& first, Turns::Account& second, Urgency ofSecond = Urgency::finer) {
    Turns::Account holder;
    std::optional<Turns::Turn> held;
    held.emplace(std::move(*turns.take(holder, {})));
    std::string order;
    auto user = [&](Turns::Account& account, char name, Urgency urgency) {
        auto turn = turns.take(account, {}, urgency);
        order += name;
    };
    std::jthread one([&] { user(first, '1', Urgency::finer); });
    EXPECT_TRUE(test::until([&] { return turns.waiting() >= 1; }));
    std::jthread two([&] { user(second, '2', ofSecond); });
    EXPECT_TRUE(test::until([&] { return turns.waiting() >= 2; }));
    held.reset();
    one.join();
    two.join();
    return order;
}

TEST(Turns, EqualsAreServedInOrderOfArrival) {
    Clock clock;
    Turns turns(clock.reader());
    Turns::Account a, b;
    EXPECT_EQ(orderOf(turns, a, b), "12");
    EXPECT_EQ(orderOf(turns, b, a), "12");
}

TEST(Turns, WhoHasUsedLessComesFirst) {
    Clock clock;
    Turns turns(clock.reader());
    Turns::Account greedy, modest;
    use(turns, greedy, clock, 0.5);
    EXPECT_EQ(orderOf(turns, greedy, modest), "21");
    EXPECT_DOUBLE_EQ(turns.used(greedy).own, 0.5);
    EXPECT_DOUBLE_EQ(turns.used(greedy).all, 0.5);
    EXPECT_DOUBLE_EQ(turns.used(modest).own, 0.0);
}

struct User {
    double seconds;  // a turn
    Urgency urgency;
    double start = 0.0;  // virtual time
};

/// Who has the next `turns` turns if all want one all the time, by number.
std::vector<int> served(std::vector<User> users, int turns) {
    auto place = [](const User& user) { return placeInLine(user.start, user.urgency); };
    std::vector<int> order;
    for (int turn = 0; turn < turns; turn++) {
        const auto next =
            std::min_element(users.begin(), users.end(), [&](const User& a, const User& b) { return place(a) < place(b); });
        next->start += next->seconds;
        order.push_back(static_cast<int>(next - users.begin()));
    }
    return order;
}

TEST(Turns, AnAwaitedPictureGoesBeforeFinerOnesWithinItsHeadStart) {
    EXPECT_LT(placeInLine(1.0 + 0.9 * HEAD_START, Urgency::awaited), placeInLine(1.0, Urgency::finer));
    EXPECT_GT(placeInLine(1.0 + 1.1 * HEAD_START, Urgency::awaited), placeInLine(1.0, Urgency::finer));
    EXPECT_LT(placeInLine(1.0, Urgency::awaited), placeInLine(1.1, Urgency::awaited)) << "among themselves by use";
    // The dear one has used ten times as much when its hand rests; the others' pictures only become finer meanwhile.
    EXPECT_EQ(served({{0.004, Urgency::finer}, {0.004, Urgency::finer}, {0.04, Urgency::awaited, 0.04}}, 1),
              std::vector<int>{2});
    // Who never rests gets ahead by the head start and no further: from then on both have half of the time.
    const std::vector<int> order = served({{0.01, Urgency::finer}, {0.01, Urgency::awaited}}, 200);
    const auto awaited = std::count(order.begin(), order.end(), 1);
    EXPECT_NEAR(static_cast<double>(awaited), 100.0 + 0.5 * HEAD_START / 0.01, 2.0);
}

TEST(Turns, AnAwaitedTurnIsGivenBeforeAFinerOneThatCameFirst) {
    Clock clock;
    Turns turns(clock.reader());
    Turns::Account rests, moves;
    use(turns, moves, clock, 0.5 * HEAD_START);
    EXPECT_EQ(orderOf(turns, rests, moves, Urgency::awaited), "21");
    use(turns, moves, clock, 2.0 * HEAD_START);
    EXPECT_EQ(orderOf(turns, rests, moves, Urgency::awaited), "12");
}

TEST(Turns, ANewcomerDoesNotMakeUpForTheTimeBefore) {
    Clock clock;
    Turns turns(clock.reader());
    Turns::Account old, fresh;
    for (int i = 0; i < 100; i++) use(turns, old, clock, 1.0);
    // It has used 100 times as much, yet after one longer turn of the newcomer it comes first.
    use(turns, fresh, clock, 3.0);
    EXPECT_EQ(orderOf(turns, fresh, old), "21");
}

TEST(Turns, WhoCameBackLatelySharesThoughNobodyWaits) {
    double now = 0.0;
    Turns turns([&] { return now; });
    Turns::Account light, heavy;
    auto turn = [&](Turns::Account& account, double seconds) {
        auto taken = turns.take(account, {});
        now += seconds;
    };
    turn(heavy, 0.2);
    EXPECT_FALSE(turns.shared(heavy));
    turn(light, 0.01);
    turn(heavy, 0.2);
    EXPECT_TRUE(turns.shared(heavy));
    EXPECT_TRUE(turns.shared(light));
    turn(heavy, 0.4);
    EXPECT_FALSE(turns.shared(heavy)) << "the other one has gone";
    EXPECT_TRUE(turns.shared(light)) << "it would come back to one that is busy";
}

}  // namespace
}  // namespace heliograph::TEST_FILE
