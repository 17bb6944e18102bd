#pragma once

namespace heliograph {

/// Drivers register destructors for the data of each thread that has called them. A thread that ends when its driver has been unloaded
/// with the last instance would jump into nothing, so what is loaded now stays until the process ends.
void keepLibraries();

}  // namespace heliograph
