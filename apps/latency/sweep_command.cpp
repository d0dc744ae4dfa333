#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "apps/cli/commands.h"
#include "apps/cli/console.h"
#include "apps/cli/interrupts.h"
#include "apps/cli/writable.h"
#include "apps/latency/latency_commands.h"
#include "apps/latency/loop_options.h"
#include "apps/latency/sweep_report.h"
#include "apps/play/play_report.h"

namespace tactus::app {
namespace {

struct SweepOptions {
  LoopOptions loop;
  std::vector<int> blocks = {16, 32, 64, 128, 256, 512, 1024};
  std::vector<int> periods;
  std::vector<std::string> rates;
  std::string picture;
  bool json = false;
};

/// Only to be opened with: nothing is played.
class Silence final : public BlockProcessor {
 public:
  Status prepare(const StreamFormat&) override { return {}; }
  void process(const BlockIo&) noexcept override {}
};

/// What the device makes of a request. Errors: of `open`.
Result<StreamGranted> ask(Backend& backend, const MeasureSettings& settings) {
  auto request = settings.request;
  request.in_channels = request.out_channels = 1;
  request.in_map = {settings.input};
  request.out_map = {settings.output};
  Silence silence;
  Guarded guarded{silence, {settings.guard}, false};
  const auto stream = backend.open(request, guarded);
  if (!stream) return tl::unexpected(stream.error());
  return (*stream)->granted();
}

bool same(const SettingDelay& a, const SettingDelay& b) {
  return a.sample_rate == b.sample_rate && a.block_frames == b.block_frames && a.periods == b.periods;
}

void take(const Measurement& measurement, SweepRow& row) {
  auto& setting = row.setting;
  setting.finding = measurement.finding;
  setting.delay_frames = measurement.delay_frames;
  setting.standard_error_frames = measurement.standard_error_frames;
  row.reported_frames = measurement.reported_frames;
  row.analysis = shown_of(measurement)->analysis;
  for (const auto& opening : measurement.openings) {
    row.xruns += opening.health.xruns;
    row.lost_frames += opening.health.lost_frames;
    for (const auto& step : opening.analysis.steps) row.detected_lost_frames += std::abs(step.frames);
    setting.gaps += opening.health.xruns + static_cast<std::int64_t>(opening.analysis.steps.size());
    setting.measured_s +=
        static_cast<double>(opening.health.frames) / opening.granted.format.sample_rate.value;
  }
}

class Sweep {
 public:
  Sweep(Loop& loop, const SweepOptions& options, const std::vector<Hertz>& rates)
      : loop_(loop), options_(options), rates_(rates) {
    report_.source = loop.devices.output.id;
    if (!loop.settings.request.input_device.empty())
      report_.source += " and " + loop.settings.request.input_device;
  }

  /// The exit code, where it is to end at once.
  std::optional<int> run() {
    auto periods = std::vector<std::optional<int>>(options_.periods.begin(), options_.periods.end());
    if (periods.empty()) periods = {std::nullopt};
    for (const auto& rate : rates_)
      for (const auto& count : periods)
        for (const int block : options_.blocks)
          if (!measure_one(rate, count, block)) return kInterrupted;
    return std::nullopt;
  }
  SweepReport& report() { return report_; }

 private:
  /// False: the user ended it.
  bool measure_one(Hertz rate, std::optional<int> periods, int block) {
    auto& request = loop_.settings.request;
    request.sample_rate = rate;
    request.periods = periods;
    request.block_frames = block;
    auto& row = report_.rows.emplace_back();
    row.asked_block = block;
    row.asked_periods = periods;
    row.setting.sample_rate = rate;
    const auto granted = ask(*loop_.devices.backend, loop_.settings);
    if (!granted) return row.refused = granted.error(), true;
    row.setting.sample_rate = granted->format.sample_rate;
    row.setting.block_frames = granted->block_frames;
    row.setting.periods = granted->periods;
    row.again = std::any_of(report_.rows.begin(), report_.rows.end() - 1,
                            [&](const SweepRow& other) { return same(other.setting, row.setting); });
    if (row.again) return true;
    fmt::print(stderr, "{}\n", setting_text(row.setting));
    const auto measured = measure_now(*loop_.devices.backend, loop_.settings);
    if (!measured) return row.refused = measured.error(), true;
    if (!*measured) return false;
    take(**measured, row);
    return true;
  }

  Loop& loop_;
  const SweepOptions& options_;
  const std::vector<Hertz>& rates_;
  SweepReport report_;
};

int publish(SweepReport& sweep, const SweepOptions& options) {
  Status written;
  if (!options.picture.empty()) {
    written = write_svg(options.picture, {picture_of(sweep)});
    if (written) sweep.written.push_back(options.picture);
  }
  if (options.json)
    fmt::print("{}\n", json_of(sweep).dump(2));
  else
    fmt::print("{}", text_of(sweep));
  if (!written) return report(written.error());
  if (sweep.settings().empty()) return kDevice;
  return shortest_good(sweep.settings()) == nullptr ? kNo : kDone;
}

int run_latency_sweep(const SweepOptions& options) {
  auto loop = make_loop(options.loop);
  if (!loop) return report(loop.error().errors), loop.error().exit;
  std::vector<Hertz> rates;
  for (const auto& text : options.rates) {
    const auto rate = parse_rate(text, "rates");
    if (!rate) return report(rate.error());
    rates.push_back(*rate);
  }
  if (rates.empty()) rates = {*loop->settings.request.sample_rate};
  install_signal_handlers();
  Sweep sweep{*loop, options, rates};
  if (const auto ended = sweep.run()) return fmt::print(stderr, "interrupted\n"), *ended;
  return publish(sweep.report(), options);
}

}  // namespace

void add_latency_sweep(CLI::App& latency, int& exit_code) {
  auto* command =
      latency.add_subcommand("sweep", "Measure the latency at several block sizes, and recommend one");
  auto options = std::make_shared<SweepOptions>();
  auto& loop = options->loop;
  loop.openings = 2;
  loop.probes = 4;
  add_loop_options(*command, loop);
  command->add_option("--blocks", options->blocks, "block sizes in frames")
      ->delimiter(',')
      ->check(CLI::Range(1, 8192))
      ->capture_default_str();
  command->add_option("--periods", options->periods, "numbers of blocks in the driver's buffer, such as 2,3")
      ->delimiter(',')
      ->check(CLI::Range(1, 64));
  command->add_option("--rates", options->rates, "sample rates, such as 48kHz,96kHz; default: the device's")
      ->delimiter(',');
  add_repetition_options(*command, loop);
  command
      ->add_option("--report", options->picture, "write a plot of delay against block size to this SVG file")
      ->check(writable_file());
  command->add_flag("--json", options->json, "print the report as JSON");
  command->footer(
      "Examples:\n  tactus latency sweep --device jack:system\n"
      "  tactus latency sweep --device USB --blocks 32,64,128 --periods 2,3 --report blocks.svg\n"
      "No delay is saved: run tactus latency measure with the chosen setting.\n"
      "Exit code 1: no setting gave a reliable result.");
  command->callback([options, &exit_code] { exit_code = run_latency_sweep(*options); });
}

}  // namespace tactus::app
