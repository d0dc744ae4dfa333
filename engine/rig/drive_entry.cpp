#include "engine/rig/drive_entry.h"

#include "engine/graph/file/field.h"
#include "engine/graph/file/load.h"
#include "engine/graph/file/quantity.h"

namespace tactus {
namespace {

class DriveReader {
 public:
  DriveReader(const EntrySpec& entry, const ProfilePlaces& places, ErrorList& mistakes)
      : entry_(entry), places_(places), mistakes_(mistakes) {}

  DriveEntry read() {
    drive_.volts = number("volts_per_full_scale");
    drive_.profile = mistakes_.text(entry_.fields, "profile");
    if (const auto limits = read_profile()) drive_.limits = *limits;
    lower_ceiling();
    return drive_;
  }

 private:
  std::optional<DriveLimits> read_profile() {
    const auto* name = find(entry_.fields, "profile");
    const auto* volts = find(entry_.fields, "volts_per_full_scale");
    if ((name == nullptr) != (volts == nullptr))
      mistakes_.add(Errc::Missing, entry_.at,
                    std::string{"drive '"} + entry_.name + "' lacks '" +
                        (name == nullptr ? "profile" : "volts_per_full_scale") + "'",
                    "write profile = \"woofer\", volts_per_full_scale = \"10 V\"");
    if (name == nullptr || name->text() == nullptr || !drive_.volts) return std::nullopt;
    const auto file = path_of(drive_.profile, name->at);
    if (mistakes_.keep(file) == nullptr) return std::nullopt;
    const auto profile = load_profile(*file);
    if (!profile) return mistakes_.add(profile.error()), std::nullopt;
    auto limits = limits_for(*profile, *drive_.volts);
    if (const auto status = check(limits); !status)
      return mistakes_.add(Errc::OutOfRange, entry_.at, status.error().what, status.error().remedy),
             std::nullopt;
    return limits;
  }

  std::optional<double> number(const char* key) {
    static const SectionType section{"", actuator_fields()};
    const auto& field = section[key];
    return read_bounded(entry_.fields, key, field.unit, field.low, field.high, mistakes_);
  }

  /// A path is the file's own affair and stays in its folders like that of a part.
  Result<std::filesystem::path> path_of(const std::string& text, const Source& at) const {
    if (!text.ends_with(".toml")) return find_profile(text, places_.named, at.text());
    return find_part(text, places_.folder, places_.within, at).map([](const PartPath& path) {
      return std::filesystem::path{path.name};
    });
  }

  void lower_ceiling() {
    drive_.ceiling = number("ceiling");
    if (!drive_.ceiling) return;
    auto& limit = drive_.limits.ceiling;
    if (*drive_.ceiling > limit)
      return mistakes_.add(
          Errc::OutOfRange, find(entry_.fields, "ceiling")->at,
          "a file cannot raise a limit: the ceiling of '" + entry_.name + "' is " + short_number(limit),
          "lower it, or say --raise-limit ceiling=" + short_number(*drive_.ceiling) +
              " on the command line, if you must");
    limit = *drive_.ceiling;
  }

  const EntrySpec& entry_;
  const ProfilePlaces& places_;
  ErrorList& mistakes_;
  DriveEntry drive_;
};

}  // namespace

std::vector<FieldType> actuator_fields() {
  return {text_field("profile", "woofer, bass_shaker, tactor_lra, voice_coil, …, or a path"),
          quantity_field("volts_per_full_scale", "V", 1e-3, 1000, "what a sample of 1 puts on its terminals"),
          quantity_field("ceiling", "", 1e-6, 1, "less than the profile allows, in full scale"),
          about_field()};
}

DriveEntry read_drive(const EntrySpec& entry, const ProfilePlaces& places, ErrorList& mistakes) {
  return DriveReader{entry, places, mistakes}.read();
}

}  // namespace tactus
