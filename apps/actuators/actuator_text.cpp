#include "apps/actuators/actuator_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/core/index.h"
#include "engine/graph/file/quantity.h"

namespace tactus::app {
namespace {

/// "164 Hz to 176 Hz"; ~: a judgement.
std::string cell(const ActuatorFigure& figure, const char* unit) {
  if (!figure.low && !figure.high) return figure.kind == ActuatorFigure::Kind::Unknown ? "unknown" : "-";
  std::string text = figure.kind == ActuatorFigure::Kind::Judgement ? "~" : "";
  if (figure.low) text += number_text(*figure.low, unit);
  if (figure.high && figure.high != figure.low)
    text += (figure.low ? " to " : "") + number_text(*figure.high, unit);
  return text;
}

std::string price_cell(const ActuatorFigure& price) {
  if (!price.low) return "unknown";
  return price.high && price.high != price.low ? fmt::format("${:g} to ${:g}", *price.low, *price.high)
                                               : fmt::format("${:g}", *price.low);
}

using Row = std::array<std::string, 6>;

Row row_of(const ActuatorFigures& figures) {
  return {figures.name,
          price_cell(figures.price),
          cell(figures.force, "N"),
          cell(figures.band, "Hz"),
          cell(figures.excursion, "m"),
          cell(figures.resolution, "m")};
}

Json figure_json(const ActuatorFigure& figure) {
  Json json{{"value", figure.value},
            {"kind", actuator_figure_kinds()[index(static_cast<int>(figure.kind))]},
            {"source", figure.source}};
  if (figure.low) json["low"] = *figure.low;
  if (figure.high) json["high"] = known(std::isfinite(*figure.high), *figure.high);
  return json;
}

}  // namespace

double three_digits(double si) { return std::isfinite(si) ? std::stod(fmt::format("{:.3g}", si)) : si; }

std::string number_text(double si, const char* unit) {
  return std::isinf(si) ? "endless" : short_quantity(three_digits(si), parse_unit(unit)->dimension);
}

void print_table(const std::vector<const Actuator*>& actuators) {
  std::vector<Row> rows = {{"actuator", "price", "force", "band", "excursion", "resolution"}};
  for (const auto* actuator : actuators) rows.push_back(row_of(actuator->figures));
  std::array<std::size_t, 6> widths{};
  for (const auto& row : rows)
    for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], row[c].size());
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t c = 0; c < row.size(); ++c) line += fmt::format("{:<{}}  ", row[c], widths[c]);
    fmt::print("{}\n", line.substr(0, line.find_last_not_of(' ') + 1));
  }
}

void print_sources(const Actuator& actuator) {
  const auto& figures = actuator.figures;
  fmt::print("\n  {}\n", figures.name);
  for (const auto& [what, figure] : {std::pair{"price", &figures.price},
                                     {"force", &figures.force},
                                     {"band", &figures.band},
                                     {"excursion", &figures.excursion},
                                     {"resolution", &figures.resolution}})
    fmt::print("    {:<11} {}{}\n", what, figure->value.empty() ? price_cell(*figure) : figure->value,
               figure->source.empty() ? "" : " (" + figure->source + ")");
}

Json json_of(const ActuatorFigures& figures) {
  return {{"name", figures.name},
          {"section", figures.section},
          {"profile", figures.profile},
          {"price_usd", figure_json(figures.price)},
          {"force_n", figure_json(figures.force)},
          {"band_hz", figure_json(figures.band)},
          {"excursion_m", figure_json(figures.excursion)},
          {"resolution_m", figure_json(figures.resolution)}};
}

}  // namespace tactus::app
