#pragma once

// Thread: [control]

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/error.h"
#include "engine/graph/file/field.h"
#include "engine/graph/file/spec.h"
#include "engine/guard/drive_limits.h"
#include "engine/rig/limits.h"

namespace tactus {

/// The limits of an actuator at its terminals, as in a file of instruments/profiles: SI, by section and key
/// ("heat.power"). How they become the limits of a drive: docs/drive_guard.md.
using ActuatorProfile = std::map<std::string, double>;

/// [any] All keys of a profile.
const SectionType& profile_fields();

/// [control] All errors of a profile at once.
Checked<ActuatorProfile> load_profile(const std::filesystem::path& file);
Checked<ActuatorProfile> parse_profile(std::string_view text, const std::string& file_name);

/// Folders in whose folder "profiles" the name of a profile is looked up, in this order.
using ProfileFolders = std::vector<std::filesystem::path>;

/// [control] What "woofer" means: the first profiles/woofer.toml in `folders`; a text that ends in .toml is
/// the path of a file. Errors, at `where`: UnknownName with the nearest, BadFile.
Result<std::filesystem::path> find_profile(const std::string& name, const ProfileFolders& folders,
                                           const std::string& where);

/// [any] The limits at a converter whose full scale puts `volts_per_full_scale` on the terminals.
DriveLimits limits_for(const ActuatorProfile& profile, double volts_per_full_scale);

/// The folders of the profiles that a file refers to.
struct ProfilePlaces {
  std::filesystem::path folder;  ///< of the file: paths ("my_woofer.toml") start here
  std::filesystem::path within;  ///< and may not leave this
  ProfileFolders named;          ///< of names ("woofer")
};

/// [control] The file of a profile that a file refers to at `at`, by name or path. Errors: those of
/// find_profile and find_part.
Result<std::filesystem::path> find_profile_of_file(const std::string& text, const ProfilePlaces& places,
                                                   const Source& at);

/// What a file says of one actuator, as written:
///   { profile = "woofer", volts_per_full_scale = "10 V", ceiling = 0.8 }
struct DriveEntry {
  std::string name = {};  ///< for messages: "[outputs] woofer"
  std::string profile = {};
  std::optional<double> volts = {};  ///< per full scale
  std::optional<double> ceiling = {};
  Source ceiling_at = {};
  std::filesystem::path profile_file = {};         ///< of `profile`
  std::optional<DriveLimits> profile_limits = {};  ///< of `profile` at `volts`

  std::vector<LimitSource> sources() const;
  /// [any] By this entry alone, as a drive.
  DriveLimits limits() const { return combine_limits(OutputTarget::Drive, sources()).limits; }
};

/// [any] The keys of an actuator.
std::vector<FieldType> actuator_fields();
/// [control] Reads these keys of `entry`, which stands in the section `section`. Errors besides those of the
/// keys: OutOfRange for a ceiling above that of the profile.
DriveEntry read_drive(const EntrySpec& entry, const std::string& section, FieldReader& fields,
                      const ProfilePlaces& places, ErrorList& errors);
/// [control] OutOfRange if the ceiling of an entry without a profile is above that of a drive of which
/// nothing is known.
void check_ceiling(const DriveEntry& entry, ErrorList& errors);

}  // namespace tactus
