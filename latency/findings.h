#pragma once

#include <optional>
#include <span>
#include <vector>

#include "latency/estimation/analysis.h"
#include "latency/estimation/coarse.h"
#include "latency/path/response.h"

namespace tactus {

/// What to do about lost frames.
inline constexpr const char* kAgainstGaps =
    "use a larger block size or more periods (`tactus latency sweep` finds the smallest that works), close "
    "other programs, and run `tactus doctor`";

/// Another way by which what was played comes back, too far from the first one for the same window.
struct SecondPath {
  /// [any] Nearer ones are left to Response::echo, which sees as much as the pauses between probes leave.
  /// [frames]
  static std::int64_t near(Hertz rate) {
    constexpr double kLongest = 2048.0;
    constexpr Seconds kTime{0.04};
    return std::llround(std::min(kLongest, frames_in(kTime, rate)));
  }
  std::int64_t frames = 0;  ///< from the path to it; negative: it is earlier
  double level_db = 0.0;    ///< beside the path
};

/// Results of an analysis that its report omits.
struct Evidence {
  CoarseDelay coarse;
  Response::Echo echo;
  std::optional<SecondPath> second;  ///< further away
  std::optional<int> harmonic;       ///< what looks like a second path is a distortion of that order
  bool with_profile = false;
  bool overdriven = false;                    ///< loud and soft probes differ in shape
  bool unsteady = false;                      ///< the noise comes and goes
  bool ends_hidden = false;                   ///< lost frames before or behind the probes would go unseen
  double least_step_frames = 0.0;             ///< fewer lost frames between probes might not be detected
  double gain_range_db = 0.0;                 ///< highest over lowest gain of the model in the band
  double widest_error_frames = 0.1;           ///< standard error that is still called a result
  std::optional<double> level_probe_gain_db;  ///< highest gain of bursts before the probes
};

/// [control] No path was found on a channel: the reason, from where the probe is found on every channel, or
/// `cut_short`: fewer than three complete probes were captured.
Finding not_detected(const std::vector<CoarseDelay>& channels, int channel, bool cut_short);
/// [control] The first reason, in the order of Verdict, why `analysis` of `captured` is unreliable.
Finding verdict_of(const Analysis& analysis, const Evidence& evidence, std::span<const double> captured);

/// [any] The one that comes first in the order of Verdict; Ok if there is no other.
Finding first_of(const std::vector<Finding>& findings);

}  // namespace tactus
