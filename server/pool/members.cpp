#include "server/pool/members.h"

#include "server/base/text.h"

namespace heliograph {

namespace {

constexpr double TELL_AGAIN = 5.0;  // seconds between refusals

}  // namespace

std::string shownText(const std::string& text) { return oneLine(text.substr(0, 80)); }

Members::News Members::note(const NodeBeat& beat, double now) {
    News news;
    auto found = members_.find(beat.id);
    if (found == members_.end()) {
        if (members_.size() >= MOST) return news;
        Member member{++lastNumber_, beat, now, now, {}};
        if (beat.build != build_)
            member.refused = "is of another build (" + hexOf(beat.build, 6) + ", this head is " + hexOf(build_, 6) +
                             "): pictures could differ";
        found = members_.emplace(beat.id, std::move(member)).first;
        byNumber_[found->second.number] = beat.id;
        if (found->second.refused.empty()) news.joined = &found->second;
    }
    Member& member = found->second;
    member.beat = beat;
    member.heard = now;
    if (!member.refused.empty() && now - member.told >= TELL_AGAIN) {
        member.told = now;
        news.refused = &member;
    }
    return news;
}

std::vector<Member> Members::dropSilent(double now) {
    std::vector<Member> gone;
    std::erase_if(members_, [&](const auto& entry) {
        if (now - entry.second.heard < SILENCE_SECONDS) return false;
        byNumber_.erase(entry.second.number);
        gone.push_back(entry.second);
        return true;
    });
    return gone;
}

std::vector<Member> Members::dropAll() {
    std::vector<Member> gone = all();
    members_.clear();
    byNumber_.clear();
    return gone;
}

std::optional<Member> Members::drop(uint32_t number) {
    const auto found = byNumber_.find(number);
    if (found == byNumber_.end()) return std::nullopt;
    Member member = std::move(members_.extract(found->second).mapped());
    byNumber_.erase(found);
    return member;
}

const Member* Members::renders(uint32_t number) const {
    const auto found = byNumber_.find(number);
    if (found == byNumber_.end()) return nullptr;
    const Member& member = members_.at(found->second);
    return member.refused.empty() ? &member : nullptr;
}

std::vector<Member> Members::all() const {
    std::vector<Member> list;
    for (const auto& [number, id] : byNumber_) list.push_back(members_.at(id));
    return list;
}

}  // namespace heliograph
