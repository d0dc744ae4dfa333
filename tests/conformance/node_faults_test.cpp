#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <set>

#include "engine/nodes/table.h"
#include "tests/conformance/node_cases.h"
#include "tests/support/graphs/graph_runner.h"

// What a broken sensor, driver or control program can deliver, at every input of every node in a running
// graph, and beside it a branch that must not notice.

using namespace tactus;
using namespace tactus::test;

namespace {

constexpr int kFrames = 6000, kBadFrom = 1000, kBadTo = 1333;
/// For what remains at the end of those: 1e30 is 690 dB above what came before.
constexpr int kManyFrames = 32 * kFrames;
/// As a share of the largest sample.
constexpr double kNothing = 1e-9;

enum class Bad { NotANumber, Infinity, MinusInfinity, Huge, MinusHuge, Denormal, Square, Dc };
constexpr Bad kAllBad[] = {Bad::NotANumber, Bad::Infinity, Bad::MinusInfinity, Bad::Huge,
                           Bad::MinusHuge,  Bad::Denormal, Bad::Square,        Bad::Dc};

double bad_sample(Bad bad, int frame) {
  switch (bad) {
    case Bad::NotANumber:
      return std::numeric_limits<double>::quiet_NaN();
    case Bad::Infinity:
      return std::numeric_limits<double>::infinity();
    case Bad::MinusInfinity:
      return -std::numeric_limits<double>::infinity();
    case Bad::Huge:
      return 1e30;
    case Bad::MinusHuge:
      return -1e30;
    case Bad::Denormal:
      return 1e-310;
    case Bad::Square:
      return frame / 41 % 2 == 0 ? 1 : -1;
    case Bad::Dc:
      break;
  }
  return 1;
}

bool finite(Bad bad) { return std::isfinite(bad_sample(bad, 0)); }

/// A graph around one node or network, "tested", of which one port hears `p`: what can go wrong.
struct Rig {
  std::string name;            ///< "delay.time"
  std::string node, networks;  ///< lines of the file
  std::string from;            ///< what the node is listened to by
  std::string unit;            ///< of the port
  Interval good;
  std::filesystem::path file = "test.toml";
};

/// To the last bit.
std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

double middle_of(const Rig& rig) { return 0.5 * (rig.good.low + rig.good.high); }

std::string graph_text(const Rig& rig, bool by_control) {
  const bool plain = rig.unit.empty() || rig.unit == "any" || rig.unit[0] == '=';
  const std::string unit = plain ? "" : "unit = \"" + rig.unit + "\"";
  std::string text = "format = 1\n[inputs]\nx = {}\n";
  if (!by_control) text += "p = { " + unit + " }\n";
  if (by_control)
    text += "[controls]\np = { value = " + number(middle_of(rig)) + (plain ? "" : ", ") + unit + " }\n";
  return text + "[nodes]\n" + rig.node +
         "other = { type = \"delay\", in = \"x + 0.6 * other\", time = \"11 / system.rate\" }\n" +
         rig.networks + "[outputs]\ny = { from = \"" + rig.from + "\" }\nother = { from = \"other\" }\n";
}

struct RunResult {
  Channels out;
  std::vector<FaultCount> faults;
  std::int64_t bad_inputs = 0;
};

RunResult run_with(Player& engine, const Rig& rig, std::optional<Bad> bad, bool by_control,
                   int frames = kFrames, const std::vector<int>& blocks = {64, 100}) {
  auto samples = noise(frames, 7, rig.good.low, rig.good.high);
  Channels in{noise(frames, 1)};
  std::vector<JournalEntry> journal;
  if (by_control) {
    const auto move = [&](int frame, double value) {
      journal.push_back(
          {.frame = frame, .kind = JournalEntry::Kind::ControlChange, .index = 0, .value = value});
    };
    if (bad)
      for (int frame = kBadFrom; frame < kBadTo; frame += 41) move(frame, bad_sample(*bad, frame));
    if (bad) move(kBadTo, middle_of(rig));
  } else {
    for (int n = kBadFrom; bad && n < kBadTo; ++n) samples[static_cast<std::size_t>(n)] = bad_sample(*bad, n);
    in.push_back(std::move(samples));
  }
  engine.set_journal(std::move(journal));
  RunResult result;
  result.out = run(engine, in, frames, blocks);
  result.faults = engine.faults();
  result.bad_inputs = engine.bad_input_samples();
  return result;
}

/// How far from the undisturbed output the last quarter is, as a share of its largest sample.
double left_over(const Samples& out, const Samples& undisturbed) {
  double most = 1e-3, apart = 0;
  for (std::size_t n = out.size() * 3 / 4; n < out.size(); ++n) {
    most = std::max(most, std::abs(undisturbed[n]));
    apart = std::max(apart, std::abs(out[n] - undisturbed[n]));
  }
  return apart / most;
}

std::vector<Rig> node_rigs();
std::vector<Rig> network_rigs();

/// By definition what comes in has an effect for ever, until another trigger or reset.
const std::set<std::string> kRemember = {
    "counter.trigger", "counter.reset",   // counts
    "latch.set", "latch.reset",           // the last one of the two
    "curve.trigger",                      // stays at its last point
    "hysteresis.in", "hysteresis.width",  // where the play was left
    "proxy.x", "proxy.y", "proxy.z", "proxy.at_x", "proxy.at_y", "proxy.at_z", "proxy.pitch",
    "proxy.friction",       // where friction holds the proxy
    "sample_hold.trigger",  // the sample held
    "state.trigger",        // the value taken over
    "interval.trigger",     // the time since
    "toggle.trigger", "toggle.reset",
    "sequence.trigger",  // the place in the list
    "pitch.in",          // the last pitch that was clear
    "random_walk.time",  // a sum of all steps
    // the phase, a sum of all frequencies
    "sine.frequency", "wavetable.frequency", "phasor.frequency", "phasor.reset", "saw.frequency",
    "square.frequency", "triangle.frequency", "clock.tempo", "clock.division", "clock.swing", "clock.reset"};

}  // namespace

TEST_CASE("faults: whatever comes to an input or a control, the node is finite, named and recovers",
          "[conformance]") {
  auto rigs = node_rigs();
  for (auto& rig : network_rigs()) rigs.push_back(std::move(rig));
  std::set<std::string> remembered, overflowed;
  for (const auto& rig : rigs)
    for (const bool by_control : {false, true}) {
      INFO(graph_text(rig, by_control));
      const auto load = [&] {
        return compile(parse_graph_leniently(graph_text(rig, by_control), rig.file.string()),
                       standard_nodes(), {});
      };
      auto schedule = load();
      CHECK((schedule ? "" : to_string(schedule.error())) == "");
      if (!schedule) continue;
      Player engine{std::move(*schedule)};
      const auto undisturbed = run_with(engine, rig, std::nullopt, by_control);
      CHECK(undisturbed.faults.empty());
      RunResult long_undisturbed;
      for (const auto bad : kAllBad) {
        INFO(rig.name << (by_control ? " by a control" : "") << ", bad input " << static_cast<int>(bad));
        const auto result = run_with(engine, rig, bad, by_control);
        CHECK(std::all_of(result.out[0].begin(), result.out[0].end(),
                          [](double y) { return std::isfinite(y); }));
        CHECK(first_difference({undisturbed.out[1]}, {result.out[1]}) == "");
        CHECK(result.bad_inputs == (finite(bad) || by_control ? 0 : kBadTo - kBadFrom));
        for (const auto& fault : result.faults) CHECK(fault.path == "tested");
        if (!result.faults.empty()) overflowed.insert(rig.name);
        if (!finite(bad)) CHECK(result.faults.empty());
        if (remembered.count(rig.name) == 0 && left_over(result.out[0], undisturbed.out[0]) > kNothing) {
          if (long_undisturbed.out.empty())
            long_undisturbed = run_with(engine, rig, std::nullopt, by_control, kManyFrames);
          const auto long_after = run_with(engine, rig, bad, by_control, kManyFrames);
          if (left_over(long_after.out[0], long_undisturbed.out[0]) > kNothing) remembered.insert(rig.name);
        }
        const auto recut = run_with(engine, rig, bad, by_control, kFrames, {1, 37, 100, 3});
        CHECK(first_difference(result.out, recut.out) == "");
      }
      // Started again, nothing is left of it.
      CHECK(first_difference(undisturbed.out, run_with(engine, rig, std::nullopt, by_control).out) == "");
    }
  CHECK(remembered == kRemember);
  CHECK(overflowed.count("force.force") == 1);  // 1e30 N between masses and contacts
}

TEST_CASE("faults: a node that was given what is no number is as new after a reset", "[conformance]") {
  for (const auto* type : standard_nodes().types)
    for (const auto& one : ordinary_cases(*type, 640, 2)) {
      auto runner = one.runner();
      const auto fresh = runner.run(even_cutting(640, kLongestSubBlock));
      for (const auto bad : kAllBad)
        for (const auto& port : type->inputs) {
          if (port.fixed) continue;
          INFO(one.label << ": " << port.name << ", bad input " << static_cast<int>(bad));
          Samples samples(640);
          for (int n = 0; n < 640; ++n) samples[static_cast<std::size_t>(n)] = bad_sample(bad, n);
          std::vector<Samples> held;
          for (const auto& other : type->inputs)
            held.push_back(other.name == port.name ? samples : Samples(640, typical_range(other).high));
          std::vector<Signal> in;
          for (const auto& values : held) in.push_back({values.data(), 1});
          Outputs outputs(type->outputs.size(), Samples(640));
          for (int from = 0; from < 640; from += kLongestSubBlock) {
            std::vector<double*> out;
            auto moved = in;
            for (auto& signal : moved) signal.data += from;
            for (auto& output : outputs) out.push_back(output.data() + from);
            runner.node().process({moved.data(), out.data(), kLongestSubBlock, from});
          }
          CHECK(first_difference(fresh, runner.run(even_cutting(640, kLongestSubBlock))) == "");
        }
    }
}

namespace {

/// Inside its range; a rate that is over before the end is looked at.
double resting(const InputPort& port) { return port.unit == "=in/s" ? 1000 : 0.7 * typical_range(port).high; }

/// Every input of every type, with the settings of its example; inputs that must be wired hear `x`.
std::vector<Rig> node_rigs() {
  std::vector<Rig> rigs;
  for (const auto* type : standard_nodes().types)
    for (const auto& [variant, settings] : setting_variants(*type))
      for (const auto& port : type->inputs) {
        if (port.fixed) continue;
        Rig rig{type->name + "." + port.name, "", "", "", port.unit, typical_range(port)};
        rig.node = "tested = { type = \"" + type->name + "\"";
        for (const auto& other : type->inputs) {
          if (other.name == port.name)
            rig.node += ", " + other.name + " = \"p\"";
          else if (!other.fallback)
            rig.node += ", " + other.name + " = " + number(resting(other));
        }
        for (const auto& setting : type->settings)
          if (const auto given = settings.find(setting.name); given != settings.end()) {
            rig.node += ", " + setting.name + " = " + as_written(setting, given->second);
            if (setting.kind == Setting::Kind::File)
              rig.file = std::filesystem::path{given->second}.parent_path() / "test.toml";
          }
        if (type->name == "delay") rig.node += ", max = \"20 ms\"";
        rig.node += " }\n";
        rig.from = plain_signal("tested", type->outputs[0].unit);
        rigs.push_back(std::move(rig));
      }
  return rigs;
}

/// One of each kind of element that takes a signal.
std::vector<Rig> network_rigs() {
  struct Port {
    const char *name, *unit;
    double scale;
    const char* line;
  };
  static constexpr Port kPorts[] = {
      {"motion.position", "m", 0.01, "table = { type = \"motion\", position = \"p\" }\n"},
      {"force.force", "N", 1, "push = { type = \"force\", on = \"ball\", force = \"p\" }\n"},
      {"hand.position", "m", 0.01,
       "hand = { type = \"hand\", on = \"ball\", stiffness = \"10 N/m\", damping = \"1 N s/m\", position = "
       "\"p\" }\n"},
      {"hand.force", "N", 1,
       "hand = { type = \"hand\", on = \"ball\", stiffness = \"10 N/m\", damping = \"1 N s/m\", force = "
       "\"p\" }\n"},
      {"coil.voltage", "V", 1,
       "coil = { type = \"coil\", on = \"ball\", voltage = \"p\", force_factor = \"6 T m\", resistance = "
       "\"6 ohm\", inductance = \"1 mH\" }\n"}};
  std::vector<Rig> rigs;
  for (const auto& port : kPorts)
    for (const std::string solver : {"passive", "explicit", "implicit", "exact"}) {
      const bool table = std::string{port.name} == "motion.position";
      Rig rig{port.name, "", "", "tested.ball.position / 1 mm", port.unit, {-port.scale, port.scale}};
      rig.networks =
          "[networks.tested]\nsolver = \"" + solver +
          "\"\nfloor = { type = \"ground\" }\n"
          "ball = { type = \"mass\", mass = \"20 g\", at = \"1 mm\" }\n" +
          port.line + "hold = { type = \"spring\", between = [\"" + (table ? "table" : "floor") +
          "\", \"ball\"], stiffness = \"500 N/m\", damping = \"2 N s/m\" }\n"
          "touch = { type = \"contact\", between = [\"floor\", \"ball\"], stiffness = \"1e4 N/m^1.5\", "
          "loss = \"1 s/m\" }\n";
      rigs.push_back(std::move(rig));
    }
  return rigs;
}

}  // namespace
