#include "server/net/listen/descriptors.h"

#include <sys/resource.h>

#include <algorithm>

namespace heliograph {

size_t raiseDescriptorLimit(size_t wanted) {
    rlimit limit{};
    if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return wanted;
    if (limit.rlim_cur < wanted) {
        rlimit raised = limit;
        raised.rlim_cur = std::min<rlim_t>(wanted, limit.rlim_max);
        if (setrlimit(RLIMIT_NOFILE, &raised) == 0) limit = raised;
    }
    return static_cast<size_t>(std::min<rlim_t>(limit.rlim_cur, 1u << 20));
}

}  // namespace heliograph
