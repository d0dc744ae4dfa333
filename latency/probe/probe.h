#pragma once
// Thread: [control]

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine/core/units.h"

namespace tactus {

/// [any]
std::size_t whole_frames(Seconds time, Hertz sample_rate);

/// A sine whose frequency f(t) = start * exp(t / growth) rises from `start` to `stop`, with amplitude 1
/// between two raised-cosine edges:  s(t) = sin(2π start growth (exp(t / growth) - 1)),  growth = duration /
/// ln(stop / start). A distortion of order k answers at time t with k f(t); in the deconvolved response it
/// lies growth * ln k before the linear one. Source: A. Farina, "Simultaneous measurement of impulse
/// response and distortion with a swept-sine technique", AES 108, 2000.
struct ExponentialSweep {
  Hertz start, stop;
  Seconds duration;

  Seconds growth() const;
  /// [control] As long as `duration`.
  std::vector<double> samples(Hertz sample_rate) const;
};

/// The probe that everything is measured with: 20 Hz to 0.42 of the sample rate.
ExponentialSweep measuring_probe(Hertz sample_rate);
/// A shorter one, for finding the level.
ExponentialSweep level_probe(Hertz sample_rate);
/// Noise between -1 and 1 for half a second, the same on every machine: whatever part of it is captured
/// tells where in it that part stands.
std::vector<double> pilot(Hertz sample_rate);
/// 30 ms of noise of almost constant level, from its first frame on: frames that are lost before the first
/// probe, or in its bass, move the probes away from it.
std::vector<double> mark(Hertz sample_rate);

/// The mark, probes one after another, then the pilot. The pauses differ, so that no probe is taken for its
/// neighbour.
struct ProbeTrain {
  static constexpr int kProbes = 8;
  static constexpr double kSoftGain = 0.5;  ///< of some, so that a gain that depends on the level shows
  static constexpr Seconds kLead{0.15};     ///< from the mark's beginning to the first probe

  static double gain(int probe);
  /// [control] `level` (0, 1] is that of the loudest.
  static std::vector<double> samples(Hertz sample_rate, int count, double level, Seconds lead = kLead);
};

/// [control] The whole signal, `level` (0, 1] at its loudest, the first probe after half a second. Files that
/// were written before there was a mark begin with silence; they are analysed like any other signal.
std::vector<double> stimulus(Hertz sample_rate, double level);

/// The sound between two pauses.
struct Burst {
  std::int64_t at = 0;
  std::int64_t frames = 0;
  double gain = 1.0;  ///< times the waveform of its group
  std::int64_t end() const { return at + frames; }
};

/// What a recording played, taken apart: one waveform again and again, and what else there was.
struct PlayedBursts {
  std::vector<double> waveform;  ///< of the repeated ones, as loud as the loudest of them
  std::vector<Burst> repeated;   ///< in time order, at least one
  std::vector<Burst> others;     ///< the level ramp, the mark, the pilot
  std::int64_t pause = 0;        ///< the shortest one behind a repeated burst [frames]
  double peak = 0.0;             ///< of the waveform

  /// The longest of the others, if it lasts a quarter of a second.
  std::optional<Burst> pilot(Hertz sample_rate) const;
  /// The last of the others before the first probe, if it is as short as a mark.
  std::optional<Burst> mark(Hertz sample_rate) const;
};

/// [control] Is `samples` the waveform again, at whatever level?
bool repeats(std::span<const double> samples, std::span<const double> waveform);

/// [control] Nothing if all is silent. Pauses last at least 20 ms. Bursts count as one waveform when they
/// agree within 1 % of their power, whatever their gain.
std::optional<PlayedBursts> find_bursts(std::span<const double> played, Hertz sample_rate);

}  // namespace tactus
