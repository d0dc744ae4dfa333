#pragma once
// Thread: [control]

namespace tactus::app {

/// "tactus 0.1.0", as CMakeLists.txt has it.
const char* version();

}  // namespace tactus::app
