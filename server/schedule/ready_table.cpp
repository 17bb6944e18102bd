#include "server/schedule/ready_table.h"

#include <algorithm>
#include <limits>

namespace heliograph {

void ReadyTable::reset(double begin, double span) {
    begin_ = begin;
    span_ = std::max(span, 1e-9);
    slots_.fill({});
}

size_t ReadyTable::slotOf(double time) const {
    const double at = (time - begin_) / span_ * SLOTS;
    return at < SLOTS ? static_cast<size_t>(std::max(at, 0.0)) : SLOTS;
}

void ReadyTable::change(double rate, double weighted, double ready) {
    Slot& slot = slots_[slotOf(ready)];
    slot.rate += rate;
    slot.weighted += weighted - rate * begin_;  // small numbers keep their digits
}

double ReadyTable::end(double work, double now) const {
    const double past = std::max(0.0, now - begin_);
    const size_t current = slotOf(now);
    double rates = 0.0, weighted = 0.0, end = std::numeric_limits<double>::infinity();
    for (size_t i = 0; i <= SLOTS; i++) {
        // Those that were ready before now start now.
        if (i > current && end <= span_ * static_cast<double>(i) / SLOTS) break;
        const Slot& slot = slots_[i];
        if (slot.rate <= 0.0) continue;
        rates += slot.rate;
        weighted += i < current ? slot.rate * past : std::max(slot.weighted, i == current ? slot.rate * past : 0.0);
        end = (work + weighted) / rates;
    }
    return begin_ + end;
}

}  // namespace heliograph
