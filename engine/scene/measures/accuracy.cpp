#include "engine/scene/measures/accuracy.h"

#include <algorithm>
#include <tuple>

#include "engine/graph/file/nearest.h"
#include "engine/graph/file/read_graph.h"
#include "engine/graph/semantics/scope.h"
#include "engine/scene/file/scene_sections.h"

namespace tactus {
namespace {

void read_measure(const EntrySpec& entry, Accuracy& accuracy, Mistakes& mistakes) {
  accuracy.measure = mistakes.text(entry.fields, "measure");
  const auto* measure = find(entry.fields, "measure");
  if (measure == nullptr)
    return mistakes.add(Errc::Missing, entry.at, "'" + entry.name + "' says nothing to measure",
                        "write measure = \"position\" or another one");
  accuracy.measure_at = measure->at;
  if (accuracy.measure.empty() || find_accuracy(accuracy.measure) != nullptr) return;
  std::vector<std::string> names;
  for (const auto& type : accuracy_types()) names.push_back(type.name);
  const auto near = nearest_name(accuracy.measure, names);
  mistakes.add(Errc::UnknownName, measure->at, "nothing called '" + accuracy.measure + "' can be compared",
               near.empty() ? "there are " + listed(names) : "did you mean '" + near + "'?");
}

void check_exact(const Accuracy& accuracy, const Value::Table& fields, Mistakes& mistakes) {
  const auto* type = find_accuracy(accuracy.measure);
  const auto* exact = find(fields, "exact");
  if (type != nullptr && exact != nullptr && !type->may_be_exact)
    mistakes.add(Errc::BadArgument, exact->at, "'" + type->name + "' is no single number that could be exact",
                 "leave 'exact' out");
  if (accuracy.scale && !(accuracy.scale->si > 0.0))
    mistakes.add(Errc::OutOfRange, find(fields, "scale")->at, "'scale' must be above 0",
                 "give what an error of 1 is");
}

Accuracy read_entry(const EntrySpec& entry, Seconds duration, Mistakes& mistakes) {
  static const std::vector<std::string> kKeys = {"measure", "of", "from", "to", "exact", "scale", "about"};
  Accuracy accuracy;
  accuracy.name = entry.name;
  accuracy.at = accuracy.measure_at = accuracy.of_at = entry.at;
  mistakes.unknown_keys(entry.fields, kKeys);
  mistakes.text(entry.fields, "about");
  read_measure(entry, accuracy, mistakes);
  accuracy.of = mistakes.text(entry.fields, "of");
  if (const auto* of = find(entry.fields, "of"))
    accuracy.of_at = of->at;
  else
    mistakes.add(Errc::Missing, entry.at, "'" + entry.name + "' lacks 'of'",
                 "name a signal, as in of = \"plant.stick\"");
  std::tie(accuracy.from_s, accuracy.to_s) = read_window(entry.fields, duration, mistakes);
  accuracy.exact = read_any(entry.fields, "exact", mistakes);
  accuracy.scale = read_any(entry.fields, "scale", mistakes);
  check_exact(accuracy, entry.fields, mistakes);
  return accuracy;
}

}  // namespace

const std::vector<AccuracyType>& accuracy_types() {
  constexpr auto kSame = AccuracyType::kUnitOfSubject;
  static const std::vector<AccuracyType> types = {
      {"position", kSame, kSame, false, "root mean square of the difference, by the largest value"},
      {"energy", kSame, kSame, true,
       "largest difference of its change from the first sample on, by the largest value"},
      {"frequency", "Hz", "Hz", true, "difference of the frequency of an oscillation, relative"},
      {"decay", "1/s", "1/s", true, "difference of the rate at which an oscillation dies away, relative"},
      {"speed", "m/s", "m/s", true, "difference of the speed, a straight line through a position, relative"},
      {"event_times", "s", "s", false,
       "root mean square of the differences of the times at which a signal falls through 0, by the mean "
       "interval between them"},
  };
  return types;
}

const AccuracyType* find_accuracy(std::string_view name) {
  const auto& types = accuracy_types();
  const auto found =
      std::find_if(types.begin(), types.end(), [&](const AccuracyType& type) { return type.name == name; });
  return found == types.end() ? nullptr : &*found;
}

std::vector<Accuracy> read_accuracy(const Value::Table& scene, Seconds duration, Mistakes& mistakes) {
  std::vector<Accuracy> accuracies;
  NameSpace names;
  for (const auto& entry :
       read_entries(scene, "accuracy", "{ measure = \"position\", of = \"plant.stick\" }", mistakes)) {
    names.add(entry.name, "a line of [accuracy]", entry.at, mistakes);
    accuracies.push_back(read_entry(entry, duration, mistakes));
  }
  return accuracies;
}

}  // namespace tactus
