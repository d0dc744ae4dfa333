#include "engine/rig/profile.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "engine/graph/file/error_list.h"
#include "engine/graph/file/field.h"
#include "engine/graph/file/load.h"
#include "engine/graph/file/quantity.h"
#include "engine/graph/file/read_graph.h"

namespace tactus {
namespace {

/// Reads the sections of one profile.
class ProfileReader {
 public:
  ProfileReader(const Value::Table& table, const Source& file) : table_(table), file_(file) {}

  Checked<ActuatorProfile> read() {
    check_format(table_, file_, mistakes_);
    FieldReader{table_, profile_fields(), mistakes_};
    profile_.name = mistakes_.text(table_, "name");
    profile_.about = mistakes_.text(table_, "about");
    profile_.source = mistakes_.text(table_, "source");
    read_drive();
    read_heat();
    read_travel();
    read_direct();
    if (mistakes_.any()) return tl::unexpected(mistakes_.take());
    return profile_;
  }

 private:
  void read_drive() {
    if (!open("drive"))
      return mistakes_.add(Errc::Missing, {file_.file, 1, 1}, "[drive] is missing",
                           "give at least resistance and peak of the terminals");
    profile_.resistance_ohm = number("resistance");
    profile_.peak_volts = number("peak");
    if (find(*section_, "slew") != nullptr) profile_.slew_volts_per_second = number("slew");
    profile_.soft_start = Seconds{number("soft_start")};
    profile_.fade_out = Seconds{number("fade_out")};
  }

  // clang 14 emplaces no empty one of a class inside a class.
  void read_heat() {
    if (!open("heat")) return;
    auto& heat = profile_.heat.emplace(ActuatorProfile::Heat{});
    heat.watts = number("power");
    heat.coil_time = Seconds{number("coil_time")};
    heat.body_time = Seconds{number("body_time")};
    heat.coil_share = number("coil_share");
    heat.rise_kelvin = number("rise");
  }

  void read_travel() {
    if (!open("travel")) return;
    auto& travel = profile_.travel.emplace(ActuatorProfile::Travel{});
    travel.metres = number("limit");
    travel.mass_kg = number("mass");
    travel.stiffness_n_per_m = number("stiffness");
    travel.damping_kg_per_s = number("damping");
    travel.force_factor_tm = number("force_factor");
  }

  void read_direct() {
    if (!open("direct")) return;
    auto& direct = profile_.direct.emplace(ActuatorProfile::Direct{});
    direct.volts = number("level");
    direct.time = Seconds{number("time")};
  }

  /// False if the section is not there.
  bool open(const std::string& name) {
    section_ = read_section(table_, name, mistakes_);
    if (section_ == nullptr) return false;
    type_ = profile_fields()[name].inside;
    name_ = name;
    at_ = find(table_, name)->at;
    FieldReader{*section_, *type_, mistakes_};
    return true;
  }

  double number(const std::string& key) {
    const auto& field = (*type_)[key];
    FieldReader fields{*section_, *type_, mistakes_, FieldReader::kKeysChecked};
    if (!fields.has(key))
      mistakes_.add(Errc::Missing, at_, "[" + name_ + "] lacks '" + key + "'",
                    field.unit.empty() ? "give a plain number" : "give it in " + field.unit);
    return fields.number(key).value_or(field.low);
  }

  const Value::Table& table_;
  Source file_, at_;
  const Value::Table* section_ = nullptr;
  const SectionType* type_ = nullptr;
  std::string name_;
  ErrorList mistakes_;
  ActuatorProfile profile_;
};

Checked<ActuatorProfile> read(const Result<Value::Table>& table, const std::string& file) {
  if (!table) return tl::unexpected(std::vector{table.error()});
  return ProfileReader{*table, {std::make_shared<const std::string>(file), 0, 0}}.read();
}

std::vector<std::string> profiles_in(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator{folder, error})
    if (entry.path().extension() == ".toml") names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace

const SectionType& profile_fields() {
  static const auto number = [](const char* key, const char* unit, double low, double high, const char* doc) {
    return required(quantity_field(key, unit, low, high, doc));
  };
  static const SectionType drive{"the terminals",
                                 {number("resistance", "ohm", 0.01, 1e6, "of the coil, cold"),
                                  number("peak", "V", 1e-3, 1000, "largest voltage"),
                                  quantity_field("slew", "V/s", 1e-3, 1e9, "slew rate", "no limit"),
                                  number("soft_start", "s", 0, 60, "time from silence to full"),
                                  number("fade_out", "s", 0, 1, "time to silence")}};
  static const SectionType heat{
      "limits of heat",
      {number("power", "W", 1e-3, 1e5, "steady, leads to the limit in the end"),
       number("coil_time", "s", 0.01, 1e5, "time constant of the coil"),
       number("body_time", "s", 0.01, 1e6, "time constant of the body around it"),
       number("coil_share", "", 0.01, 0.99, "of the rise that lies between coil and body"),
       number("rise", "", 1, 500, "kelvin above the room")}};
  static const SectionType travel{
      "limits of excursion",
      {number("limit", "m", 1e-6, 1, "to either side"), number("mass", "kg", 1e-6, 100, "that moves"),
       number("stiffness", "N/m", 1e-3, 1e9, "of its suspension"),
       number("damping", "kg/s", 0, 1e6, "without the coil"),
       number("force_factor", "T m", 1e-3, 1e4, "Bl")}};
  static const SectionType direct{"limits of DC",
                                  {number("level", "V", 1e-6, 1000, "allowed for ever"),
                                   number("time", "s", 0, 3600, "that the mean may lie above it")}};
  static const SectionType section = [] {
    SectionType profile{"the limits of an actuator", heading_fields()};
    profile.fields.push_back(required(section_field("drive", drive)));
    for (const auto& [key, inside] : {std::pair{"heat", &heat}, {"travel", &travel}, {"direct", &direct}})
      profile.fields.push_back(section_field(key, *inside));
    return profile;
  }();
  return section;
}

Checked<ActuatorProfile> load_profile(const std::filesystem::path& file) {
  return read(load_toml(file), file.string());
}

Checked<ActuatorProfile> parse_profile(std::string_view text, const std::string& file_name) {
  return read(parse_toml(text, file_name), file_name);
}

Result<std::filesystem::path> find_profile(const std::string& name, const std::filesystem::path& folder,
                                           const std::string& where) {
  std::error_code error;
  if (name.ends_with(".toml")) return std::filesystem::path{name};
  const auto names = profiles_in(folder / "profiles");
  if (std::find(names.begin(), names.end(), name) != names.end())
    return folder / "profiles" / (name + ".toml");
  if (names.empty())
    return fail(Errc::BadFile, where, "there is no folder of profiles in '" + folder.string() + "'",
                "name the profile's file, as in \"my_woofer.toml\"");
  return fail(Errc::UnknownName, where, "there is no profile '" + name + "'", suggest(name, names));
}

DriveLimits limits_for(const ActuatorProfile& profile, double volts) {
  DriveLimits limits;
  limits.ceiling = std::min(1.0, profile.peak_volts / volts);
  if (profile.slew_volts_per_second) limits.slew_per_second = *profile.slew_volts_per_second / volts;
  limits.soft_start = profile.soft_start;
  limits.fade_out = profile.fade_out;
  if (profile.direct) limits.dc = {profile.direct->volts / volts, profile.direct->time};
  if (const auto& heat = profile.heat)
    limits.heat = HeatLimits{volts * volts / profile.resistance_ohm,
                             heat->watts,
                             heat->coil_time,
                             heat->body_time,
                             heat->coil_share,
                             heat->rise_kelvin};
  if (const auto& t = profile.travel) {
    const double damping =
        t->damping_kg_per_s + t->force_factor_tm * t->force_factor_tm / profile.resistance_ohm;
    limits.excursion =
        ExcursionLimits{t->metres, t->force_factor_tm * volts / profile.resistance_ohm / t->stiffness_n_per_m,
                        Hertz{std::sqrt(t->stiffness_n_per_m / t->mass_kg) / (2.0 * std::numbers::pi)},
                        std::sqrt(t->stiffness_n_per_m * t->mass_kg) / damping};
  }
  return limits;
}

Status raise_limit(DriveLimits& limits, const std::string& name, const std::string& text,
                   const std::string& where) {
  static const std::vector<std::string> kNames = {"ceiling", "slew",         "power",
                                                  "travel",  "direct_level", "direct_time"};
  if (std::find(kNames.begin(), kNames.end(), name) == kNames.end())
    return fail(Errc::UnknownName, where, "there is no limit '" + name + "'", "there are " + listed(kNames));
  const char* unit = name == "power" ? "W" : name == "travel" ? "m" : name == "direct_time" ? "s" : "";
  const auto value = read_quantity(Value{text, {}}, *parse_unit(unit), name);
  if (!value) return fail(value.error().code, where, value.error().what, value.error().remedy);
  double* limit = name == "ceiling"        ? &limits.ceiling
                  : name == "slew"         ? &limits.slew_per_second
                  : name == "direct_level" ? &limits.dc.level
                  : name == "direct_time"  ? &limits.dc.time.value
                  : name == "power"        ? (limits.heat ? &limits.heat->watts_for_ever : nullptr)
                                           : (limits.excursion ? &limits.excursion->metres : nullptr);
  if (limit == nullptr || !std::isfinite(*limit))
    return fail(Errc::OutOfRange, where, "this drive has no limit on '" + name + "' to raise",
                "leave it out");
  if (!(*value > *limit))
    return fail(Errc::OutOfRange, where, "'" + name + "' is " + short_number(*limit) + " as it is",
                "a limit can only be raised here");
  const double before = std::exchange(*limit, *value);
  auto status = check(limits);
  if (status) return status;
  *limit = before;
  status.error().where = where;
  return status;
}

const DriveLimits& DriveBook::of(const std::string& channel) const {
  auto found = named.find(channel);
  if (found == named.end()) found = named.find(channel.substr(0, channel.find('[')));
  return found == named.end() ? others : found->second;
}

}  // namespace tactus
