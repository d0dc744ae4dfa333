#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "engine/core/error.h"
#include "engine/scene/measures/events.h"
#include "engine/scene/play_scene.h"

namespace tactus {

/// Something that can be asked of a recording, by the name that [expect] uses.
struct MeasureType {
  enum class Subject {
    Nothing,  ///< of the whole scene
    Signal,   ///< of a signal as it is
    Events,   ///< of a trigger, or of the strikes in a contact force
    Port,     ///< of a port of the scene
  };
  static constexpr auto kUnitOfSubject = "=of";
  std::string name;
  std::string unit;  ///< or kUnitOfSubject
  std::string doc;
  Subject subject = Subject::Events;
  std::string of{};      ///< what it is taken of if the scene does not say; empty: the scene must
  std::string beside{};  ///< what it is compared with, if anything
};
/// [any] All of them.
const std::vector<MeasureType>& measure_types();
/// [any] nullptr if there is none of that name.
const MeasureType* find_measure(std::string_view name);
/// [any] What an expectation is taken of.
const std::string& subject_of(const Expectation& expectation, const MeasureType& type);

/// The contact force in which a plant shows its strikes.
inline constexpr auto kStrikeContact = "plant.contact";

/// [control] Of a recording, between two times. Where events are asked for, `of` is a trigger of the
/// instrument ("instrument.hit") or a contact force ("plant.contact": its strikes); of energy it is a port.
/// Errors: UnknownName, Missing.
Result<double> measure(const SceneRecording& recording, const Expectation& expectation);

/// What came of one line of [expect].
struct Outcome {
  std::string name, measure;
  double value = 0;
  std::string unit;
  bool holds = false;
  std::string wanted;  ///< "at least 15 Hz"
};
/// [control] What a scene that could be built promised: `build_scene` has told the mistakes of [expect].
/// Errors: UnknownName for what was not recorded all the same.
Checked<std::vector<Outcome>> check_expectations(const SceneSpec& scene, const SceneRecording& recording);

/// The instrument's strikes on what it plays: pushes of a contact force above 5 N; less than 5 ms apart they
/// are one.
std::vector<Strike> strikes_of(const SceneRecording& recording, const std::string& contact = kStrikeContact);
/// How well triggers at these times heard what touched `contact` between two times. A touch is any push that
/// the ear could follow; of those, pushes above 5 N must be heard.
Detection detection_of(const RecordedSignal& contact, Hertz sample_rate,
                       const std::vector<double>& triggers_s, double from_s, double to_s);
/// Times of the first trigger called `name` ("instrument.hit", with or without its output); empty if there is
/// none.
std::vector<double> triggers_of(const SceneRecording& recording, const std::string& name);

}  // namespace tactus
