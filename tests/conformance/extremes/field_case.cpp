#include "tests/conformance/extremes/field_case.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "engine/graph/file/read_graph.h"
#include "engine/rig/rig.h"
#include "engine/scene/file/scene_spec.h"
#include "engine/scene/play_scene.h"
#include "tests/support/graphs/graph_runner.h"
#include "tests/support/graphs/node_runner.h"
#include "tests/support/temporary_folder.h"

namespace tactus::test {

struct FileKind {
  struct Entry {
    std::string section, key, value;
  };
  std::string name;
  const SectionType& (*fields)();
  std::vector<Entry> entries;  ///< in order
  /// What is wrong with a text; nothing: it was loaded, and is right as far as `judged` says.
  std::function<std::vector<Error>(const std::string& text, Judgement& judged)> load;
};

namespace {

using Kind = FieldType::Kind;
constexpr int kMostFrames = 60'000;  ///< that are played

/// A folder with what the files refer to.
const TemporaryFolder& folder() {
  static const TemporaryFolder made;
  static const bool written = [] {
    made.write("instrument.toml",
               "format = 1\n[inputs]\nmic = { unit = \"full scale\" }\n[controls]\nstrength = { value = 0.5, "
               "range = [0, 1] }\n"
               "[nodes]\nhit = { type = \"onset\", in = \"mic\" }\n[outputs]\nwoofer = { from = \"0.1 * mic "
               "+ strength * hit\" }\n");
    made.write(
        "plant.toml",
        "format = 1\n[inputs]\ndrive = { unit = \"full scale\" }\nlift = { unit = \"m\" }\n[outputs]\n"
        "mic = { from = \"0.01 * drive + lift / 1 m\" }\nmotor = { from = \"drive * 1 N\", unit = \"N\" }\n"
        "stick = { from = \"lift\", unit = \"m\" }\n");
    return true;
  }();
  (void)written;
  return made;
}

std::string text_of(const FileKind& kind, const std::string& section, const std::string& key,
                    const std::string& value) {
  std::string text, open;
  bool written = false;
  const auto write = [&](const std::string& name, const std::string& of) {
    text += name + " = " + of + "\n";
  };
  const auto close = [&] {
    if (open == section && !written && !key.empty()) write(key, value), written = true;
  };
  for (const auto& entry : kind.entries) {
    if (entry.section != open) {
      close();
      open = entry.section;
      text += "[" + open + "]\n";
    }
    const bool tested = entry.section == section && entry.key == key;
    write(entry.key, tested ? value : entry.value);
    written = written || tested;
  }
  close();
  return text;
}

Samples signals_of(const SceneRecording& recording) {
  Samples all;
  for (const auto& signal : recording.signals)
    all.insert(all.end(), signal.samples.begin(), signal.samples.end());
  return all;
}

std::vector<Error> load_scene_text(const std::string& text, Judgement& judged) {
  const auto loaded =
      parse_scene_leniently(text, (folder().path() / "extremes.toml").generic_string(), folder().path());
  auto built = build_scene(loaded, standard_nodes());
  if (!built) return built.error();
  const auto& scene = *loaded.scene;
  const double frames = scene.duration.value * scene.rate.value;
  const double delay = std::round(scene.delay.value * scene.rate.value);
  if (std::abs(built->delay_frames - delay) > 0.5)
    return judged = {Verdict::Wrong, fmt::format("{} frames of delay", built->delay_frames)},
           std::vector<Error>{};
  if (frames > kMostFrames) return {};
  const auto recording = play_scene(scene, *built, 64);
  if (!recording) return {recording.error()};
  auto again = build_scene(loaded, standard_nodes());
  const auto recut = play_scene(scene, *again, 7);
  const auto samples = signals_of(*recording);
  judged = {Verdict::Right, "frames and delay as written"};
  if (!recording->faults.empty()) judged = {Verdict::Wrong, "a fault"};
  for (const double x : samples)
    if (!std::isfinite(x)) judged = {Verdict::Wrong, "a signal is not finite"};
  if (std::abs(static_cast<double>(recording->signals[0].samples.size()) - std::round(frames)) > 1)
    judged = {Verdict::Wrong, fmt::format("{} frames", recording->signals[0].samples.size())};
  if (const auto apart = first_difference({samples}, {signals_of(*recut)}); !apart.empty())
    judged = {Verdict::Wrong, "blocks matter: " + apart};
  return {};
}

std::vector<Error> load_rig_text(const std::string& text, Judgement& judged) {
  const ProfilePlaces places{folder().path(), folder().path(), {}};
  const auto file = (folder().path() / "extremes.toml").generic_string();
  const auto rig = parse_rig(text, file, places);
  if (!rig) return rig.error();
  const auto again = parse_rig(to_text(*rig), file, places);
  judged = again && to_text(*again) == to_text(*rig)
               ? Judgement{Verdict::Right, "reads back the same"}
               : Judgement{Verdict::Wrong, "its text does not read back"};
  return {};
}

/// A profile becomes limits of a drive, which are checked.
std::vector<Error> load_profile_text(const std::string& text, Judgement& judged) {
  const auto profile = parse_profile(text, (folder().path() / "extremes.toml").generic_string());
  if (!profile) return profile.error();
  const auto limits = limits_for(*profile, 10);
  const auto status = check(limits);
  if (!status) return {status.error().at((folder().path() / "extremes.toml").generic_string() + ":1:1")};
  judged = {Verdict::Right, "limits of a drive"};
  return {};
}

std::vector<Error> load_graph_text(const std::string& text, Judgement& judged) {
  auto plan = compile(parse_graph_leniently(text, (folder().path() / "extremes.toml").generic_string()),
                      standard_nodes(), {});
  if (!plan) return plan.error();
  Player player{std::move(*plan)};
  const Channels in(static_cast<std::size_t>(player.in_channels()), noise(500, 1));
  const auto out = run(player, in, 500, {64});
  for (const auto& channel : out)
    for (const double x : channel)
      if (!std::isfinite(x)) judged = {Verdict::Wrong, "an output is not finite"};
  if (!player.faults().empty()) judged = {Verdict::Wrong, "a fault"};
  if (const auto apart = first_difference(out, run(player, in, 500, {1, 37, 3})); !apart.empty())
    judged = {Verdict::Wrong, "blocks matter: " + apart};
  return {};
}

const std::vector<FileKind>& file_kinds() {
  static const std::vector<FileKind::Entry> scene = {
      {"", "format", "1"},
      {"", "rate", "\"48 kHz\""},
      {"", "delay", "\"5 ms\""},
      {"", "duration", "\"1.1 s\""},
      {"parts.instrument", "use", "\"instrument.toml\""},
      {"parts.instrument", "mic", "\"plant.mic\""},
      {"parts.plant", "use", "\"plant.toml\""},
      {"parts.plant", "drive", "\"instrument.woofer\""},
      {"parts.plant", "lift", "\"finger\""},
      {"gestures.finger", "points", "[[\"0 s\", \"0 m\"], [\"10 ms\", \"1 mm\"]]"},
      {"converters", "bits", "24"},
      {"drives.woofer", "profile", "\"profile.toml\""},
      {"drives.woofer", "volts_per_full_scale", "\"10 V\""},
      {"ports.arm", "force", "\"plant.motor\""},
      {"ports.arm", "position", "\"plant.stick\""},
      {"ports.arm", "active_up_to", "\"1 J\""},
      {"roles", "contact", "\"plant.motor\""},
      {"expect.peak", "measure", "\"peak\""},
      {"expect.peak", "of", "\"plant.stick\""},
      {"expect.peak", "max", "\"1 m\""},
      {"accuracy.place", "measure", "\"position\""},
      {"accuracy.place", "of", "\"plant.stick\""},
      {"playability", "kind", "\"roll\""},
      {"playability", "from", "\"1 ms\""},
      {"playability", "hits", "\"instrument.hit\""},
      {"compare", "name", "\"weaker\""},
      {"compare", "strength", "0.1"},
      {"show", "from", "\"1 ms\""},
  };
  static const std::vector<FileKind::Entry> tone = [] {
    auto entries = scene;
    std::erase_if(entries, [](const auto& entry) { return entry.section == "playability"; });
    for (const auto& [key, value] :
         {std::pair{"kind", "\"tone\""}, {"sound", "\"instrument.woofer\""}, {"pitch", "\"440 Hz\""}})
      entries.push_back({"playability", key, value});
    return entries;
  }();
  static const std::vector<FileKind::Entry> rig = {
      {"", "format", "1"},
      {"device", "output", "\"card\""},
      {"inputs.mic", "channel", "1"},
      {"inputs.mic", "volts_per_full_scale", "\"1 V\""},
      {"inputs.mic", "sensitivity", "\"50 mV\""},
      {"outputs.woofer", "channel", "1"},
      {"outputs.woofer", "profile", "\"profile.toml\""},
      {"outputs.woofer", "volts_per_full_scale", "\"10 V\""},
      {"actuators.shaker", "channel", "2"},
      {"actuators.shaker", "profile", "\"profile.toml\""},
      {"actuators.shaker", "volts_per_full_scale", "\"10 V\""},
      {"controls", "strength", "0.5"},
      {"midi.strength", "control", "7"},
      {"midi.volume", "note", "36"},
      {"midi_out.hit", "note", "38"},
      {"midi_out.strength", "control", "7"},
      {"midi_out.rate", "clock", "true"},
      {"osc.strength", "address", "\"/1/fader3\""},
      {"hid.strength", "axis", "1"},
      {"hid.volume", "button", "2"},
      {"delay", "measured", "\"10 ms\""},
  };
  static const std::vector<FileKind::Entry> profile = {
      {"", "format", "1"},
      {"drive", "resistance", "\"6.5 ohm\""},
      {"drive", "peak", "\"20 V\""},
      {"drive", "soft_start", "\"200 ms\""},
      {"drive", "fade_out", "\"5 ms\""},
      {"heat", "power", "\"30 W\""},
      {"heat", "coil_time", "\"5 s\""},
      {"heat", "body_time", "\"1200 s\""},
      {"heat", "coil_share", "0.6"},
      {"heat", "rise", "120"},
      {"travel", "limit", "\"6 mm\""},
      {"travel", "mass", "\"35 g\""},
      {"travel", "stiffness", "\"1000 N/m\""},
      {"travel", "damping", "\"1.2 kg/s\""},
      {"travel", "force_factor", "\"6 T m\""},
      {"direct", "level", "\"3 V\""},
      {"direct", "time", "\"10 s\""},
  };
  static const std::vector<FileKind::Entry> graph = {
      {"", "format", "1"},
      {"inputs.x", "lanes", "1"},
      {"controls.gain", "value", "0.5"},
      {"controls.gain", "range", "[0, 1]"},
      {"nodes.soft", "type", "\"one_pole\""},
      {"nodes.soft", "in", "\"gain * x\""},
      {"nodes.soft", "cutoff", "\"100 Hz\""},
      {"networks.body", "solver", "\"passive\""},
      {"networks.body", "ball", "{ type = \"oscillator\", mass = \"10 g\", frequency = \"100 Hz\" }"},
      {"outputs.y", "from", "\"soft\""},
      {"delay", "tested", "[\"0 s\", \"10 ms\"]"},
  };
  static const std::vector<FileKind> kinds = [] {
    const FileKind of_profile{"profile", profile_fields, profile, load_profile_text};
    folder().write("profile.toml", text_of(of_profile, "", "", ""));
    return std::vector<FileKind>{{"scene", scene_fields, scene, load_scene_text},
                                 {"scene (tone)", scene_fields, tone, load_scene_text},
                                 {"rig", rig_fields, rig, load_rig_text},
                                 of_profile,
                                 {"graph", graph_fields, graph, load_graph_text}};
  }();
  return kinds;
}

/// The places of numbers in the value of a field.
std::vector<std::string> shapes_of(const FieldType& field) {
  switch (field.kind) {
    case Kind::Quantity:
    case Kind::Integer:
    case Kind::Any:
    case Kind::Channels:
      return {"@"};
    case Kind::Range:
      return {"[@, 1]", "[0, @]"};
    case Kind::Points:
      return {"[[0, 0], [@, 1]]", "[[0, 0], [0.01, @]]"};
    default:
      return {};
  }
}

/// The name of the entry that the text of a kind has in a section of free names.
std::vector<std::string> sections_of(const FileKind& kind, const std::string& name, bool entries) {
  std::vector<std::string> found;
  for (const auto& entry : kind.entries)
    if (entry.section == name || (entries && entry.section.starts_with(name + ".")))
      if (found.empty() || found.back() != entry.section) found.push_back(entry.section);
  return found;
}

void add_cases(const FileKind& kind, const std::string& section, const SectionType& type,
               const std::string& chosen, std::vector<FieldCase>& cases, std::vector<std::string>& missing) {
  for (const auto& field : type.fields) {
    if (field.inside != nullptr) {
      const auto inside = sections_of(kind, field.name, field.kind == Kind::Entries);
      if (inside.empty()) missing.push_back(kind.name + " " + field.name);
      for (const auto& one : inside) add_cases(kind, one, *field.inside, chosen, cases, missing);
      continue;
    }
    if (!field.only.empty() && field.only != chosen) continue;
    for (const auto& shape : shapes_of(field)) {
      const bool limits = field.kind == Kind::Quantity || field.kind == Kind::Integer;
      for (const double value :
           extreme_values(limits ? Interval{field.low, field.high} : Interval{}, field.kind == Kind::Integer))
        cases.push_back({&kind, section, field, shape, value});
    }
    if (field.kind == Kind::Settings)
      for (const double value : extreme_values({}, false))
        cases.push_back({&kind, field.name, {.name = "strength", .kind = Kind::Any, .doc = ""}, "@", value});
  }
}

std::string chosen_kind(const FileKind& kind) {
  for (const auto& entry : kind.entries)
    if (entry.key == "kind") return entry.value.substr(1, entry.value.size() - 2);
  return "";
}

struct AllFields {
  std::vector<FieldCase> cases;
  std::vector<std::string> missing;
};
const AllFields& all_fields() {
  static const AllFields all = [] {
    AllFields made;
    for (const auto& kind : file_kinds())
      add_cases(kind, "", kind.fields(), chosen_kind(kind), made.cases, made.missing);
    return made;
  }();
  return all;
}

std::string written(const FieldCase& c) {
  auto number = fmt::format("{:.17g}", c.value);
  const bool whole =
      std::floor(c.value) == c.value && std::abs(c.value) < 1e15 && !(c.value == 0 && std::signbit(c.value));
  if (number.find_first_of(".e") == std::string::npos && !(whole && c.field.kind != Kind::Quantity))
    number += ".0";
  auto value = c.shape;
  value.replace(value.find('@'), 1, number);
  return value;
}

}  // namespace

std::string FieldCase::name() const {
  return fmt::format("{} [{}] {} = {}", kind->name, section, field.name, written(*this));
}
std::string FieldCase::family() const { return kind->name.substr(0, kind->name.find(' ')); }

std::vector<FieldCase> field_cases() { return all_fields().cases; }
std::vector<std::string> missing_sections() { return all_fields().missing; }

Judgement judge(const FieldCase& c) {
  const auto wrong = [](std::string reason) { return Judgement{Verdict::Wrong, std::move(reason)}; };
  const auto text = text_of(*c.kind, c.section, c.field.name, written(c));
  Judgement judged;
  const auto errors = c.kind->load(text, judged);
  const bool limits = c.field.kind == Kind::Quantity || c.field.kind == Kind::Integer;
  const double taken = taken_for(c.value);
  const bool beyond = limits && (!(taken >= c.field.low && taken <= c.field.high) ||
                                 (c.field.kind == Kind::Integer && std::floor(taken) != taken));
  if (errors.empty()) return beyond ? wrong("accepted beyond its range") : judged;
  // An extreme value may be wrong in more than one way.
  const auto names_key = [&](const Error& error) {
    return error.what.find("'" + c.field.name + "'") != std::string::npos;
  };
  const auto named = std::ranges::find_if(errors, names_key);
  const auto& error = named != errors.end() ? *named : errors.front();
  const auto message = to_string(error);
  // A loop without a delay is one of the graphs that the scene joins.
  if (error.where.find(".toml:") == std::string::npos) return wrong("refused without a place: " + message);
  if (error.remedy.empty()) return wrong("refused without a remedy: " + message);
  if (beyond && !names_key(error)) return wrong("the refusal does not name the key: " + message);
  return {Verdict::Refused, message};
}

}  // namespace tactus::test
