#include "engine/rig/profile.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "engine/core/named.h"
#include "engine/graph/file/error_list.h"
#include "engine/graph/file/load.h"
#include "engine/graph/file/quantity.h"
#include "engine/graph/file/read_graph.h"

namespace tactus {
namespace {

void read_values(const Value::Table& profile, const FieldType& section, ActuatorProfile& values,
                 ErrorList& errors) {
  const auto* table = read_section(profile, section.name, errors);
  if (table == nullptr) return;
  FieldReader fields{*table, *section.inside, errors, "[" + section.name + "]",
                     find(profile, section.name)->at};
  for (const auto& field : section.inside->fields)
    if (const auto number = fields.number(field.name)) values[section.name + "." + field.name] = *number;
}

Checked<ActuatorProfile> read(const Result<Value::Table>& table, const std::string& file) {
  if (!table) return tl::unexpected(std::vector{table.error()});
  const Source start{std::make_shared<const std::string>(file), 1, 1};
  ErrorList errors;
  check_format(*table, start, errors);
  FieldReader fields{*table, profile_fields(), errors, "the profile", start};
  for (const auto* key : {"name", "about", "source"}) (void)fields.text(key);  // for people
  ActuatorProfile profile;
  for (const auto& field : profile_fields().fields)
    if (field.inside != nullptr) read_values(*table, field, profile, errors);
  if (errors.any()) return tl::unexpected(errors.take());
  return profile;
}

/// Profiles by their names; of two with one name the first.
std::map<std::string, std::filesystem::path> profiles_in(const ProfileFolders& folders) {
  std::map<std::string, std::filesystem::path> files;
  std::error_code error;
  for (const auto& folder : folders)
    for (const auto& entry : std::filesystem::directory_iterator{folder / "profiles", error})
      if (entry.path().extension() == ".toml")
        files.emplace(entry.path().stem().generic_string(), entry.path());
  return files;
}

std::string listed_folders(const ProfileFolders& folders) {
  std::string text;
  for (const auto& folder : folders) text += (text.empty() ? "'" : ", '") + folder.generic_string() + "'";
  return text;
}

/// Of the profile file of `drive`.
std::optional<DriveLimits> read_limits(const DriveEntry& drive, const Source& entry_at, ErrorList& errors) {
  const auto profile = load_profile(drive.profile_file);
  if (!profile) return errors.add(profile.error()), std::nullopt;
  const auto limits = limits_for(*profile, *drive.volts);
  if (const auto status = check(limits); !status)
    return errors.add(Errc::OutOfRange, entry_at, status.error().what, status.error().remedy), std::nullopt;
  return limits;
}

void report_raise(const DriveEntry& entry, double limit, ErrorList& errors) {
  errors.add(
      Errc::OutOfRange, entry.ceiling_at,
      "a file cannot raise a limit: the ceiling of " + entry.name + " is " + short_number(limit),
      "lower it, or use --raise-limit ceiling=" + short_number(*entry.ceiling) + " on the command line");
}

}  // namespace

const SectionType& profile_fields() {
  static const auto number = [](const char* key, const char* unit, double low, double high, const char* doc) {
    return required(quantity_field(key, unit, low, high, doc));
  };
  static const SectionType drive{
      "limits at the terminals",
      {number("resistance", "ohm", 0.01, 1e6, "resistance of the cold coil"),
       number("peak", "V", 1e-3, 1000, "largest voltage"),
       quantity_field("slew", "V/s", 1e-3, 1e9, "slew rate", "no limit"),
       number("soft_start", "s", 0, 60, "soft-start time from silence to full level"),
       number("fade_out", "s", 0, 1, "fade-out time to silence")}};
  static const SectionType heat{
      "heat limit",
      {number("power", "W", 1e-3, 1e5, "continuous power that reaches the limit in the steady state"),
       number("coil_time", "s", 0.01, 1e5, "thermal time constant of the coil"),
       number("body_time", "s", 0.01, 1e6, "thermal time constant of the body (magnet and frame)"),
       number("coil_share", "", 0.01, 0.99,
              "fraction of the temperature rise that lies between coil and body"),
       number("rise", "", 1, 500, "temperature rise above the room, in kelvin")}};
  static const SectionType travel{"excursion limit",
                                  {number("limit", "m", 1e-6, 1, "excursion to either side"),
                                   number("mass", "kg", 1e-6, 100, "moving mass"),
                                   number("stiffness", "N/m", 1e-3, 1e9, "stiffness of the suspension"),
                                   number("damping", "kg/s", 0, 1e6, "mechanical damping, without the coil"),
                                   number("force_factor", "T m", 1e-3, 1e4, "force factor Bl")}};
  static const SectionType direct{
      "DC limit",
      {number("level", "V", 1e-6, 1000, "DC level allowed continuously"),
       number("time", "s", 0, 3600, "time for which the mean may exceed the DC level")}};
  static const SectionType section{
      "an actuator profile: the limits of an actuator",
      joined(heading_fields(), {required(section_field("drive", drive)), section_field("heat", heat),
                                section_field("travel", travel), section_field("direct", direct)})};
  return section;
}

Checked<ActuatorProfile> load_profile(const std::filesystem::path& file) {
  return read(load_toml(file), file.generic_string());
}

Checked<ActuatorProfile> parse_profile(std::string_view text, const std::string& file_name) {
  return read(parse_toml(text, file_name), file_name);
}

Result<std::filesystem::path> find_profile(const std::string& name, const ProfileFolders& folders,
                                           const std::string& where) {
  if (name.ends_with(".toml")) return std::filesystem::path{name};
  const auto files = profiles_in(folders);
  if (const auto file = files.find(name); file != files.end()) return file->second;
  if (files.empty())
    return fail(Errc::BadFile, where, "there is no profiles folder in " + listed_folders(folders),
                "give the profile's file, as in \"my_woofer.toml\"");
  std::vector<std::string> names;
  for (const auto& [known, file] : files) names.push_back(known);
  return fail(Errc::UnknownName, where, "there is no profile '" + name + "'", suggest(name, names));
}

Result<std::filesystem::path> find_profile_of_file(const std::string& text, const ProfilePlaces& places,
                                                   const Source& at) {
  if (!text.ends_with(".toml")) return find_profile(text, places.named, at.text());
  return find_part(text, places.folder, places.within, at).map([](const PartPath& path) {
    return std::filesystem::path{path.name};
  });
}

DriveLimits limits_for(const ActuatorProfile& profile, double volts) {
  DriveLimits limits;
  const double ohms = profile.at("drive.resistance");
  limits.ceiling = std::min(1.0, profile.at("drive.peak") / volts);
  if (profile.contains("drive.slew")) limits.slew_per_second = profile.at("drive.slew") / volts;
  limits.soft_start = Seconds{profile.at("drive.soft_start")};
  limits.fade_out = Seconds{profile.at("drive.fade_out")};
  if (profile.contains("direct.level"))
    limits.dc = {profile.at("direct.level") / volts, Seconds{profile.at("direct.time")}};
  if (profile.contains("heat.power"))
    limits.heat = HeatLimits{volts * volts / ohms,
                             profile.at("heat.power"),
                             Seconds{profile.at("heat.coil_time")},
                             Seconds{profile.at("heat.body_time")},
                             profile.at("heat.coil_share"),
                             profile.at("heat.rise")};
  if (profile.contains("travel.limit")) {
    const double stiffness = profile.at("travel.stiffness"), mass = profile.at("travel.mass");
    const double force_factor = profile.at("travel.force_factor");
    const double damping = profile.at("travel.damping") + force_factor * force_factor / ohms;
    limits.excursion = ExcursionLimits{profile.at("travel.limit"), force_factor * volts / ohms / stiffness,
                                       Hertz{std::sqrt(stiffness / mass) / (2.0 * std::numbers::pi)},
                                       std::sqrt(stiffness * mass) / damping};
  }
  return limits;
}

std::vector<FieldType> actuator_fields() {
  return {text_field("profile", "woofer, bass_shaker, tactor_lra, voice_coil, …, or a path"),
          quantity_field("volts_per_full_scale", "V", 1e-3, 1000,
                         "voltage at the terminals for a sample value of 1"),
          quantity_field("ceiling", "", 1e-6, 1, "ceiling below that of the profile, in full scale"),
          about_field()};
}

std::vector<LimitSource> DriveEntry::sources() const {
  std::vector<LimitSource> sources;
  if (profile_limits)
    sources.push_back({LimitSource::Kind::Profile,
                       "profile '" + profile + "' (" + profile_file.generic_string() + ") of " + name,
                       *profile_limits, profile_file.string()});
  if (ceiling) sources.push_back({LimitSource::Kind::Ceiling, name, DriveLimits{.ceiling = *ceiling}});
  return sources;
}

DriveEntry read_drive(const EntrySpec& entry, const std::string& section, FieldReader& fields,
                      const ProfilePlaces& places, ErrorList& errors) {
  DriveEntry drive{section + " " + entry.name, fields.text("profile"), fields.number("volts_per_full_scale"),
                   fields.number("ceiling"), fields.at("ceiling", entry.at)};
  if (!drive.profile.empty() && drive.volts) {
    const auto file = find_profile_of_file(drive.profile, places, fields.value("profile")->at);
    if (errors.keep(file) != nullptr) {
      drive.profile_file = *file;
      drive.profile_limits = read_limits(drive, entry.at, errors);
    }
  }
  if (drive.profile_limits && drive.ceiling && *drive.ceiling > drive.profile_limits->ceiling)
    report_raise(drive, drive.profile_limits->ceiling, errors);
  return drive;
}

void check_ceiling(const DriveEntry& entry, ErrorList& errors) {
  const double built_in = conservative_limits().ceiling;
  if (entry.profile.empty() && entry.ceiling && *entry.ceiling > built_in)
    report_raise(entry, built_in, errors);
}

}  // namespace tactus
