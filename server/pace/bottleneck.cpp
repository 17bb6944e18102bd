#include "server/pace/bottleneck.h"

namespace heliograph {

const char* wordOf(Bottleneck bottleneck) {
    switch (bottleneck) {
        case Bottleneck::server: return "server";
        case Bottleneck::line: return "line";
        case Bottleneck::viewer: return "viewer";
        case Bottleneck::none: break;
    }
    return "none";
}

Bottleneck bottleneckOf(const PaceFigures& figures) {
    constexpr double LONG = 0.06;  // seconds
    if (figures.level > 0 || figures.lineDelay + figures.viewerDelay > LONG)
        return figures.lineDelay >= figures.viewerDelay ? Bottleneck::line : Bottleneck::viewer;
    if (figures.lowered) return Bottleneck::server;
    return figures.video ? Bottleneck::line : Bottleneck::none;
}

}  // namespace heliograph
