#pragma once

namespace tactus::app {

/// From now on Ctrl-C and SIGTERM are only noted, and `interrupted` tells of it.
void heed_interrupts();
bool interrupted();

}  // namespace tactus::app
