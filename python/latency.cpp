#include <algorithm>
#include <cmath>

#include "engine/core/decibels.h"
#include "latency/estimation/analysis.h"
#include "latency/probe/probe.h"
#include "python/convert.h"

namespace tactus::python {
namespace {

std::vector<double> column_of(const Array& samples, py::ssize_t column) {
  std::vector<double> values(static_cast<std::size_t>(samples.shape(0)));
  const auto view = samples.unchecked<2>();
  for (py::ssize_t n = 0; n < view.shape(0); ++n) values[static_cast<std::size_t>(n)] = view(n, column);
  return values;
}

py::list harmonics_of(const Analysis& analysis) {
  py::list levels;
  for (const auto& level : analysis.harmonics_db) levels.append(py::cast(level));
  return levels;
}

template <class List, class Convert>
py::list list_of(const List& list, Convert convert) {
  py::list all;
  for (const auto& item : list) all.append(convert(item));
  return all;
}

/// What is not known is None, as in the report of the program.
py::dict dict_of(const Analysis& analysis) {
  const bool ok = analysis.finding.verdict == Verdict::Ok, detected = analysis.detected;
  const bool known = detected || !ok;
  const double rate = analysis.sample_rate.value;
  const auto if_known = [](bool is_known, double value) -> py::object {
    if (!is_known) return py::none();
    return py::float_(value);
  };
  py::dict all;
  all["verdict"] = code(analysis.finding.verdict);
  all["what"] = analysis.finding.what;
  all["remedy"] = analysis.finding.remedy;
  all["sample_rate"] = rate;
  all["delay_frames"] = if_known(ok, analysis.delay_frames);
  all["delay_ms"] = if_known(ok, 1e3 * analysis.delay_frames / rate);
  all["standard_error_frames"] = if_known(ok, analysis.standard_error_frames);
  all["polarity"] = detected ? py::object{py::int_(analysis.polarity)} : py::none();
  all["gain_db"] = if_known(detected, analysis.gain_db);
  all["snr_db"] = if_known(detected, analysis.snr_db);
  all["drift_ppm"] = if_known(detected && analysis.compared, analysis.drift_ppm);
  all["noise_floor_dbfs"] = if_known(known, analysis.noise_floor_dbfs);
  all["dc"] = if_known(known, analysis.dc);
  all["low_hz"] = if_known(detected, analysis.low_hz);
  all["high_hz"] = if_known(detected, analysis.high_hz);
  all["high_pass_hz"] = if_known(detected, analysis.high_pass_hz);
  all["misfit"] = if_known(detected, analysis.misfit);
  all["harmonics_db"] = harmonics_of(analysis);
  all["group_delay"] = list_of(analysis.group_delay, [](const BandDelay& band) {
    return py::make_tuple(band.centre_hz, band.delay_frames, band.standard_error_frames);
  });
  all["probes"] = list_of(analysis.probes, [rate](const ProbeDelay& probe) {
    return py::make_tuple(static_cast<double>(probe.played_at) / rate, probe.delay_frames, probe.gain_db,
                          probe.level);
  });
  all["steps"] = list_of(analysis.steps, [rate](const DelayStep& step) {
    return py::make_tuple(static_cast<double>(step.frame) / rate, step.frames);
  });
  all["spectrum"] = list_of(analysis.spectrum, [](const ResponsePoint& point) {
    return py::make_tuple(point.frequency_hz, point.gain_db, point.noise_db);
  });
  all["impulse_response"] = array_of(analysis.response);
  all["impulse_response_at"] = analysis.response_at;
  return all;
}

/// `recording`: frames x channels; `played`: frames x 1.
py::dict analyze_latency(const Array& recording, const Array& played, int channel,
                         const py::object& sample_rate) {
  LoopRecording loop;
  loop.sample_rate = Hertz{quantity(sample_rate, "Hz", "sample_rate", 1e3, 1e6)};
  loop.played = column_of(played, 0);
  for (py::ssize_t c = 0; c < recording.shape(1); ++c) loop.captured.push_back(column_of(recording, c));
  loop.played.resize(std::max(loop.played.size(), loop.captured.front().size()));
  std::optional<Analysis> analysis;
  {
    const py::gil_scoped_release unlocked;
    analysis = or_throw(analyze(loop, {channel, {}}));
  }
  return dict_of(*analysis);
}

py::array latency_probe(const py::object& sample_rate, double level_dbfs) {
  const Hertz rate{quantity(sample_rate, "Hz", "sample_rate", 1e3, 1e6)};
  return array_of(stimulus(rate, amplitude_from_db(level_dbfs)));
}

}  // namespace

void add_latency(py::module_& module) {
  module.def("analyze_latency", &analyze_latency);
  module.def("latency_probe", &latency_probe);
}

}  // namespace tactus::python
