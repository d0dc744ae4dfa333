#include "backends/jack_clients.h"

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <utility>

#if defined(TACTUS_HAS_JACK)
#include <jack/jack.h>
#endif

#include "backends/library_calls.h"

namespace tactus {
namespace {

std::mutex clients_mutex;
std::condition_variable clients_changed;
int clients_held = 0;
int clients_calling = 0;      ///< of those held: they open or close a client
bool server_is_dead = false;  ///< that of the clients held

}  // namespace

std::unique_ptr<JackClientHold> JackClientHold::acquire() {
  std::unique_lock lock{clients_mutex};
  const auto may_open = [] { return clients_calling == 0 && !server_is_dead; };
  if (!clients_changed.wait_for(lock, std::chrono::seconds{1}, may_open)) return nullptr;
  ++clients_held;
  ++clients_calling;
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
  hold->opened();
  return hold;
#else
  auto hold = acquire();
  if (hold) hold->opened();
  return hold;
#endif
}

void JackClientHold::opened() {
  const std::lock_guard lock{clients_mutex};
  if (std::exchange(calls_, false)) --clients_calling;
  clients_changed.notify_all();
}

void JackClientHold::closing() {
  const std::lock_guard lock{clients_mutex};
  if (!std::exchange(calls_, true)) ++clients_calling;
}

JackClientHold::~JackClientHold() {
#if defined(TACTUS_HAS_JACK)
  closing();
  if (watch_ != nullptr) jack_client_close(watch_);
#endif
  const std::lock_guard lock{clients_mutex};
  if (calls_) --clients_calling;
  if (--clients_held == 0) server_is_dead = false;
  clients_changed.notify_all();
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
