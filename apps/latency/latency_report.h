#pragma once
// Thread: [control]

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "engine/plot/plot.h"
#include "latency/calibration.h"
#include "latency/measurement.h"

namespace tactus::app {

/// The opening that shows best what was found: the first with the verdict of the whole. nullptr: none.
const Opening* shown_of(const Measurement& measurement);

/// The report of a measurement. One recorded elsewhere has a single opening without a stream.
struct LatencyReport {
  std::string source;  ///< a device and its setting, or a file
  Measurement measurement;
  bool live = false;                 ///< measured now, on a device
  std::vector<std::string> saved;    ///< where the delay was saved
  std::vector<std::string> written;  ///< files

  bool ok() const { return measurement.finding.verdict == Verdict::Ok; }
  Hertz sample_rate() const;
  const Opening* shown() const { return shown_of(measurement); }
};

/// Was there anything to analyse? Not if the measurement was given up before.
bool is_known(const Analysis& analysis);

/// What the delay is, in a sentence.
extern const char* const kDelayIs;

/// null is what is not known.
template <class T>
nlohmann::ordered_json known(bool is_known, const T& value) {
  return is_known ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}
template <class T>
nlohmann::ordered_json known(const std::optional<T>& value) {
  return known(value.has_value(), value.value_or(T{}));
}

/// Part of every report.
struct Essentials {
  Finding finding;
  Hertz sample_rate;
  double delay_frames = 0.0, standard_error_frames = 0.0;
};
nlohmann::ordered_json essentials_json(const Essentials& essentials, const Analysis& analysis);

/// One object, the same keys for every measurement; null is what is not known or not to be trusted.
nlohmann::ordered_json json_of(const LatencyReport& report);
/// Lines for people.
std::string text_of(const LatencyReport& report);
/// A page: impulse response, spectrum, group delay, the delay of every probe.
std::vector<Plot> picture_of(const LatencyReport& report);
/// A page: impulse response, spectrum, group delay of an actuator and a sensor.
std::vector<Plot> picture_of(const Calibration& calibration);

/// With so many digits behind the point; 0 has no sign.
std::string fixed(double value, int digits);
/// "960.0031 ± 0.0004": as many digits as the error leaves.
std::string with_error(double value, double standard_error);

}  // namespace tactus::app
