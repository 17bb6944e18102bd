#include "server/base/version.h"

namespace heliograph {

const char* programVersion() { return HELIOGRAPH_VERSION; }

}  // namespace heliograph
