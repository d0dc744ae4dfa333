#pragma once
// Thread: [control]

#include <cstdint>
#include <span>
#include <vector>

#include "latency/estimation/analysis.h"
#include "latency/estimation/delay_trend.h"
#include "latency/path/path_model.h"
#include "latency/probe/probe.h"

namespace tactus {

/// A burst that is played once, and the path behind which it is searched for in a recording: the mark and the
/// pilot.
struct SingleBurst {
  std::span<const double> played;  ///< all that was played
  Burst burst;
  const PathModel& model;           ///< its delay counts from `at`
  std::span<const double> profile;  ///< taps; empty: a cable
  std::int64_t at = 0;              ///< whole frames of the delay

  static constexpr std::int64_t kLead = 64;  ///< frames: what a filter may answer before its delay
  /// [any] The burst as it was played.
  std::span<const double> sound() const;
  /// [control] What the path would bring, from `kLead` frames before its delay on.
  std::vector<double> expected() const;
  /// The frame of the recording at which that begins.
  std::int64_t begin() const { return burst.at + at - kLead; }
};

/// What was captured of the pilot.
struct PilotTrack {
  std::vector<DelayPoint> points;  ///< of each part that was recorded and found
  double least_step = 0.0;         ///< frames: less may be noise, or a path that the model does not know well
  std::vector<std::int64_t>
      damage;  ///< frames of the recording where for a moment something else is captured
};

/// [control] In parts: where 2048 frames of it, as the path would bring them, are captured within 4096
/// frames of the delay, to the frame. `variance`: of a frame of noise; `unsteady`: it may be far louder.
PilotTrack track_pilot(const SingleBurst& pilot, std::span<const double> captured, double variance,
                       bool unsteady);

/// What was captured of the mark.
struct MarkTrack {
  bool recorded = false;
  bool judged = false;           ///< it stands out of what else sounds
  std::vector<DelayStep> steps;  ///< from the mark to the probes
};

/// [control] Where the mark is captured within 8192 frames of the delay, and whether all of it is. `longest`:
/// frames behind it until something else is played.
MarkTrack track_mark(const SingleBurst& mark, std::span<const double> captured, std::int64_t longest);

/// Beside what is expected, for some frames.
struct Damage {
  double kept = 0.0;         ///< of the expected amplitude, how much is captured
  double unexplained = 0.0;  ///< power beside it, over the expected power

  static Damage of(std::span<const double> captured, std::span<const double> expected);
  /// Something else was captured in its place, and not beside it; `certainty`: independent values.
  bool replaced(double certainty) const;
};

}  // namespace tactus
