#include <algorithm>
#include <atomic>

#include "engine/nodes/table.h"
#include "engine/scene/build_scene.h"
#include "engine/scene/measures/measure.h"
#include "engine/scene/play_scene.h"
#include "engine/study/stability/stability_check.h"
#include "engine/study/sweep/sweep.h"
#include "python/convert.h"

namespace tactus::python {
namespace {

constexpr double kLongestScene_s = 3600;

/// Without the lock.
LoadedScene load(const Target& target, const Place& place) {
  return load_scene_leniently(target.file, target.root(), instrument_folders(place.shipped));
}
LoadedScene load_scene(const Place& place) {
  if (place.is_text) return parse_scene_leniently(place.text, kTextName);
  const auto target = target_of(place, FolderMeans::Scene);
  if (!target.scene)
    throw failure({Errc::BadArgument, target.file.string(), "this is an instrument, and not a scene",
                   "load it with tactus.load, or write a scene.toml that connects it to a plant"});
  return load(target, place);
}

struct PlayedScene {
  SceneSpec scene;
  SceneRecording recording;
  std::vector<ExpectationResult> outcomes;
  std::vector<Error> warnings;

  bool passed() const {
    const auto met = [](const ExpectationResult& outcome) { return outcome.holds || !outcome.reached; };
    return recording.faults.empty() && !recording.guard.faded() && std::ranges::all_of(outcomes, met);
  }
};
using Played = std::shared_ptr<PlayedScene>;

/// Without the lock.
Played play(LoadedScene loaded, const SceneOptions& changes, std::optional<Seconds> duration, int block) {
  if (!loaded.scene) throw Failure{std::move(loaded.errors)};
  auto& scene = *loaded.scene;
  if (duration) scene.duration = *duration;
  auto built = or_throw(build_scene(loaded, standard_nodes(), changes));
  std::vector<Error> warnings;
  for (const auto* player : {&built.instrument, &built.plant})
    for (const auto& warning : (*player)->plan().warnings) warnings.push_back(warning);
  InterruptCheck check_interrupt;
  auto recording = or_throw(play_scene(scene, built, block, [&](double) { check_interrupt(); }));
  auto outcomes = or_throw(check_expectations(scene, recording));
  return std::make_shared<PlayedScene>(
      PlayedScene{std::move(scene), std::move(recording), std::move(outcomes), std::move(warnings)});
}

Played run_scene(const Place& place, const py::dict& parameters, const py::object& delay,
                 const py::object& rate, const py::object& duration, int block) {
  SceneOptions changes;
  changes.set = control_values(parameters);
  changes.delay = seconds_of(delay, "delay", 0, 10);
  changes.rate = rate_of(rate);
  const auto seconds = seconds_of(duration, "duration", 1e-3, kLongestScene_s);
  const py::gil_scoped_release unlocked;
  return play(load_scene(place), changes, seconds, block);
}

py::dict signals_of(const Played& played) {
  py::dict signals;
  for (const auto& signal : played->recording.signals)
    signals[py::str(signal.name)] = view_of(signal.samples, played);
  return signals;
}

py::dict units_of(const PlayedScene& played) {
  py::dict units;
  for (const auto& signal : played.recording.signals)
    units[py::str(signal.name)] = to_string(signal.dimension);
  return units;
}

/// The triggers of the instrument by name, each with its times.
py::dict events_of(const PlayedScene& played) {
  py::dict events;
  const std::string prefix = "instrument.";
  for (const auto& signal : played.recording.signals) {
    const auto dot = signal.name.find('.', prefix.size());
    if (!signal.name.starts_with(prefix) || dot == signal.name.npos || signal.name.ends_with(".level"))
      continue;
    const auto node = signal.name.substr(prefix.size(), dot - prefix.size());
    events[py::str(node)] = array_of(trigger_times(signal.samples, played.recording.sample_rate));
  }
  return events;
}

py::list outcomes_of(const PlayedScene& played) {
  py::list outcomes;
  for (const auto& one : played.outcomes)
    outcomes.append(py::make_tuple(one.name, one.value, one.unit, one.wanted, one.holds, one.reached));
  return outcomes;
}

py::list faults_of(const PlayedScene& played) {
  py::list faults;
  for (const auto& fault : played.recording.faults) faults.append(py::make_tuple(fault.path, fault.count));
  return faults;
}

/// (value, unit)
py::tuple measure_of(const PlayedScene& played, const std::string& text, std::optional<double> from_s,
                     std::optional<double> to_s) {
  auto expectation = or_throw(find_swept_measure(played.scene, text));
  if (from_s) expectation.from_s = from_s;
  if (to_s) expectation.to_s = to_s;
  const double value = or_throw(measure(played.recording, expectation));
  const auto* type = find_measure(expectation.measure);
  const auto* signal = played.recording.find(expectation.of);
  const bool own = type == nullptr || type->unit != Measure::kUnitOfSubject || signal == nullptr;
  return py::make_tuple(value, own ? unit_of(expectation) : to_string(signal->dimension));
}

// ---- sweeps ----

/// What a sweep runs over, besides the scene.
struct SweepRequest {
  std::vector<std::pair<std::string, std::vector<ControlValue>>> over;
  std::vector<std::string> solvers;  ///< of the quantity "solver"
  std::map<std::string, ControlValue> set;
  std::vector<std::string> measures;
  std::optional<double> from_s, to_s;
  std::optional<Seconds> duration;
  int draws = 0, threads = 0;
  double within = 0.2;
  std::uint64_t seed = 1;
  std::string keep;
};

SweepRequest request_of(const py::dict& over, const py::dict& set) {
  SweepRequest request;
  request.set = control_values(set);
  for (const auto& [key, values] : over) {
    const auto name = py::cast<std::string>(py::str(key));
    if (request.set.contains(name))
      throw failure({Errc::BadArgument, "argument 'parameters'",
                     "'" + name + "' is swept, and cannot be set too", "omit one of them"});
    auto& swept = request.over.emplace_back(name, std::vector<ControlValue>{}).second;
    for (const auto& value : values) {
      if (name == "solver")
        request.solvers.push_back(py::cast<std::string>(value));
      else
        swept.push_back(control_value(value, name));
    }
  }
  return request;
}

/// Without the lock.
SweepTable run(const Place& place, const SweepRequest& request) {
  auto loaded = load_scene(place);
  if (!loaded.scene || !loaded.errors.empty()) throw Failure{std::move(loaded.errors)};
  auto& scene = *loaded.scene;
  if (request.duration) scene.duration = *request.duration;
  SweepPlan plan;
  plan.workers = request.threads;
  plan.cache = request.keep;
  for (const auto& [name, values] : request.over)
    plan.over.push_back(name == "solver" ? or_throw(swept_solvers(request.solvers, "argument 'solver'"))
                                         : or_throw(find_swept(scene, name, values)));
  plan.set = request.set;
  plan.draws = request.draws;
  plan.within = request.within;
  plan.seed = request.seed;
  std::atomic<bool> interrupted{false};
  plan.progress = [&](double) {
    if (!interrupted && InterruptCheck::pending()) interrupted = true;
  };
  plan.stop = [&] { return interrupted.load(); };
  std::vector<Expectation> measures;
  for (const auto& text : request.measures) {
    auto& measure = measures.emplace_back(or_throw(find_swept_measure(scene, text)));
    if (request.from_s) measure.from_s = request.from_s;
    if (request.to_s) measure.to_s = request.to_s;
  }
  auto table = or_throw(sweep_measures(scene, standard_nodes(), plan, measures));
  if (interrupted) throw Interrupted{};
  return table;
}

/// (points as rows of values, their variants, rows of measures, units)
py::tuple sweep(const Place& place, const py::dict& over, const py::dict& set,
                std::vector<std::string> measures, std::optional<double> from_s, std::optional<double> to_s,
                const py::object& duration, int draws, double within, std::uint64_t seed, int threads,
                std::string keep) {
  auto request = request_of(over, set);
  request.measures = std::move(measures);
  request.from_s = from_s;
  request.to_s = to_s;
  request.duration = seconds_of(duration, "duration", 1e-3, kLongestScene_s);
  request.draws = draws;
  request.within = within;
  request.seed = seed;
  request.threads = threads;
  request.keep = std::move(keep);
  SweepTable table;
  {
    const py::gil_scoped_release unlocked;
    table = run(place, request);
  }
  py::list at, variants, results, units;
  for (const auto& point : table.points) {
    at.append(point.at);
    variants.append(point.variant);
    results.append(*point.result);
  }
  for (const auto& measure : table.measures) units.append(unit_of(measure));
  return py::make_tuple(at, variants, results, units);
}

// ---- stability ----

/// (verdict, sentences, runs that were not as predicted)
py::tuple check(const Place& place, const py::dict& parameters, const py::object& delay,
                const py::object& rate, bool quick, int threads) {
  StabilityOptions options;
  options.world.set = control_values(parameters);
  options.world.rate = rate_of(rate);
  options.world.delay = seconds_of(delay, "delay", 0, 10);
  StabilityReport report;
  {
    const py::gil_scoped_release unlocked;
    const auto target = place.is_text ? Target{} : target_of(place, FolderMeans::Scene);
    std::optional<LoadedScene> scene;
    std::optional<LoadedGraph> instrument;
    if (target.scene) {
      scene = load(target, place);
      if (!scene->scene) throw Failure{scene->errors};
      if (!options.world.delay) options.world.delay = scene->scene->delay;
    } else {
      instrument = place.is_text ? parse_graph_leniently(place.text, kTextName)
                                 : load_graph_leniently(target.file, target.root());
      if (instrument->spec == nullptr) throw Failure{instrument->errors};
      if (const auto& tested = instrument->spec->tested; tested && !options.world.delay)
        options.world.delay = Seconds{tested->high};
    }
    report = or_throw(
        check_stability({scene ? &*scene : nullptr, instrument ? &*instrument : nullptr, &standard_nodes()},
                        options, quick, {}, threads));
  }
  return py::make_tuple(name_of(report.stability()), describe(report.verdict));
}

}  // namespace

void add_scenes(py::module_& module) {
  py::class_<PlayedScene, Played>(module, "PlayedScene")
      .def_property_readonly("name", [](const PlayedScene& played) { return played.scene.name; })
      .def_property_readonly("sample_rate",
                             [](const PlayedScene& played) { return played.recording.sample_rate.value; })
      .def_property_readonly("delay_frames",
                             [](const PlayedScene& played) { return played.recording.delay_frames; })
      .def_property_readonly("duration", [](const PlayedScene& played) { return played.recording.seconds(); })
      .def_property_readonly("inputs", [](const PlayedScene& played) { return played.recording.inputs; })
      .def_property_readonly("outputs", [](const PlayedScene& played) { return played.recording.outputs; })
      .def_property_readonly("passed", &PlayedScene::passed)
      .def_property_readonly("warnings",
                             [](const PlayedScene& played) { return error_list(played.warnings); })
      .def_property_readonly("guard",
                             [](const PlayedScene& played) {
                               return describe(played.recording.guard, played.recording.sample_rate);
                             })
      .def_property_readonly("signals", &signals_of)
      .def_property_readonly("units", &units_of)
      .def_property_readonly("events", &events_of)
      .def_property_readonly("outcomes", &outcomes_of)
      .def_property_readonly("faults", &faults_of)
      .def("measure", &measure_of);
  module.def("run_scene", &run_scene);
  module.def("sweep", &sweep);
  module.def("check", &check);
}

}  // namespace tactus::python
