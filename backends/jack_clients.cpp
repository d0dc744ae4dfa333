#include "backends/jack_clients.h"

#include <mutex>

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

JackClientHold::~JackClientHold() {
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
