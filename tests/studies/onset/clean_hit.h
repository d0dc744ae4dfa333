#pragma once

#include <vector>

namespace tactus::study {

/// What the recording of one hit, alone and without noise, says about it. Times in seconds from its first
/// frame.
struct CleanHit {
  double onset = 0;      ///< first frame within 20 dB of the peak of the first 10 ms
  double rise = 0;       ///< from there to the first frame above 90 % of that peak (10-90 % rise time)
  double peak_time = 0;  ///< of the largest frame of all
  bool several_strokes = false;
};

/// The recording without the silence before it: from the first frame within 40 dB of its largest.
std::vector<float> trimmed(const std::vector<float>& recording);

/// `hit` is trimmed.
/// Several strokes: after 20 ms some 10 ms window is twice as high as the one before it, and within 20 dB of
/// the whole hit's peak; or the peak itself comes later than 20 ms. Measured on the clean recording only.
CleanHit measure(const std::vector<float>& hit, double sample_rate);

/// By how many dB the hit falls in `seconds`: highest of the first 5 ms over highest of the 10 ms before
/// then, in the signal or in its first difference, whichever falls more.
double fall_db(const std::vector<float>& hit, double sample_rate, double seconds);

}  // namespace tactus::study
