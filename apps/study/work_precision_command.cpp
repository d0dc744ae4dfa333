#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>

#include "apps/cli/commands.h"
#include "apps/cli/console.h"
#include "apps/cli/writable.h"
#include "apps/play/play_report.h"
#include "apps/study/study_commands.h"
#include "apps/study/work_precision_report.h"
#include "engine/graph/file/error_list.h"
#include "engine/nodes/table.h"
#include "engine/study/sweep/scene_variants.h"
#include "engine/study/work_precision/work_precision_plot.h"

namespace tactus::app {
namespace {

namespace fs = std::filesystem;

struct WorkPrecisionArguments {
  std::string target, folder;
  std::vector<std::string> solvers, rates;
  std::vector<int> oversamples;
  int repeats = 5;
  bool json = false;
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
  return write_json((folder / "work_precision.json").string(), json_of(study));
}

Result<std::vector<Hertz>> rates_of(const std::vector<std::string>& texts) {
  std::vector<Hertz> rates;
  for (const auto& text : texts) {
    const auto rate = parse_option(text, "Hz", "rates");
    if (!rate) return tl::unexpected(rate.error());
    if (!(*rate >= 1e3 && *rate <= 768e3))
      return fail(Errc::OutOfRange, "--rates", text + " is out of range", "choose 1 kHz to 768 kHz");
    rates.push_back(Hertz{*rate});
  }
  return rates;
}

/// Errors: UnknownName of a solver.
Status check_solvers(const std::vector<std::string>& asked) {
  const auto known = stepping_solvers();
  for (const auto& word : asked)
    if (std::find(known.begin(), known.end(), word) == known.end())
      return fail(Errc::UnknownName, "--solvers", "there is no solver '" + word + "'",
                  "there are " + listed(known));
  return {};
}

int run_work_precision(const WorkPrecisionArguments& options) {
  if (const auto status = check_solvers(options.solvers); !status) return report(status.error()), kUsage;
  const auto rates = rates_of(options.rates);
  if (!rates) return report(rates.error()), kUsage;
  const auto file = resolve_target(options.target, "scene.toml");
  const auto scene = load_scene(file, root_of(file));
  if (!scene) return report(scene.error());
  std::optional<Progress> progress{std::in_place, "studying " + scene->name};
  const auto study =
      study_work_precision(*scene, standard_nodes(),
                           {options.solvers, *rates, options.oversamples, options.repeats,
                            [&](double share, const std::string& what) { (*progress)(share, what); }});
  progress.reset();
  if (!study) return report(study.error());
  const auto written = options.folder.empty() ? Status{} : write_files(*study, options.folder);
  if (options.json)
    fmt::print("{}\n", json_of(*study).dump(2));
  else
    fmt::print("{}", text_of(*study));
  if (!written) return report(written.error());
  return study->cheapest(1.0) == nullptr ? kNo : kDone;
}

}  // namespace

void add_study_work_precision(CLI::App& study, int& exit_code) {
  auto* command = study.add_subcommand(
      "work-precision", "Error against computing time for every solver, rate and oversampling");
  auto options = std::make_shared<WorkPrecisionArguments>();
  command->add_option("SCENE", options->target, "scene with [accuracy]; a folder means its scene.toml")
      ->required();
  command->add_option("--solvers", options->solvers, "such as explicit,passive; [all]")->delimiter(',');
  command->add_option("--rates", options->rates, "such as 24kHz,96kHz; [the scene's, half and twice that]")
      ->delimiter(',');
  command->add_option("--oversample", options->oversamples, "steps a frame; [1,2,4,8,16]")
      ->delimiter(',')
      ->check(CLI::Range(1, 64));
  command->add_option("--repeat", options->repeats, "runs for the time, of which the median counts")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command
      ->add_option("--out", options->folder,
                   "folder for the picture (SVG), the table (Markdown) and the JSON")
      ->check(writable_folder());
  command->add_flag("--json", options->json, "for machines");
  command->footer(
      "Examples:\n  tactus study work-precision instruments/numerics/stick_impact\n"
      "  tactus study work-precision instruments/numerics/woofer --solvers explicit,passive --rates 48kHz "
      "--out out/woofer\n"
      "What is compared is in [accuracy] of the scene (docs/graph_files.md).\n"
      "Exit code 1: nothing is stable in real time.");
  command->callback([options, &exit_code] { exit_code = run_work_precision(*options); });
}

}  // namespace tactus::app
