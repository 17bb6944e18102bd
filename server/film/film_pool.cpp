#include "server/film/film_pool.h"

#include "server/base/machine.h"

#include <algorithm>
#include <new>
#include <stdexcept>
#include <string>

namespace heliograph {

namespace {

[[noreturn]] void noMemory(uvec2 size) {
    throw std::runtime_error("no memory for " + std::to_string(size.x) + " x " + std::to_string(size.y) +
                             " pixels; a smaller window or render scale needs less");
}

}  // namespace

void resetWithRoom(Film& film, uvec2 resolution, uint32_t generation) {
    constexpr uint64_t LARGE = 1 << 20, BYTES = 64;  // pixels; of a pixel at most
    const uint64_t pixels = uint64_t{resolution.x} * resolution.y;
    const bool grows = pixels > uint64_t{film.resolution().x} * film.resolution().y;
    if (grows && pixels > LARGE && !areAddressesLeft(pixels * BYTES + ROOM_FOR_DRIVERS)) throw std::bad_alloc();
    film.reset(resolution, generation);
}

bool FilmPool::emptied(Film& film, uvec2 resolution, uint32_t generation) {
    try {
        reset_(film, resolution, generation);
        return true;
    } catch (const std::bad_alloc&) {
        return false;
    }
}

std::shared_ptr<Film> FilmPool::next(uvec2 resolution, uint32_t generation) {
    auto found = std::ranges::find_if(films_, [](const auto& film) { return film.use_count() == 1; });
    if (found == films_.end()) found = std::ranges::find(films_, nullptr);
    if (found == films_.end()) found = films_.begin();  // whoever holds it keeps it
    if (found->use_count() != 1) *found = std::make_shared<Film>();
    if (emptied(**found, resolution, generation)) return *found;
    std::ranges::replace_if(
        films_, [](const auto& film) { return film.use_count() == 1; }, nullptr);
    *found = std::make_shared<Film>();
    if (emptied(**found, resolution, generation)) return *found;
    noMemory(resolution);
}

std::shared_ptr<Film> FilmPool::extra(uvec2 resolution, uint32_t generation) {
    auto film = std::make_shared<Film>();
    if (emptied(*film, resolution, generation)) return film;
    noMemory(resolution);
}

}  // namespace heliograph
