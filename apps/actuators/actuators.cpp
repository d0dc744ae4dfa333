#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <optional>
#include <set>

#include "apps/cli/console.h"
#include "apps/cli/json.h"
#include "apps/cli/rig_files.h"
#include "apps/cli/target.h"
#include "apps/play/play_report.h"
#include "engine/core/index.h"
#include "engine/graph/file/quantity.h"
#include "engine/guard/drive_guard.h"
#include "engine/rig/actuator_figures.h"
#include "latency/estimation/fourier.h"

namespace tactus::app {
namespace {

namespace fs = std::filesystem;

constexpr double kBandShare = 0.05;     // of the energy of a drive, below its band and above it
constexpr double kLimitedShare = 1e-3;  // of the frames: fewer are not felt
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

/// A vibrating motor: that it turns without end moves nothing.
bool only_vibrates(const ActuatorFigures& figures) { return figures.drive_to.has_value(); }

/// Whether an actuator has it, and what is not known of it.
struct Match {
  std::vector<std::string> lacks, unknown;
};

Match match(const ActuatorFigures& figures, const Need& need) {
  Match found;
  const auto judge = [&](const char* what, bool known, bool has) {
    if (!known)
      found.unknown.emplace_back(what);
    else if (!has)
      found.lacks.emplace_back(what);
  };
  if (need.force) judge("force", figures.force.high.has_value(), figures.force.high >= need.force);
  if (need.excursion)
    judge("excursion", figures.excursion.high.has_value(),
          figures.excursion.high >= need.excursion && !only_vibrates(figures));
  if (need.resolution)
    judge("resolution", figures.resolution.low.has_value(), figures.resolution.low <= need.resolution);
  if (need.price) judge("price", figures.price.low.has_value(), figures.price.low <= need.price);
  if (need.band)
    judge("band", figures.band.high.has_value(),
          figures.band.low.value_or(0.0) <= need.band->low && figures.band.high >= need.band->high);
  return found;
}

// What an instrument needs.

/// What goes to one drive of a scene.
struct Drive {
  std::string name;
  std::vector<double> samples;
  Interval band{0.0, 0.0};  ///< Hz, with all but a twentieth of the energy on either side
};

/// The frequencies with all but a twentieth of the energy at either end.
Interval band_of(const std::vector<double>& samples, double rate_hz) {
  Fourier fourier{samples.size()};
  std::vector<double> energy;
  double sum = 0.0;
  for (const auto& bin : fourier.forward(samples)) energy.push_back(sum += std::norm(bin));
  const auto frequency = [&](double share) {
    const auto bin = std::ranges::lower_bound(energy, share * sum) - energy.begin();
    return static_cast<double>(bin) * rate_hz / static_cast<double>(fourier.size());
  };
  if (!(sum > 0)) return {0.0, 0.0};
  return {frequency(kBandShare), frequency(1.0 - kBandShare)};
}

/// What a scene needs.
struct Demand {
  std::string scene;
  double rate_hz = 0.0;
  std::vector<Drive> drives;
  std::optional<double> force = {};   ///< largest on the player, where a port measures it
  std::optional<double> travel = {};  ///< [m] to either side of the middle, of what the instrument reads in m
  bool sensed = false;                ///< the instrument reads a position or a velocity
};

/// What the instrument of a scene reads of its plant.
void add_motion(Demand& demand, const SceneSpec& scene, const SceneRecording& recording) {
  const auto metre = parse_unit("m")->dimension, second = parse_unit("s")->dimension;
  const auto* part = scene.part("instrument");
  if (part == nullptr || part->graph == nullptr) return;
  for (const auto& input : part->graph->inputs) {
    const auto is = [&](const Dimension& d) { return input.dimension == d; };
    const auto radian = parse_unit("rad")->dimension;
    const bool place = is(metre) && input.dimension.radian == 0;
    demand.sensed |= is(metre) || is(metre / second) ||
                     (input.dimension.radian != 0 && (is(radian) || is(radian / second)));
    const auto* signal = place ? recording.find("instrument." + input.name) : nullptr;
    if (signal == nullptr || signal->samples.empty()) continue;
    const auto [least, most] = std::ranges::minmax(signal->samples);
    demand.travel = std::max(demand.travel.value_or(0.0), 0.5 * (most - least));
  }
}

Demand demand_of(const std::string& target) {
  const auto played = play_file(resolve_target(target), {});
  const auto& recording = played.recording;
  Demand demand{.scene = played.scene.name, .rate_hz = recording.sample_rate.value, .drives = {}};
  for (const auto& name : drive_names(recording)) {
    const auto* signal = recording.find("instrument." + name);
    if (signal == nullptr) continue;
    demand.drives.push_back({name, signal->samples, band_of(signal->samples, demand.rate_hz)});
  }
  const auto newton = parse_unit("N")->dimension;
  for (const auto& port : played.scene.ports)
    if (const auto* force = recording.find(port.force.name); force != nullptr && force->dimension == newton)
      for (const double sample : force->samples)
        demand.force = std::max(demand.force.value_or(0.0), std::abs(sample));
  add_motion(demand, played.scene, recording);
  if (demand.drives.empty())
    exit_with({Errc::BadArgument, target, "it drives no actuator", "name a scene with a drive"}, kNo);
  return demand;
}

/// What the guard of an actuator does to a drive whose full scale is the actuator's largest voltage.
struct GuardVerdict {
  std::string drive;
  std::vector<std::pair<std::string, double>> limited;  ///< by stage: share of the frames
};

GuardVerdict judge(const Drive& drive, const DriveLimits& limits, double rate_hz) {
  DriveGuard guard{DriveGuard::Kind::Drive, limits, Hertz{rate_hz}, {false, false}};
  guard.set_open(true, 0);
  guard.skip_soft_start();
  auto samples = drive.samples;
  for (std::size_t at = 0; at < samples.size(); at += kBlock)
    guard.process(samples.data() + at, static_cast<int>(std::min<std::size_t>(kBlock, samples.size() - at)),
                  static_cast<std::int64_t>(at));
  GuardVerdict verdict{drive.name, {}};
  const auto counts = guard.counts();
  for (std::size_t stage = 0; stage < kGuardStages; ++stage) {
    const double share = static_cast<double>(counts[stage].frames) / static_cast<double>(samples.size());
    if (share >= kLimitedShare) verdict.limited.emplace_back(name_of(GuardStage::Index{stage}), share);
  }
  return verdict;
}

/// Nothing: the actuator has no profile.
std::optional<std::vector<GuardVerdict>> judge(const Actuator& actuator, const Demand& demand) {
  const auto& name = actuator.figures.profile;
  if (name.empty()) return std::nullopt;
  const auto file = name.ends_with(".toml")
                        ? actuator.file.parent_path() / name
                        : or_exit(find_profile(name, option_profile_folders(), "profile"));
  const auto profile = or_exit(load_profile(file), kBadFile);
  const auto limits = limits_for(profile, profile.at("drive.peak"));
  std::vector<GuardVerdict> verdicts;
  for (const auto& drive : demand.drives) verdicts.push_back(judge(drive, limits, demand.rate_hz));
  return verdicts;
}

/// Why the actuator cannot move as a drive asks; empty: it can, as far as its band is known. A force on the
/// player must have the frequencies of the drive; otherwise a vibration may follow it.
std::string band_objection(const ActuatorFigures& figures, const Drive& drive, bool gives_force) {
  if (figures.drive_to && !gives_force)
    return drive.band.high <= *figures.drive_to
               ? ""
               : fmt::format("'{}' changes at up to {}, and it follows changes up to {}", drive.name,
                             number_text(drive.band.high, "Hz"), number_text(*figures.drive_to, "Hz"));
  if (figures.band.high && drive.band.high > *figures.band.high)
    return fmt::format("'{}' reaches up to {}, and it moves up to {}", drive.name,
                       number_text(drive.band.high, "Hz"), number_text(*figures.band.high, "Hz"));
  if (figures.band.low && drive.band.low < *figures.band.low)
    return fmt::format("'{}' reaches down to {}, and it moves from {} on", drive.name,
                       number_text(drive.band.low, "Hz"), number_text(*figures.band.low, "Hz"));
  return "";
}

/// What cannot be compared: the scene does not show it, or the figures of the actuator lack it.
std::vector<std::string> not_compared(const ActuatorFigures& figures, const Demand& demand) {
  std::vector<std::string> all;
  if (!demand.force || !figures.force.high) all.emplace_back("force");
  if (!figures.band.high && !figures.drive_to) all.emplace_back("band");
  if (!demand.travel || !figures.excursion.high) all.emplace_back("travel");
  return all;
}

/// Why the actuator does not render the scene; empty: it does, as far as it is known.
std::vector<std::string> objections(const Actuator& actuator, const Demand& demand) {
  std::vector<std::string> all;
  const auto& figures = actuator.figures;
  if (demand.travel && figures.excursion.high && *figures.excursion.high < *demand.travel)
    all.push_back(fmt::format("the device moves {} to either side, and it moves {}",
                              number_text(*demand.travel, "m"), number_text(*figures.excursion.high, "m")));
  if (demand.sensed && only_vibrates(figures)) all.push_back("it moves nothing that could be sensed");
  if (demand.force && figures.force.high && *figures.force.high < *demand.force)
    all.push_back(fmt::format("the force reaches {}, and it has {}", number_text(*demand.force, "N"),
                              number_text(*figures.force.high, "N")));
  for (const auto& drive : demand.drives)
    if (const auto against = band_objection(figures, drive, demand.force.has_value()); !against.empty())
      all.push_back(against);
  if (const auto verdicts = judge(actuator, demand))
    for (const auto& verdict : *verdicts)
      for (const auto& [stage, share] : verdict.limited)
        all.push_back(fmt::format("its drive guard limits '{}' for {:.1f} % of the time ({})", verdict.drive,
                                  100 * share, stage));
  return all;
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

void print_demand(const Demand& demand) {
  fmt::print("{}\n", demand.scene);
  for (const auto& drive : demand.drives)
    fmt::print("  '{}': nine tenths of its energy between {} and {}\n", drive.name,
               number_text(drive.band.low, "Hz"), number_text(drive.band.high, "Hz"));
  if (demand.force) fmt::print("  largest force on the player: {}\n", number_text(*demand.force, "N"));
  if (demand.travel)
    fmt::print("  travel of the device: {} to either side\n", number_text(*demand.travel, "m"));
  fmt::print("\n");
}

std::string judgement(const Actuator& actuator, const Demand& demand,
                      const std::vector<std::string>& against) {
  if (!against.empty()) return fmt::format("{}", fmt::join(against, "; "));
  if (actuator.figures.profile.empty()) return "not judged: it has no profile";
  const auto open = not_compared(actuator.figures, demand);
  std::string text =
      open.empty() ? "renders it" : fmt::format("no objection; not compared: {}", fmt::join(open, ", "));
  if (demand.sensed && !actuator.figures.resolution.low) text += "; it needs a sensor of its own";
  return text;
}

int run_actuators(const ActuatorOptions& options) {
  const auto need = need_of(options);
  const auto all = known_actuators();
  if (all.empty())
    exit_with({Errc::BadFile, "actuators", "the figures of actuators are not installed",
               "install the shipped instruments"},
              kBadFile);
  const auto demand = options.scene.empty() ? std::nullopt : std::optional{demand_of(options.scene)};
  Json json{{"actuators", Json::array()}};
  std::vector<Row> rows = {{"actuator", "price", "force", "band", "excursion", "resolution"}};
  std::vector<std::string> notes;
  std::vector<const Actuator*> shown;
  int left_out = 0;
  for (const auto& actuator : all) {
    const auto found = match(actuator.figures, need);
    const auto against = demand ? objections(actuator, *demand) : std::vector<std::string>{};
    auto entry = actuator_json(actuator.figures);
    entry["lacks"] = found.lacks;
    entry["unknown"] = found.unknown;
    if (demand) {
      entry["objections"] = against;
      entry["not_compared"] = not_compared(actuator.figures, *demand);
    }
    json["actuators"].push_back(std::move(entry));
    if (!found.lacks.empty()) {
      ++left_out;
      continue;
    }
    rows.push_back(row_of(actuator.figures));
    shown.push_back(&actuator);
    if (!found.unknown.empty())
      notes.push_back(fmt::format("{}: unknown: {}", actuator.figures.name, fmt::join(found.unknown, ", ")));
    if (demand)
      notes.push_back(fmt::format("{}: {}", actuator.figures.name, judgement(actuator, *demand, against)));
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
  if (!notes.empty()) fmt::print("\n");
  for (const auto& note : notes) fmt::print("{}\n", note);
  if (demand) fmt::print("stability is not compared: tactus check {}\n", options.scene);
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
      "a scene: which actuators render it, by the spectrum of its drives, its largest force and "
      "the models of the drive guard");
  command.add_flag("--sources", options.sources, "also print where each figure comes from");
  command.add_flag("--json", options.json, "print the report as JSON");
  command.footer(
      "Examples:\n  tactus actuators\n  tactus actuators --force \"1 N\" --price 50\n"
      "  tactus actuators --for instruments/haptic_drum");
}

}  // namespace tactus::app
