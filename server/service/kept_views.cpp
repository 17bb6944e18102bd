#include "server/service/kept_views.h"

#include <algorithm>

namespace heliograph {

KeptViews::Views KeptViews::keep(std::shared_ptr<View> view, Clock::time_point until, size_t most) {
    // Who comes and goes again has one place.
    std::erase_if(entries_, [&](const Entry& entry) { return entry.view == view; });
    entries_.push_back({std::move(view), until});
    Views tooMany;
    while (entries_.size() > most) {
        tooMany.push_back(std::move(entries_.front().view));
        entries_.erase(entries_.begin());
    }
    return tooMany;
}

KeptViews::Views KeptViews::over(Clock::time_point now) {
    Views ended;
    std::erase_if(entries_, [&](Entry& entry) {
        if (entry.until > now) return false;
        ended.push_back(std::move(entry.view));
        return true;
    });
    return ended;
}

KeptViews::Views KeptViews::all() {
    Views views;
    for (Entry& entry : entries_) views.push_back(std::move(entry.view));
    entries_.clear();
    return views;
}

}  // namespace heliograph
