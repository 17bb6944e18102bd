#pragma once
// Which objects of its file a scene's triangles belong to, for people: devices know nothing of it.

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace heliograph {

class ObjectNames {
public:
    /// Triangles from here on, up to the next call's, belong to this object. `firstTriangle` never falls.
    void addTriangles(uint32_t firstTriangle, const std::string& name);
    /// The instances from here on belong to one object each, in their order; those before it hold what addTriangles told of.
    void addInstance(uint32_t instance, const std::string& name);
    /// The object's name; "" where the file gives none.
    const std::string& of(uint32_t instance, uint32_t triangle) const;

private:
    struct Run {
        uint32_t first = 0;  // triangle
        uint32_t name = 0;   // index into names_
    };
    uint32_t indexOf(const std::string& name);

    std::vector<std::string> names_;  // each once
    std::map<std::string, uint32_t, std::less<>> indices_;
    std::vector<Run> runs_;            // ascending
    std::vector<uint32_t> instances_;  // names, from firstInstance_ on
    uint32_t firstInstance_ = 0;
};

}  // namespace heliograph
