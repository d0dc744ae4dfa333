#pragma once
// Thread: [any, one thread]

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/rig/rig.h"
#include "remote/remote.h"

namespace tactus {

/// Without a rig: the events of the instrument play the notes from C2 on, in channel 10, that of drums.
std::vector<RigMidiOut> default_midi_out(const std::vector<std::string>& events);

/// Turns events and controls into MIDI messages: events into notes, whose velocity is their level between
/// `softest` and `loudest` on a scale of decibels; controls into controllers, 0 to 127 over their range; a
/// control in Hz into the 24 pulses a beat of a clock. Source: MIDI 1.0 Detailed Specification.
class MidiOutMap {
 public:
  using Clock = std::chrono::steady_clock;
  using Send = std::function<void(std::span<const std::uint8_t>)>;

  MidiOutMap(std::vector<RigMidiOut> bindings, Send send);

  /// What does not fit the instrument. Errors: UnknownName; UnitMismatch: a clock's control is not in Hz.
  std::vector<Error> check(const RemoteDescription& description) const;
  /// A note for each binding of this event.
  void event(const RemoteEvent& event, Clock::time_point now);
  /// Controls that moved, notes that end, pulses that are due.
  void tick(const RemoteDescription& description, Clock::time_point now);
  /// When the next note ends or the next pulse is due.
  std::optional<Clock::time_point> due() const;
  /// Ends all notes and the clock.
  void stop();

  /// 1 to 127.
  static int velocity(double level, const RigMidiOut& binding);

 private:
  struct Pulses {
    Clock::time_point next;
    bool runs = false;
  };
  using Note = std::pair<int, int>;  ///< channel, number

  void note_off(const Note& note);
  void send_controller(const RigMidiOut& binding, const RemoteControl& control, int& last);
  void send_clock(const RigMidiOut& binding, double hertz, Clock::time_point now);

  std::vector<RigMidiOut> bindings_;
  Send send_;
  std::map<Note, Clock::time_point> sounding_;  ///< until when
  std::vector<int> last_;                       ///< [binding] value of a controller; -1: none was sent
  Pulses pulses_;
};

}  // namespace tactus
