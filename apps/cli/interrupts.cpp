#include "apps/cli/interrupts.h"

#include <csignal>

namespace tactus::app {
namespace {

volatile std::sig_atomic_t came = 0;
extern "C" void note_interrupt(int) { came = 1; }

}  // namespace

void heed_interrupts() {
  std::signal(SIGINT, note_interrupt);
  std::signal(SIGTERM, note_interrupt);
}

bool interrupted() { return came != 0; }

}  // namespace tactus::app
