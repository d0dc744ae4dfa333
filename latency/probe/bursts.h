#pragma once
// Thread: [control]

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine/core/units.h"

namespace tactus {

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
  std::vector<Burst> others;     ///< the level ramp, the pilot
  std::int64_t pause = 0;        ///< the shortest one behind a repeated burst [frames]
  double peak = 0.0;             ///< of the waveform

  /// The longest of the others, if it lasts a quarter of a second.
  std::optional<Burst> pilot(Hertz sample_rate) const;
};

/// [control] Is `samples` the waveform again, at whatever level?
bool repeats(std::span<const double> samples, std::span<const double> waveform);

/// [control] Nothing if all is silent. Pauses last at least 20 ms. Bursts count as one waveform when they
/// agree within 1 % of their power, whatever their gain.
std::optional<PlayedBursts> find_bursts(std::span<const double> played, Hertz sample_rate);

}  // namespace tactus
