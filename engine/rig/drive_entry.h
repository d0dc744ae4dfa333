#pragma once

// Thread: [control]

#include <filesystem>
#include <optional>
#include <string>

#include "engine/graph/file/error_list.h"
#include "engine/graph/file/field.h"
#include "engine/graph/file/spec.h"
#include "engine/rig/profile.h"

namespace tactus {

/// The folders of the profiles of a file.
struct ProfilePlaces {
  std::filesystem::path folder;  ///< of the file: paths ("my_woofer.toml") start here
  std::filesystem::path within;  ///< and may not leave this
  std::filesystem::path named;   ///< "woofer" is profiles/woofer.toml in here
};

/// What a file says of one actuator, as written:
///   { profile = "woofer", volts_per_full_scale = "10 V", ceiling = 0.8 }
struct DriveEntry {
  std::string profile;          ///< empty: cautious limits
  std::optional<double> volts;  ///< per full scale
  std::optional<double> ceiling;
  DriveLimits limits = cautious_limits();  ///< that all this comes to
};

/// The keys of an actuator.
std::vector<FieldType> actuator_fields();
/// Reads these three keys of `entry`; a ceiling may be lower than it is anyway, never higher.
DriveEntry read_drive(const EntrySpec& entry, const ProfilePlaces& places, ErrorList& mistakes);

}  // namespace tactus
