#include "apps/latency/sweep_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "apps/latency/latency_report.h"
#include "engine/core/index.h"

namespace tactus::app {
namespace {

using Json = nlohmann::ordered_json;

std::string periods_text(int periods) { return periods > 0 ? std::to_string(periods) : "?"; }

bool same_group(const SettingDelay& a, const SettingDelay& b) {
  return a.sample_rate == b.sample_rate && a.periods == b.periods;
}

/// The note behind a row.
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
  if (row.refused)
    return fmt::format("{:>8g}  {:>6}  {:>7}  {}\n", setting.sample_rate.value / 1e3, row.asked_block,
                       periods_text(row.asked_periods.value_or(0)), note_of(row));
  const auto head = fmt::format("{:>8g}  {:>6}  {:>7}", setting.sample_rate.value / 1e3, setting.block_frames,
                                periods_text(setting.periods));
  const bool known = setting.finding.verdict == Verdict::Ok;
  const auto note = note_of(row);
  return head + fmt::format("  {:>24}  {:>9}  {:>5}  {:>6}  {:>6}{}\n",
                            known ? with_error(setting.delay_frames, setting.standard_error_frames)
                                  : std::string{code(setting.finding.verdict)},
                            known ? fmt::format("{:.3f}", 1e3 * setting.delay().value) : "", row.xruns,
                            row.lost_frames,
                            row.reported_frames ? fmt::format("{:.0f}", *row.reported_frames) : "?",
                            note.empty() ? "" : "  " + note);
}

/// Settings that the device turned into ones that it has.
std::string changed_settings_text(const std::vector<SweepRow>& rows) {
  std::string asked;
  for (const auto& row : rows)
    if (row.again)
      asked += fmt::format("{}{} frames{}", asked.empty() ? "" : "; ", row.asked_block,
                           row.asked_periods ? fmt::format(", {} periods", *row.asked_periods) : "");
  if (asked.empty()) return "";
  return fmt::format(
      "Also requested, but changed to one of these settings by the device or its server: {}. Change it there "
      "if needed.\n",
      asked);
}

std::string law_text(const LawOfGroup& group) {
  const auto& law = group.law;
  const auto number = [](double value, const std::optional<double>& error) {
    return error ? "(" + with_error(value, *error) + ")" : fmt::format("{:.4g}", value);
  };
  auto text =
      fmt::format("delay = {} frames + {} x block", number(law.fixed_frames, law.fixed_standard_error),
                  number(law.per_frame, law.per_frame_standard_error));
  text += fmt::format("   at {:g} kHz", group.sample_rate.value / 1e3);
  if (group.periods > 0) text += fmt::format(", {} periods", group.periods);
  return text + (law.settings > 2
                     ? fmt::format("; {} settings, residual {:.2g} frames", law.settings, law.residual_frames)
                     : "; from two settings, so the fit is exact");
}

Json essentials_of(const SweepRow& row) {
  const auto& setting = row.setting;
  return essentials_json(
      {setting.finding, setting.sample_rate, setting.delay_frames, setting.standard_error_frames},
      row.analysis);
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

Json json_of(const LawOfGroup& group) {
  const auto& law = group.law;
  return {{"sample_rate_hz", group.sample_rate.value},
          {"periods", known(group.periods > 0, group.periods)},
          {"fixed_frames", law.fixed_frames},
          {"fixed_standard_error_frames", known(law.fixed_standard_error)},
          {"per_frame", law.per_frame},
          {"per_frame_standard_error", known(law.per_frame_standard_error)},
          {"residual_frames", known(law.settings > 2, law.residual_frames)},
          {"settings", law.settings}};
}

std::string group_name(const SettingDelay& setting) {
  return fmt::format("{:g} kHz{}", setting.sample_rate.value / 1e3,
                     setting.periods > 0 ? fmt::format(", {} periods", setting.periods) : "");
}

/// Of a group: its points, its line, and what is no good.
void add_group(const std::vector<SettingDelay>& group, PlotColor color, Subplot& subplot) {
  PlotSeries good{.label = group_name(group.front()), .mark = PlotMark::Points, .color = color};
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
      line.y.push_back(law->at(block) / group.front().sample_rate.value);
    }
    subplot.series.push_back(line);
  }
  if (!good.x.empty()) subplot.series.push_back(good);
  if (!gaps.x.empty()) subplot.series.push_back(gaps);
}

std::vector<std::vector<SettingDelay>> groups_of(const std::vector<SettingDelay>& settings) {
  std::vector<std::vector<SettingDelay>> groups;
  for (const auto& setting : settings) {
    const auto group = std::find_if(groups.begin(), groups.end(),
                                    [&](const auto& other) { return same_group(other.front(), setting); });
    if (group == groups.end())
      groups.push_back({setting});
    else
      group->push_back(setting);
  }
  return groups;
}

}  // namespace

std::vector<SettingDelay> SweepReport::settings() const {
  std::vector<SettingDelay> all;
  for (const auto& row : rows)
    if (!row.refused && !row.again) all.push_back(row.setting);
  return all;
}

const SweepRow* SweepReport::recommended() const {
  std::vector<const SweepRow*> measured;
  for (const auto& row : rows)
    if (!row.refused && !row.again) measured.push_back(&row);
  if (measured.empty()) return nullptr;
  const auto all = settings();
  const auto* shortest = shortest_good(all);
  return shortest == nullptr ? measured.back() : measured[index(shortest - all.data())];
}

std::vector<LawOfGroup> SweepReport::laws() const {
  std::vector<LawOfGroup> laws;
  for (const auto& group : groups_of(settings()))
    if (const auto law = fit_block_law(group))
      laws.push_back({group.front().sample_rate, group.front().periods, *law});
  return laws;
}

Json json_of(const SweepReport& report) {
  const auto settings = report.settings();
  Json json{{"source", report.source}};
  if (const auto* row = report.recommended()) json.update(essentials_of(*row));
  json["settings"] = json["laws"] = Json::array();
  for (const auto& row : report.rows) json["settings"].push_back(json_of(row));
  for (const auto& law : report.laws()) json["laws"].push_back(json_of(law));
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
  for (const auto& law : report.laws()) text += law_text(law) + "\n";
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
  for (const auto& group : groups_of(report.settings())) {
    add_group(group, static_cast<PlotColor>(color), subplot);
    // Vermillion is for what lost frames.
    color = color == static_cast<int>(PlotColor::Blue) ? static_cast<int>(PlotColor::Green) : color % 6 + 1;
  }
  plot.subplots = {subplot};
  return plot;
}

}  // namespace tactus::app
