#include "server/scene/object_names.h"

#include <algorithm>

namespace heliograph {

uint32_t ObjectNames::indexOf(const std::string& name) {
    const auto [found, isNew] = indices_.try_emplace(name, static_cast<uint32_t>(names_.size()));
    if (isNew) names_.push_back(name);
    return found->second;
}

void ObjectNames::addTriangles(uint32_t firstTriangle, const std::string& name) {
    runs_.push_back({firstTriangle, indexOf(name)});
}

void ObjectNames::addInstance(uint32_t instance, const std::string& name) {
    if (instances_.empty()) firstInstance_ = instance;
    instances_.push_back(indexOf(name));
}

const std::string& ObjectNames::of(uint32_t instance, uint32_t triangle) const {
    static const std::string none;
    if (!instances_.empty() && instance >= firstInstance_) {
        const size_t at = instance - firstInstance_;
        return at < instances_.size() ? names_[instances_[at]] : none;
    }
    const auto after = std::ranges::upper_bound(runs_, triangle, {}, &Run::first);
    return after == runs_.begin() ? none : names_[std::prev(after)->name];
}

}  // namespace heliograph
