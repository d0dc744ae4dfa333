#include "engine/scene/measures/measure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/core/named.h"
#include "engine/core/port_name.h"
#include "engine/graph/file/error_list.h"
#include "engine/graph/file/quantity.h"
#include "engine/scene/file/scene_spec.h"

namespace tactus {
namespace {

using Subject = Measure::Subject;

constexpr Seconds kStrikeGap = 5_ms;
constexpr double kLeastStrike_N = 5.0;
// Any audible push, from its beginning to its end.
constexpr Seconds kTouchGap = 1_ms;
constexpr double kLeastTouch_N = 0.1;

/// Of a node's outputs a trigger, not the level that goes with it.
bool is_event_of(const RecordedSignal& signal, const std::string& node) {
  return signal.name.starts_with(node + ".") && !EventSignal{signal.name}.is_level;
}

/// What a name may mean: a signal, or the triggers of a node, of which each lane has its own.
std::vector<const RecordedSignal*> signals_called(const SceneRecording& recording, const std::string& name) {
  if (const auto* exact = recording.find(name)) return {exact};
  std::vector<const RecordedSignal*> events;
  for (const auto& signal : recording.signals)
    if (is_event_of(signal, name)) events.push_back(&signal);
  return events;
}

/// The first of them; nullptr: there is none.
const RecordedSignal* find_signal(const SceneRecording& recording, const std::string& name) {
  const auto all = signals_called(recording, name);
  return all.empty() ? nullptr : all.front();
}

tl::unexpected<Error> unknown_signal(const SceneRecording& recording, const Expectation& expectation) {
  const auto names = names_of(recording.signals);
  return fail(Errc::UnknownName, (expectation.of.empty() ? expectation.at : expectation.of_at).text(),
              expectation.of.empty() ? "'" + expectation.measure + "' needs an 'of'"
                                     : "no signal '" + expectation.of + "' was recorded",
              suggest(expectation.of, names, "recorded were " + listed(names)));
}

/// Finds what the measure is taken of.
Result<Window> window_of(const SceneRecording& recording, const Expectation& expectation,
                         const Measure& type) {
  Window window{recording, expectation.from_s, expectation.to_s};
  if (recording.playability) window.playability = &*recording.playability;
  if (type.subject == Subject::Playing && window.playability == nullptr)
    return fail(Errc::Missing, expectation.at.text(), "'" + type.name + "' needs [playability]",
                "add a [playability] section with kind = \"roll\" or kind = \"tone\"");
  if (type.subject == Subject::Port) {
    window.port = find_named(recording.ports, expectation.of);
    if (window.port == nullptr)
      return fail(Errc::UnknownName, expectation.of_at.text(), "there is no port '" + expectation.of + "'",
                  "declare it under [ports]");
  }
  if (type.subject != Subject::Signal && type.subject != Subject::Events) return window;
  if (const auto called = signals_called(recording, expectation.of); called.size() > 1) {
    std::vector<std::string> names;
    for (const auto* signal : called) names.push_back(signal->name);
    return fail(Errc::UnknownName, expectation.of_at.text(),
                fmt::format("'{}' is {} signals", expectation.of, names.size()),
                "name one of them: " + listed(names));
  }
  window.signal =
      find_signal(recording, expectation.of.empty() ? signal_of(recording.roles, type.of) : expectation.of);
  if (!type.beside.empty()) window.beside = find_signal(recording, signal_of(recording.roles, type.beside));
  // Without any trigger nothing was detected.
  const bool may_be_silent = !type.beside.empty() && type.subject == Subject::Events;
  if ((window.signal == nullptr && !may_be_silent) || (window.beside == nullptr && !type.beside.empty()))
    return unknown_signal(recording, expectation);
  return window;
}

std::string limits_text(const Expectation& expectation, const std::string& unit) {
  const auto number = [&](const QuantityValue& q) {
    return short_number(q.si) + (unit.empty() ? "" : " " + unit);
  };
  if (expectation.min && expectation.max && expectation.min->si == expectation.max->si)
    return "exactly " + number(*expectation.min);
  if (expectation.min && expectation.max) return number(*expectation.min) + " to " + number(*expectation.max);
  return expectation.min ? "at least " + number(*expectation.min) : "at most " + number(*expectation.max);
}

struct Measured {
  double value;
  std::string unit;
};
Result<Measured> measured(const SceneRecording& recording, const Expectation& expectation) {
  const auto* type = find_measure(expectation.measure);
  if (type == nullptr || type->value == nullptr)
    return fail(Errc::UnknownName, expectation.at.text(), "there is no measure '" + expectation.measure + "'",
                "there are " + listed(value_names()));
  return window_of(recording, expectation, *type).map([&](const Window& window) {
    const bool own = type->unit != Measure::kUnitOfSubject;
    return Measured{window.empty() ? std::nan("") : type->value(window),
                    own ? type->unit : to_string(window.signal->dimension)};
  });
}

std::vector<std::string> names_with(auto Measure::*function) {
  std::vector<std::string> names;
  for (const auto& type : measures())
    if (type.*function != nullptr) names.push_back(type.name);
  return names;
}

}  // namespace

std::span<const double> Window::samples(const RecordedSignal& of) const {
  const auto size = static_cast<double>(of.samples.size());
  const auto frame = [&](double seconds) {
    const double exact = seconds * rate().value;
    return static_cast<std::size_t>(std::clamp(edges == Edges::Down ? exact : std::round(exact), 0.0, size));
  };
  const auto first = frame(from_s), last = frame(to_s);
  return std::span{of.samples}.subspan(first, std::max(first, last) - first);
}

std::vector<double> Window::event_times() const {
  if (events) return *events;
  if (!(signal->dimension == Dimension{.metre = 1, .kilogram = 1, .second = -2}))
    return trigger_times(signal->samples, rate());
  std::vector<double> times;
  for (const auto& strike : strikes_in(*signal, rate())) times.push_back(strike.start_s);
  return times;
}

double RunPair::scale(double natural) const {
  const double chosen = accuracy.scale ? accuracy.scale->si : natural;
  return chosen > 0 ? chosen : 1.0;
}

const Measure* find_measure(std::string_view name) { return find_named(measures(), name); }

std::vector<std::string> value_names() { return names_with(&Measure::value); }
std::vector<std::string> error_names() { return names_with(&Measure::error); }

Result<double> measure(const SceneRecording& recording, const Expectation& expectation) {
  return measured(recording, expectation).map(&Measured::value);
}

std::vector<Strike> strikes_in(const RecordedSignal& contact, Hertz sample_rate) {
  return find_strikes(contact.samples, sample_rate, kStrikeGap, kLeastStrike_N);
}

Detection detection_of(const RecordedSignal& contact, Hertz sample_rate,
                       const std::vector<double>& triggers_s, double from_s, double to_s) {
  const auto outside = [&](double time) { return !(time >= from_s && time <= to_s); };
  auto triggers = triggers_s;
  std::erase_if(triggers, outside);
  auto touches = find_strikes(contact.samples, sample_rate, kTouchGap, kLeastTouch_N);
  std::erase_if(touches, [&](const Strike& s) { return outside(s.start_s); });
  // A touch so late may be detected, and need not be.
  for (auto& touch : touches)
    if (touch.start_s > to_s - kDetectionDelay.value) touch.peak = 0;
  return match(touches, triggers, kLeastStrike_N);
}

std::vector<double> triggers_of(const SceneRecording& recording, const std::string& name) {
  const auto* signal = find_signal(recording, name);
  return signal == nullptr ? std::vector<double>{} : trigger_times(signal->samples, recording.sample_rate);
}

Checked<std::vector<ExpectationResult>> check_expectations(const SceneSpec& scene,
                                                           const SceneRecording& recording) {
  std::vector<ExpectationResult> outcomes;
  std::vector<Error> errors;
  for (const auto& expectation : scene.expect) {
    const double end_s = std::max(expectation.from_s.value_or(0), expectation.to_s.value_or(0));
    if (end_s > recording.seconds() + 1 / recording.sample_rate.value) {
      outcomes.push_back(
          {expectation.name, expectation.measure, 0, {}, false, limits_text(expectation, {}), false});
      continue;
    }
    const auto result = measured(recording, expectation);
    if (!result) {
      errors.push_back(result.error());
      continue;
    }
    const auto& [value, unit] = *result;
    const bool enough = !expectation.min || value >= expectation.min->si;
    const bool holds = enough && (!expectation.max || value <= expectation.max->si);
    // What is too little in a part of the scene may come in the rest.
    const bool reached = enough || recording.seconds() + 1 / recording.sample_rate.value >= scene.whole.value;
    outcomes.push_back(
        {expectation.name, expectation.measure, value, unit, holds, limits_text(expectation, unit), reached});
  }
  if (!errors.empty()) return tl::unexpected(std::move(errors));
  return outcomes;
}

Result<double> accuracy_error(const Accuracy& accuracy, const SceneRecording& run,
                              const SceneRecording& reference) {
  using enum Window::Edges;
  Window windows[] = {{run, accuracy.from_s, accuracy.to_s, Nearest},
                      {reference, accuracy.from_s, accuracy.to_s, Nearest}};
  for (auto& window : windows) {
    window.signal = window.recording.find(accuracy.of);
    if (window.signal == nullptr)
      return fail(Errc::UnknownName, accuracy.of_at.text(), "no signal '" + accuracy.of + "' was recorded",
                  "give an output of the plant");
  }
  const auto* type = find_measure(accuracy.measure);
  return type->error(*type, {windows[0], windows[1], accuracy});
}

}  // namespace tactus
