#include "server/film/film_pool.h"

#include <gtest/gtest.h>

#include <new>

namespace heliograph::TEST_FILE {
namespace {

constexpr uvec2 SIZE{64, 48};

TEST(FilmPool, UsesAFilmAgainThatNobodyHolds) {
    FilmPool pool;
    std::shared_ptr<Film> first = pool.next(SIZE, 1);
    const Film* address = first.get();
    std::shared_ptr<Film> second = pool.next(SIZE, 2);
    EXPECT_NE(second.get(), address) << "the first is still held";
    first.reset();
    EXPECT_EQ(pool.next(SIZE, 3).get(), address);
}

TEST(FilmPool, AFilmThatIsHeldIsNeverTouched) {
    FilmPool pool;
    std::vector<std::shared_ptr<Film>> held;
    for (uint32_t i = 1; i <= 5; i++) held.push_back(pool.next(SIZE, i));
    for (uint32_t i = 1; i <= 5; i++) EXPECT_EQ(held[i - 1]->generation(), i);
}

// Room for what is wanted is made of what is not needed any more, before anybody is told.
TEST(FilmPool, LetsGoOfIdleFilmsBeforeItGivesUp) {
    int failures = 1;
    FilmPool pool([&](Film& film, uvec2 resolution, uint32_t generation) {
        if (generation == 3 && failures-- > 0) throw std::bad_alloc();
        film.reset(resolution, generation);
    });
    std::shared_ptr<Film> a = pool.next(SIZE, 1), b = pool.next(SIZE, 2);
    const std::weak_ptr<Film> idle = b;
    a.reset();
    b.reset();
    EXPECT_EQ(pool.next(SIZE, 3)->generation(), 3u);
    EXPECT_TRUE(idle.expired());
}

TEST(FilmPool, SaysInWordsThatMemoryRanOut) {
    FilmPool pool([](Film&, uvec2, uint32_t) { throw std::bad_alloc(); });
    for (auto make : {&FilmPool::next, &FilmPool::extra}) {
        try {
            (pool.*make)(SIZE, 1);
            FAIL() << "there was no memory";
        } catch (const std::runtime_error& error) {
            EXPECT_NE(std::string(error.what()).find("no memory for 64 x 48 pixels"), std::string::npos) << error.what();
        }
    }
}

}  // namespace
}  // namespace heliograph::TEST_FILE
