#include "server/base/progress_bar.h"

#include "server/base/clock.h"
#include "server/base/text.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace heliograph {

ProgressBar::ProgressBar() : terminal_(isatty(STDERR_FILENO) != 0) {}

ProgressBar::~ProgressBar() {
    if (drawn_) std::fputs("\r\033[K", stderr);
}

Progress ProgressBar::progress() {
    if (!terminal_) return {};
    return [this](const std::string& what, double share) { draw(what, share); };
}

void ProgressBar::draw(const std::string& what, double share) {
    constexpr int WIDTH = 40;
    constexpr double INTERVAL = 0.1;  // seconds
    double now = wallSeconds();
    if (what == lastWhat_ && now - lastDrawn_ < INTERVAL) return;
    lastDrawn_ = now;
    lastWhat_ = what;
    drawn_ = true;
    auto filled = static_cast<int>(std::clamp(share, 0.0, 1.0) * WIDTH);
    std::string bar(static_cast<size_t>(filled), '#');
    std::fprintf(stderr, "\r\033[K[%-*s] %3.0f%% %s", WIDTH, bar.c_str(), 100.0 * std::clamp(share, 0.0, 1.0),
                 oneLine(what).c_str());
    std::fflush(stderr);
}

}  // namespace heliograph
