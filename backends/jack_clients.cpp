#include "backends/jack_clients.h"

#include <mutex>

#if defined(TACTUS_HAS_JACK)
#include <jack/jack.h>
#endif

#include "backends/library_calls.h"

namespace tactus {
namespace {

std::mutex clients_mutex;
int clients_held = 0;
bool server_is_dead = false;  ///< that of the clients held

}  // namespace

std::unique_ptr<JackClientHold> JackClientHold::acquire() {
  const std::lock_guard lock{clients_mutex};
  if (server_is_dead) return nullptr;
  ++clients_held;
  return std::unique_ptr<JackClientHold>{new JackClientHold};
}

std::unique_ptr<JackClientHold> JackClientHold::acquire_watched([[maybe_unused]] const std::string& name) {
#if defined(TACTUS_HAS_JACK)
  auto hold = acquire();
  if (!hold) return nullptr;
  silence_library_logs();
  hold->watch_ = jack_client_open(name.c_str(), JackNoStartServer, nullptr);
  if (hold->watch_ == nullptr) return nullptr;
  jack_on_info_shutdown(
      hold->watch_, [](jack_status_t, const char*, void*) { note_jack_server_death(); }, nullptr);
  return hold;
#else
  return acquire();
#endif
}

JackClientHold::~JackClientHold() {
#if defined(TACTUS_HAS_JACK)
  if (watch_ != nullptr) jack_client_close(watch_);
#endif
  const std::lock_guard lock{clients_mutex};
  if (--clients_held == 0) server_is_dead = false;
}

void note_jack_server_death() {
  const std::lock_guard lock{clients_mutex};
  server_is_dead = clients_held > 0;
}

bool jack_clients_must_close() {
  const std::lock_guard lock{clients_mutex};
  return server_is_dead;
}

}  // namespace tactus
