#include "server/service/scene_cache.h"

#include "server/base/error.h"
#include "tests/support/until.h"

#include "tests/support/direct_renderer.h"
#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

constexpr auto PATIENCE = std::chrono::seconds(30);

class IdleDevice : public Device {
public:
    DeviceInfo info() const override { return {"embree", "for tests", "none", 1}; }
    void load(std::shared_ptr<const Scene>, const Settings&, const Progress& progress) override {
        report(progress, "building", 0.5);
    }
    void render(const FrameRequest&, std::span<const Tile>, const TileSink&, std::stop_token) override {}
};

/// What a listener was told.
struct Told {
    std::mutex mutex;
    std::condition_variable changed;
    std::vector<std::pair<std::string, double>> progress;
    std::shared_ptr<ResidentScene> scene;
    std::string failure;

    SceneListener listener() {
        SceneListener l;
        l.progress = [this](const std::string& what, double share) {
            std::lock_guard lock(mutex);
            progress.emplace_back(what, share);
            changed.notify_all();
        };
        l.ready = [this](std::shared_ptr<ResidentScene> ready) {
            std::lock_guard lock(mutex);
            scene = std::move(ready);
            changed.notify_all();
        };
        l.failed = [this](const std::string& why, std::exception_ptr) {
            std::lock_guard lock(mutex);
            failure = why;
            changed.notify_all();
        };
        return l;
    }
    template <typename Condition>
    bool until(Condition condition) {
        std::unique_lock lock(mutex);
        return changed.wait_for(lock, PATIENCE, condition);
    }
    /// Inside the opener.
    bool untilReading() {
        return until([&] { return !progress.empty() && progress.back().first == "reading"; });
    }
    std::pair<std::string, double> first() {
        std::lock_guard lock(mutex);
        return progress.front();
    }
    bool untilReady() {
        return until([&] { return scene != nullptr; });
    }
};

/// Opens scenes by name: "bad..." fails, "slow..." goes on reporting progress until it is told to end or given up.
struct Source {
    std::atomic<int> opened{0}, abandoned{0};
    std::atomic<bool> release{false};
    SceneCache::Opener opener() {
        return [this](const std::string& name, const Progress& progress) {
            opened++;
            if (name.starts_with("bad")) throw InputError(name, "cannot be read", "a good one");
            if (name.starts_with("huge")) throw std::bad_alloc();
            try {
                do {
                    report(progress, "reading", 0.5);
                    std::this_thread::yield();
                } while (name.starts_with("slow") && !release);
            } catch (...) {
                abandoned++;
                throw;
            }
            auto scene = std::make_shared<Scene>();
            scene->name = name;
            scene->environment.image = NO_INDEX;
            scene->cameras.push_back({"start"});
            return std::shared_ptr<const Scene>(scene);
        };
    }
    SceneCache::DeviceFactory devices() {
        return [] { return std::make_unique<test::DirectRenderer>(std::make_shared<IdleDevice>()); };
    }
};

TEST(SceneCache, LoadsOnceForEverybody) {
    Source source;
    Told a, b, c;
    SceneCache cache(source.opener(), source.devices(), {});
    auto ticketA = cache.open("slow", a.listener());
    auto ticketB = cache.open("slow", b.listener());
    source.release = true;
    ASSERT_TRUE(a.untilReady());
    ASSERT_TRUE(b.untilReady());
    EXPECT_EQ(a.scene, b.scene);
    auto ticketC = cache.open("slow", c.listener());
    EXPECT_EQ(c.scene, a.scene);  // at once
    EXPECT_EQ(source.opened, 1);
    EXPECT_EQ(cache.residentCount(), 1u);
}

TEST(SceneCache, ProgressGrowsFromOpeningToBuilding) {
    Source source;
    Told told;
    SceneCache cache(source.opener(), source.devices(), {});
    auto ticket = cache.open("a", told.listener());
    ASSERT_TRUE(told.untilReady());
    ASSERT_GE(told.progress.size(), 3u);
    double before = 0.0;
    for (const auto& [what, share] : told.progress) {
        EXPECT_GE(share, before);
        EXPECT_LE(share, 1.0);
        before = share;
    }
    EXPECT_EQ(told.progress.back().first, "building");
}

TEST(SceneCache, WhoComesLateIsToldWhereTheLoadStands) {
    Source source;
    Told early, late, queued;
    SceneCache cache(source.opener(), source.devices(), {});
    auto one = cache.open("slow", early.listener());
    ASSERT_TRUE(early.untilReading());
    auto two = cache.open("slow", late.listener());
    EXPECT_EQ(late.first(), (std::pair<std::string, double>("reading", 0.7 * 0.5)));
    auto three = cache.open("other", queued.listener());
    EXPECT_EQ(queued.first(), (std::pair<std::string, double>("Waiting for another scene", 0.0)));
    source.release = true;
    ASSERT_TRUE(queued.untilReady());
}

TEST(SceneCache, FailuresAreToldAndTriedAgain) {
    Source source;
    Told first, second, huge;
    SceneCache cache(source.opener(), source.devices(), {});
    auto one = cache.open("bad", first.listener());
    ASSERT_TRUE(first.until([&] { return !first.failure.empty(); }));
    EXPECT_EQ(first.failure, "bad: cannot be read; allowed: a good one");
    auto two = cache.open("bad", second.listener());
    ASSERT_TRUE(second.until([&] { return !second.failure.empty(); }));
    auto three = cache.open("huge", huge.listener());
    ASSERT_TRUE(huge.until([&] { return !huge.failure.empty(); }));
    EXPECT_EQ(huge.failure, "huge: too large for this machine's memory");
    EXPECT_EQ(source.opened, 3);
    EXPECT_EQ(cache.residentCount(), 0u);
}

TEST(SceneCache, ALoadThatNobodyWaitsForIsGivenUp) {
    Source source;
    Told lost, other;
    SceneCache cache(source.opener(), source.devices(), {});
    auto ticket = cache.open("slow", lost.listener());
    ASSERT_TRUE(lost.untilReading());
    auto next = cache.open("quick", other.listener());
    ticket.reset();
    ASSERT_TRUE(other.untilReady());  // would wait for ever behind the slow one
    EXPECT_EQ(source.abandoned, 1);
    EXPECT_EQ(lost.scene, nullptr);
}

TEST(SceneCache, LoadsThatNobodyWaitsForTakeNoPlace) {
    Source source;
    Told first, storm, other;
    SceneCache cache(
        source.opener(), source.devices(), {}, [](const char*) {}, 3, 2);
    auto ticket = cache.open("slow", first.listener());
    ASSERT_TRUE(first.untilReading());
    // One viewer changes its mind all the time: each load but the newest is nobody's.
    for (int i = 0; i < 100; i++) {
        EXPECT_NO_THROW(cache.open("storm" + std::to_string(i), storm.listener()));
        EXPECT_LE(cache.loadCount(), 2u);
    }
    std::shared_ptr<void> wanted;
    EXPECT_NO_THROW(wanted = cache.open("wanted", other.listener()));
    EXPECT_THROW(cache.open("too many", storm.listener()), InputError);
    source.release = true;
    ASSERT_TRUE(other.untilReady());
    EXPECT_LE(source.opened, 3);  // the storm's last one was in the queue at most
}

TEST(SceneCache, WhatIsNotToStayTakesNoPlace) {
    Source source;
    Told picture, viewer, other, joined;
    SceneCache cache(
        source.opener(), source.devices(), {}, [](const char*) {}, 3, 1);
    auto one = cache.open("slow", picture.listener(), SceneCache::Stay::no);
    ASSERT_TRUE(picture.untilReading());
    std::shared_ptr<void> two;
    EXPECT_NO_THROW(two = cache.open("viewer's", viewer.listener())) << "the one place is the viewer's";
    source.release = true;
    ASSERT_TRUE(picture.untilReady());
    ASSERT_TRUE(viewer.untilReady());
    EXPECT_EQ(cache.residentCount(), 1u);
    viewer.scene.reset();
    two.reset();
    source.release = false;
    std::shared_ptr<void> three;
    ASSERT_TRUE(test::until([&] {  // who has loaded it lets go of it a moment later
        try {
            three = cache.open("slower", other.listener(), SceneCache::Stay::no);
        } catch (const InputError&) {
            return false;
        }
        return true;
    }));
    ASSERT_TRUE(other.untilReading());
    auto four = cache.open("slower", joined.listener());
    source.release = true;
    ASSERT_TRUE(joined.untilReady());
    EXPECT_EQ(cache.residentCount(), 2u) << "a viewer joined";
}

TEST(SceneCache, EndsInTheMiddleOfALoad) {
    Source source;
    Told told;
    std::shared_ptr<void> ticket;
    {
        SceneCache cache(source.opener(), source.devices(), {});
        ticket = cache.open("slow", told.listener());
        ASSERT_TRUE(told.untilReading());
    }
    EXPECT_EQ(source.abandoned, 1);
}

TEST(SceneCache, KeepsTheScenesThatWereUsedLast) {
    Source source;
    SceneCache cache(
        source.opener(), source.devices(), {}, [](const char*) {}, 2, 8);
    auto look = [&](const std::string& name) {
        Told told;
        auto ticket = cache.open(name, told.listener());
        ASSERT_TRUE(told.untilReady()) << name;
    };
    for (const char* name : {"a", "b", "a", "c"}) look(name);
    ASSERT_TRUE(test::until([&] { return cache.residentCount() <= 2; }));  // "b" goes after "c" was told
    EXPECT_EQ(source.opened, 3);
    look("a");
    EXPECT_EQ(source.opened, 3);
    look("b");
    EXPECT_EQ(source.opened, 4);
}

TEST(SceneCache, ScenesInUseStayAndTheirNumberIsLimited) {
    Source source;
    SceneCache cache(
        source.opener(), source.devices(), {}, [](const char*) {}, 1, 2);
    Told a, b, c;
    auto one = cache.open("a", a.listener());
    ASSERT_TRUE(a.untilReady());
    auto two = cache.open("b", b.listener());
    ASSERT_TRUE(b.untilReady());
    EXPECT_EQ(cache.residentCount(), 2u);
    EXPECT_THROW(cache.open("c", c.listener()), InputError);
    a.scene.reset();
    auto three = cache.open("c", c.listener());
    ASSERT_TRUE(c.untilReady());
}

TEST(SceneCache, APinnedSceneStaysButIsNotInUseForThat) {
    Source source;
    SceneCache cache(
        source.opener(), source.devices(), {}, [](const char*) {}, 1, 2);
    Told start, a, b, c;
    auto first = cache.open("start", start.listener());
    ASSERT_TRUE(start.untilReady());
    cache.pin("start");
    start.scene.reset();
    auto one = cache.open("a", a.listener());
    ASSERT_TRUE(a.untilReady());
    auto two = cache.open("b", b.listener());
    ASSERT_TRUE(b.untilReady()) << "two may be in use, and nobody looks at the first";
    EXPECT_EQ(cache.residentCount(), 3u) << "it was not forgotten";
    EXPECT_THROW(cache.open("c", c.listener()), InputError);
    start.scene.reset();
    auto again = cache.open("start", start.listener());
    ASSERT_TRUE(start.untilReady());
    EXPECT_EQ(source.opened, 3);
}

}  // namespace
}  // namespace heliograph::TEST_FILE
