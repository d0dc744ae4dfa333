#include "latency/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/core/decibels.h"
#include "latency/findings.h"

namespace tactus {
namespace {

constexpr double kRateError = 0.005;
constexpr double kBlocksOfRate = 2.0;    // blocks that a clock cannot tell apart
constexpr double kSameDelay = 0.5;       // frames
constexpr double kSessionCertain = 5.0;  // standard errors
constexpr std::size_t kEnoughGood = 3;

using Findings = std::vector<Finding>;

void add_outcome(Findings& findings, const ProbePlayer& player) {
  if (player.outcome() == ProbePlayer::Outcome::Feedback)
    findings.push_back({Verdict::Feedback,
                        "the input came near full scale and stayed there although the output had been muted: "
                        "what is captured is "
                        "played again",
                        "switch direct monitoring off, take away connections from inputs to outputs, turn "
                        "the loudspeaker down "
                        "or move the microphone away; then measure again"});
  if (player.outcome() != ProbePlayer::Outcome::TooLoud) return;
  const double level = player.level().level;
  const auto when = level > 0.0 ? fmt::format("with an output of {:.1f} dBFS", amplitude_to_db(level))
                                : std::string{"before anything was played"};
  findings.push_back(
      {Verdict::Clipping,
       "the input came within 3 dB of full scale " + when + "; the output was muted, and then it was quiet",
       "turn the input's gain or the amplifier down"});
}

void add_event(Findings& findings, const GuardEvent& event, int input, bool drive) {
  switch (event.kind) {
    case GuardEvent::Kind::Feedback:
      findings.push_back({Verdict::Feedback,
                          "the drive guard limited the output for more than 100 ms and faded it out",
                          "measure at a lower level, or give the limits of the actuator that is there"});
      return;
    case GuardEvent::Kind::SensorRailed:
      if (drive || event.channel == input)
        findings.push_back(
            {Verdict::Clipping,
             fmt::format("input {} stood at the end of its range for 40 ms", event.channel + 1),
             "look after its cable, its supply and its gain"});
      return;
    case GuardEvent::Kind::SensorStuck:
      // A digital connection may be as silent as that, and sound does not stop for it.
      if (drive)
        findings.push_back(
            {Verdict::NoSignal,
             fmt::format("input {} gave the same value for 40 ms: it hangs", event.channel + 1),
             "look after its cable, and open the device again"});
      return;
  }
}

void add_lost(Findings& findings, const Health& before, const Health& after) {
  const auto gaps = after.xruns - before.xruns;
  const auto lost = after.lost_frames - before.lost_frames;
  if (gaps == 0 && lost == 0) return;
  findings.push_back(
      {Verdict::LostFrames,
       fmt::format("the driver counted {} gap{} and {} lost frames while the sweeps were played", gaps,
                   gaps == 1 ? "" : "s", lost),
       kAgainstGaps});
}

void add_mismatch(Findings& findings, const StreamGranted& granted, const Health& before,
                  const Health& after) {
  const char* remedy =
      "choose the rate and the block that the device itself is set to, or reach it through another backend";
  const int block = granted.block_frames;
  if (block > 0 && after.blocks > 0 && (after.shortest_block != block || after.longest_block != block))
    findings.push_back({Verdict::ApiMismatch,
                        fmt::format("blocks of {} frames were granted, and blocks of {} to {} came", block,
                                    after.shortest_block, after.longest_block),
                        remedy});
  const double seconds = after.seconds - before.seconds;
  const auto frames = static_cast<double>(after.frames - before.frames);
  if (seconds <= 0.0 || frames <= 0.0) return;
  const double granted_rate = granted.format.sample_rate.value;
  const double error = frames / seconds / granted_rate - 1.0;
  if (std::abs(error) <= std::max(kRateError, kBlocksOfRate * after.longest_block / frames)) return;
  findings.push_back({Verdict::ApiMismatch,
                      fmt::format("{:.0f} Hz were granted, and by the clock it runs at {:.0f} Hz",
                                  granted_rate, frames / seconds),
                      remedy});
}

std::vector<const Opening*> those(const Measurement& measurement, Verdict verdict) {
  std::vector<const Opening*> found;
  for (const auto& opening : measurement.openings)
    if (opening.finding.verdict == verdict) found.push_back(&opening);
  return found;
}

std::string delays_of(const std::vector<const Opening*>& openings) {
  std::string text;
  for (const auto* opening : openings)
    text += fmt::format("{}{:.3f}", text.empty() ? "" : ", ", opening->analysis.delay_frames);
  return text;
}

/// The mean; its error is that within the openings, or that by which they differ, whichever is larger.
void combine(Measurement& measurement, const std::vector<const Opening*>& openings) {
  const auto count = static_cast<double>(openings.size());
  double sum = 0.0, within = 0.0, between = 0.0;
  for (const auto* opening : openings) {
    sum += opening->analysis.delay_frames;
    within += opening->analysis.standard_error_frames * opening->analysis.standard_error_frames / count;
  }
  measurement.delay_frames = sum / count;
  for (const auto* opening : openings)
    between += std::pow(opening->analysis.delay_frames - measurement.delay_frames, 2);
  between /= std::max(1.0, count - 1.0);
  measurement.spread_frames = std::sqrt(between);
  measurement.standard_error_frames = std::sqrt(std::max(within, between) / count);
}

std::optional<Finding> unstable(const std::vector<const Opening*>& openings) {
  if (openings.size() < 2) return std::nullopt;
  double least = openings.front()->analysis.delay_frames, most = least, error = 0.0;
  for (const auto* opening : openings) {
    least = std::min(least, opening->analysis.delay_frames);
    most = std::max(most, opening->analysis.delay_frames);
    error = std::max(error, opening->analysis.standard_error_frames);
  }
  if (most - least <= std::max(kSameDelay, kSessionCertain * error)) return std::nullopt;
  return Finding{
      Verdict::UnstableStart,
      fmt::format("the delay is another each time that the stream is opened: {} frames", delays_of(openings)),
      "measure again each time that you start to play, or let a backend and a device that begin the "
      "same way every time (JACK on the device itself) take its place"};
}

Finding tolerated(std::size_t lost, std::size_t all) {
  return {Verdict::Ok,
          fmt::format("{} of {} openings lost frames and do not count; the others agree", lost, all),
          "use a longer block or more periods if that happens often"};
}

}  // namespace

Finding first_of(const std::vector<Finding>& findings) {
  Finding first;
  for (const auto& finding : findings)
    if (finding.verdict != Verdict::Ok && (first.verdict == Verdict::Ok || finding.verdict < first.verdict))
      first = finding;
  return first;
}

std::vector<Finding> stream_findings(const ProbePlayer& player, const StreamGranted& granted,
                                     const std::vector<GuardEvent>& events, int input, bool drive) {
  Findings findings;
  add_outcome(findings, player);
  for (const auto& event : events) add_event(findings, event, input, drive);
  add_lost(findings, player.health_before(), player.health_after());
  add_mismatch(findings, granted, player.health_before(), player.health_after());
  return findings;
}

void conclude(Measurement& measurement) {
  const auto good = those(measurement, Verdict::Ok);
  const auto lost = those(measurement, Verdict::LostFrames);
  auto usable = good;
  if (usable.empty())
    for (const auto& opening : measurement.openings)
      if (opening.analysis.detected) usable.push_back(&opening);
  if (!usable.empty()) combine(measurement, usable);

  std::vector<Finding> findings;
  const bool tolerable = good.size() >= kEnoughGood && lost.size() < good.size();
  for (const auto& opening : measurement.openings)
    if (opening.finding.verdict != Verdict::LostFrames || !tolerable) findings.push_back(opening.finding);
  if (const auto moves = unstable(good)) findings.push_back(*moves);
  measurement.finding = first_of(findings);
  if (measurement.finding.verdict == Verdict::Ok && !lost.empty())
    measurement.finding = tolerated(lost.size(), measurement.openings.size());
}

std::string second_arrival(const Opening& before, const Opening& again) {
  const int block = before.granted.block_frames, other_block = again.granted.block_frames;
  if (block == other_block || !before.analysis.echo_frames || !again.analysis.echo_frames) return {};
  const int spacing = *before.analysis.echo_frames, other_spacing = *again.analysis.echo_frames;
  const bool stays = std::abs(spacing - other_spacing) <= 1;
  return fmt::format(
      "{:+d} frames with blocks of {}, {:+d} with blocks of {}: {}", spacing, block, other_spacing,
      other_block,
      stays ? "direct monitoring in the card" : "a connection in software, from its input to its output");
}

}  // namespace tactus
