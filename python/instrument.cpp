#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "backends/take/replay.h"
#include "engine/graph/file/load.h"
#include "engine/graph/file/quantity.h"
#include "engine/nodes/table.h"
#include "engine/rig/profile.h"
#include "engine/runtime/player.h"
#include "engine/scene/guard_report.h"
#include "python/convert.h"

namespace tactus::python {
namespace {

/// What a control does while an instrument is rendered.
struct ControlMove {
  std::string control;
  std::vector<std::int64_t> frames;  ///< they rise
  std::vector<double> values;        ///< SI
  bool at_once = false;              ///< without the control's ramp
};

/// What the drives move, for the guard.
struct DriveOptions {
  std::string profile;  ///< of the actuator, a name or a file; empty: not known
  double volts = 0;     ///< at full scale
  std::vector<std::pair<std::string, std::string>> raises;  ///< (limit or OUTPUT.LIMIT, value)
  std::string shipped;                                      ///< the folder of the shipped profiles
};

/// Without the lock. Throws a Failure: UnknownName of the profile, those of its file, OutOfRange.
LimitBook limits_of(const DriveOptions& options) {
  LimitBook limits;
  for (const auto& [name, value] : options.raises) {
    const auto dot = name.rfind('.');
    limits.raises.push_back({dot == name.npos ? "" : name.substr(0, dot), name.substr(dot + 1), value});
  }
  if (options.profile.empty()) return limits;
  const auto* place = "argument 'profile'";
  auto folders = instrument_folders(options.shipped);
  folders.push_back(".");
  const auto file = or_throw(find_profile(options.profile, folders, place));
  const auto profile = limits_for(or_throw(load_profile(file)), options.volts);
  if (const auto status = check(profile); !status) throw failure(status.error().at(place));
  limits.drives.push_back({LimitSource::Kind::Profile, "profile '" + options.profile + "'", profile});
  return limits;
}

LoadedGraph load_graph(const Place& place) {
  if (place.is_text) return parse_graph_leniently(place.text, kTextName);
  const auto target = target_of(place, FolderMeans::Instrument);
  if (target.scene)
    throw failure({Errc::BadArgument, target.file.string(), "this is a scene, and not an instrument",
                   "play it with tactus.run_scene, or load the instrument that it names"});
  return load_graph_leniently(target.file, target.root());
}

/// Entries in the order of their frames.
std::vector<JournalEntry> journal_of(const std::vector<ControlMove>& moves, const Player& player) {
  std::vector<JournalEntry> entries;
  for (const auto& move : moves) {
    const auto place = "argument '" + move.control + "'";
    const int number = player.control_index(move.control);
    const int planned = player.plan().control_index(move.control);
    if (number < 0 || planned < 0)
      throw failure({Errc::UnknownName, place, "the instrument has no control of this name",
                     "Instrument.controls lists them"});
    const auto& control = player.plan().controls[static_cast<std::size_t>(planned)];
    if (control.frozen)
      throw failure({Errc::BadArgument, place,
                     "this control is read when the graph is compiled, and cannot move", "give one number"});
    const auto& [low, high] = control.control.range;
    for (std::size_t i = 0; i < move.values.size(); ++i) {
      if (!control.control.range.contains(move.values[i]))
        throw failure({Errc::OutOfRange, place, fmt::format("{:g} is out of range", move.values[i]),
                       limits_text(low, high, control.control.unit)});
      entries.push_back({move.frames[i],
                         move.at_once ? JournalEntry::Kind::ControlSet : JournalEntry::Kind::ControlChange,
                         number, move.values[i]});
    }
  }
  std::ranges::stable_sort(entries, {}, &JournalEntry::frame);
  return entries;
}

/// What a run did besides its samples.
struct RunReport {
  GuardReport guard;
  std::vector<FaultCount> faults;
  std::int64_t nonfinite = 0;  ///< input samples
};

/// Frame by frame, as arrays of Python are.
struct Interleaved {
  const double* in;
  double* out;
  std::int64_t frames;
  int in_channels, out_channels;
};

/// Without the lock.
RunReport run(Player& player, const LimitBook& limits, const Interleaved& samples, int block) {
  const auto& plan = player.plan();
  Guarded guarded{player, guarded_channels(plan, limits)};
  RunReport report;
  const auto read = [&, at = samples.in](double* const* to, int count) mutable {
    for (int n = 0; n < count; ++n)
      for (int c = 0; c < samples.in_channels; ++c) {
        report.nonfinite += std::isfinite(*at) ? 0 : 1;
        to[c][n] = *at++;
      }
  };
  InterruptCheck check_interrupt;
  const auto write = [&, at = samples.out](const double* const* from, int count) mutable -> Status {
    for (int n = 0; n < count; ++n)
      for (int c = 0; c < samples.out_channels; ++c) *at++ = from[c][n];
    check_interrupt();
    return {};
  };
  or_throw(run_offline(guarded, {plan.sample_rate, samples.in_channels, samples.frames, read},
                       samples.out_channels, {block}, write));
  report.guard = report_of(guarded, plan, limits);
  report.faults = player.faults();
  return report;
}

/// A graph that compiles. Every run compiles it anew, so runs do not share state.
class Instrument {
 public:
  /// Without the lock. Throws a Failure with the errors of the file.
  Instrument(LoadedGraph graph, CompileOptions options)
      : graph_(std::move(graph)), options_(std::move(options)) {
    if (graph_.spec == nullptr) throw Failure{graph_.errors};
    plan_ = compiled(options_);
  }

  const Plan& plan() const { return *plan_; }
  const GraphSpec& spec() const { return *graph_.spec; }

  /// (array of frames x outputs, report)
  py::tuple render(const Array& inputs, const py::dict& start, const std::vector<ControlMove>& moves,
                   int block, const DriveOptions& drives) const {
    auto options = options_;
    for (auto& [name, value] : control_values(start)) options.controls[name] = value;
    const auto outputs = static_cast<int>(output_names(*plan_).size());
    py::array_t<double> out{{inputs.shape(0), static_cast<py::ssize_t>(outputs)}};
    const Interleaved samples{inputs.data(), out.mutable_data(), inputs.shape(0),
                              static_cast<int>(inputs.shape(1)), outputs};
    RunReport report;
    {
      const py::gil_scoped_release unlocked;
      const auto limits = limits_of(drives);
      Player player{compiled(options)};
      player.set_journal(journal_of(moves, player));
      or_throw(limits.check_raises(limited_outputs(player.plan())));
      report = run(player, limits, samples, block);
    }
    py::list faults;
    for (const auto& fault : report.faults) faults.append(py::make_tuple(fault.path, fault.count));
    return py::make_tuple(out, describe(report.guard, options_.sample_rate), faults, report.nonfinite);
  }

 private:
  std::unique_ptr<Plan> compiled(const CompileOptions& options) const {
    return or_throw(compile(graph_, standard_nodes(), options));
  }

  LoadedGraph graph_;
  CompileOptions options_;
  std::unique_ptr<Plan> plan_;  ///< as loaded
};

std::unique_ptr<Instrument> load(const Place& place, const py::object& sample_rate,
                                 const py::dict& parameters, const py::object& delay) {
  CompileOptions options;
  options.sample_rate = rate_of(sample_rate).value_or(options.sample_rate);
  options.system_delay = seconds_of(delay, "delay", 0, 10).value_or(options.system_delay);
  options.controls = control_values(parameters);
  const py::gil_scoped_release unlocked;
  return std::make_unique<Instrument>(load_graph(place), std::move(options));
}

py::list controls_of(const Instrument& instrument) {
  py::list controls;
  for (const auto& planned : instrument.plan().controls) {
    const auto& control = planned.control;
    controls.append(py::make_tuple(
        control.name, control.value, control.unit.decibel ? "dB" : to_string(control.unit.dimension),
        py::make_tuple(control.range.low, control.range.high), control.smooth_s, planned.frozen));
  }
  return controls;
}

py::list steps_of(const Instrument& instrument) {
  py::list steps;
  for (const auto& step : instrument.plan().steps) {
    if (step.vertex < 0) continue;
    const auto& vertex = instrument.plan().vertices[static_cast<std::size_t>(step.vertex)];
    steps.append(py::make_tuple(vertex.path, vertex.description()));
  }
  return steps;
}

}  // namespace

void add_instrument(py::module_& module) {
  py::class_<Place>(module, "Place").def(py::init([](std::string text, bool is_text, std::string shipped) {
    return Place{std::move(text), is_text, std::move(shipped)};
  }));
  py::class_<ControlMove>(module, "ControlMove")
      .def(py::init([](std::string control, std::vector<std::int64_t> frames, std::vector<double> values,
                       bool at_once) {
        return ControlMove{std::move(control), std::move(frames), std::move(values), at_once};
      }));
  py::class_<DriveOptions>(module, "DriveOptions")
      .def(py::init([](std::string profile, double volts,
                       std::vector<std::pair<std::string, std::string>> raises, std::string shipped) {
        return DriveOptions{std::move(profile), volts, std::move(raises), std::move(shipped)};
      }));
  py::class_<Instrument>(module, "Instrument")
      .def(py::init(&load))
      .def_property_readonly("name", [](const Instrument& instrument) { return instrument.spec().name; })
      .def_property_readonly("about", [](const Instrument& instrument) { return instrument.spec().about; })
      .def_property_readonly("sample_rate",
                             [](const Instrument& instrument) { return instrument.plan().sample_rate.value; })
      .def_property_readonly("inputs",
                             [](const Instrument& instrument) { return instrument.plan().input_names; })
      .def_property_readonly("outputs",
                             [](const Instrument& instrument) { return output_names(instrument.plan()); })
      .def_property_readonly("sounds",
                             [](const Instrument& instrument) { return sound_names(instrument.plan()); })
      .def_property_readonly(
          "warnings", [](const Instrument& instrument) { return error_list(instrument.plan().warnings); })
      .def_property_readonly("controls", &controls_of)
      .def_property_readonly("steps", &steps_of)
      .def("render", &Instrument::render);
}

}  // namespace tactus::python
