#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/latency/latency.h"

namespace tactus::app {
namespace {

std::string periods_text(int periods) { return periods > 0 ? std::to_string(periods) : "?"; }

bool same(const SettingDelay& a, const SettingDelay& b) {
  return a.sample_rate == b.sample_rate && a.block_frames == b.block_frames && a.periods == b.periods;
}

/// "48 kHz, 2 periods"
std::string rate_text(Hertz rate, int periods) {
  const auto text = fmt::format("{:g} kHz", rate.value / 1e3);
  return periods > 0 ? text + fmt::format(", {} periods", periods) : text;
}

std::string note_of(const SweepRow& row) {
  if (row.refused) return "refused: " + row.refused->what;
  std::string note;
  if (row.setting.finding.verdict != Verdict::Ok) note = row.setting.finding.what;
  if (row.asked_block != row.setting.block_frames)
    note = fmt::format("{} requested{}{}", row.asked_block, note.empty() ? "" : "; ", note);
  return note;
}

std::string line_of(const SweepRow& row) {
  const auto& setting = row.setting;
  const auto note = note_of(row);
  const auto line = fmt::format("{:>8g}  {:>6}  {:>7}  ", setting.sample_rate.value / 1e3,
                                row.refused ? row.asked_block : setting.block_frames,
                                periods_text(row.refused ? row.asked_periods.value_or(0) : setting.periods));
  if (row.refused) return line + note + "\n";
  const bool known = setting.finding.verdict == Verdict::Ok;
  return line + fmt::format("{:>24}  {:>9}  {:>5}  {:>6}  {:>6}{}{}\n",
                            known ? with_error(setting.delay_frames, setting.standard_error_frames)
                                  : code(setting.finding.verdict),
                            known ? fmt::format("{:.3f}", 1e3 * setting.delay().value) : "", row.xruns,
                            row.lost_frames,
                            row.reported_frames ? fmt::format("{:.0f}", *row.reported_frames) : "?",
                            note.empty() ? "" : "  ", note);
}

/// Settings that the device turned into ones that it has.
std::string changed_settings_text(const std::vector<SweepRow>& rows) {
  std::vector<std::string> asked;
  for (const auto& row : rows)
    if (row.again)
      asked.push_back(fmt::format("{} frames{}", row.asked_block,
                                  row.asked_periods ? fmt::format(", {} periods", *row.asked_periods) : ""));
  if (asked.empty()) return "";
  return fmt::format(
      "Also requested, but changed to one of these settings by the device or its server: {}. Change it there "
      "if needed.\n",
      fmt::join(asked, "; "));
}

std::string law_text(const BlockLaw& law) {
  const auto number = [](double value, const std::optional<double>& error) {
    return error ? "(" + with_error(value, *error) + ")" : fmt::format("{:.4g}", value);
  };
  return fmt::format(
      "delay = {} frames + {} x block   at {}; {}\n", number(law.fixed_frames, law.fixed_standard_error),
      number(law.per_frame, law.per_frame_standard_error), rate_text(law.sample_rate, law.periods),
      law.settings > 2 ? fmt::format("{} settings, residual {:.2g} frames", law.settings, law.residual_frames)
                       : "from two settings, so the fit is exact");
}

Json essentials_of(const SweepRow& row) {
  return essentials_json(row.setting, row.setting.sample_rate, row.analysis);
}

Json json_of(const SweepRow& row) {
  const auto& setting = row.setting;
  Json json{{"asked_block_frames", row.asked_block},
            {"asked_periods", known(row.asked_periods)},
            {"sample_rate_hz", setting.sample_rate.value}};
  if (row.refused) {
    json["refused"] = to_string(*row.refused);
    return json;
  }
  json["block_frames"] = setting.block_frames;
  json["periods"] = known(setting.periods > 0, setting.periods);
  json["measured_already"] = row.again;
  if (row.again) return json;
  json.update(essentials_of(row));
  json["xruns"] = row.xruns;
  json["lost_frames_counted"] = row.lost_frames;
  json["lost_frames_heard"] = row.detected_lost_frames;
  json["reported_frames"] = known(row.reported_frames);
  json["good"] = setting.good();
  return json;
}

Json law_json(const BlockLaw& law) {
  return {{"sample_rate_hz", law.sample_rate.value},
          {"periods", known(law.periods > 0, law.periods)},
          {"fixed_frames", law.fixed_frames},
          {"fixed_standard_error_frames", known(law.fixed_standard_error)},
          {"per_frame", law.per_frame},
          {"per_frame_standard_error", known(law.per_frame_standard_error)},
          {"residual_frames", known(law.settings > 2, law.residual_frames)},
          {"settings", law.settings}};
}

/// Of a group: its points, its line, and what is no good.
void add_group(const std::vector<SettingDelay>& group, PlotColor color, Subplot& subplot) {
  const auto& first = group.front();
  PlotSeries good{
      .label = rate_text(first.sample_rate, first.periods), .mark = PlotMark::Points, .color = color};
  PlotSeries gaps{.label = "lost frames", .mark = PlotMark::Points, .color = PlotColor::Vermillion};
  for (const auto& setting : group) {
    if (setting.finding.verdict != Verdict::Ok) {
      subplot.events.push_back(
          {.x = static_cast<double>(setting.block_frames),
           .label = fmt::format("{}: {}", setting.block_frames, code(setting.finding.verdict)),
           .color = PlotColor::Vermillion});
      continue;
    }
    auto& series = setting.good() ? good : gaps;
    series.x.push_back(setting.block_frames);
    series.y.push_back(setting.delay().value);
  }
  if (const auto law = fit_block_law(group)) {
    PlotSeries line{.label = {}, .color = color, .dashed = true};
    const double last = *std::max_element(good.x.begin(), good.x.end());
    for (const double block : {0.0, last}) {
      line.x.push_back(block);
      line.y.push_back(law->at(block) / first.sample_rate.value);
    }
    subplot.series.push_back(line);
  }
  if (!good.x.empty()) subplot.series.push_back(good);
  if (!gaps.x.empty()) subplot.series.push_back(gaps);
}

}  // namespace

std::vector<SettingDelay> SweepReport::settings() const {
  std::vector<SettingDelay> all;
  for (const auto& row : rows)
    if (!row.refused && !row.again) all.push_back(row.setting);
  return all;
}

const SweepRow* SweepReport::recommended() const {
  const auto all = settings();
  const auto* shortest = shortest_good(all);
  const SweepRow* last = nullptr;
  for (const auto& row : rows) {
    if (row.refused || row.again) continue;
    last = &row;
    if (shortest != nullptr && same(row.setting, *shortest)) break;
  }
  return last;
}

std::vector<BlockLaw> SweepReport::laws() const {
  std::vector<BlockLaw> laws;
  for (const auto& group : by_rate_and_periods(settings()))
    if (const auto law = fit_block_law(group)) laws.push_back(*law);
  return laws;
}

Json json_of(const SweepReport& report) {
  const auto settings = report.settings();
  Json json{{"source", report.source}};
  if (const auto* row = report.recommended()) json.update(essentials_of(*row));
  json["settings"] = list_of(report.rows, [](const SweepRow& row) { return json_of(row); });
  json["laws"] = list_of(report.laws(), law_json);
  const auto* shortest = shortest_good(settings);
  json["shortest"] = nullptr;
  if (shortest != nullptr)
    json["shortest"] = {{"sample_rate_hz", shortest->sample_rate.value},
                        {"block_frames", shortest->block_frames},
                        {"periods", known(shortest->periods > 0, shortest->periods)},
                        {"delay_frames", shortest->delay_frames},
                        {"delay_ms", 1e3 * shortest->delay().value}};
  json["recommendation"] = recommendation(settings);
  json["delay_is"] = kDelayIs;
  json["written"] = report.written;
  return json;
}

std::string text_of(const SweepReport& report) {
  auto text =
      fmt::format("{}\n\n{:>8}  {:>6}  {:>7}  {:>24}  {:>9}  {:>5}  {:>6}  {:>6}\n", report.source,
                  "rate/kHz", "block", "periods", "delay/frames", "delay/ms", "xruns", "lost", "driver");
  for (const auto& row : report.rows)
    if (!row.again) text += line_of(row);
  text += "\n" + changed_settings_text(report.rows);
  for (const auto& law : report.laws()) text += law_text(law);
  text += recommendation(report.settings()) + "\n";
  for (const auto& file : report.written) text += "written: " + file + "\n";
  return text;
}

Plot picture_of(const SweepReport& report) {
  Plot plot;
  plot.title = "Delay against block";
  plot.subtitle = report.source + ". " + recommendation(report.settings());
  plot.x = {.label = "block", .unit = "frames", .low = 0.0};
  plot.subplot_height = 340;
  Subplot subplot;
  subplot.y = {.label = "delay", .unit = "s", .low = 0.0};
  int color = static_cast<int>(PlotColor::Blue);
  for (const auto& group : by_rate_and_periods(report.settings())) {
    add_group(group, static_cast<PlotColor>(color), subplot);
    // Vermillion is for what lost frames.
    color = color == static_cast<int>(PlotColor::Blue) ? static_cast<int>(PlotColor::Green) : color % 6 + 1;
  }
  plot.subplots = {subplot};
  return plot;
}

namespace {

struct LatencySweepOptions {
  LoopOptions loop;
  std::vector<int> blocks = {16, 32, 64, 128, 256, 512, 1024};
  std::vector<int> periods;
  std::vector<std::string> rates;
  ReportFiles report;
};

/// Only to be opened with: nothing is played.
class Silence final : public BlockProcessor {
 public:
  Status prepare(const StreamFormat&) override { return {}; }
  void process(const BlockIo&) noexcept override {}
};

/// What the device makes of a request. Errors: of `open` and `measurement_request`.
Result<StreamGranted> ask(Backend& backend, const MeasureSettings& settings) {
  const auto request = measurement_request(backend, settings);
  if (!request) return tl::unexpected(request.error());
  Silence silence;
  Guarded guarded{silence, {settings.guard}, false};
  const auto stream = backend.open(*request, guarded);
  if (!stream) return tl::unexpected(stream.error());
  return (*stream)->granted();
}

void take(const Measurement& measurement, SweepRow& row) {
  auto& setting = row.setting;
  static_cast<DelayEstimate&>(setting) = measurement;
  row.reported_frames = measurement.reported_frames;
  row.analysis = measurement.shown().analysis;
  for (const auto& opening : measurement.openings) {
    row.xruns += opening.health.xruns;
    row.lost_frames += opening.health.lost_frames;
    for (const auto& step : opening.analysis.steps) row.detected_lost_frames += std::abs(step.frames);
    setting.gaps += opening.health.xruns + static_cast<std::int64_t>(opening.analysis.steps.size());
    setting.measured_s +=
        static_cast<double>(opening.health.frames) / opening.granted.format.sample_rate.value;
  }
}

/// Errors are kept in the row that it adds.
void measure_setting(Loop& loop, Hertz rate, std::optional<int> periods, int block, SweepReport& report) {
  auto& request = loop.settings.request;
  request.sample_rate = rate;
  request.periods = periods;
  request.block_frames = block;
  auto& row = report.rows.emplace_back();
  row.asked_block = block;
  row.asked_periods = periods;
  row.setting.sample_rate = rate;
  const auto granted = ask(*loop.devices.backend, loop.settings);
  if (!granted) return void(row.refused = granted.error());
  // All settings are measured on the same device, or not at all.
  if (!loop.settings.previous) loop.settings.previous = *granted;
  row.setting.sample_rate = granted->format.sample_rate;
  row.setting.block_frames = granted->block_frames;
  row.setting.periods = granted->periods;
  row.again = std::any_of(report.rows.begin(), report.rows.end() - 1,
                          [&](const SweepRow& other) { return same(other.setting, row.setting); });
  if (row.again) return;
  fmt::print(stderr, "{}\n", setting_text(row.setting));
  const auto measured = measure_now(*loop.devices.backend, loop.settings, true);
  if (!measured) return void(row.refused = measured.error());
  take(*measured, row);
}

SweepReport measure_all(Loop& loop, const LatencySweepOptions& options) {
  const auto request = loop.settings.request;
  SweepReport report;
  report.source = request.device;
  if (!request.input_device.empty()) report.source += " and " + request.input_device;
  std::vector<Hertz> rates;
  for (const auto& text : options.rates) rates.push_back(parse_rate(text, "rates"));
  if (rates.empty()) rates = {*request.sample_rate};
  auto periods = std::vector<std::optional<int>>(options.periods.begin(), options.periods.end());
  if (periods.empty()) periods = {std::nullopt};
  for (const auto& rate : rates)
    for (const auto& count : periods)
      for (const int block : options.blocks) measure_setting(loop, rate, count, block, report);
  return report;
}

int run_latency_sweep(const LatencySweepOptions& options) {
  auto loop = make_loop(options.loop);
  install_signal_handlers();
  auto report = measure_all(loop, options);
  Status written;
  if (const auto& picture = options.report.picture; !picture.empty()) {
    written = write_svg(picture, {picture_of(report)});
    if (written) report.written.push_back(picture);
  }
  options.report.json ? print_json(app::json_of(report)) : fmt::print("{}", text_of(report));
  or_exit(written);
  if (report.settings().empty()) return kDevice;
  return shortest_good(report.settings()) == nullptr ? kNo : kDone;
}

}  // namespace

void add_latency_sweep(CLI::App& latency, int& exit_code) {
  auto [command, options] =
      add_command(latency, "sweep", "Measure the latency at several block sizes, and recommend one",
                  exit_code, run_latency_sweep);
  auto& loop = options.loop;
  loop.openings = 2;
  loop.probes = 4;
  add_loop_options(command, loop, false, true);
  add_number(command, "--blocks", options.blocks, "block sizes in frames", 1, 8192)->delimiter(',');
  command.add_option("--periods", options.periods, "blocks in the driver's buffer; several, such as 2,3")
      ->delimiter(',')
      ->check(CLI::Range(1, 64));
  command.add_option("--rates", options.rates, "sample rates; such as 48kHz,96kHz; default: the device's")
      ->delimiter(',');
  add_report_options(command, options.report, false, false);
  command.footer(
      "Examples:\n  tactus latency sweep --device jack:system\n  tactus latency sweep --device USB --blocks "
      "32,64,128 --periods 2,3 --svg blocks.svg\nNo delay is saved: run tactus latency measure with the "
      "chosen setting.\nExit code 1: no setting gave a reliable result.");
}

}  // namespace tactus::app
