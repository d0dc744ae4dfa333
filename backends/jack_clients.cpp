#include "backends/jack_clients.h"

#include <chrono>
#include <condition_variable>
#include <csignal>
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

/// Whether the server of a client that was just opened still answers. May hang. The library writes to the
/// server's socket.
bool answers([[maybe_unused]] _jack_client* client) {
#if defined(TACTUS_HAS_JACK)
#if !defined(_WIN32)
  sigset_t pipe;
  sigemptyset(&pipe);
  sigaddset(&pipe, SIGPIPE);
  pthread_sigmask(SIG_BLOCK, &pipe, nullptr);  // for good: this thread is of those that call the library
#endif
  char* id = jack_get_uuid_for_client_name(client, jack_get_client_name(client));
  jack_free(id);
  return id != nullptr;
#else
  return true;
#endif
}

/// Waits up to a second. False: nothing may be opened now.
bool begin_opening(std::unique_lock<std::mutex>& lock) {
  const auto may_open = [] { return clients_calling == 0 && !server_is_dead; };
  if (!clients_changed.wait_for(lock, std::chrono::seconds{1}, may_open)) return false;
  ++clients_calling;
  return true;
}

}  // namespace

std::unique_ptr<JackClientHold> JackClientHold::acquire() {
  std::unique_lock lock{clients_mutex};
  if (!begin_opening(lock)) return nullptr;
  ++clients_held;
  return std::unique_ptr<JackClientHold>{new JackClientHold};
}

std::unique_ptr<JackClientHold> JackClientHold::acquire_watched([[maybe_unused]] const std::string& name) {
  auto hold = acquire();
#if defined(TACTUS_HAS_JACK)
  if (!hold) return nullptr;
  silence_library_logs();
  hold->watch_ = jack_client_open(name.c_str(), JackNoStartServer, nullptr);
  if (hold->watch_ == nullptr) return nullptr;
  jack_on_info_shutdown(
      hold->watch_, [](jack_status_t, const char*, void*) { note_jack_server_death(); }, nullptr);
  if (!answers(hold->watch_)) note_jack_server_death();
#endif
  return hold;
}

bool JackClientHold::opening() {
  std::unique_lock lock{clients_mutex};
  calls_ = calls_ || begin_opening(lock);
  return calls_;
}

void JackClientHold::opened(_jack_client* client) {
  if (!calls_) return;
  // Of a death between the opening and the setting of the callback nobody is told.
  if (client != nullptr && !answers(client)) note_jack_server_death();
  const std::lock_guard lock{clients_mutex};
  calls_ = false;
  --clients_calling;
  clients_changed.notify_all();
}

void JackClientHold::closing() {
  std::unique_lock lock{clients_mutex};
  if (!calls_) {
    clients_changed.wait(lock, [] { return clients_calling == 0; });
    calls_ = true;
    ++clients_calling;
  }
}

JackClientHold::~JackClientHold() {
  closing();
#if defined(TACTUS_HAS_JACK)
  if (watch_ != nullptr) jack_client_close(watch_);
#endif
  const std::lock_guard lock{clients_mutex};
  --clients_calling;
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
