#include "apps/study/work_precision_report.h"

#include <fmt/format.h>

#include <algorithm>

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

/// Mark after an error: on the Pareto front; the reference is less than ten times more accurate.
std::string mark(const WorkPoint& point, std::size_t a) {
  return std::string{point.trusted(a) ? " " : "?"} + (point.front[a] ? "*" : " ");
}

std::string why_not(const WorkPoint& point) {
  return point.refused ? "refused: " + point.refused->what : "unstable";
}

std::string own_error_of(const ReferenceUsed& used) {
  if (used.own_error == 0.0) return "";
  return fmt::format(", itself within {:.1e}", used.own_error);
}

std::string advice(const WorkPrecision& study) {
  std::string text;
  for (const double error : {1e-2, 1e-4}) {
    const auto* point = study.cheapest(error);
    text += fmt::format(
        "Within {:g} %: {}\n", 100 * error,
        point == nullptr ? "none in real time"
                         : fmt::format("{}, {:.0f} ns a frame, {:.2g} % of real time",
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
  text +=
      fmt::format("\n{:<10} {:>5} {:>7} {:>11} {:>11}", "solver", "steps", "kHz", "ns a frame", "real time");
  for (const auto& used : study.references) text += fmt::format("  {:>12}  ", used.accuracy);
  text += "\n";
  for (const auto* point : by_load(study)) {
    const auto& variant = point->variant;
    text += fmt::format("{:<10} {:>5} {:>7g}", variant.solver, variant.oversample, variant.rate.value / 1e3);
    if (!point->known()) {
      text += fmt::format("  {}\n", why_not(*point));
      continue;
    }
    text += fmt::format(" {:>11.1f} {:>9.2g} %", point->ns_per_frame, 100 * point->load());
    for (std::size_t a = 0; a < point->errors.size(); ++a)
      text += fmt::format("  {:>12.2e}{}", point->errors[a], mark(*point, a));
    text += "\n";
  }
  return text +
         "\n* nothing cheaper is closer; ? not ten times the reference's own error. Errors are relative.\n" +
         advice(study);
}

std::string markdown_of(const WorkPrecision& study) {
  std::string text = "| solver | steps a frame | rate | ns a frame | of real time |";
  std::string line = "|---|---|---|---|---|";
  for (const auto& used : study.references) text += " " + used.accuracy + " |", line += "---|";
  text += "\n" + line + "\n";
  for (const auto* point : by_load(study)) {
    const auto& variant = point->variant;
    text +=
        fmt::format("| {} | {} | {:g} kHz |", variant.solver, variant.oversample, variant.rate.value / 1e3);
    if (point->known())
      text += fmt::format(" {:.1f} | {:.2g} % |", point->ns_per_frame, 100 * point->load());
    else
      text += " | |";
    for (std::size_t a = 0; a < study.references.size(); ++a)
      text += point->known() ? fmt::format(" {:.1e}{}{} |", point->errors[a], point->trusted(a) ? "" : "?",
                                           point->front[a] ? " \\*" : "")
                             : (a == 0 ? " " + why_not(*point) + " |" : " |");
    text += "\n";
  }
  return text;
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
