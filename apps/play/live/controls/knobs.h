#pragma once

#include <string>
#include <vector>

#include "engine/graph/plan/plan.h"
#include "engine/runtime/player.h"

namespace tactus::app {

/// The controls of a playing instrument as a person turns them: each a knob from 0 to 1 over its range, in
/// decibels where the control is.
class Knobs {
 public:
  struct Knob {
    FlatControl control;  ///< `value`: where it stands
    bool frozen = false;  ///< cannot move while it plays
  };

  explicit Knobs(Player& engine) : engine_(engine) { renew(); }

  /// [control] After an edit: new controls, those that stay keep their place.
  void renew();
  const std::vector<Knob>& all() const { return knobs_; }
  /// [control] Their controls as they stand.
  std::vector<FlatControl> controls() const;
  /// [control] Turns one to a place from 0 to 1. False: it is frozen, or the engine's queue is full.
  bool turn(std::size_t knob, double place);
  /// [control] Turns one on by a share of its way.
  bool nudge(std::size_t knob, double share) { return turn(knob, place(knob) + share); }
  /// [control] The same by name. False, too, if there is none.
  bool turn(const std::string& name, double place);
  double place(std::size_t knob) const;
  /// "strength = 0.6"
  std::string text(std::size_t knob) const;

 private:
  Player& engine_;
  std::vector<Knob> knobs_;
};

}  // namespace tactus::app
