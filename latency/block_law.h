#pragma once
// Thread: [control]

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/units.h"
#include "latency/estimation/analysis.h"

namespace tactus {

/// A setting of a card, and what came of it.
struct SettingDelay : DelayEstimate {
  Hertz sample_rate = 48_kHz;
  int block_frames = 0;
  int periods = 0;          ///< 0: not known
  std::int64_t gaps = 0;    ///< reported by the driver, or detected
  double measured_s = 0.0;  ///< how long it ran

  /// Its delay is to be trusted, and not a frame was lost.
  bool good() const { return finding.verdict == Verdict::Ok && gaps == 0; }
  Seconds delay() const { return Seconds{delay_frames / sample_rate.value}; }
};

/// Delay against block size:  delay = fixed + per_frame * block. `fixed` is what no block size takes away
/// (converters, cables, the bus), `per_frame` how many blocks lie on the way.
struct BlockLaw {
  double fixed_frames = 0.0;
  double per_frame = 0.0;
  /// Nothing where two settings alone lie on a line anyway.
  std::optional<double> fixed_standard_error, per_frame_standard_error;
  double residual_frames = 0.0;  ///< standard deviation around the line
  int settings = 0;
  Hertz sample_rate = 48_kHz;  ///< of the settings, as that of the first
  int periods = 0;

  double at(double block_frames) const { return fixed_frames + per_frame * block_frames; }
};

/// [any] The line of least squares through the good ones; nothing if they have less than two block sizes.
std::optional<BlockLaw> fit_block_law(const std::vector<SettingDelay>& settings);

/// [any] The good one with the shortest time of delay above `least`, or nullptr.
const SettingDelay* shortest_good(const std::vector<SettingDelay>& settings,
                                  Seconds least = Seconds{-std::numeric_limits<double>::infinity()});

/// [any] In the order of their first settings.
std::vector<std::vector<SettingDelay>> by_rate_and_periods(const std::vector<SettingDelay>& settings);

/// [any] "128 frames, 2 periods, 48 kHz"
std::string setting_text(const SettingDelay& setting);
/// [any] What to play with, and why, in sentences.
std::string recommendation(const std::vector<SettingDelay>& settings);

}  // namespace tactus
