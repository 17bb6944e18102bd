#include "server/scene/generate/cathedral_parts.h"

#include <cmath>

namespace heliograph::generate::cathedral {

namespace {

/// A bar of rectangular section around an arch.
void addBar(MeshWriter& writer, const Arch& arch, float halfWidth, float halfDepth, uint32_t steps) {
    addArchMoulding(writer, arch,
                    {{-halfWidth, -halfDepth}, {-halfWidth, halfDepth}, {halfWidth, halfDepth}, {halfWidth, -halfDepth},
                     {-halfWidth, -halfDepth}},
                    steps);
}

/// The pane: a sheet of leaded glass in the window's shape, its edge in the stone. uv run over the whole window.
void addPane(MeshWriter& writer, const Window& window) {
    const Arch arch = window.arch.offset(0.04f);
    const float bottom = window.sill - 0.04f, top = window.springing + arch.rise(), half = arch.halfSpan;
    auto corner = [&](vec2 p) {
        return writer.vertex({p.x, p.y, 0.0f}, {0, 0, 1},
                             {(p.x + half) / (2.0f * half), (p.y - bottom) / (top - bottom)});
    };
    const Polyline line = arch.outline(7);
    uint32_t previousLow = 0, previous = 0;
    for (size_t i = 0; i < line.size(); ++i) {
        const uint32_t low = corner({line[i].x, bottom}), high = corner(line[i] + vec2(0.0f, window.springing));
        if (i > 0) writer.quad(previousLow, low, high, previous);
        previousLow = low, previous = high;
    }
}

/// Two lights under a ring.
void addTracery(MeshWriter& writer, const Window& window) {
    const float half = window.arch.halfSpan, sub = 0.5f * half;
    const Arch light = {sub - 0.05f, 1.3f * sub};
    const mat4 at = writer.transform();
    addBox(writer, {-0.055f, window.sill - 0.03f, -0.10f}, {0.055f, window.springing + 0.04f, 0.10f},
           BOX_LEFT | BOX_RIGHT | BOX_FRONT | BOX_BACK);
    addBox(writer, {-0.12f, window.springing - 0.10f, -0.13f}, {0.12f, window.springing + 0.05f, 0.13f});
    for (float side : {-1.0f, 1.0f}) {
        writer.setTransform(at * placed({side * sub, window.springing, 0.0f}));
        addBar(writer, light, 0.045f, 0.08f, 4);
        const float jamb = side * half;
        writer.setTransform(at);
        addBox(writer, {jamb - 0.09f, window.sill - 0.03f, -0.09f}, {jamb + 0.09f, window.springing + 0.03f, 0.09f},
               BOX_LEFT | BOX_RIGHT | BOX_FRONT | BOX_BACK | BOX_TOP);
    }
    // The ring sits where it touches both lights and the window's head.
    const float radius = 0.40f * half, y = window.springing + window.arch.rise() - 1.55f * radius;
    writer.setTransform(at * placed({0.0f, y, 0.0f}) * glm::rotate(mat4(1.0f), glm::radians(90.0f), vec3(1, 0, 0)));
    addLathe(writer,
             {{radius + 0.04f, -0.07f}, {radius + 0.04f, 0.07f}, {radius - 0.05f, 0.07f}, {radius - 0.05f, -0.07f}},
             {.segments = 12, .creaseDegrees = 20.0f, .closed = true, .textureSize = 0.5f});
    writer.setTransform(at);
}

}  // namespace

void addWindowPanel(MeshWriter& writer, const Materials& materials, float x0, float x1, float y0, float y1, float half,
                    const Window& window) {
    const mat4 at = writer.transform();
    writer.setMaterial(materials.ashlar);
    addArchedPanel(writer, {.x0 = x0,
                            .x1 = x1,
                            .y0 = y0,
                            .y1 = y1,
                            .back = -half,
                            .front = half,
                            .arch = window.arch,
                            .center = window.center,
                            .springing = window.springing,
                            .sill = window.sill,
                            .steps = 7});
    writer.setTransform(at * placed({window.center, 0.0f, 0.0f}));
    Window centered = window;
    centered.center = 0.0f;
    writer.setMaterial(window.glass);
    addPane(writer, centered);
    writer.setMaterial(materials.stone);
    if (window.tracery) addTracery(writer, centered);
    writer.setTransform(at * placed({window.center, window.springing, 0.0f}));
    addArchMoulding(writer, window.arch,
                    {{-0.02f, half - 0.10f}, {-0.02f, half + 0.02f}, {0.05f, half + 0.05f}, {0.12f, half + 0.04f},
                     {0.14f, half - 0.02f}},
                    6, window.springing - window.sill);
    writer.setTransform(at);
}

}  // namespace heliograph::generate::cathedral
