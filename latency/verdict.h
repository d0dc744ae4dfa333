#pragma once
// Thread: [control]

#include <array>
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

/// What reports call them.
inline constexpr std::array<const char*, 14> kVerdictCodes{
    "ok",           "NO_SIGNAL",     "WRONG_CHANNEL", "HOWL",          "CLIPPING",          "LOST_FRAMES",
    "API_MISMATCH", "ECHO_CANCEL",   "AGC",           "CLOCKS_DIFFER", "DIRECT_MONITORING", "NOT_FLAT",
    "LOW_SNR",      "UNSTABLE_START"};
inline const char* code(Verdict verdict) { return kVerdictCodes[static_cast<std::size_t>(verdict)]; }

/// A verdict about one measurement, with its evidence.
struct Finding {
  Verdict verdict = Verdict::Ok;
  std::string what;    ///< with numbers
  std::string remedy;  ///< what to do
};

/// A delay, its uncertainty, and whether it is to be trusted.
struct DelayEstimate {
  Finding finding;
  double delay_frames = 0.0;
  double standard_error_frames = 0.0;
};

}  // namespace tactus
