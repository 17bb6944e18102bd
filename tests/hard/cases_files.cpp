// Case 40: mutations of files. Each block of them is read by a process of its own, so that one that dies is seen.

#include "server/base/error.h"
#include "server/scene/load/scene_source.h"
#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/mutate.h"
#include "tests/fuzz/seeds.h"
#include "tests/hard/cases.h"

#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <stdexcept>
#include <unistd.h>

extern char** environ;

namespace heliograph::hard {

namespace {

constexpr uint64_t BLOCK = 50;         // mutations of a process
constexpr unsigned int SECONDS = 5;    // for each
constexpr rlim_t MEMORY = 3ull << 30;  // address space; what is linked takes a part of it

std::vector<fuzz::Bytes> files() {
    std::vector<fuzz::Bytes> all;
    const auto seeds = fuzz::seeds();
    for (const fuzz::Seed& seed : seeds.at("glb")) all.emplace_back(seed.bytes.begin(), seed.bytes.end());
    return all;
}

}  // namespace

int readMutations(uint64_t first) {
    const rlimit limit{MEMORY, MEMORY};
    setrlimit(RLIMIT_AS, &limit);
    const std::vector<fuzz::Bytes> seeds = files();
    for (uint64_t i = first; i < first + BLOCK; i++) {
        test::Random random(40'000 + i);
        const auto file = fuzz::asFile(fuzz::mutated(seeds[i % seeds.size()], seeds, random, 1u << 16), "mutated.glb");
        alarm(SECONDS);  // ends the process
        fuzz::refusing([&] { openScene(file.string()); });
        alarm(0);
    }
    return 0;
}

void hostileFiles(Run& run) {
    const uint64_t count = run.count(1000, 10000);
    for (uint64_t first = 0; first < count; first += BLOCK) {
        std::string words[] = {"hard_cases", "--mutations", std::to_string(first)};
        char* arguments[] = {words[0].data(), words[1].data(), words[2].data(), nullptr};
        pid_t child = 0;
        if (posix_spawn(&child, "/proc/self/exe", nullptr, nullptr, arguments, environ) != 0)
            throw std::runtime_error("no process could be started");
        int status = 0;
        waitpid(child, &status, 0);
        const bool bad = !WIFEXITED(status) || WEXITSTATUS(status) != 0;
        run.rate(column::OWN, "blocks of 50 mutations that end a reader, or take over 5 s each", bad, 1, 0.0,
                 "hard_cases --mutations " + std::to_string(first));
    }
    run.note("without sanitizers; ./check asan reads 10,000 mutations of every format with them (test_fuzz)");
}

}  // namespace heliograph::hard
