#pragma once
// Thread: [control]

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/core/error.h"
#include "engine/core/units.h"
#include "engine/graph/file/field.h"
#include "engine/graph/file/quantity.h"
#include "engine/graph/file/spec.h"
#include "engine/rig/profile.h"

namespace tactus {

/// [any] All keys of a scene.
const SectionType& scene_fields();

/// A part of a scene and what its inputs are wired to: numbers, quantities and expressions of "part.port" and
/// gestures, whose grammar was checked but whose names were not looked up.
struct ScenePart {
  std::string name;
  Source at;
  std::shared_ptr<const GraphSpec> graph;  ///< nullptr only after an error
  Value::Table wires;
};

/// A value over time, given by breakpoints. Before the first it has the first value, behind the last the
/// last.
struct Gesture {
  enum class Curve {
    Linear,  ///< straight from point to point
    Step,    ///< each value holds until the next
    Smooth,  ///< cubic from point to point, at rest in each of them
  };
  struct Point {
    double time_s;
    double value;  ///< SI
  };
  std::string name;
  Source at;
  Curve curve = Curve::Linear;
  Unit unit{};                  ///< of the values, as the first one with a unit is written
  bool bare = false;            ///< no value has a unit: they count in the SI unit of the port
  std::vector<Point> points{};  ///< at least one; times increase
};

/// The converters of the simulated sound card: they quantise to `bits` and clip at full scale.
struct Converters {
  bool on = true;
  int bits = 24;
};

/// "part.port", and where the file names it.
struct SignalName {
  std::string name;
  Source at;
};

/// Where a motor moves the plant: the energy that it gives is added up while the scene plays.
struct Port {
  std::string name;
  Source at;
  SignalName force, position;  ///< outputs of parts: "plant.motor", "plant.arm"
  double allowed = 0;          ///< [J] that the instrument may give
};

/// A signal and what it is to measures and reports, see `role_types`.
struct Role {
  std::string name, signal;
  Source at;
  bool written = false;  ///< in [roles]; else a port plays it by its name
};

/// The kinds of roles.
struct RoleType {
  enum class Of { Signal, Control, PlantControl };  ///< of any part, or of `plant`
  std::string name;
  std::string port;  ///< or control: plays the role where `[roles]` does not name one
  std::string doc;
  Of of = Of::Signal;
};
const std::vector<RoleType>& role_types();
/// The signal or the control that plays a role; empty if there is none.
std::string signal_of(const std::vector<Role>& roles, std::string_view role);

/// A measure of a signal between two times.
struct MeasureEntry {
  std::string name;
  Source at;
  std::string measure{};  ///< empty after an error
  std::string of{};       ///< "part.port", or empty
  Source of_at{};
  std::optional<double> from_s{}, to_s{};
};

/// Limits of a measure that must be met when the scene was played.
struct Expectation : MeasureEntry {
  std::optional<QuantityValue> min, max;  ///< at least one of them
};

/// A measure whose error a study of solvers reports.
struct Accuracy : MeasureEntry {
  std::optional<QuantityValue> exact;  ///< the theoretical value
  std::optional<QuantityValue> scale;  ///< an error of 1; left out: of the reference
};

/// What playing this scene well means: `[playability]`, which `tactus study playability` evaluates.
struct Playability {
  enum class Kind {
    Roll,  ///< repeated strikes
    Tone,  ///< a note that is held, or several
  };
  /// What a roll is wanted to be.
  enum class Roll {
    Even,
    Gallop,     ///< long and short in turn
    Backwards,  ///< intervals that grow
    Any,        ///< even, or a pattern that repeats
  };
  Kind kind = Kind::Roll;
  Source at;
  double from_s = 1;             ///< start of the evaluated window
  std::optional<double> to_s{};  ///< its end; else that of the scene

  // Signals that are left out play the roles "hit", "contact" and "monitor".
  SignalName hits{};     ///< of a roll: the trigger of a detected strike
  SignalName contact{};  ///< the contact force of the strikes
  double fewest = 10;    ///< strikes in its worst second
  Roll roll = Roll::Even;
  std::optional<double> rate_hz{};  ///< strikes a second; empty: any
  SignalName sound{};               ///< of a tone
  double pitch_hz = 0;              ///< the expected note; 0: that of `pitch`
  SignalName pitch{};               ///< the expected notes, one after the other; "": the one of `pitch_hz`
  double begin_s = 0;               ///< when the bow is on the string
  double quiet = 1e-3;              ///< softer than this it is silent: root mean square
};

/// The same scene once more with some controls elsewhere, to show beside it what they do.
struct Comparison {
  std::string name;  ///< "without the pulse"
  Source at;
  std::map<std::string, double> set;     ///< SI, named as `--set` names them
  std::map<std::string, Source> places;  ///< the place of each in the file
};

/// The part of a scene that its plot shows: `[show]`.
struct ShownTimes {
  double from_s = 0;
  std::optional<double> to_s{};  ///< else to the end
};

/// A scene file, read once into plain data: an instrument, the world it plays in, and the gestures that play
/// it.
struct SceneSpec {
  Source file;
  std::string name, about, source;
  Hertz rate = 48_kHz;
  Seconds delay;  ///< system delay
  Seconds duration;
  Seconds whole;                 ///< the duration as the file gives it, when another one is played
  std::vector<ScenePart> parts;  ///< in file order; mostly `instrument` and `plant`
  std::vector<Gesture> gestures;
  Converters converters;
  double monitor_gain = 1;                     ///< of the monitor output in sound files and speakers
  LimitBook drives;                            ///< limits of the drives
  std::map<std::string, Source> drive_places;  ///< where [drives] names them
  std::vector<Port> ports;
  std::vector<Role> roles;          ///< of signals
  std::vector<Role> control_roles;  ///< of controls
  std::vector<Expectation> expect;
  std::vector<Accuracy> accuracy;
  std::optional<Playability> playability;
  std::optional<Comparison> compare;
  ShownTimes shown;
  std::optional<std::uint64_t> seed;  ///< of everything random
  Source duration_at;                 ///< where the file gives it
  bool incomplete = false;            ///< a section could not be read
  bool bench = false;                 ///< an instrument alone, whose plant only generates signals

  /// nullptr if there is none.
  const ScenePart* part(std::string_view name) const;
  const Gesture* gesture(std::string_view name) const;
  const Port* port(std::string_view name) const;
};

/// Gives the roles that no `[roles]` gives to the ports, nodes and controls with their names.
void add_roles_by_name(SceneSpec& scene);

/// A control of a part of a scene.
struct SceneControl {
  const ScenePart* part;
  const ControlSpec* spec;

  /// As options name it: "gamma" of the instrument, "plant.gamma" of another part.
  std::string name() const;
  /// SI, as the scene sets it, else as the part's file does; nullopt: a gesture or a signal moves it.
  std::optional<double> constant() const;
};
/// The names of all controls, part by part.
std::vector<std::string> control_names(const SceneSpec& scene);
/// The control called "gamma", "instrument.gamma" or "plant.gamma"; nullopt if there is none.
std::optional<SceneControl> find_control(const SceneSpec& scene, const std::string& name);
/// The control with a role; nullopt if there is none.
std::optional<SceneControl> control_of(const SceneSpec& scene, std::string_view role);

/// Whether a file is a scene, and not a graph or another file.
bool is_scene(const Value::Table& file);

/// A scene together with the errors in its text and those of its parts; `build_scene` finds the others.
struct LoadedScene {
  std::optional<SceneSpec> scene;  ///< nothing if the file cannot be read or is no TOML
  std::vector<Error> errors;       ///< by file, line and column

  LoadedScene(SceneSpec read) : scene(std::move(read)) {}
  LoadedScene(std::optional<SceneSpec> read, std::vector<Error> found)
      : scene(std::move(read)), errors(std::move(found)) {}
};

/// [control] Reads a scene and the files of its parts; a folder means its scene.toml. `root` is the folder
/// that no path may leave (empty: the scene's own). Names of profiles are looked up there, then in
/// `profiles`.
LoadedScene load_scene_leniently(const std::filesystem::path& path, const std::filesystem::path& root = {},
                                 const ProfileFolders& profiles = {});
/// [control] The same from text; `file_name` is for messages, and relative paths start at its folder.
LoadedScene parse_scene_leniently(std::string_view text, const std::string& file_name,
                                  const std::filesystem::path& root = {});

/// [control] The same; a scene with errors in its text is an error.
Checked<SceneSpec> load_scene(const std::filesystem::path& path, const std::filesystem::path& root = {},
                              const ProfileFolders& profiles = {});

}  // namespace tactus
