#pragma once
// The program's version.

namespace heliograph {

/// "MAJOR.MINOR.PATCH" of CMakeLists.txt.
const char* programVersion();

}  // namespace heliograph
