#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <memory>

#include "apps/cli/commands.h"
#include "apps/cli/console.h"
#include "apps/cli/writable.h"
#include "apps/play/play_report.h"
#include "apps/study/reports.h"
#include "apps/study/sweep_options.h"
#include "engine/nodes/table.h"

namespace tactus::app {
namespace {

namespace fs = std::filesystem;

struct WorkPrecisionArguments : StudyOptions {
  std::string folder;
  std::vector<std::string> solvers, rates;
  std::vector<int> oversamples;
  int repeats = 5;
};

Status write_text(const fs::path& file, const std::string& text) {
  std::ofstream stream{file};
  stream << text;
  stream.close();
  return stream ? Status{} : fail(Errc::BadFile, file.string(), "cannot be written", "choose another folder");
}

Status write_files(const WorkPrecision& study, const fs::path& folder) {
  std::error_code ignored;
  fs::create_directories(folder, ignored);
  if (auto status = write_svg(folder / "work_precision.svg", plots_of(study)); !status) return status;
  if (auto status = write_text(folder / "work_precision.md", markdown_of(study)); !status) return status;
  return write_json((folder / "work_precision.json").string(), app::json_of(study));
}

Result<std::vector<Hertz>> rates_of(const std::vector<std::string>& texts) {
  std::vector<Hertz> rates;
  for (const auto& text : texts) {
    auto& rate = rates.emplace_back();
    if (auto status = read_option(text, "Hz", "rates", 1e3, 768e3, rate.value); !status)
      return tl::unexpected(status.error());
  }
  return rates;
}

int run_work_precision(const WorkPrecisionArguments& options) {
  if (const auto solvers = swept_solvers(options.solvers, "--solvers"); !solvers)
    return report(solvers.error());
  const auto rates = rates_of(options.rates);
  if (!rates) return report(rates.error()), kUsage;
  const auto scene = load_target(options);
  if (!scene) return report(scene.error());
  const auto study = [&] {
    Progress progress{"studying " + scene->name};
    return study_work_precision(*scene, standard_nodes(),
                                {options.solvers, *rates, options.oversamples, options.repeats,
                                 [&](double share, const std::string& what) { progress(share, what); }});
  }();
  if (!study) return report(study.error());
  const auto written = options.folder.empty() ? Status{} : write_files(*study, options.folder);
  const int failed = publish(options, app::text_of(*study), app::json_of(*study), plots_of(*study));
  if (!written) return report(written.error());
  if (failed) return failed;
  return study->cheapest(1.0) == nullptr ? kNo : kDone;
}

}  // namespace

void add_study_work_precision(CLI::App& study, int& exit_code) {
  auto* command = study.add_subcommand(
      "work-precision",
      "Numerical error against computing time for every solver, sample rate and oversampling");
  auto options = std::make_shared<WorkPrecisionArguments>();
  add_study_options(*command, *options, "scene with [accuracy]; for a folder, its scene.toml")->required();
  command->add_option("--solvers", options->solvers, "solvers, such as explicit,passive; default: all")
      ->delimiter(',');
  command
      ->add_option("--rates", options->rates,
                   "sample rates, such as 24kHz,96kHz; default: the scene's, half and twice that")
      ->delimiter(',');
  command->add_option("--oversample", options->oversamples, "steps per frame; default: 1,2,4,8,16")
      ->delimiter(',')
      ->check(CLI::Range(1, 64));
  command->add_option("--repeat", options->repeats, "number of timing runs; their median is reported")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command
      ->add_option("--out", options->folder,
                   "folder for the plot (SVG), the table (Markdown) and the results (JSON)")
      ->check(writable_folder());
  command->footer(
      "Examples:\n  tactus study work-precision instruments/numerics/stick_impact\n"
      "  tactus study work-precision instruments/numerics/woofer --solvers explicit,passive --rates 48kHz "
      "--out out/woofer\n"
      "The scene's [accuracy] section lists the compared measures (docs/graph_files.md).\n"
      "Exit code 1: no variant is both stable and fast enough for real time.");
  command->callback([options, &exit_code] { exit_code = run_work_precision(*options); });
}

}  // namespace tactus::app
