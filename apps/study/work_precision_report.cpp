#include <fmt/format.h>

#include <algorithm>

#include "apps/study/reports.h"

namespace tactus::app {
namespace {

using Json = nlohmann::ordered_json;

std::vector<const WorkPoint*> by_load(const WorkPrecision& study) {
  std::vector<const WorkPoint*> points;
  for (const auto& point : study.points) points.push_back(&point);
  std::stable_sort(points.begin(), points.end(), [](const WorkPoint* a, const WorkPoint* b) {
    return a->known() != b->known() ? a->known() : a->load() < b->load();
  });
  return points;
}

/// An error with marks: the reference is less than ten times more accurate; on the Pareto front.
std::string error_text(const WorkPoint& point, std::size_t a) {
  return fmt::format("{:.2e}{}{}", point.errors[a], point.trusted(a) ? "" : "?", point.front[a] ? " *" : "");
}

/// A row per variant, by computing time.
Table table_of(const WorkPrecision& study) {
  Table table{{{"solver", "steps per frame", "rate", "ns per frame", "of real time"}}};
  for (const auto& used : study.references) table.rows[0].push_back(used.accuracy);
  for (const auto* point : by_load(study)) {
    auto& row = table.rows.emplace_back();
    row = {point->variant.solver, std::to_string(point->variant.oversample),
           fmt::format("{:g} kHz", point->variant.rate.value / 1e3)};
    if (point->known())
      row.insert(row.end(),
                 {fmt::format("{:.1f}", point->ns_per_frame), fmt::format("{:.2g} %", 100 * point->load())});
    else
      row.insert(row.end(), {"", "", point->refused ? "refused: " + point->refused->what : "unstable"});
    for (std::size_t a = 0; a < point->errors.size(); ++a) row.push_back(error_text(*point, a));
    row.resize(table.rows[0].size());
  }
  return table;
}

std::string own_error_of(const ReferenceUsed& used) {
  if (used.own_error == 0.0) return "";
  return fmt::format(", whose own error is at most {:.1e}", used.own_error);
}

std::string advice(const WorkPrecision& study) {
  std::string text;
  for (const double error : {1e-2, 1e-4}) {
    const auto* point = study.cheapest(error);
    text += fmt::format(
        "Within {:g} %: {}\n", 100 * error,
        point == nullptr ? "none in real time"
                         : fmt::format("{}, {:.0f} ns per frame, {:.2g} % of real time",
                                       to_string(point->variant), point->ns_per_frame, 100 * point->load()));
  }
  return text;
}

}  // namespace

std::string text_of(const WorkPrecision& study) {
  auto text = fmt::format("{}\n\n", study.scene);
  for (const auto& used : study.references)
    text += fmt::format("  {}: {} of {}, against {}{}\n", used.accuracy, used.measure, used.of, used.what,
                        own_error_of(used));
  return text + "\n" + table_of(study).text() +
         "\n*: no cheaper variant has a smaller error; ?: less than ten times the reference's own error. "
         "Errors are relative.\n" +
         advice(study);
}

std::string markdown_of(const WorkPrecision& study) {
  auto table = table_of(study);
  for (auto& row : table.rows)
    for (auto& cell : row)
      if (cell.ends_with(" *")) cell.replace(cell.size() - 1, 1, "\\*");
  return table.markdown();
}

Json json_of(const WorkPrecision& study) {
  Json json{{"scene", study.scene}, {"references", Json::array()}, {"runs", Json::array()}};
  for (const auto& used : study.references)
    json["references"].push_back({{"accuracy", used.accuracy},
                                  {"measure", used.measure},
                                  {"of", used.of},
                                  {"against", used.what},
                                  {"own_error", used.own_error}});
  for (const auto* point : by_load(study)) {
    const bool known = point->known();
    Json run{{"solver", point->variant.solver},
             {"oversample", point->variant.oversample},
             {"sample_rate_hz", point->variant.rate.value},
             {"verdict", point->refused    ? "refused"
                         : point->unstable ? "unstable"
                                           : "ok"},
             {"ns_per_frame", known ? Json(point->ns_per_frame) : Json(nullptr)},
             {"of_real_time", known ? Json(point->load()) : Json(nullptr)},
             {"errors", Json::object()},
             {"nothing_cheaper_is_closer", Json::object()}};
    if (point->refused) run["why"] = to_string(*point->refused);
    for (std::size_t a = 0; a < point->errors.size(); ++a) {
      run["errors"][study.references[a].accuracy] = point->errors[a];
      run["reference_own_errors"][study.references[a].accuracy] = point->floors[a];
      run["nothing_cheaper_is_closer"][study.references[a].accuracy] = static_cast<bool>(point->front[a]);
    }
    json["runs"].push_back(std::move(run));
  }
  return json;
}

}  // namespace tactus::app
