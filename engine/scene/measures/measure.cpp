#include "engine/scene/measures/measure.h"

#include <algorithm>
#include <cmath>

#include "engine/dsp/pitch/pitch_detector.h"
#include "engine/graph/file/mistakes.h"
#include "engine/graph/file/nearest.h"
#include "engine/graph/file/quantity.h"
#include "engine/scene/measures/landings.h"

namespace tactus {
namespace {

constexpr Seconds kStrikeGap = 5_ms;
constexpr double kLeastStrike_N = 5.0;
// Any push that the ear could follow, where it begins and ends.
constexpr Seconds kTouchGap = 1_ms;
constexpr double kLeastTouch_N = 0.1;

const RecordedSignal* trigger_signal(const SceneRecording& recording, const std::string& name) {
  if (const auto* exact = recording.find(name)) return exact;
  for (const auto& signal : recording.signals)
    if (signal.name.starts_with(name + ".") && !signal.name.ends_with(".level")) return &signal;
  return nullptr;
}

bool is_force(const RecordedSignal& signal) { return signal.dimension == parse_unit("N")->dimension; }

/// The samples between two times.
std::vector<double> part_of(const RecordedSignal& signal, Hertz rate, double from, double to) {
  const auto size = static_cast<double>(signal.samples.size());
  const auto first = static_cast<std::ptrdiff_t>(std::clamp(from * rate.value, 0.0, size));
  const auto last = static_cast<std::ptrdiff_t>(std::clamp(to * rate.value, 0.0, size));
  return {signal.samples.begin() + first, signal.samples.begin() + std::max(first, last)};
}

double rms(const std::vector<double>& samples) {
  double squares = 0;
  for (const double x : samples) squares += x * x;
  return samples.empty() ? 0 : std::sqrt(squares / static_cast<double>(samples.size()));
}

double peak(const std::vector<double>& samples) {
  double most = 0;
  for (const double x : samples) most = std::max(most, std::abs(x));
  return most;
}

/// Median; 0 where nothing has a pitch.
double pitch(const std::vector<double>& samples, Hertz rate) {
  std::vector<double> found;
  for (const auto& point : track_pitch(samples, rate, 40_Hz, 2_kHz)) found.push_back(point.hertz);
  if (found.empty()) return 0;
  const auto middle = found.begin() + static_cast<std::ptrdiff_t>(found.size() / 2);
  std::nth_element(found.begin(), middle, found.end());
  return *middle;
}

class Measurement {
 public:
  Measurement(const SceneRecording& recording, const Expectation& expectation)
      : recording_(recording),
        expectation_(expectation),
        from_(expectation.from_s.value_or(0)),
        to_(expectation.to_s.value_or(recording.seconds())) {}

  Result<double> run() {
    const auto& what = expectation_.measure;
    if (what == "faults") return faults();
    if (what == "missed" || what == "doubled" || what == "detection_time") return detection(what);
    if (what == "restitution") return bounce();
    if (what == "period") return period();
    if (what == "energy_given") return energy_given();
    const auto* signal = trigger_signal(recording_, expectation_.of);
    if (signal == nullptr) return unknown_signal();
    if (what == "peak") return peak(part_of(*signal, recording_.sample_rate, from_, to_));
    if (what == "rms") return rms(part_of(*signal, recording_.sample_rate, from_, to_));
    if (what == "pitch")
      return pitch(part_of(*signal, recording_.sample_rate, from_, to_), recording_.sample_rate);
    return rhythm(*signal, what);
  }

 private:
  Result<double> unknown_signal() const {
    std::vector<std::string> names;
    for (const auto& signal : recording_.signals) names.push_back(signal.name);
    const auto near = nearest_name(expectation_.of, names);
    return fail(Errc::UnknownName, (expectation_.of.empty() ? expectation_.at : expectation_.of_at).text(),
                expectation_.of.empty() ? "'" + expectation_.measure + "' needs an 'of'"
                                        : "nothing called '" + expectation_.of + "' was recorded",
                near.empty() ? "recorded were " + listed(names) : "did you mean '" + near + "'?");
  }

  Result<double> faults() const {
    double sum = static_cast<double>(recording_.bad_inputs);
    for (const auto& fault : recording_.faults) sum += static_cast<double>(fault.count);
    return sum;
  }

  Result<double> rhythm(const RecordedSignal& signal, const std::string& what) const {
    std::vector<double> times;
    if (is_force(signal))
      for (const auto& strike : strikes_of(recording_, signal.name)) times.push_back(strike.start_s);
    else
      times = trigger_times(signal.samples, recording_.sample_rate);
    const auto found = rhythm_of(times, from_, to_);
    if (what == "count") return found.count;
    if (what == "rate") return found.rate_hz;
    if (what == "fewest_per_second") return found.fewest_in_a_second;
    if (what == "spread") return found.spread;
    if (what == "long_short") return found.long_short;
    if (what == "growing") return found.growing;
    return found.last_s;
  }

  Result<double> detection(const std::string& what) const {
    const auto triggers =
        triggers_of(recording_, expectation_.of.empty() ? "instrument.hit" : expectation_.of);
    const auto* force = recording_.find(kStrikeContact);
    if (force == nullptr) return unknown_signal();
    const auto found = detection_of(*force, recording_.sample_rate, triggers, from_, to_);
    return what == "missed" ? found.missed : what == "doubled" ? found.doubled : found.latest_s;
  }

  Result<double> bounce() const {
    const auto* position = recording_.find(expectation_.of.empty() ? "plant.stick" : expectation_.of);
    if (position == nullptr) return unknown_signal();
    std::vector<Strike> strikes;
    for (const auto& strike : strikes_of(recording_))
      if (strike.start_s >= from_ && strike.end_s <= to_) strikes.push_back(strike);
    return restitution(position->samples, recording_.sample_rate, strikes);
  }

  Result<double> period() const {
    const auto bouncing =
        bouncing_in(recording_, expectation_.of.empty() ? "plant.ball" : expectation_.of, from_, to_);
    return bouncing ? Result<double>{bouncing->period} : unknown_signal();
  }

  Result<double> energy_given() const {
    for (const auto& port : recording_.ports) {
      if (port.name != expectation_.of) continue;
      const auto force = part_of(*recording_.find(port.force), recording_.sample_rate, from_, to_);
      const auto position = part_of(*recording_.find(port.position), recording_.sample_rate, from_, to_);
      EnergyWatch watch{port.allowed};
      watch.take(force.data(), position.data(), static_cast<int>(force.size()));
      return watch.energy(recording_.sample_rate).given;
    }
    return fail(Errc::UnknownName, expectation_.of_at.text(), "there is no port '" + expectation_.of + "'",
                "name it under [ports]");
  }

  const SceneRecording& recording_;
  const Expectation& expectation_;
  double from_, to_;
};

std::string wanted_text(const Expectation& expectation, const std::string& unit) {
  const auto number = [&](const QuantityValue& q) {
    return short_number(q.si) + (unit.empty() ? "" : " " + unit);
  };
  if (expectation.min && expectation.max && expectation.min->si == expectation.max->si)
    return "exactly " + number(*expectation.min);
  if (expectation.min && expectation.max) return number(*expectation.min) + " to " + number(*expectation.max);
  return expectation.min ? "at least " + number(*expectation.min) : "at most " + number(*expectation.max);
}

std::string unit_in(const SceneRecording& recording, const Expectation& expectation,
                    const MeasureType& type) {
  if (type.unit != MeasureType::kUnitOfSubject) return type.unit;
  const auto* signal = trigger_signal(recording, subject_of(expectation, type));
  return signal != nullptr ? to_string(signal->dimension) : "";
}

}  // namespace

const std::vector<MeasureType>& measure_types() {
  using Subject = MeasureType::Subject;
  static const std::vector<MeasureType> types = {
      {"count", "", "number of events"},
      {"rate", "Hz", "events a second, from the first to the last"},
      {"fewest_per_second", "", "fewest events in any second"},
      {"spread", "", "standard deviation of the intervals over their mean"},
      {"long_short", "", "longer of two neighbouring intervals over the shorter, median"},
      {"growing", "", "longest run of intervals that each grow by 3 % or more"},
      {"last", "s", "time of the last event"},
      {"restitution", "", "speed after a strike over the speed before, geometric mean", Subject::Signal,
       "plant.stick", kStrikeContact},
      {"missed", "", "strikes that were not heard", Subject::Events, "instrument.hit", kStrikeContact},
      {"doubled", "", "hits heard without a strike of their own", Subject::Events, "instrument.hit",
       kStrikeContact},
      {"detection_time", "s", "longest time from the start of a strike to the hit", Subject::Events,
       "instrument.hit", kStrikeContact},
      {"period", "", "landings of a ball on plant.table until it does the same again; 0: not within 8",
       Subject::Signal, "plant.ball", kTable},
      {"peak", MeasureType::kUnitOfSubject, "largest absolute value", Subject::Signal},
      {"rms", MeasureType::kUnitOfSubject, "root mean square", Subject::Signal},
      {"pitch", "Hz", "how often a second it repeats itself, median; 0: it has no pitch", Subject::Signal},
      {"energy_given", "J", "most that the instrument gave to the plant since any earlier moment",
       Subject::Port},
      {"faults", "", "values that were not numbers, at inputs and in nodes", Subject::Nothing},
  };
  return types;
}

const MeasureType* find_measure(std::string_view name) {
  const auto& types = measure_types();
  const auto found =
      std::find_if(types.begin(), types.end(), [&](const MeasureType& type) { return type.name == name; });
  return found == types.end() ? nullptr : &*found;
}

const std::string& subject_of(const Expectation& expectation, const MeasureType& type) {
  return expectation.of.empty() ? type.of : expectation.of;
}

Result<double> measure(const SceneRecording& recording, const Expectation& expectation) {
  return Measurement{recording, expectation}.run();
}

std::vector<Strike> strikes_of(const SceneRecording& recording, const std::string& contact) {
  const auto* force = recording.find(contact);
  if (force == nullptr) return {};
  return find_strikes(force->samples, recording.sample_rate, kStrikeGap, kLeastStrike_N);
}

Detection detection_of(const RecordedSignal& contact, Hertz sample_rate,
                       const std::vector<double>& triggers_s, double from_s, double to_s) {
  std::vector<double> heard;
  for (const double time : triggers_s)
    if (time >= from_s && time <= to_s) heard.push_back(time);
  const DetectionRules rules;
  auto touches = find_strikes(contact.samples, sample_rate, kTouchGap, kLeastTouch_N);
  std::erase_if(touches, [&](const Strike& s) { return s.start_s < from_s || s.start_s > to_s; });
  // What comes so late may be heard, and need not be.
  for (auto& touch : touches)
    if (touch.start_s > to_s - rules.late.value) touch.peak = 0;
  return match(touches, heard, rules);
}

std::vector<double> triggers_of(const SceneRecording& recording, const std::string& name) {
  const auto* signal = trigger_signal(recording, name);
  return signal == nullptr ? std::vector<double>{} : trigger_times(signal->samples, recording.sample_rate);
}

Checked<std::vector<Outcome>> check_expectations(const SceneSpec& scene, const SceneRecording& recording) {
  std::vector<Outcome> outcomes;
  std::vector<Error> mistakes;
  for (const auto& expectation : scene.expect) {
    const auto* type = find_measure(expectation.measure);
    if (type == nullptr) {
      mistakes.push_back({Errc::UnknownName, expectation.measure_at.text(),
                          "there is no measure '" + expectation.measure + "'", ""});
      continue;
    }
    const auto value = measure(recording, expectation);
    if (!value) {
      mistakes.push_back(value.error());
      continue;
    }
    const bool holds = (!expectation.min || *value >= expectation.min->si) &&
                       (!expectation.max || *value <= expectation.max->si);
    const auto unit = unit_in(recording, expectation, *type);
    outcomes.push_back(
        {expectation.name, expectation.measure, *value, unit, holds, wanted_text(expectation, unit)});
  }
  if (!mistakes.empty()) return tl::unexpected(std::move(mistakes));
  return outcomes;
}

}  // namespace tactus
