#pragma once
// The views of a server, by their ids. An id cannot be guessed: who knows it was given it by somebody who looks at the view. It
// opens that view and nothing else; where a token is asked for it does not replace it.

#include "server/stream/view.h"

namespace heliograph {

/// Safe from all threads. Keeps no view alive.
class Views {
public:
    /// A new view, which ends when the last one who looks has left it.
    std::shared_ptr<View> open(SessionHost& host, const Settings& defaults, const SettingCaps& caps);
    /// Nothing where no view that is looked at has this id.
    std::shared_ptr<View> find(std::string_view id) const;
    /// It has ended.
    void remove(const View& view);
    size_t count() const;

private:
    struct Entry {
        std::string id;
        std::weak_ptr<View> view;
    };
    mutable std::mutex mutex_;
    std::vector<Entry> entries_;
    uint32_t last_ = 0;
};

}  // namespace heliograph
