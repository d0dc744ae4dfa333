#pragma once
// Thread: [control]

#include <string>
#include <vector>

#include "engine/graph/plan/plan.h"
#include "engine/runtime/player.h"

namespace tactus::app {

/// A control with the value that the player has or is about to get.
struct LiveControl : PlannedControl {
  double value_in_file = 0.0;
  bool sent = true;  ///< the player got this value
};

/// The controls of a running instrument as positions from 0 to 1 over their ranges, in decibels where the
/// control is. The last value of each control is kept until the player takes it: no number of changes is too
/// many, and none is lost while the device is away.
class LiveControls {
 public:
  explicit LiveControls(Player& player) : player_(player) { renew(); }

  /// After an edit: reads the controls again. As in the player, one whose `value` in the file changed moves
  /// there; the others keep their value, within their range.
  void renew();
  /// With their current values.
  const std::vector<LiveControl>& all() const { return controls_; }
  /// Moves one to a position from 0 to 1. False: it is frozen, or it has no range.
  bool turn(std::size_t index, double position);
  /// Moves one by a share of its range.
  bool nudge(std::size_t index, double share) { return turn(index, position(index) + share); }
  /// The same by name. False, too, if there is none.
  bool turn(const std::string& name, double position);
  /// Sets one, in SI, within its range. False: it is frozen, or there is none.
  bool set(const std::string& name, double value);
  /// It was set by an entry that somebody else has posted or is about to post.
  void note(const std::string& name, double value);
  /// nullptr: there is none.
  const LiveControl* find(const std::string& name) const;
  /// How often `renew` was called.
  int version() const { return version_; }
  /// While blocks flow: posts the values that changed. What the queue of the player has no room for is posted
  /// by a later call.
  void send();
  /// [control & stopped, prepared] Every control starts at its current value, without a ramp. In place of the
  /// player's journal, and of what was posted before.
  void post_all();
  /// Not frozen, and with a range.
  bool can_change(std::size_t index) const;
  double position(std::size_t index) const;
  /// "strength = 0.6"
  std::string text(std::size_t index) const;
  /// "0.6", "-34 dB"
  std::string value_text(std::size_t index) const;

 private:
  Player& player_;
  std::vector<LiveControl> controls_;
  int version_ = 0;
};

}  // namespace tactus::app
