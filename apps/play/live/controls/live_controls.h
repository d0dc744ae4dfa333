#pragma once
// Thread: [control]

#include <string>
#include <vector>

#include "engine/graph/plan/plan.h"
#include "engine/runtime/player.h"

namespace tactus::app {

/// The controls of a running instrument as positions from 0 to 1 over their ranges, in decibels where the
/// control is.
class LiveControls {
 public:
  explicit LiveControls(Player& player) : player_(player) { renew(); }

  /// After an edit: reads the controls again; those that remain keep their value.
  void renew();
  /// With their current values.
  const std::vector<PlannedControl>& all() const { return controls_; }
  /// Moves one to a position from 0 to 1. False: it is frozen, or the engine's queue is full.
  bool turn(std::size_t index, double position);
  /// Moves one by a share of its range.
  bool nudge(std::size_t index, double share) { return turn(index, position(index) + share); }
  /// The same by name. False, too, if there is none.
  bool turn(const std::string& name, double position);
  /// After the engine began again: posts the value of every control. False: the engine's queue is full.
  [[nodiscard]] bool post_all();
  double position(std::size_t index) const;
  /// "strength = 0.6"
  std::string text(std::size_t index) const;

 private:
  Player& player_;
  std::vector<PlannedControl> controls_;
};

}  // namespace tactus::app
