#include "server/render/turns.h"

#include <algorithm>

namespace heliograph {

Turns::Turn::Turn(Turns& turns, Account& account) : turns_(&turns), account_(&account), begin_(turns.clock_()) {}

Turns::Turn::Turn(Turn&& other) noexcept : turns_(other.turns_), account_(other.account_), begin_(other.begin_) {
    other.turns_ = nullptr;
}

Turns::Turn::~Turn() {
    if (!turns_) return;
    turns_->release(*account_, turns_->clock_() - begin_);
}

std::optional<Turns::Turn> Turns::take(Account& account, std::stop_token stop, Urgency urgency) {
    std::unique_lock lock(mutex_);
    std::condition_variable_any called;
    const double start = std::max(now_, account.finish_);
    waiting_.push_back({&account, start, placeInLine(start, urgency), &called});
    const bool mine = called.wait(lock, stop, [&] {
        wakeUps_++;
        return !holder_ && next()->account == &account;
    });
    const auto self = std::find_if(waiting_.begin(), waiting_.end(), [&](const Waiter& w) { return w.account == &account; });
    if (mine) {
        now_ = self->start;
        holder_ = &account;
        heldSince_ = clock_();
    }
    waiting_.erase(self);
    if (mine) return Turn(*this, account);
    // One who leaves may have been the next in line.
    callNext();
    return std::nullopt;
}

/// With the lock held: the one who is next is woken, and nobody else.
void Turns::callNext() {
    if (!holder_ && !waiting_.empty()) next()->called->notify_one();
}

const Turns::Waiter* Turns::next() const {
    return &*std::min_element(waiting_.begin(), waiting_.end(),
                              [](const Waiter& a, const Waiter& b) { return a.place < b.place; });
}

void Turns::release(Account& account, double seconds) {
    std::lock_guard lock(mutex_);
    account.used_ += seconds;
    account.finish_ = now_ + seconds;
    all_ += seconds;
    if (latest_.account != &account) before_ = latest_;
    latest_ = {&account, clock_()};
    holder_ = nullptr;
    callNext();
}

bool Turns::shared(const Account& account) const {
    constexpr double RECENT = 0.5;  // seconds
    std::lock_guard lock(mutex_);
    if (!waiting_.empty()) return true;
    const Past& other = latest_.account == &account ? before_ : latest_;
    return other.account != nullptr && other.account != &account && clock_() - other.end < RECENT;
}

size_t Turns::waiting() const {
    std::lock_guard lock(mutex_);
    return waiting_.size();
}

uint64_t Turns::wakeUps() const {
    std::lock_guard lock(mutex_);
    return wakeUps_;
}

Turns::Used Turns::used(const Account& account) const {
    std::lock_guard lock(mutex_);
    return {account.used_, all_};
}

std::optional<double> Turns::held(const Account& account) const {
    std::lock_guard lock(mutex_);
    return holder_ == &account ? std::optional(clock_() - heldSince_) : std::nullopt;
}

}  // namespace heliograph
