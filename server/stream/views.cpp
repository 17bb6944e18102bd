#include "server/stream/views.h"

#include "server/net/guard/token.h"

#include <algorithm>

namespace heliograph {

std::shared_ptr<View> Views::open(SessionHost& host, const Settings& defaults, const SettingCaps& caps) {
    std::string id = randomSecret();
    uint32_t number;
    {
        std::lock_guard lock(mutex_);
        number = ++last_;
    }
    auto view = std::make_shared<View>(host, number, id, defaults, caps);
    std::lock_guard lock(mutex_);
    std::erase_if(entries_, [](const Entry& entry) { return entry.view.expired(); });  // that nobody could enter
    entries_.push_back({std::move(id), view});
    return view;
}

std::shared_ptr<View> Views::find(std::string_view id) const {
    std::lock_guard lock(mutex_);
    // All are compared, in equal time: how long it takes says nothing of how much was guessed right.
    const Entry* found = nullptr;
    for (const Entry& entry : entries_) {
        if (sameSecret(id, entry.id)) found = &entry;
    }
    return found ? found->view.lock() : nullptr;
}

void Views::remove(const View& view) {
    std::lock_guard lock(mutex_);
    std::erase_if(entries_, [&](const Entry& entry) { return entry.id == view.id(); });
}

size_t Views::count() const {
    std::lock_guard lock(mutex_);
    return entries_.size();
}

}  // namespace heliograph
