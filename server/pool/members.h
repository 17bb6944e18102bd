#pragma once
// Who is in the pool, as a head sees it. Pure: time is an argument, in seconds on one clock.

#include "server/pool/wire/messages.h"

#include <map>
#include <optional>
#include <vector>

namespace heliograph {

/// A node that has been heard.
struct Member {
    uint32_t number = 0;  // of its stay: who leaves and comes back gets another one
    NodeBeat beat;        // its last
    double joined = 0.0;
    double heard = 0.0;
    std::string refused;  // why it may not render; empty: it may
    double told = -1e9;   // when it was told so
};

class Members {
public:
    /// Most at once; beats of others are not looked at.
    static constexpr size_t MOST = 4096;

    explicit Members(const Digest& build) : build_(build) {}

    struct News {
        const Member* joined = nullptr;   // with this beat
        const Member* refused = nullptr;  // to be told so now
    };
    /// What is returned is valid until the next call.
    News note(const NodeBeat& beat, double now);
    /// Those that have been silent for SILENCE_SECONDS; they are members no more.
    std::vector<Member> dropSilent(double now);
    /// Nobody can be reached.
    std::vector<Member> dropAll();
    std::optional<Member> drop(uint32_t number);
    /// Null where there is none of that number, or it may not render.
    const Member* renders(uint32_t number) const;
    /// By number.
    std::vector<Member> all() const;

private:
    const Digest build_;
    std::map<PeerId, Member> members_;
    std::map<uint32_t, PeerId> byNumber_;
    uint32_t lastNumber_ = 0;
};

/// Text of a peer, as it is shown: of at most 80 bytes, on one line.
std::string shownText(const std::string& text);

}  // namespace heliograph
