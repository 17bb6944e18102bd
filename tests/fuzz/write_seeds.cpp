// Writes the fuzzers' seeds: fuzz_seeds FOLDER makes FOLDER/<target>/ with a few small valid inputs each.

#include "tests/fuzz/seeds.h"

#include <filesystem>
#include <fstream>

int main(int argc, char** argv) {
    if (argc != 2) return 2;
    for (const auto& [target, seeds] : heliograph::fuzz::seeds()) {
        const std::filesystem::path folder = std::filesystem::path(argv[1]) / target;
        std::filesystem::create_directories(folder);
        for (const heliograph::fuzz::Seed& seed : seeds)
            std::ofstream(folder / seed.name, std::ios::binary)
                .write(seed.bytes.data(), static_cast<std::streamsize>(seed.bytes.size()));
    }
}
