#include "backends/jack/client_hold.h"

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <utility>

namespace tactus::jack {
namespace {

std::mutex clients_mutex;
std::condition_variable clients_changed;
int clients_held = 0;
int clients_calling = 0;      ///< of those held: they are being opened or closed
bool server_is_dead = false;  ///< that of the clients held

}  // namespace

std::unique_ptr<ClientHold> ClientHold::acquire() {
  std::unique_lock lock{clients_mutex};
  const auto may_open = [] { return clients_calling == 0 && !server_is_dead; };
  if (!clients_changed.wait_for(lock, std::chrono::seconds{1}, may_open)) return nullptr;
  ++clients_held;
  ++clients_calling;
  return std::unique_ptr<ClientHold>{new ClientHold};
}

void ClientHold::opened() {
  const std::lock_guard lock{clients_mutex};
  if (std::exchange(calls_, false)) --clients_calling;
  clients_changed.notify_all();
}

void ClientHold::closing() {
  const std::lock_guard lock{clients_mutex};
  if (!std::exchange(calls_, true)) ++clients_calling;
}

ClientHold::~ClientHold() {
  const std::lock_guard lock{clients_mutex};
  if (calls_) --clients_calling;
  if (--clients_held == 0) server_is_dead = false;
  clients_changed.notify_all();
}

void note_server_death() {
  const std::lock_guard lock{clients_mutex};
  server_is_dead = clients_held > 0;
}

}  // namespace tactus::jack
