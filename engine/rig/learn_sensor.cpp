#include "engine/rig/learn_sensor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/core/decibels.h"
#include "engine/core/median.h"
#include "engine/core/named.h"

namespace tactus {
namespace {

constexpr double kPeak_s = 0.03;
constexpr double kGroup_s = 0.01;
constexpr double kRinging_s = 0.5;
constexpr double kRinging = 0.18;  // -15 dB
constexpr double kClips = 0.99;
constexpr double kAboveNoise = 2.0;       // the highest of many minutes of noise lies 4 dB above a group's
constexpr std::size_t kFirstGroups = 20;  // before the noise is known
constexpr std::size_t kGroupsPerLook = 10;
constexpr std::size_t kMaxGroups = 6000;  // a minute
constexpr double kQuietest = 1e-5;        // below is only the noise of converters
constexpr double kNoDetection = 1e9;

}  // namespace

SensorLearner::SensorLearner(Hertz sample_rate)
    : threshold_(kNoDetection),
      peak_frames_(static_cast<int>(frames_in(Seconds{kPeak_s}, sample_rate))),
      group_frames_(static_cast<int>(frames_in(Seconds{kGroup_s}, sample_rate))),
      ringing_frames_(static_cast<int>(frames_in(Seconds{kRinging_s}, sample_rate))) {
  tactus_onset_start(&onset_, sample_rate.value, 30, 0.020, 0.028);
}

void SensorLearner::process(std::span<const double> samples) {
  for (const double sample : samples) {
    if (done()) return;
    const double in = std::isfinite(sample) ? sample : 0.0;
    const bool hit = tactus_onset_step(&onset_, in, threshold_, 0.2, 1.41, 7) != 0;
    const double envelope = onset_.fast[0];
    if (hit && hits() < kHits) {
      peaks_.push_back(0);
      peak_frames_left_ = peak_frames_;
      before_ = std::exchange(since_hit_, 0);
    }
    since_hit_ = std::min(since_hit_ + 1, ringing_frames_);
    if (peak_frames_left_ > 0) {
      peaks_.back() = std::max(peaks_.back(), envelope);
      if (--peak_frames_left_ == 0) close_peak();
    }
    highest_ = std::max(highest_, std::abs(in));
    group_ = std::max(group_, envelope);
    if (++in_group_ == group_frames_) close_group();
  }
}

void SensorLearner::close_peak() {
  const auto last = peaks_.size() - 1;
  if (last == 0 || before_ >= ringing_frames_ || peaks_[last] > kRinging * peaks_[last - 1]) return;
  peaks_.pop_back();
  since_hit_ = std::min(since_hit_ + before_, ringing_frames_);  // the one before is the last hit again
}

void SensorLearner::close_group() {
  if (groups_.size() < kMaxGroups) groups_.push_back(std::exchange(group_, 0.0));
  in_group_ = 0;
  if (groups_.size() < kFirstGroups || groups_.size() % kGroupsPerLook != 0) return;
  noise_ = quantile(groups_, 0.25);
  threshold_ = std::max(kQuietest, kAboveNoise * noise_);
}

Result<LearntSensor> SensorLearner::result() const {
  if (!done())
    return fail(
        Errc::Missing, "",
        fmt::format("{} of {} hits were detected", hits() == 0 ? "none" : std::to_string(hits()), kHits),
        hits() == 0 ? "check that this is the sensor's channel and that its gain is not too low"
                    : "hit again, a little harder, or raise the sensor's gain");
  if (highest_ >= kClips)
    return fail(Errc::OutOfRange, "", "the hits clip at the card's input",
                "lower the sensor's gain, and hit again");
  const auto [softest, loudest] = std::minmax_element(peaks_.begin(), peaks_.end());
  const double over_noise = noise_ > 0 ? amplitude_to_db(*softest / noise_) : 1e3;
  if (over_noise < kOverNoise_db)
    return fail(Errc::OutOfRange, "",
                fmt::format("the softest hit is only {:.0f} dB above the noise; {:.0f} dB are needed",
                            over_noise, kOverNoise_db),
                "hit a little harder, raise the sensor's gain, or find the source of the noise");
  const double unequal = amplitude_to_db(*loudest / *softest);
  if (unequal > kMostUnequal_db)
    return fail(Errc::OutOfRange, "",
                fmt::format("the hits differ by {:.0f} dB, more than {:.0f} dB", unequal, kMostUnequal_db),
                "hit five times with equal force");
  const double soft = median(peaks_);
  return LearntSensor{soft, noise_, soft * amplitude_from_db(-kSoft_db)};
}

Status use_learnt(Rig& rig, const std::string& name, const LearntSensor& learnt, const Dimension& unit) {
  auto* const input = find_named(rig.inputs, name);
  if (input == nullptr)
    return fail(Errc::UnknownName, "", "the rig has no input '" + name + "'", "give one of its [inputs]");
  if (!unit.plain())
    return fail(Errc::UnitMismatch, "",
                "'" + name + "' is in " + to_string(unit) + ", for which hits are not suitable",
                "take the sensitivity from the sensor's data sheet");
  if (!input->volts) input->volts = 1.0;
  const auto volt = *parse_unit("V");
  input->sensitivity = QuantityValue{*input->volts * learnt.full_scale, volt, false};
  return {};
}

}  // namespace tactus
