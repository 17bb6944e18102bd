#include "server/scene/load/gltf_shapes.h"

#include "server/base/error.h"
#include "server/scene/load/gltf_document.h"
#include "server/scene/load/gltf_textures.h"

#include <array>

namespace heliograph {

namespace {

/// What each kind may have beside a material, in the order of SHAPE_*.
struct KindOfShape {
    const char* name;
    bool radius, height;
};
constexpr std::array KINDS{KindOfShape{"sphere", true, false}, KindOfShape{"cylinder", true, true},
                           KindOfShape{"disc", true, false}, KindOfShape{"plane", false, false}};

}  // namespace

GltfShape readGltfShape(const tinygltf::Value& extension, const std::string& where, SceneBuilder& builder) {
    const std::string kind = extension.Get("kind").IsString() ? extension.Get("kind").Get<std::string>() : "";
    GltfShape shape;
    while (shape.form.kind < KINDS.size() && kind != KINDS[shape.form.kind].name) shape.form.kind++;
    if (shape.form.kind == KINDS.size())
        throw InputError(where + "/kind", "'" + kind.substr(0, 40) + "'", "sphere, cylinder, disc or plane");
    const KindOfShape& has = KINDS[shape.form.kind];
    const auto unused = [&](const char* property, bool used) {
        if (!used && extension.Has(property)) builder.warn(where + "/" + property + ": a " + kind + " has none, ignored");
    };
    unused("radius", has.radius);
    unused("height", has.height);
    unused("capped", has.height);
    const double radius = has.radius ? numberOf(extension, "radius", 1.0) : 1.0;
    shape.size = dvec3(radius, has.height ? 0.5 * numberOf(extension, "height", 1.0) : has.radius ? radius : 1.0, radius);
    const bool open = extension.Has("capped") && extension.Get("capped").IsBool() && !extension.Get("capped").Get<bool>();
    shape.form.capped = has.height && !open;
    shape.material = static_cast<int>(numberOf(extension, "material", -1.0));
    return shape;
}

}  // namespace heliograph
