// Who looks at a view: coming, leaving, and who of them drives.

#include "server/stream/view.h"

#include "server/net/guard/token.h"

#include <algorithm>

namespace heliograph {

void View::join(Viewer& viewer, std::optional<uint32_t> inputId, const SeatKeys& keys) {
    std::lock_guard lock(mutex_);
    if (ended_) throw InputError("watch.view", "nobody looks at it any more", "a view that somebody looks at");
    const size_t place = vacate(keys.former);
    Seat& seat = *seats_.insert(seats_.begin() + static_cast<ptrdiff_t>(place),
                                Seat{&viewer, keys.own, inputId.value_or(0), request_.settings.jpegQuality, {}, {}});
    viewer.setQuality(seat.quality);
    if (place == 0) {
        request_.viewer = viewer.number();
        request_.inputId = seat.inputId;
    }
    if (inputId) tellRole(seat, inputId);
    tellSettings(seat, std::nullopt);
    tellScene(viewer);
    if (playing_) viewer.say(pathMessage(true, std::nullopt));
    if (place > 0) loop_.offerAgain();
    else if (inputId) show();  // somebody comes back
}

/// The place that is free for who comes: the last one, or that of the viewer who holds this key and comes back on another
/// connection before its old one was found to be broken. That one looks no more.
size_t View::vacate(std::string_view key) {
    const auto former =
        std::ranges::find_if(seats_, [&](const Seat& seat) { return !key.empty() && sameSecret(key, seat.key); });
    const auto place = static_cast<size_t>(former - seats_.begin());
    if (former == seats_.end()) return place;
    Viewer& viewer = *former->viewer;
    seats_.erase(former);
    if (pictureAsked_ && pictureAsked_->viewer == viewer.number()) forgetPicture();
    viewer.dropPicture();
    viewer.close(CloseCode::normal, "the viewer came back on another connection");
    if (place == 0) rest();
    return place;
}

bool View::leave(Viewer& viewer) {
    std::lock_guard lock(mutex_);
    if (!seatOf(viewer.number())) return false;
    const bool drove = seats_.front().viewer == &viewer;
    std::erase_if(seats_, [&](const Seat& seat) { return seat.viewer == &viewer; });
    if (pictureAsked_ && pictureAsked_->viewer == viewer.number()) forgetPicture();
    if (viewer.dropPicture())
        viewer.say(errorMessage("picture: the view was left before it was finished", "picture", std::nullopt));
    if (seats_.empty()) {
        rest();
        return true;
    }
    if (drove) promote(seats_.front());
    return false;
}

/// As long as nobody looks.
void View::rest() {
    newest_.reset();
    dropMeasurements();
    request_.moving = false;
    if (playing_) loop_.playPath(false);
}

bool View::end() {
    std::shared_ptr<void> ticket;  // goes after the lock
    std::lock_guard lock(mutex_);
    if (!seats_.empty() || ended_) return false;
    stop();
    std::swap(ticket, sceneTicket_);
    return true;
}

/// From now on it drives.
void View::promote(Seat& seat, std::optional<uint32_t> inputId) {
    dropMeasurements();
    request_.viewer = seat.viewer->number();
    request_.inputId = seat.inputId;
    request_.settings.jpegQuality = seat.quality;
    request_.moving = false;  // who moved does not drive any more
    tellRole(seat, inputId);
    show();
}

void View::stay(const Viewer& viewer, uint32_t inputId) {
    std::lock_guard lock(mutex_);
    Seat* seat = seatOf(viewer.number());
    if (!seat) return;
    seat->inputId = inputId;
    tellRole(*seat, inputId);
    if (seat != &seats_.front()) return loop_.offerAgain();
    request_.inputId = inputId;
    show();
}

bool View::drives(const Viewer& viewer) const {
    std::lock_guard lock(mutex_);
    return !seats_.empty() && seats_.front().viewer == &viewer;
}

View::Seat* View::seatOf(uint32_t viewer) {
    auto found = std::ranges::find_if(seats_, [&](const Seat& seat) { return seat.viewer->number() == viewer; });
    return found == seats_.end() ? nullptr : &*found;
}

/// The seat of who drives. Throws InputError for anybody else.
View::Seat& View::driver(const Viewer& viewer, const char* about) {
    if (seats_.empty() || seats_.front().viewer != &viewer) {
        throw InputError(about, "this view is driven by another viewer",
                         "in a view of your own, which `watch` without `view` leads to");
    }
    return seats_.front();
}

void View::handle(Viewer& viewer, const DriveMessage& message) {
    std::lock_guard lock(mutex_);
    Seat* seat = seatOf(viewer.number());
    if (!seat) return;
    if (!message.viewer) return ask(*seat, message.inputId);
    driver(viewer, DriveMessage::TYPE);
    Seat* next = seatOf(*message.viewer);
    if (!next || next == seat) {
        throw InputError("drive.viewer", std::to_string(*message.viewer),
                         "the number of a viewer that watches this view, as `driveAsked` tells it");
    }
    if (message.refuse) {
        if (next->asked) tellRole(*next, next->asked);
        next->asked.reset();
    } else {
        handOver(*next, message.inputId);
    }
}

/// It wants to drive: who drives is told, once until that one has answered.
void View::ask(Seat& seat, uint32_t inputId) {
    seat.inputId = inputId;
    if (&seat == &seats_.front()) {
        request_.inputId = inputId;
        tellRole(seat, inputId);
        return show();
    }
    if (!seat.asked) seats_.front().viewer->say(driveAskedMessage(seat.viewer->number()));
    seat.asked = inputId;
    loop_.offerAgain();
}

/// From who drives to one who watches; who drove watches, and is the next to drive when that one leaves. `inputId`: of the
/// driver's message.
void View::handOver(Seat& next, uint32_t inputId) {
    dropEffectCosts("the view was handed over before they were measured");
    giveUpAccuracy();
    const std::optional<uint32_t> asked = next.asked;
    seats_.front().inputId = inputId;
    const auto place = seats_.begin() + (&next - seats_.data());
    std::rotate(seats_.begin(), place, place + 1);
    for (Seat& seat : seats_) seat.asked.reset();
    promote(seats_.front(), asked);
    tellRole(seats_[1], inputId);
    loop_.offerAgain();
}

}  // namespace heliograph
