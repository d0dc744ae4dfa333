#include "backends/jack/client_hold.h"

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <utility>

namespace tactus::jack {
namespace {

struct Clients {
  std::mutex mutex;
  std::condition_variable changed;
  int held = 0;
  int calling = 0;              ///< of those held: they are being opened or closed
  bool server_is_dead = false;  ///< that of the clients held
};

/// Never destroyed: a client that hangs may be closed when the program ends.
Clients& clients() {
  static auto& all = *new Clients;
  return all;
}

}  // namespace

std::unique_ptr<ClientHold> ClientHold::acquire() {
  auto& all = clients();
  std::unique_lock lock{all.mutex};
  const auto may_open = [&] { return all.calling == 0 && !all.server_is_dead; };
  if (!all.changed.wait_for(lock, std::chrono::seconds{1}, may_open)) return nullptr;
  ++all.held;
  ++all.calling;
  return std::unique_ptr<ClientHold>{new ClientHold};
}

void ClientHold::opened() {
  auto& all = clients();
  const std::lock_guard lock{all.mutex};
  if (std::exchange(calls_, false)) --all.calling;
  all.changed.notify_all();
}

void ClientHold::closing() {
  auto& all = clients();
  const std::lock_guard lock{all.mutex};
  if (!std::exchange(calls_, true)) ++all.calling;
}

ClientHold::~ClientHold() {
  auto& all = clients();
  const std::lock_guard lock{all.mutex};
  if (calls_) --all.calling;
  if (--all.held == 0) all.server_is_dead = false;
  all.changed.notify_all();
}

void note_server_death() {
  auto& all = clients();
  const std::lock_guard lock{all.mutex};
  all.server_is_dead = all.held > 0;
}

}  // namespace tactus::jack
