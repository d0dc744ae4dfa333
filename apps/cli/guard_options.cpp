#include "apps/cli/guard_options.h"

#include <fmt/format.h>

#include <utility>

#include "apps/cli/console.h"

namespace tactus::app {
namespace {

DriveLimits limits_of(const GuardOptions& options, const std::filesystem::path& root) {
  if (options.profile.empty() || options.volts.empty())
    exit_with({Errc::BadArgument, options.profile.empty() ? "--volts-per-full-scale" : "--profile",
               "a profile and the volts of full scale belong together",
               "give both, as in --profile woofer --volts-per-full-scale 8"});
  const double volts = parse_option(options.volts, "V", "volts-per-full-scale", 1e-3, 1000);
  const auto limits =
      limits_for(or_exit(load_profile(or_exit(find_profile(options.profile, root, "--profile")))), volts);
  if (const auto status = check(limits); !status)
    exit_with({Errc::BadArgument, "--profile", status.error().what, status.error().remedy});
  return limits;
}

void raise(DriveBook& drives, const std::string& text, bool silent) {
  const auto [name, value] =
      parse_assignment(text, "--raise-limit", "NAME=VALUE", "--raise-limit ceiling=0.8");
  for (auto& [drive, limits] : drives.named) or_exit(raise_limit(limits, name, value, "--raise-limit"));
  // Where every drive has limits of its own, the cautious ones need not have what is raised.
  const auto others = raise_limit(drives.others, name, value, "--raise-limit");
  if (drives.named.empty()) or_exit(others);
  if (!silent)
    fmt::print(
        stderr,
        "warning: the drive guard's limit '{}' is raised to {}, beyond what the profile or the cautious "
        "default allows; keep hands away until its effect is known\n",
        name, value);
}

}  // namespace

void add_guard_options(CLI::App& command, GuardOptions& options) {
  command.add_option("--profile", options.profile,
                     "actuator of every drive: woofer, bass_shaker, tactor_lra, voice_coil, … or a file");
  command.add_option("--volts-per-full-scale", options.volts,
                     "voltage at the actuator for a sample of 1, such as 8 or \"8 V\"");
  command.add_option(
      "--raise-limit", options.raise,
      "NAME=VALUE: a limit of the drive guard beyond the profile's, such as ceiling=0.8: ceiling, "
      "slew, power, travel, direct_level or direct_time");
}

DriveBook apply(const GuardOptions& options, DriveBook drives, const std::filesystem::path& root,
                bool silent) {
  if (!options.profile.empty() || !options.volts.empty()) drives = DriveBook{{}, limits_of(options, root)};
  for (const auto& text : options.raise) raise(drives, text, silent);
  return drives;
}

Json guard_json(const GuardReport& report, Hertz sample_rate) {
  const auto output_json = [&](const GuardedOutput& output) {
    Json stages = Json::object();
    for (std::size_t s = 0; s < kGuardStages; ++s) {
      const auto& count = output.counts.stages[s];
      if (count.frames == 0) continue;
      stages[name_of(static_cast<GuardStage>(s))] = {
          {"frames", count.frames},
          {"seconds", static_cast<double>(count.frames) / sample_rate.value},
          {"most_full_scale", count.most}};
    }
    return Json{{"output", output.name},
                {"limited", stages},
                {"coil_heat", output.heat.coil},
                {"body_heat", output.heat.body},
                {"coil_rise_kelvin", output.rise_kelvin}};
  };
  const auto event_json = [](const GuardEvent& event) {
    return Json{{"frame", event.frame}, {"kind", name_of(event.kind)}, {"channel", event.channel}};
  };
  return {{"idle", report.idle()},
          {"outputs", list_of(report.outputs, output_json)},
          {"events", list_of(report.events, event_json)},
          {"in_words", describe(report, sample_rate)}};
}

void print_guard(const GuardReport& report, Hertz sample_rate) {
  auto lines = describe(report, sample_rate);
  if (lines.empty()) lines.push_back("no intervention");
  const char* heading = "drive guard";
  for (const auto& line : lines) fmt::print("  {:<18}  {}\n", std::exchange(heading, ""), line);
}

}  // namespace tactus::app
