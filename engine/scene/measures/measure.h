#pragma once

#include <algorithm>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/error.h"
#include "engine/scene/measures/events.h"
#include "engine/scene/play_scene.h"

// Thread: [control]

namespace tactus {

struct ToneValues;

/// A recording between two times, at most to its end, with what a measure is taken of. Signals that the
/// measure does not need are nullptr.
struct Window {
  /// How times become frames.
  enum class Edges { Down, Nearest };

  const SceneRecording& recording;
  double from_s, to_s;
  Edges edges;
  const RecordedSignal* signal = nullptr;
  const RecordedSignal* beside = nullptr;    ///< what `signal` is compared with
  const PortEnergy* port = nullptr;          ///< of a measure of a port
  const Playability* playability = nullptr;  ///< of a measure of playing
  const ToneValues* tone = nullptr;          ///< likewise; this and the next two: computed before
  const Detection* detection = nullptr;
  std::optional<std::vector<double>> events = {};  ///< instead of those in `signal`

  Window(const SceneRecording& recorded, std::optional<double> from, std::optional<double> to,
         Edges rounded = Edges::Down)
      : recording(recorded),
        from_s(from.value_or(0)),
        to_s(std::min(to.value_or(recorded.seconds()), recorded.seconds())),
        edges(rounded) {}

  Hertz rate() const { return recording.sample_rate; }
  bool empty() const { return !(from_s < to_s); }
  /// The frames of `of` in the window.
  std::span<const double> samples(const RecordedSignal& of) const;
  std::span<const double> samples() const { return samples(*signal); }
  /// Times of events: `events`, or the strikes in a force, or where a trigger rises. Not cut to the window.
  std::vector<double> event_times() const;
};

/// The same window of a run and of its reference.
struct RunPair {
  const Window &run, &reference;
  const Accuracy& accuracy;

  /// What an error of 1 is: as [accuracy] says, else `natural`.
  double scale(double natural) const;
};

/// Any number that is computed from a run. This is the only table of them: [expect], [accuracy], `play`,
/// studies and sweeps find measures in it by name.
struct Measure {
  enum class Subject {
    Nothing,  ///< the whole scene
    Signal,   ///< a signal
    Events,   ///< a trigger, or the strikes in a contact force
    Port,     ///< a port of the scene
    Playing,  ///< what [playability] names
  };
  static constexpr auto kUnitOfSubject = "=of";
  std::string name;
  std::string unit;  ///< or kUnitOfSubject
  std::string doc;
  Subject subject;
  double (*value)(const Window&);  ///< NaN: not defined for this window. nullptr: only compares two runs
  std::string of{};      ///< role that it is taken of if the scene names no signal; empty: must be named
  std::string beside{};  ///< role that it is compared with
  /// Relative error of a run against a reference, for [accuracy]; nullptr: not used there.
  double (*error)(const Measure&, const RunPair&) = nullptr;
  std::string error_doc{};
  bool has_exact = false;  ///< theory can give it as one number
};
const std::vector<Measure>& measures();
/// nullptr if there is none of that name.
const Measure* find_measure(std::string_view name);
/// Names of those with a value, for [expect]; of those with an error, for [accuracy].
std::vector<std::string> value_names();
std::vector<std::string> error_names();

/// Of a recording, between two times. Where events are asked for, `of` is a trigger of the instrument or a
/// contact force (its strikes); of energy it is a port. Errors: UnknownName, Missing.
Result<double> measure(const SceneRecording& recording, const Expectation& expectation);

/// The result of one entry of [expect].
struct ExpectationResult {
  std::string name, measure;
  double value = 0;
  std::string unit;
  bool holds = false;
  std::string wanted;   ///< "at least 15 Hz"
  bool reached = true;  ///< false: the run ended before its window did, so that nothing is judged
};
/// Of a scene that `build_scene` accepted. Errors: UnknownName for what was not recorded all the same.
Checked<std::vector<ExpectationResult>> check_expectations(const SceneSpec& scene,
                                                           const SceneRecording& recording);

/// Relative error of what `accuracy` names in `run`: against its exact value if it has one, else against
/// `reference`, played at the same rate. What should oscillate, or happen, and does not is wrong by 1.
/// Errors: UnknownName if it was not recorded.
Result<double> accuracy_error(const Accuracy& accuracy, const SceneRecording& run,
                              const SceneRecording& reference);

/// Strikes: pushes of a contact force above 5 N; less than 5 ms apart they are one.
std::vector<Strike> strikes_in(const RecordedSignal& contact, Hertz sample_rate);
/// How well triggers at these times detect what touched `contact` between two times. A touch is any
/// audible push; those above 5 N must be detected.
Detection detection_of(const RecordedSignal& contact, Hertz sample_rate,
                       const std::vector<double>& triggers_s, double from_s, double to_s);
/// Times of the first trigger called `name`, with or without its output; empty if there is none.
std::vector<double> triggers_of(const SceneRecording& recording, const std::string& name);

}  // namespace tactus
