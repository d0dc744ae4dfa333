#include <algorithm>
#include <tuple>

#include "engine/graph/file/read_graph.h"
#include "engine/graph/semantics/scope.h"
#include "engine/scene/file/scene_fields.h"
#include "engine/scene/file/scene_sections.h"
#include "engine/scene/measures/measure.h"

namespace tactus {
namespace {

const Measure* type_of(const Accuracy& accuracy) {
  const auto* type = find_measure(accuracy.measure);
  return type != nullptr && type->error != nullptr ? type : nullptr;
}

void read_measure(const EntrySpec& entry, Accuracy& accuracy, ErrorList& mistakes) {
  accuracy.measure = mistakes.text(entry.fields, "measure");
  const auto* measure = find(entry.fields, "measure");
  if (measure == nullptr)
    return mistakes.add(Errc::Missing, entry.at, "'" + entry.name + "' says nothing to measure",
                        "write measure = \"position\" or another one");
  accuracy.measure_at = measure->at;
  if (accuracy.measure.empty() || type_of(accuracy) != nullptr) return;
  const auto names = error_names();
  mistakes.add(Errc::UnknownName, measure->at, "nothing called '" + accuracy.measure + "' can be compared",
               suggest(accuracy.measure, names));
}

void check_exact(const Accuracy& accuracy, const Value::Table& fields, ErrorList& mistakes) {
  const auto* type = type_of(accuracy);
  const auto* exact = find(fields, "exact");
  if (type != nullptr && exact != nullptr && !type->has_exact)
    mistakes.add(Errc::BadArgument, exact->at, "'" + type->name + "' is no single number that could be exact",
                 "leave 'exact' out");
  if (accuracy.scale && !(accuracy.scale->si > 0.0))
    mistakes.add(Errc::OutOfRange, find(fields, "scale")->at, "'scale' must be above 0",
                 "give what an error of 1 is");
}

Accuracy read_entry(const EntrySpec& entry, Seconds duration, ErrorList& mistakes) {
  FieldReader fields{entry.fields, accuracy_fields(), mistakes};
  Accuracy accuracy;
  accuracy.name = entry.name;
  accuracy.at = accuracy.measure_at = entry.at;
  read_measure(entry, accuracy, mistakes);
  accuracy.of = fields.text("of");
  accuracy.of_at = fields.at("of", entry.at);
  if (!fields.has("of"))
    mistakes.add(Errc::Missing, entry.at, "'" + entry.name + "' lacks 'of'",
                 "name a signal, as in of = \"plant.stick\"");
  std::tie(accuracy.from_s, accuracy.to_s) = fields.window(duration);
  accuracy.exact = fields.any("exact");
  accuracy.scale = fields.any("scale");
  check_exact(accuracy, entry.fields, mistakes);
  return accuracy;
}

}  // namespace

std::vector<Accuracy> read_accuracy(const Value::Table& scene, Seconds duration, ErrorList& mistakes) {
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
