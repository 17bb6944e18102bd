#include "tests/support/places.h"

namespace heliograph {

std::filesystem::path sourceFolder() { return HELIOGRAPH_SOURCE_DIR; }

std::filesystem::path sharedScenes() { return sourceFolder().parent_path() / "shared/scenes"; }

}  // namespace heliograph
