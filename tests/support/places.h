#pragma once
// Where the tests find files.

#include <filesystem>

namespace heliograph {

/// The root of the repository.
std::filesystem::path sourceFolder();

/// Real scenes for tests, beside the repository; may not be there: then a test skips and says so.
std::filesystem::path sharedScenes();

}  // namespace heliograph
