#include "apps/actuators/actuator_need.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "apps/actuators/actuator_text.h"
#include "apps/cli/console.h"
#include "engine/graph/file/quantity.h"

namespace tactus::app {
namespace {

/// "20 Hz" or "20 Hz,200 Hz": where the actuator must move.
Interval band_of(const std::string& text) {
  const auto comma = text.find(',');
  const double first = parse_option(text.substr(0, comma), "Hz", "band", 0);
  const double last =
      comma == std::string::npos ? first : parse_option(text.substr(comma + 1), "Hz", "band", 0);
  return {std::min(first, last), std::max(first, last)};
}

double price_of(const std::string& text) {
  char* end = nullptr;
  const double price = std::strtod(text.c_str(), &end);
  if (*end != '\0' || !std::isfinite(price) || price < 0)
    exit_with({Errc::BadArgument, "--price", "'" + text + "' is not a price in US $",
               "give a number from 0 on, such as 50"});
  return price;
}

/// A bare number would be in metres, where people think in millimetres.
double length_of(const std::string& text, const char* option) {
  if (const auto quantity = read_quantity(Value{text, {}}); quantity && quantity->bare && quantity->si != 0)
    exit_with({Errc::BadArgument, fmt::format("--{}", option), "'" + text + "' has no unit",
               "write \"" + text + " mm\""});
  return parse_option(text, "m", option, 0);
}

/// An actuator whose band has a lower end gives no force at rest.
bool only_vibrates(const ActuatorFigures& figures) { return figures.band.low.value_or(0.0) > 0; }

/// The amplitude of the force that moves the mass of an actuator by `excursion`, |k - m w^2 + j w c| x, at
/// that end of `band` where it is larger; with the frequency there.
std::pair<double, double> force_to_move(const ActuatorProfile& profile, Interval band, double excursion) {
  const auto at = [&](double hz) {
    const double w = 2 * std::numbers::pi * hz;
    return excursion * std::hypot(profile.at("travel.stiffness") - profile.at("travel.mass") * w * w,
                                  profile.at("travel.damping") * w);
  };
  return std::max(std::pair{at(band.low), band.low}, std::pair{at(band.high), band.high});
}

/// Band and excursion together need a force.
std::string force_remark(const Actuator& actuator, const Need& need) {
  if (!need.band || !need.excursion) return "";
  const auto& profile = actuator.profile;
  if (!profile || !profile->contains("travel.mass")) return "";
  const auto [force, hz] = force_to_move(*profile, *need.band, *need.excursion);
  const double has =
      profile->at("travel.force_factor") * profile->at("drive.peak") / profile->at("drive.resistance");
  if (force <= has) return "";
  return fmt::format("{} at {} would need {}, and its coil has {}", number_text(*need.excursion, "m"),
                     number_text(hz, "Hz"), number_text(force, "N"), number_text(has, "N"));
}

}  // namespace

Need need_of(const NeedOptions& options) {
  Need need;
  if (!options.force.empty()) need.force = parse_option(options.force, "N", "force", 0);
  if (!options.excursion.empty()) need.excursion = length_of(options.excursion, "excursion");
  if (!options.resolution.empty()) need.resolution = length_of(options.resolution, "resolution");
  if (!options.band.empty()) need.band = band_of(options.band);
  if (!options.price.empty()) need.price = price_of(options.price);
  return need;
}

Match match(const Actuator& actuator, const Need& need) {
  const auto& figures = actuator.figures;
  Match found;
  const auto judge = [&](const char* what, const ActuatorFigure& figure, bool known, bool has) {
    const bool in_words = figure.kind != ActuatorFigure::Kind::Unknown && !figure.value.empty();
    if (!known)
      found.unknown.push_back(in_words ? fmt::format("{} ({})", what, figure.value) : what);
    else if (!has)
      found.lacks.emplace_back(what);
  };
  if (need.force)
    judge("force", figures.force, figures.force.high.has_value(), figures.force.high >= need.force);
  if (need.excursion) {  // turning is none; a motor that gives a force at rest may move an arm
    const bool known =
        figures.turns_without_end() ? only_vibrates(figures) : figures.excursion.high.has_value();
    judge("excursion", figures.excursion, known,
          !figures.turns_without_end() && figures.excursion.high >= need.excursion);
  }
  if (need.resolution) {
    const bool known = figures.resolution.low.has_value() || figures.no_sensor;
    judge("resolution", figures.resolution, known,
          !figures.no_sensor && figures.resolution.low <= need.resolution);
  }
  if (need.price)
    judge("price", figures.price, figures.price.low.has_value(), figures.price.low <= need.price);
  if (need.band)
    judge("band", figures.band, figures.band.high.has_value(),
          figures.band.low.value_or(0.0) <= need.band->low && figures.band.high >= need.band->high);
  if (const auto remark = force_remark(actuator, need); !remark.empty()) found.remarks.push_back(remark);
  return found;
}

}  // namespace tactus::app
