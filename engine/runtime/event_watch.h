#pragma once
// Thread: [control, one thread] unless stated otherwise.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "engine/core/spsc_queue.h"
#include "engine/graph/plan/plan.h"
#include "engine/runtime/signal_reader.h"

namespace tactus {

/// An event of a plan: a node of the graph itself, not of its parts, triggers.
struct GraphEvent {
  std::string name;     ///< as a file names the trigger: "hit", "voice.note_on"
  SignalPlace trigger;  ///< an event is its rise through 0.5
  SignalPlace level;    ///< how strong the event was; without `data`: the node does not say
};

std::vector<GraphEvent> graph_events(const Plan& plan);

struct WatchedEvent {
  std::uint64_t version = 0;  ///< of the graph, Running::number
  int number = 0;             ///< in its `graph_events`
  std::int64_t frame = 0;
  double level = 1.0;
};

/// Finds the events of a running player.
class EventWatch final : public SignalObserver {
 public:
  static constexpr int kMostEvents = 16;
  /// An event that follows another one of its trigger in less time is left out.
  static constexpr double kLeastInterval_s = 0.002;

  /// From the next sub-block on. The places belong to this version of the graph; those beyond the 16th are
  /// left out. False: too many choices wait, try again after a block.
  [[nodiscard]] bool choose(std::uint64_t version, const std::vector<GraphEvent>& events);
  /// [any, one thread] The oldest event. False: there is none.
  [[nodiscard]] bool take(WatchedEvent& event) { return found_.pop(event); }

  void observe(const Running& running, std::int64_t now, int frames) noexcept override;

 private:
  struct Choice {
    std::uint64_t version = 0;
    int count = 0;
    std::array<SignalPlace, kMostEvents> triggers, levels;
  };
  static constexpr std::int64_t kNever = -(std::int64_t{1} << 62);

  void restart() noexcept;

  SpscQueue<Choice> choices_{8};
  SpscQueue<WatchedEvent> found_{256};
  // Audio side.
  Choice choice_;
  std::array<double, kMostEvents> before_{}, held_levels_{};
  std::array<std::int64_t, kMostEvents> last_{};
  std::int64_t next_ = 0;
};

}  // namespace tactus
