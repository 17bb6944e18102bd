// How long a mesh takes to load in each way that glTF may store its geometry: compressed_twins FOLDER [QUADS A SIDE] writes the
// files and opens each in turns, five times. A row per kind: bytes, milliseconds (median, fastest), share of the plain one, and the
// most memory that a process of its own took for it.

#include "server/scene/load/scene_source.h"
#include "tests/support/compressed_files.h"

#include <malloc.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

using namespace heliograph;
using namespace heliograph::testing_files;

namespace {

struct Kind {
    const char* name;
    std::string file;
    size_t bytes = 0;
    double mebibytes = 0.0;
    std::vector<double> milliseconds;
};

double openOnce(const std::string& file) {
    const auto start = std::chrono::steady_clock::now();
    if (openScene(file)->triangleCount() == 0) std::abort();
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

/// MiB that a process took at most that did nothing but open the file. To be asked before this one has threads.
double mebibytesFor(const std::string& file) {
    const pid_t child = fork();
    if (child == 0) {
        openOnce(file);
        _exit(0);
    }
    rusage used{};
    int status = 0;
    if (wait4(child, &status, 0, &used) != child || status != 0) std::abort();
    return static_cast<double>(used.ru_maxrss) / 1024.0;
}

/// One mesh of 2 x side x side triangles in each kind of file.
void writeTwins(const std::filesystem::path& folder, uint32_t side, std::vector<Kind>& kinds, size_t& triangles) {
    const WavyGrid grid(side);
    triangles = grid.indices.size() / 3;
    const auto add = [&](const char* name, const std::string& content) {
        const std::string file = (folder / (std::string(name) + ".glb")).string();
        std::ofstream(file, std::ios::binary).write(content.data(), static_cast<std::streamsize>(content.size()));
        kinds.push_back({name, file, content.size(), 0.0, {}});
    };
    add("plain", plainGlb(grid));
    add("draco", dracoGlb(grid));
    add("draco-sequential", dracoGlb(grid, dracoBytes(grid, true), grid.vertices()));
    add("meshopt", meshoptGlb(grid, MeshoptKind::exact, true));
    add("meshopt-filtered", meshoptGlb(grid, MeshoptKind::filtered, true));
}

}  // namespace

int main(int count, char** arguments) {
    if (count < 2) return std::fprintf(stderr, "compressed_twins FOLDER [QUADS A SIDE]\n"), 2;
    const std::filesystem::path folder(arguments[1]);
    std::vector<Kind> kinds;
    size_t triangles = 0;
    writeTwins(folder, count > 2 ? static_cast<uint32_t>(std::atoi(arguments[2])) : 670, kinds, triangles);
    malloc_trim(0);  // what the making took is not what the files take
    for (Kind& kind : kinds) kind.mebibytes = mebibytesFor(kind.file);
    for (int turn = 0; turn < 5; turn++) {
        for (Kind& kind : kinds) kind.milliseconds.push_back(openOnce(kind.file));
    }
    std::printf("%zu triangles\n%-18s %10s %8s %8s %6s %6s\n", triangles, "kind", "bytes", "median", "fastest", "share", "MiB");
    for (Kind& kind : kinds) {
        std::sort(kind.milliseconds.begin(), kind.milliseconds.end());
        std::printf("%-18s %10zu %8.0f %8.0f %6.2f %6.0f\n", kind.name, kind.bytes, kind.milliseconds[2], kind.milliseconds[0],
                    kind.milliseconds[0] / kinds.front().milliseconds.front(), kind.mebibytes);
    }
}
