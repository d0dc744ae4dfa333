#pragma once

#include <cstdint>

#include "engine/core/realtime.h"

namespace tactus {

/// An input of `process` that is no sample. Samples and journal together determine the output: a take that
/// keeps both replays bit for bit, whatever the block size.
struct JournalEntry {
  enum class Kind : std::uint8_t {
    ControlChange,  ///< `index`: control; `value`: its new target, SI
    Arm,            ///< `index`: output channel or kAllChannels; `value`: 1 lets the drive move, 0 does not
    Mute,           ///< `index`: output channel or kAllChannels; `value`: 1 silences, 0 releases
    SystemDelay,    ///< `value`: sensor voltage to actuator voltage [frames]; negative: unknown from now on,
                    ///< the last one is kept
    LostFrames,     ///< `value`: frames that went missing just before `frame`
    CoilHeat,       ///< `index`: output channel; `value`: lower bound of the coil's heat (ThermalState)
    BodyHeat,       ///< the same for the actuator's body
    Replacement,    ///< another version of the graph took over; `index`: how many there were so far
    Halt,           ///< the stream was stopped just before `frame`, with zeros, and went on without `prepare`
    Fade,           ///< `index`: kAllChannels; `value`: 1 fades every output out, 0 lets it come back
  };

  static constexpr int kAllChannels = -1;
  /// For an entry that applies as soon as it arrives. Applied entries carry the true frame.
  static constexpr std::int64_t kNow = -1;

  std::int64_t frame = kNow;  ///< first frame that it applies to, counted since `prepare`
  Kind kind = Kind::ControlChange;
  int index = 0;
  double value = 0.0;

  bool operator==(const JournalEntry&) const = default;
};

/// Receives every entry when it is applied.
class JournalTap {
 public:
  virtual ~JournalTap() = default;
  /// [realtime] `entry` carries its true frame, which lies in the block being processed.
  virtual void applied(const JournalEntry& entry) noexcept TACTUS_NONBLOCKING = 0;
};

}  // namespace tactus
