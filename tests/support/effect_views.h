#pragma once
// Settings that show each effect in the scene made for it, for comparisons between devices.

#include <string>
#include <vector>

namespace heliograph::test {

struct EffectView {
    std::string scene;
    std::vector<std::string> set;  // NAME=VALUE
};

inline std::vector<EffectView> effectViews() {
    return {{"effects/soft-shadows", {}},
            {"effects/depth-of-field", {"depthOfField=true", "aperture=0.2"}},
            {"effects/fog", {"fog=true"}},
            {"effects/glossy", {"glossyReflections=true"}},
            {"effects/motion-blur", {"motionBlur=true"}},
            {"effects/indirect-light", {"indirectLight=true"}},
            {"effects/image-light", {"glossyReflections=true"}},
            {"effects/image-light", {"integrator=path"}},
            {"effects/image-light", {"integrator=path", "russianRoulette=2"}},
            {"effects/layers", {}},
            {"effects/layers", {"glossyReflections=true", "indirectLight=true"}},
            {"effects/layers", {"integrator=path"}},
            {"effects/layers", {"ground=true"}},
            {"effects/shapes", {}},
            {"effects/shapes", {"integrator=path"}},
            {"courtyard", {"textureFilter=anisotropic"}}};
}

}  // namespace heliograph::test
