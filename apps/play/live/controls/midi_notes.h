#pragma once

// Thread: [control]

#include <cstdint>
#include <deque>
#include <functional>
#include <string>
#include <vector>

#include "backends/midi.h"
#include "engine/core/journal.h"
#include "engine/graph/semantics/flat_graph.h"

namespace tactus::app {

/// Turns the notes of keyboards into values of the controls that follow them (MidiRole): the number and the
/// velocity of the key are set in the frame in which the trigger rises, and the trigger falls a frame later.
/// Each note has frames of its own, so that the notes of a chord, which come at once, start one after the
/// other, two frames apart.
class MidiNotes {
 public:
  /// A control with a role, by the number that journal entries name it by.
  struct Follower {
    MidiRole role = MidiRole::None;
    int index = -1;
    Interval range = {};
  };

  /// The controls of the version that plays now.
  void follow(std::vector<Follower> followers) { followers_ = std::move(followers); }
  bool any() const { return !followers_.empty(); }

  /// `earliest` is a frame that the player has not reached yet.
  void play(const MidiMessage& message, std::int64_t earliest);
  /// Posts what there is room for, in order; `post` is false where there is none.
  void flush(const std::function<bool(const JournalEntry&)>& post);
  /// The first frame that no note has.
  std::int64_t next() const { return next_; }
  /// Frames are counted from 0 again.
  void restart();

 private:
  void set(MidiRole role, double value, std::int64_t frame);

  std::vector<Follower> followers_;
  std::deque<JournalEntry> waiting_;
  std::int64_t next_ = 0;  ///< first frame that no note has
};

}  // namespace tactus::app
