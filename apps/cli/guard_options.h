#pragma once
// Thread: [control]

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "apps/cli/json.h"
#include "engine/core/error.h"
#include "engine/scene/guard_report.h"

namespace tactus::app {

/// Options of the drive guard.
struct GuardOptions {
  std::string profile;             ///< "woofer", or a file; empty: as the scene says, else cautious
  std::string volts;               ///< volts per full scale
  std::vector<std::string> raise;  ///< NAME=VALUE
};

/// --profile, --volts-per-full-scale and --raise-limit.
void add_guard_options(CLI::App& command, GuardOptions& options);

/// Changes `drives` as the command line wants, and warns on stderr of what was raised, unless `silent`.
/// `root`: the folder with the profiles. Throws a CommandError.
DriveBook apply(const GuardOptions& options, DriveBook drives, const std::filesystem::path& root,
                bool silent = false);

/// What the guards did, for machines.
Json guard_json(const GuardReport& report, Hertz sample_rate);
/// And for people.
void print_guard(const GuardReport& report, Hertz sample_rate);

}  // namespace tactus::app
