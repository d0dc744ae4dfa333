#pragma once

#include <optional>

#include "engine/core/error.h"
#include "latency/estimation/analysis.h"
#include "latency/estimation/loop_recording.h"

namespace tactus {

/// A resonance as its peak shows it.
struct Resonance {
  double frequency_hz = 0.0;
  double q = 0.0;  ///< frequency over the width at -3 dB
};

/// How an actuator and a sensor answer together, measured from one recording through both: the analysis as if
/// they were a cable, but with finding, polarity, spectrum and group delay of the profile.
struct Calibration : Analysis {
  PathProfile profile{};  ///< without taps where the finding spoils it
  std::optional<Resonance> resonance{};
  /// When the first swing that reaches a third of the highest begins, without the card's delay. The polarity
  /// is that of this swing.
  double arrival_frames = 0.0;
  double unexplained = 0.0;  ///< share of what is captured that the profile does not explain
};

struct CalibrationSettings {
  int channel = 0;
  double electrical_frames = 0.0;  ///< the card's own delay, measured over a cable
  Seconds length{0.3};             ///< of the response, at most
};

/// [any] Does a verdict about a recording spoil it for calibration, too? That its path is no cable does not.
bool spoils(Verdict verdict);

/// [control] The causal response h of `length` that minimises  |captured - h * played|² + λ |h|²  over the
/// mean of all probes, once the card's delay is taken off: Toeplitz normal equations, by conjugate gradients
/// with a circulant preconditioner. λ is what the noise asks for. Errors as `analyze`.
Result<Calibration> calibrate(const LoopRecording& recording, const CalibrationSettings& settings);

}  // namespace tactus
