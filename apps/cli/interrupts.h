#pragma once
// Thread: [control]

namespace tactus::app {

/// From now on Ctrl-C and SIGTERM only set `interrupted`. `also_hangup`: a closed terminal too, and a closed
/// pipe does not end the program: for a program whose outputs must fade before it ends.
void install_signal_handlers(bool also_hangup = false);
bool interrupted();

}  // namespace tactus::app
