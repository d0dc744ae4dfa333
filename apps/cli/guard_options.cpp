#include "apps/cli/guard_options.h"

#include <fmt/format.h>

#include <utility>

#include "apps/cli/console.h"

namespace tactus::app {
namespace {

using Json = nlohmann::ordered_json;

tl::unexpected<std::vector<Error>> invalid(const std::string& option, const std::string& what,
                                           const std::string& remedy) {
  return tl::unexpected(std::vector{Error{Errc::BadArgument, option, what, remedy}});
}

Checked<DriveLimits> limits_of(const GuardOptions& options, const std::filesystem::path& root) {
  if (options.profile.empty() || options.volts.empty())
    return invalid(options.profile.empty() ? "--volts-per-full-scale" : "--profile",
                   "the profile and the voltage at full scale must be given together",
                   "give both, as in --profile woofer --volts-per-full-scale 8");
  const auto volts = parse_option(options.volts, "V", "volts-per-full-scale");
  if (!volts) return tl::unexpected(std::vector{volts.error()});
  if (!(*volts >= 1e-3 && *volts <= 1000))
    return invalid("--volts-per-full-scale", "must be between 1 mV and 1 kV", "");
  const auto file = find_profile(options.profile, root, "--profile");
  if (!file) return tl::unexpected(std::vector{file.error()});
  const auto profile = load_profile(*file);
  if (!profile) return tl::unexpected(profile.error());
  const auto limits = limits_for(*profile, *volts);
  if (const auto status = check(limits); !status)
    return invalid("--profile", status.error().what, status.error().remedy);
  return limits;
}

Status raise(DriveBook& drives, const std::string& text, bool silent) {
  const auto equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    return fail(Errc::Syntax, "--raise-limit", "'" + text + "' is not of the form NAME=VALUE",
                "write for instance --raise-limit ceiling=0.8");
  const auto name = text.substr(0, equals), value = text.substr(equals + 1);
  for (auto& [drive, limits] : drives.named)
    if (auto status = raise_limit(limits, name, value, "--raise-limit"); !status) return status;
  // Where every drive has limits of its own, the conservative ones need not have what is raised.
  auto others = raise_limit(drives.others, name, value, "--raise-limit");
  if (!others && drives.named.empty()) return others;
  if (!silent)
    fmt::print(stderr,
               "warning: the limit '{}' of the drive guard is raised to {}, above the limit of the profile "
               "or the conservative default; keep hands away until its effect is known\n",
               name, value);
  return {};
}

}  // namespace

void add_guard_options(CLI::App& command, GuardOptions& options) {
  command.add_option("--profile", options.profile,
                     "actuator profile for all drives (outputs to actuators): woofer, bass_shaker, "
                     "tactor_lra, voice_coil, … or a file");
  command.add_option("--volts-per-full-scale", options.volts,
                     "voltage at the actuator for a sample value of 1, such as 8 or \"8 V\"");
  command.add_option(
      "--raise-limit", options.raise,
      "NAME=VALUE: raises a limit of the drive guard above the profile's, such as ceiling=0.8; NAME: "
      "ceiling, slew, power, travel (excursion), direct_level (DC level) or direct_time (time above it)");
}

Checked<DriveBook> apply(const GuardOptions& options, DriveBook drives, const std::filesystem::path& root,
                         bool silent) {
  if (!options.profile.empty() || !options.volts.empty()) {
    const auto limits = limits_of(options, root);
    if (!limits) return tl::unexpected(limits.error());
    drives = DriveBook{{}, *limits};
  }
  for (const auto& text : options.raise)
    if (const auto status = raise(drives, text, silent); !status)
      return tl::unexpected(std::vector{status.error()});
  return drives;
}

Json guard_json(const GuardReport& report, Hertz sample_rate) {
  Json json{{"idle", report.idle()}, {"outputs", Json::array()}, {"events", Json::array()}};
  for (const auto& output : report.outputs) {
    Json stages = Json::object();
    for (std::size_t s = 0; s < kGuardStages; ++s) {
      const auto& count = output.counts.stages[s];
      if (count.frames == 0) continue;
      stages[name_of(static_cast<GuardStage>(s))] = {
          {"frames", count.frames},
          {"seconds", static_cast<double>(count.frames) / sample_rate.value},
          {"most_full_scale", count.most}};
    }
    json["outputs"].push_back({{"output", output.name},
                               {"limited", stages},
                               {"coil_heat", output.heat.coil},
                               {"body_heat", output.heat.body},
                               {"coil_rise_kelvin", output.rise_kelvin}});
  }
  for (const auto& event : report.events)
    json["events"].push_back(
        {{"frame", event.frame}, {"kind", name_of(event.kind)}, {"channel", event.channel}});
  json["in_words"] = in_words(report, sample_rate);
  return json;
}

void print_guard(const GuardReport& report, Hertz sample_rate) {
  auto lines = in_words(report, sample_rate);
  if (lines.empty()) lines.push_back("no intervention");
  const char* heading = "drive guard";
  for (const auto& line : lines) fmt::print("  {:<18}  {}\n", std::exchange(heading, ""), line);
}

}  // namespace tactus::app
