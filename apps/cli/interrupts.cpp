#include "apps/cli/interrupts.h"

#include <csignal>

namespace tactus::app {
namespace {

volatile std::sig_atomic_t signalled = 0;
extern "C" void note_signal(int) { signalled = 1; }

}  // namespace

void install_signal_handlers([[maybe_unused]] bool also_hangup) {
  std::signal(SIGINT, note_signal);
  std::signal(SIGTERM, note_signal);
#if defined(SIGHUP)
  if (!also_hangup) return;
  std::signal(SIGHUP, note_signal);
  std::signal(SIGQUIT, note_signal);
  std::signal(SIGPIPE, SIG_IGN);
#endif
}

bool interrupted() { return signalled != 0; }

}  // namespace tactus::app
