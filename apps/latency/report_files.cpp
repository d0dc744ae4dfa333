#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "apps/cli/commands.h"
#include "apps/cli/console.h"
#include "apps/cli/writable.h"
#include "apps/latency/latency_commands.h"
#include "apps/latency/latency_files.h"
#include "apps/play/play_report.h"

namespace tactus::app {
namespace {

namespace fs = std::filesystem;

/// "raw.wav" for the first, "raw_2.wav" for the second.
std::string numbered(const fs::path& file, std::size_t index) {
  if (index == 0) return file.string();
  auto name = file.stem();
  name += fmt::format("_{}", index + 1);
  name += file.extension();
  return (file.parent_path() / name).string();
}

Status write_sounds(LatencyReport& report, const std::string& file) {
  const auto& openings = report.measurement.openings;
  for (std::size_t i = 0; i < openings.size(); ++i) {
    const auto path = numbered(file, i);
    if (auto status = write_recording(path, openings[i].recording); !status) return status;
    report.written.push_back(path);
  }
  return {};
}

Status write_picture(LatencyReport& report, const std::string& file) {
  auto status = write_svg(file, picture_of(report));
  if (status) report.written.push_back(file);
  return status;
}

Status write_folder(LatencyReport& report, const fs::path& folder) {
  std::error_code ignored;
  fs::create_directories(folder, ignored);
  if (auto status = write_picture(report, (folder / "latency.svg").string()); !status) return status;
  if (report.live)
    if (auto status = write_sounds(report, (folder / "latency.wav").string()); !status) return status;
  const auto file = (folder / "latency.json").string();
  report.written.push_back(file);
  return write_json(file, json_of(report));
}

Status write_files(LatencyReport& report, const ReportFiles& files) {
  if (!files.sound.empty())
    if (auto status = write_sounds(report, files.sound); !status) return status;
  if (!files.picture.empty())
    if (auto status = write_picture(report, files.picture); !status) return status;
  return files.folder.empty() ? Status{} : write_folder(report, files.folder);
}

}  // namespace

void add_report_options(CLI::App& command, ReportFiles& files) {
  command.add_option("--folder", files.folder, "folder for the plot, the report as JSON and the recordings")
      ->check(writable_folder());
  command.add_option("--report", files.picture, "write the plot to this SVG file")->check(writable_file());
  command.add_flag("--json", files.json, "print the report as JSON");
}

int publish(LatencyReport report, const ReportFiles& files) {
  const auto written = write_files(report, files);
  if (files.json)
    fmt::print("{}\n", json_of(report).dump(2));
  else
    fmt::print("{}", text_of(report));
  if (!written) return app::report(written.error());
  return report.ok() ? kDone : kNo;
}

}  // namespace tactus::app
