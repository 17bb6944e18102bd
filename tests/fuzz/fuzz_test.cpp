// A smoke of every fuzz target: its seeds, then 10,000 mutations of them. A crash, a report of a sanitizer, or anything thrown
// but InputError ends the program, and the input that did it lies in the file that is named then. ./check asan runs it with
// both sanitizers; tests/fuzz/run.sh searches by coverage, for as long as one likes.

#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/mutate.h"
#include "tests/fuzz/seeds.h"

#include <cstdlib>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <iostream>
#include <unistd.h>

#define TARGETS(TARGET) \
    TARGET(message)     \
    TARGET(settings) TARGET(header) TARGET(upload) TARGET(image) TARGET(gltf) TARGET(glb) TARGET(obj) TARGET(pool)
#define DECLARE(NAME) extern "C" int fuzz_##NAME(const uint8_t* data, size_t size);
TARGETS(DECLARE)

#if defined(__SANITIZE_ADDRESS__)
// Beyond 1 GiB the process ends with a report.
extern "C" const char* __asan_default_options() { return "hard_rss_limit_mb=1024:allocator_may_return_null=0:handle_abort=1"; }
#endif

namespace heliograph::fuzz {
namespace {

constexpr uint32_t MUTATIONS = 10'000;
constexpr size_t MOST_BYTES = 4096;
constexpr unsigned MOST_SECONDS = 60;  // an input that hangs ends the program by SIGALRM

struct Target {
    const char* name;
    int (*run)(const uint8_t*, size_t);
};
#define ROW(NAME) {#NAME, fuzz_##NAME},
const Target ALL[] = {TARGETS(ROW)};

std::vector<Bytes> seedsOf(const std::string& target) {
    std::vector<Bytes> bytes;
    const std::map<std::string, std::vector<Seed>> all = seeds();
    for (const Seed& seed : all.at(target)) bytes.emplace_back(seed.bytes.begin(), seed.bytes.end());
    return bytes;
}

/// Keeps the input on disk while it runs, so that what ended the program can be run again.
class Runner {
public:
    explicit Runner(const Target& target) : target_(target), file_((scratch() / "input").string()) {}
    int run(const Bytes& input) {
        const int out = open(file_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
        EXPECT_EQ(write(out, input.data(), input.size()), static_cast<ssize_t>(input.size())) << file_;
        close(out);
        alarm(MOST_SECONDS);
        const int result = target_.run(input.data(), input.size());
        alarm(0);
        return result;
    }
    const std::string& file() const { return file_; }

private:
    const Target& target_;
    std::string file_;
};

class FuzzSmoke : public testing::TestWithParam<Target> {};

TEST_P(FuzzSmoke, NoSeedAndNoMutationBreaksIt) {
    const std::vector<Bytes> from = seedsOf(GetParam().name);
    ASSERT_FALSE(from.empty());
    Runner runner(GetParam());
    std::cout << "should this end the program: " << runner.file() << " is the input" << std::endl;
    for (const Bytes& seed : from) ASSERT_EQ(runner.run(seed), 0);
    test::Random random(11);
    std::vector<Bytes> pool = from;
    for (uint32_t i = 0; i < MUTATIONS; i++) {
        const Bytes input = mutated(pool[random.below(static_cast<uint32_t>(pool.size()))], from, random, MOST_BYTES);
        ASSERT_EQ(runner.run(input), 0);
        if (random.below(64) == 0) pool.push_back(input);  // changes upon changes
    }
}

INSTANTIATE_TEST_SUITE_P(Targets, FuzzSmoke, testing::ValuesIn(ALL),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(Mutate, IsTheSameForASeedAndChangesTheInput) {
    const std::vector<Bytes> from = seedsOf("message");
    test::Random one(3), two(3);
    uint32_t different = 0;
    for (uint32_t i = 0; i < 1000; i++) {
        const Bytes a = mutated(from[0], from, one, 100);
        ASSERT_EQ(a, mutated(from[0], from, two, 100));
        ASSERT_LE(a.size(), 100u);
        different += a != from[0];
    }
    EXPECT_GT(different, 950u);
}

}  // namespace
}  // namespace heliograph::fuzz
