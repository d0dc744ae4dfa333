#pragma once
// Thread: [control]

#include <string>

namespace tactus {

/// Why a delay is unreliable, in the order in which they are reported: what comes first explains what
/// comes later.
enum class Verdict {
  Ok,
  NoSignal,          ///< nothing of what was played came back
  WrongChannel,      ///< it came back on another input
  Feedback,          ///< the loop fed itself; the output was muted
  Clipping,          ///< the input was at its end
  LostFrames,        ///< the driver dropped or repeated frames
  ApiMismatch,       ///< the stream does not run as it was granted
  EchoCancel,        ///< something takes away more and more of what is played
  Agc,               ///< the gain depends on the level
  ClocksDiffer,      ///< input and output run at different speeds, so the delay moves
  DirectMonitoring,  ///< a second path beside the measured one
  NotFlat,           ///< a path whose own delay depends on the frequency: an actuator, a sensor, a room
  LowSnr,            ///< too much noise
  UnstableStart,     ///< another delay each time that the stream is opened
};

/// "ok", "NO_SIGNAL", …: what reports call it.
const char* code(Verdict verdict);

/// A verdict about one measurement, with its evidence.
struct Finding {
  Verdict verdict = Verdict::Ok;
  std::string what;    ///< what was seen, in numbers
  std::string remedy;  ///< what to do
};

}  // namespace tactus
