#include "apps/cli/version.h"

namespace tactus::app {

const char* version() { return "tactus " TACTUS_VERSION; }

}  // namespace tactus::app
