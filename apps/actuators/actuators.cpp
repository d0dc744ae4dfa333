#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <optional>
#include <set>

#include "apps/actuators/scene_demand.h"
#include "apps/cli/console.h"
#include "apps/cli/json.h"
#include "apps/cli/rig_files.h"
#include "apps/play/play_report.h"
#include "engine/core/index.h"
#include "engine/graph/file/quantity.h"
#include "engine/guard/drive_guard.h"
#include "engine/rig/actuator_figures.h"

namespace tactus::app {
namespace {

namespace fs = std::filesystem;

constexpr double kLimitedShare = 1e-3;    // of the frames: fewer are not felt
constexpr double kEdgeUncertainty = 0.1;  // of the ends of a band that were not read in a source
constexpr int kBlock = 64;

struct ActuatorOptions {
  std::string force, band, excursion, resolution, price, scene;
  bool json = false, sources = false;
};

struct Actuator {
  ActuatorFigures figures;
  fs::path file;
};

std::vector<Actuator> known_actuators() {
  std::vector<Actuator> all;
  std::set<std::string> names;
  std::vector<Error> errors;
  for (const auto& folder : instrument_folders()) {
    std::error_code none;
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator{folder / "actuators" / "figures", none})
      if (entry.path().extension() == ".toml") files.push_back(entry.path());
    std::ranges::sort(files);
    for (const auto& file : files) {
      if (!names.insert(file.stem().generic_string()).second) continue;  // the user's own goes first
      if (auto figures = load_actuator_figures(file))
        all.push_back({std::move(*figures), file});
      else
        errors.insert(errors.end(), figures.error().begin(), figures.error().end());
    }
  }
  if (!errors.empty()) throw CommandError{std::move(errors)};
  return all;
}

/// With three digits.
std::string number_text(double si, const char* unit) {
  if (std::isinf(si)) return "endless";
  return short_quantity(std::stod(fmt::format("{:.3g}", si)), parse_unit(unit)->dimension);
}

// What is asked for.

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

/// What an actuator must have.
struct Need {
  std::optional<double> force, excursion, resolution, price;
  std::optional<Interval> band;

  bool any() const { return force || excursion || resolution || price || band; }
};

Need need_of(const ActuatorOptions& options) {
  Need need;
  if (!options.force.empty()) need.force = parse_option(options.force, "N", "force", 0);
  if (!options.excursion.empty()) need.excursion = parse_option(options.excursion, "m", "excursion", 0);
  if (!options.resolution.empty()) need.resolution = parse_option(options.resolution, "m", "resolution", 0);
  if (!options.band.empty()) need.band = band_of(options.band);
  if (!options.price.empty()) need.price = price_of(options.price);
  return need;
}

/// Whether an actuator has it, and what could not be compared.
struct Match {
  std::vector<std::string> lacks, unknown, remarks;
};

/// An actuator whose band has a lower end gives no force at rest.
bool only_vibrates(const ActuatorFigures& figures) { return figures.band.low.value_or(0.0) > 0; }

bool turns(const ActuatorFigures& figures) { return std::isinf(figures.excursion.high.value_or(0.0)); }

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

std::optional<ActuatorProfile> profile_of(const Actuator& actuator) {
  const auto& name = actuator.figures.profile;
  if (name.empty()) return std::nullopt;
  const auto file = name.ends_with(".toml")
                        ? actuator.file.parent_path() / name
                        : or_exit(find_profile(name, option_profile_folders(), "profile"));
  return or_exit(load_profile(file), kBadFile);
}

/// Band and excursion together need a force.
std::string force_remark(const Actuator& actuator, const Need& need) {
  if (!need.band || !need.excursion) return "";
  const auto profile = profile_of(actuator);
  if (!profile || !profile->contains("travel.mass")) return "";
  const auto [force, hz] = force_to_move(*profile, *need.band, *need.excursion);
  const double has =
      profile->at("travel.force_factor") * profile->at("drive.peak") / profile->at("drive.resistance");
  if (force <= has) return "";
  return fmt::format("{} at {} would need {}, and its coil has {}", number_text(*need.excursion, "m"),
                     number_text(hz, "Hz"), number_text(force, "N"), number_text(has, "N"));
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
    const bool known = turns(figures) ? only_vibrates(figures) : figures.excursion.high.has_value();
    judge("excursion", figures.excursion, known, !turns(figures) && figures.excursion.high >= need.excursion);
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

/// Why an actuator does not render a scene, what is within the uncertainty of its figures, and what was not
/// compared.
struct Verdict {
  std::vector<std::string> against, close, open;
};

/// The limits of the scene where it names the profile of the actuator.
const DriveLimits* own_limits(const Drive& drive, const Actuator& actuator) {
  const auto named = "profile '" + actuator.figures.profile + "' ";
  const auto found = std::ranges::find_if(drive.limits, [&](const LimitSource& source) {
    return source.kind == LimitSource::Kind::Profile && source.name.starts_with(named);
  });
  return found == drive.limits.end() ? nullptr : &found->limits;
}

/// Those, else the limits with full scale at the largest voltage.
DriveLimits limits_of(const Drive& drive, const Actuator& actuator, const ActuatorProfile& profile) {
  const auto* own = own_limits(drive, actuator);
  return own != nullptr ? *own : limits_for(profile, profile.at("drive.peak"));
}

/// The largest force on the case of an actuator in a scene; nothing: its profile has no moving mass.
std::optional<double> force_on_case(const Actuator& actuator, const ActuatorProfile& profile,
                                    const Drive& drive, double rate_hz) {
  if (!profile.contains("travel.mass")) return std::nullopt;
  return drive.force_on_case(*limits_of(drive, actuator, profile).excursion, profile.at("travel.mass"),
                             rate_hz);
}

/// What the drives of a scene without a sensor do to the actuators that it names. Nothing: one of them is
/// not known.
std::optional<double> force_on_case(const std::vector<Actuator>& all, const Demand& demand) {
  double most = 0.0;
  for (const auto& drive : demand.drives) {
    const auto own = std::ranges::find_if(
        all, [&](const Actuator& actuator) { return own_limits(drive, actuator) != nullptr; });
    if (own == all.end()) return std::nullopt;
    const auto force = force_on_case(*own, *profile_of(*own), drive, demand.rate_hz);
    if (!force) return std::nullopt;
    most = std::max(most, *force);
  }
  return most;
}

/// What the drive guard does to a drive.
void compare_guard(const Drive& drive, const DriveLimits& limits, double rate_hz, Verdict& verdict) {
  DriveGuard guard{DriveGuard::Kind::Drive, limits, Hertz{rate_hz}, {false, false}};
  guard.set_open(true, 0);
  guard.skip_soft_start();
  auto samples = drive.samples;
  for (std::size_t at = 0; at < samples.size(); at += kBlock)
    guard.process(samples.data() + at, static_cast<int>(std::min<std::size_t>(kBlock, samples.size() - at)),
                  static_cast<std::int64_t>(at));
  const auto counts = guard.counts();
  for (std::size_t stage = 0; stage < kGuardStages; ++stage) {
    const double share = static_cast<double>(counts[stage].frames) / static_cast<double>(samples.size());
    if (share >= kLimitedShare)
      verdict.against.push_back(fmt::format("its drive guard limits '{}' for {:.1f} % of the time ({})",
                                            drive.name, 100 * share, name_of(GuardStage::Index{stage})));
  }
}

/// A force that is held must have the frequencies of the drive; otherwise a vibration may follow it.
void compare_band(const ActuatorFigures& figures, const Drive& drive, bool holds_force, Verdict& verdict) {
  const auto band = drive.band();
  if (figures.drive_to && !holds_force) {
    if (band.high > *figures.drive_to)
      verdict.against.push_back(fmt::format("'{}' changes at up to {}, and it follows changes up to {}",
                                            drive.name, number_text(band.high, "Hz"),
                                            number_text(*figures.drive_to, "Hz")));
    return;
  }
  const double slack = figures.band.kind == ActuatorFigure::Kind::Sheet ? 0.0 : kEdgeUncertainty;
  if (figures.band.high && band.high > *figures.band.high)
    (band.high > *figures.band.high * (1 + slack) ? verdict.against : verdict.close)
        .push_back(fmt::format("'{}' reaches up to {}, and it moves up to {}", drive.name,
                               number_text(band.high, "Hz"), number_text(*figures.band.high, "Hz")));
  if (figures.band.low && band.low < *figures.band.low)
    (band.low < *figures.band.low * (1 - slack) ? verdict.against : verdict.close)
        .push_back(fmt::format("{:.0f} % of the energy of '{}' lies below {}, where its band begins",
                               100 * drive.spectrum.share_below(*figures.band.low), drive.name,
                               number_text(*figures.band.low, "Hz")));
}

void compare_travel(const ActuatorFigures& figures, const std::optional<ActuatorProfile>& profile,
                    const Demand& demand, Verdict& verdict) {
  const auto& has = figures.excursion.high;
  const bool endless = turns(figures);
  if (!demand.travel && !demand.angle) {
    // Without a sensor the plant moves by its drive alone, and the drive guard compares its excursion.
    if (demand.senses || !(endless || (profile && profile->contains("travel.limit"))))
      verdict.open.emplace_back("travel");
    return;
  }
  if (endless && (!demand.travel || figures.arm)) return;  // the tip of an arm goes as far as its angle
  if (demand.angle || !has || endless) return verdict.open.push_back("travel");
  if (*has < *demand.travel)
    verdict.against.push_back(fmt::format("the plant moves {} to either side, and it has {}",
                                          number_text(*demand.travel, "m"), number_text(*has, "m")));
}

/// `needed`: largest of the scene; `has`: of the actuator.
void compare_largest(const char* what, const char* unit, double needed, std::optional<double> has,
                     Verdict& verdict) {
  if (!has) return verdict.open.push_back(what);
  if (*has < needed)
    verdict.against.push_back(fmt::format("the {} reaches {}, and it has {}", what, number_text(needed, unit),
                                          number_text(*has, unit)));
}

/// By the models of both; of an actuator without one, the figure.
void compare_case_force(const Actuator& actuator, const std::optional<ActuatorProfile>& profile,
                        const Demand& demand, Verdict& verdict) {
  std::optional<double> given;
  for (const auto& drive : demand.drives)
    if (profile)
      if (const auto force = force_on_case(actuator, *profile, drive, demand.rate_hz))
        given = std::max(given.value_or(0.0), *force);
  if (!given) return compare_largest("force", "N", *demand.case_force, actuator.figures.force.high, verdict);
  if (*given < *demand.case_force)
    verdict.against.push_back(fmt::format("the force reaches {}, and with this drive it gives {}",
                                          number_text(*demand.case_force, "N"), number_text(*given, "N")));
}

void compare_force(const Actuator& actuator, const std::optional<ActuatorProfile>& profile,
                   const Demand& demand, Verdict& verdict) {
  const auto& figures = actuator.figures;
  if (demand.force) compare_largest("force", "N", *demand.force, figures.force.high, verdict);
  if (demand.torque) compare_largest("torque", "N m", *demand.torque, figures.torque(), verdict);
  if (demand.force || demand.torque) return;
  if (demand.case_force)
    compare_case_force(actuator, profile, demand, verdict);
  else
    verdict.open.emplace_back("force");
}

/// A stable scene is stable with the actuator that it simulates; with the mass of another one that is not
/// known.
void compare_stability(const Actuator& actuator, const Demand& demand, Verdict& verdict) {
  if (!demand.senses) return;
  if (demand.stability == Stability::Unstable)
    return verdict.against.push_back("the scene is unstable (see tactus check)");
  std::error_code none;
  const auto plant = actuator.file.parent_path() / actuator.figures.plant;
  const bool own =
      !actuator.figures.plant.empty() && std::ranges::any_of(demand.plants, [&](const std::string& file) {
        return fs::equivalent(plant, file, none);
      });
  if (!own || demand.stability != Stability::Stable) verdict.open.emplace_back("stability");
}

Verdict compare(const Actuator& actuator, const Demand& demand) {
  Verdict verdict;
  const auto& figures = actuator.figures;
  const auto profile = profile_of(actuator);
  compare_force(actuator, profile, demand, verdict);
  compare_travel(figures, profile, demand, verdict);
  if (demand.senses && figures.no_sensor) verdict.against.emplace_back("it needs a sensor of its own");
  if (!figures.band.high && !(figures.drive_to && !demand.holds_force())) verdict.open.emplace_back("band");
  for (const auto& drive : demand.drives) compare_band(figures, drive, demand.holds_force(), verdict);
  if (!profile) verdict.open.emplace_back("drive guard");
  for (const auto& drive : demand.drives)
    if (profile) compare_guard(drive, limits_of(drive, actuator, *profile), demand.rate_hz, verdict);
  compare_stability(actuator, demand, verdict);
  return verdict;
}

// The table.

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

void print(const std::vector<Row>& rows) {
  std::array<std::size_t, 6> widths{};
  for (const auto& row : rows)
    for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], row[c].size());
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t c = 0; c < row.size(); ++c) line += fmt::format("{:<{}}  ", row[c], widths[c]);
    fmt::print("{}\n", line.substr(0, line.find_last_not_of(' ') + 1));
  }
}

void print_details(const ActuatorFigures& figures) {
  for (const auto& [what, figure] : {std::pair{"price", &figures.price},
                                     {"force", &figures.force},
                                     {"band", &figures.band},
                                     {"excursion", &figures.excursion},
                                     {"resolution", &figures.resolution}})
    fmt::print("    {:<11} {} ({})\n", what, figure->value.empty() ? "unknown" : figure->value,
               figure->source);
}

Json figure_json(const ActuatorFigure& figure) {
  Json json{{"value", figure.value},
            {"kind", actuator_figure_kinds()[index(static_cast<int>(figure.kind))]},
            {"source", figure.source}};
  if (figure.low) json["low"] = *figure.low;
  if (figure.high) json["high"] = known(std::isfinite(*figure.high), *figure.high);
  return json;
}

Json actuator_json(const ActuatorFigures& figures) {
  return {{"name", figures.name},
          {"section", figures.section},
          {"profile", figures.profile},
          {"price_usd", figure_json(figures.price)},
          {"force_n", figure_json(figures.force)},
          {"band_hz", figure_json(figures.band)},
          {"excursion_m", figure_json(figures.excursion)},
          {"resolution_m", figure_json(figures.resolution)}};
}

struct DemandFigure {
  const char *what, *unit;
  double value;
};

std::vector<DemandFigure> figures_of(const Demand& demand) {
  std::vector<DemandFigure> known;
  const auto add = [&](const char* what, const char* unit, const std::optional<double>& value) {
    if (value) known.push_back({what, unit, *value});
  };
  add("largest force on the player", "N", demand.force);
  add("largest torque on the player", "N m", demand.torque);
  add("largest force on the case of its actuator", "N", demand.case_force);
  add("travel to either side", "m", demand.travel);
  add("angle to either side", "rad", demand.angle);
  return known;
}

void print_demand(const Demand& demand) {
  fmt::print("{}\n", demand.scene);
  for (const auto& drive : demand.drives)
    fmt::print("  '{}': nine tenths of its energy between {} and {}\n", drive.name,
               number_text(drive.band().low, "Hz"), number_text(drive.band().high, "Hz"));
  for (const auto& [what, unit, value] : figures_of(demand))
    fmt::print("  {}: {}\n", what, number_text(value, unit));
  if (demand.senses) fmt::print("  the instrument reads a sensor\n");
  if (demand.stability)
    fmt::print("  with the plant of the scene: {} (see tactus check)\n", name_of(*demand.stability));
  fmt::print("\n");
}

std::string judgement(const Verdict& verdict) {
  auto parts = verdict.against;
  if (parts.empty() && (!verdict.close.empty() || !verdict.open.empty())) parts.emplace_back("no objection");
  if (!verdict.close.empty())
    parts.push_back(fmt::format("at the edge of its band: {}", fmt::join(verdict.close, ", ")));
  if (!verdict.open.empty()) parts.push_back(fmt::format("not compared: {}", fmt::join(verdict.open, ", ")));
  return parts.empty() ? "renders it" : fmt::format("{}", fmt::join(parts, "; "));
}

int run_actuators(const ActuatorOptions& options) {
  const auto need = need_of(options);
  auto all = known_actuators();
  if (all.empty())
    exit_with({Errc::BadFile, "actuators", "the figures of actuators are not installed",
               "install the shipped instruments"},
              kBadFile);
  auto demand = options.scene.empty() ? std::nullopt : std::optional{demand_of(options.scene)};
  if (demand && !demand->senses && !demand->force && !demand->torque)
    demand->case_force = force_on_case(all, *demand);
  const auto sensors =
      demand || need.any() ? std::erase_if(all, [](const Actuator& one) { return one.figures.sensor; }) : 0;
  Json json{{"actuators", Json::array()}};
  std::vector<Row> rows = {{"actuator", "price", "force", "band", "excursion", "resolution"}};
  std::vector<std::string> notes;
  std::vector<const Actuator*> shown;
  int left_out = 0;
  for (const auto& actuator : all) {
    const auto found = match(actuator, need);
    auto entry = actuator_json(actuator.figures);
    entry["lacks"] = found.lacks;
    entry["unknown"] = found.unknown;
    entry["remarks"] = found.remarks;
    const auto verdict = demand ? std::optional{compare(actuator, *demand)} : std::nullopt;
    if (verdict) {
      entry["objections"] = verdict->against;
      entry["at_the_edge"] = verdict->close;
      entry["not_compared"] = verdict->open;
    }
    json["actuators"].push_back(std::move(entry));
    if (!found.lacks.empty()) {
      ++left_out;
      continue;
    }
    rows.push_back(row_of(actuator.figures));
    shown.push_back(&actuator);
    const auto note = [&](const std::string& text) {
      notes.push_back(fmt::format("{}: {}", actuator.figures.name, text));
    };
    if (!found.unknown.empty()) note(fmt::format("not compared: {}", fmt::join(found.unknown, ", ")));
    for (const auto& remark : found.remarks) note(remark);
    if (verdict) note(judgement(*verdict));
  }
  if (options.json) return print_json(json), kDone;
  if (demand) print_demand(*demand);
  print(rows);
  if (options.sources)
    for (const auto* actuator : shown) {
      fmt::print("\n  {}\n", actuator->figures.name);
      print_details(actuator->figures);
    }
  if (left_out > 0)
    fmt::print("{} more {} not have what is asked for\n", left_out, left_out == 1 ? "does" : "do");
  if (sensors > 0) fmt::print("sensors are left out\n");
  if (!notes.empty()) fmt::print("\n");
  for (const auto& note : notes) fmt::print("{}\n", note);
  if (!options.sources)
    fmt::print(
        "\n~: a judgement; -: none, or not one number; --sources prints each figure in words, and where it "
        "comes "
        "from\n");
  return kDone;
}

}  // namespace

void add_actuators(CLI::App& app, int& exit_code) {
  auto [command, options] = add_command(
      app, "actuators", "List actuators with price, force, band, excursion and resolution, or those that fit",
      exit_code, run_actuators);
  command.add_option("--force", options.force, "force that it must have, such as \"2 N\"");
  command.add_option("--band", options.band, "frequency that it must move at, or two: \"20 Hz,200 Hz\"");
  command.add_option("--excursion", options.excursion, "excursion to either side, such as \"3 mm\"");
  command.add_option("--resolution", options.resolution, "of its own sensor, such as \"0.2 mm\"");
  command.add_option("--price", options.price, "US $ that it may cost, such as 50");
  command.add_option(
      "--for", options.scene,
      "a scene: which actuators render it, by the spectrum of its drives, its force, travel and "
      "sensor, its stability and the models of the drive guard");
  command.add_flag("--sources", options.sources, "also print where each figure comes from");
  command.add_flag("--json", options.json, "print the report as JSON");
  command.footer(
      "Examples:\n  tactus actuators\n  tactus actuators --force \"1 N\" --price 50\n"
      "  tactus actuators --for instruments/haptic_drum");
}

}  // namespace tactus::app
