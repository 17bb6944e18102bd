#include "server/stream/views.h"

#include "server/net/guard/token.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <stdexcept>

namespace heliograph {

std::string randomViewId() {
    std::array<unsigned char, 16> bytes;
    if (::getentropy(bytes.data(), bytes.size()) != 0)
        throw std::runtime_error("the system has no random numbers for a view's id");
    std::string id;
    for (unsigned char byte : bytes) {
        id += "0123456789abcdef"[byte >> 4];
        id += "0123456789abcdef"[byte & 15];
    }
    return id;
}

std::shared_ptr<View> Views::open(SessionHost& host, const Settings& defaults, const SettingCaps& caps) {
    std::string id = randomViewId();
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
