#pragma once
// Thread: [control]

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/error.h"
#include "engine/core/units.h"
#include "latency/estimation/loop_recording.h"

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
  BackgroundSound,   ///< something else sounds, and hides what was played
  LowSnr,            ///< too much noise
  UnstableStart,     ///< another delay each time that the stream is opened
};

/// What reports call them.
inline constexpr std::array<const char*, 15> kVerdictCodes{"ok",
                                                           "NO_SIGNAL",
                                                           "WRONG_CHANNEL",
                                                           "HOWL",
                                                           "CLIPPING",
                                                           "LOST_FRAMES",
                                                           "API_MISMATCH",
                                                           "ECHO_CANCEL",
                                                           "AGC",
                                                           "CLOCKS_DIFFER",
                                                           "DIRECT_MONITORING",
                                                           "NOT_FLAT",
                                                           "BACKGROUND_SOUND",
                                                           "LOW_SNR",
                                                           "UNSTABLE_START"};
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

/// How a path answers at one frequency, relative to what was played.
struct ResponsePoint {
  double frequency_hz = 0.0;
  double gain_db = 0.0;
  double noise_db = 0.0;  ///< at the same scale
};

/// The slope of the phase in one octave.
struct BandDelay {
  double centre_hz = 0.0;
  double delay_frames = 0.0;
  double standard_error_frames = 0.0;
};

/// From `frame` of the recording on, the delay is another.
struct DelayStep {
  std::int64_t frame = 0;
  /// Positive: longer (frames were added on the way), negative: frames were lost, 0: something else was
  /// captured in their place.
  double frames = 0.0;
};

/// One probe by itself.
struct ProbeDelay {
  std::int64_t played_at = 0;  ///< frame of the recording
  double delay_frames = 0.0;
  double gain_db = 0.0;
  double level = 0.0;              ///< its peak as played
  double gain_deviation_db = 0.0;  ///< as the noise makes it
};

/// What one recording says about the path from output to input.
///
/// The delay is the D of the model  H(f) = g P(f) A(f) exp(-2πi f D / rate):  a gain g of either sign, the
/// path's profile P (1 for a cable), and for A what coupling capacitors (the phase of any high-pass) and slow
/// filters (a magnitude without phase) do. It is fitted over all probes at once, each frequency weighted by
/// its power over that of the noise: for white noise and a flat path this is the maximum-likelihood estimate.
///
/// Where the delay moves, the estimate is that in the middle of the probes.
struct Analysis : DelayEstimate {
  Hertz sample_rate = 48_kHz;
  bool detected = false;       ///< false: nothing is known but noise floor and DC
  double bound_frames = 0.0;   ///< Cramér–Rao, for what was played and the noise that was captured
  double spread_frames = 0.0;  ///< standard deviation over probes
  int polarity = 1;
  double gain_db = 0.0;  ///< of the path, middle of its band
  double snr_db = 0.0;   ///< per sample, while a probe at full level is captured
  double noise_floor_dbfs = 0.0;
  double dc = 0.0;         ///< full scale
  bool compared = true;    ///< at least three probes, so that drift and lost frames show
  double drift_ppm = 0.0;  ///< by which the delay grows: a millionth of a frame in every frame
  double drift_standard_error_ppm = 0.0;
  double low_hz = 0.0, high_hz = 0.0;        ///< where the gain is within 3 dB of its middle
  double high_pass_hz = 0.0;                 ///< sum of the corners of coupling capacitors
  std::optional<double> high_pass_error_hz;  ///< standard error of it; nothing: it was not fitted
  double fitted_from_hz = 0.0;               ///< lowest frequency that delay and high-pass were fitted to
  double misfit_frames = 0.0;                ///< what that may do to the delay
  double misfit = 0.0;                       ///< share of the captured power that the model does not explain
  std::array<std::optional<double>, 4> harmonics_db;  ///< H2 … H5, relative to the fundamental
  std::optional<int> echo_frames;                     ///< from the first arrival to a second one
  std::vector<BandDelay> group_delay;
  std::vector<ProbeDelay> probes;
  std::vector<DelayStep> steps;
  std::vector<ResponsePoint> spectrum;
  std::vector<double> response;  ///< impulse response
  std::int64_t response_at = 0;  ///< delay of its first sample [frames]
};

struct AnalysisSettings {
  int channel = 0;                     ///< of `captured`
  std::optional<PathProfile> profile;  ///< of the path, when it is no cable
  bool details = true;                 ///< false: no spectrum, response, group delay and harmonics
};

/// [control] Errors: BadArgument if what was played has no repeated bursts between pauses, or nothing was
/// recorded.
Result<Analysis> analyze(const LoopRecording& recording, const AnalysisSettings& settings = {});

}  // namespace tactus
