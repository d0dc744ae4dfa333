#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "engine/core/error.h"
#include "engine/graph/file/field.h"
#include "engine/guard/drive_limits.h"

namespace tactus {

/// The limits of an actuator at its terminals, as in a file of instruments/profiles. How its figures become
/// the limits of a drive: docs/drive_guard.md.
struct ActuatorProfile {
  struct Heat {
    double watts = 0;  ///< steady power at which the coil reaches its limit in the end
    Seconds coil_time, body_time;
    double coil_share = 0.5;
    double rise_kelvin = 100;
  };
  struct Travel {
    double metres = 0;
    double mass_kg = 0, stiffness_n_per_m = 0, damping_kg_per_s = 0, force_factor_tm = 0;
  };
  struct Direct {
    double volts = 0;
    Seconds time;
  };
  std::string name, about, source;
  double resistance_ohm = 0;
  double peak_volts = 0;
  std::optional<double> slew_volts_per_second;
  Seconds soft_start, fade_out;
  std::optional<Heat> heat;
  std::optional<Travel> travel;
  std::optional<Direct> direct;
};

/// [any] All keys of a profile.
const SectionType& profile_fields();

/// [control] All mistakes of a profile in one go.
Checked<ActuatorProfile> load_profile(const std::filesystem::path& file);
Checked<ActuatorProfile> parse_profile(std::string_view text, const std::string& file_name);

/// [control] What "woofer" means: profiles/woofer.toml in `folder`; a text that ends in .toml is the path of
/// a file. Errors, at `where`: UnknownName with the nearest, BadFile.
Result<std::filesystem::path> find_profile(const std::string& name, const std::filesystem::path& folder,
                                           const std::string& where);

/// [any] The limits at a converter whose full scale puts `volts_per_full_scale` on the terminals.
DriveLimits limits_for(const ActuatorProfile& profile, double volts_per_full_scale);

/// What the user can raise on the command line and nowhere else: "ceiling", "slew", "power", "travel",
/// "direct_level", "direct_time". Errors, at `where`: UnknownName; OutOfRange if `text` is no raise.
Status raise_limit(DriveLimits& limits, const std::string& name, const std::string& text,
                   const std::string& where);

/// Limits of the drives of an instrument, by the name of the output or of one of its lanes.
struct DriveBook {
  std::map<std::string, DriveLimits> named;
  DriveLimits others = cautious_limits();

  /// `channel`: an output, or one of its lanes, as in "strings[2]".
  const DriveLimits& of(const std::string& channel) const;
};

}  // namespace tactus
