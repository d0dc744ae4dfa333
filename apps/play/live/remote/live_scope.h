#pragma once
// Thread: [control, one thread] unless stated otherwise.

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "engine/runtime/player.h"
#include "engine/runtime/signal_scope.h"
#include "remote/remote.h"

namespace tactus::app {

/// The scope of a session: signals of its instrument and, where there is one, of its simulated plant, whose
/// names begin with "plant/". Also the levels of all signals, a few at a time.
class LiveScope {
 public:
  struct Signal {
    int player = 0;  ///< 0: the instrument, 1: the plant
    std::string name;
    ScopeSignal of;
  };

  /// [control & stopped] `plant`: or nullptr. Both outlive it.
  LiveScope(Player& instrument, Player* plant);
  ~LiveScope();

  /// Of the versions of the graphs that were there when `tick` was called last.
  const std::vector<Signal>& signals() const { return signals_; }
  /// Highest sample of each signal of late; empty where they are not asked for.
  const std::vector<double>& levels() const { return levels_; }
  /// Obeys the orders that came, and follows edits: true where the signals are others now.
  bool tick();

  /// [any, the network thread]
  void order(std::uint32_t id, int bin, std::vector<std::string> names);
  void order_levels(bool on);
  bool take(ScopeChunk& chunk);
  /// [any]
  std::shared_ptr<const RemoteScope> shown() const;

 private:
  struct Order {
    std::uint32_t id = 0;
    int bin = 1;
    std::vector<std::string> names;
  };
  /// Where the traces of the players lie among those that were asked for.
  struct Layout {
    std::uint32_t id = 0;
    std::array<std::vector<int>, 2> places;
  };
  /// The scopes of one player.
  struct Half {
    Player* player = nullptr;
    SignalScope scope, levels{16};
    std::uint64_t version = 0;          ///< of the graph, whose signals are known
    std::size_t next_level = 0;         ///< of its own signals
    std::vector<std::size_t> measured;  ///< signals whose levels are being measured
    std::uint32_t level_id = 0;
    bool measuring = false;
  };

  bool follow_edits();
  void choose();
  void measure_levels(std::size_t half);
  void choose_levels(std::size_t half);
  bool take_half(std::size_t half, std::uint32_t id);
  ScopeChunk joined(const Layout& layout);

  std::vector<std::unique_ptr<Half>> halves_;
  std::vector<Signal> signals_;
  std::vector<double> levels_;
  Order order_;               ///< that is obeyed
  mutable std::mutex mutex_;  ///< of the orders and what is shown
  std::optional<Order> new_order_;
  std::shared_ptr<const RemoteScope> shown_;
  std::shared_ptr<const Layout> layout_;
  std::atomic<bool> levels_wanted_{false};
  // Of the network thread.
  std::array<std::optional<ScopeChunk>, 2> waiting_;  ///< for that of the other player
};

}  // namespace tactus::app
