#pragma once

#include <span>
#include <vector>

#include "engine/core/error.h"
#include "engine/core/units.h"
#include "engine/dsp/envelopes/onset_kernel.h"
#include "engine/rig/rig.h"

namespace tactus {

/// The sensitivity of a sensor from five soft hits. In samples of the card, whose full scale is 1.
struct LearntSensor {
  double soft = 0;        ///< the middle one of the hits' peaks
  double noise = 0;       ///< level between them: highest envelope of 10 ms, lower quartile
  double full_scale = 0;  ///< what counts as full scale, so that a soft hit is at -20 dB: soft * 10
};

/// "Hit softly five times": finds the hits in what a sensor gives and how sensitive it is.
///
/// The first 0.2 s are taken for noise. A hit begins where the onset detector finds one (onset_kernel.h) 6 dB
/// or more above the noise so far, at least 0.2 s after the last, so that neither ringing nor a second bounce
/// counts. Its peak is the highest envelope, above 30 Hz, of the next 30 ms. The median of five peaks does
/// not mind that one was different.
class SensorLearner {
 public:
  static constexpr int kHits = 5;
  static constexpr double kSoft_db = -20;        ///< of full scale
  static constexpr double kOverNoise_db = 12;    ///< minimum of each hit
  static constexpr double kMostUnequal_db = 12;  ///< from the softest to the loudest

  /// [control]
  explicit SensorLearner(Hertz sample_rate);
  /// [control] The next samples, in blocks of any size. After the fifth hit it ignores them.
  void process(std::span<const double> samples);
  /// [control] Hits detected so far.
  int hits() const { return static_cast<int>(peaks_.size()); }
  /// [control] Five hits were detected, and the last one to its peak.
  bool done() const { return hits() == kHits && peak_frames_left_ == 0; }
  /// [control] Errors: Missing for fewer than five hits; OutOfRange for hits that clip, that are too close
  /// to the noise, or too unequal.
  Result<LearntSensor> result() const;

 private:
  void close_group();
  void close_peak();

  tactus_onset onset_{};
  double threshold_;  ///< of the detector
  int peak_frames_, group_frames_, ringing_frames_;
  int peak_frames_left_ = 0;
  int since_hit_ = 0;  ///< frames since the last hit began
  int before_ = 0;     ///< and from the one before to it
  int in_group_ = 0;
  double group_ = 0;
  double noise_ = 0;    ///< so far
  double highest_ = 0;  ///< of |sample|
  std::vector<double> peaks_;
  std::vector<double> groups_;  ///< highest envelope of each 10 ms
};

/// [control] Puts what was learnt into a rig's input; where its volts are not known, 1 V is taken for full
/// scale, since only the ratio counts. Errors: UnknownName; UnitMismatch for a port whose unit is not plain:
/// how hard a hit is in newtons cannot be learnt from hits.
Status use_learnt(Rig& rig, const std::string& input, const LearntSensor& learnt, const Dimension& unit);

}  // namespace tactus
