#pragma once
// The films of one view. While the encoder has one the next frame is rendered into another; a picture at full resolution may
// need a third, which is not kept.

#include "server/film/film.h"

#include <array>
#include <functional>
#include <memory>

namespace heliograph {

/// Film::reset; throws std::bad_alloc also where a film of more than a million pixels would leave fewer addresses than
/// ROOM_FOR_DRIVERS.
void resetWithRoom(Film& film, uvec2 resolution, uint32_t generation);

class FilmPool {
public:
    /// Films of one view at once, at most: what the memory for films has to be counted with.
    static constexpr uint32_t FILMS = 3;
    /// Makes a film empty; throws std::bad_alloc. Tests let it fail.
    using Reset = std::function<void(Film&, uvec2 resolution, uint32_t generation)>;

    explicit FilmPool(Reset reset = resetWithRoom) : reset_(std::move(reset)) {}

    /// An empty film that nobody else holds. Throws std::runtime_error, in words for people, when memory runs out.
    std::shared_ptr<Film> next(uvec2 resolution, uint32_t generation);
    /// The same, not of those that are kept.
    std::shared_ptr<Film> extra(uvec2 resolution, uint32_t generation);

private:
    bool emptied(Film& film, uvec2 resolution, uint32_t generation);

    Reset reset_;
    std::array<std::shared_ptr<Film>, 2> films_;
};

}  // namespace heliograph
