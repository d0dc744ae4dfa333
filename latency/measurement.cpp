#include "latency/measurement.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <numeric>
#include <thread>
#include <utility>

#include "backends/find_device.h"
#include "engine/core/decibels.h"
#include "engine/core/index.h"
#include "latency/findings.h"
#include "latency/probe/probe.h"
#include "latency/probe/probe_player.h"

namespace tactus {
namespace {

constexpr std::chrono::milliseconds kTick{10};
constexpr std::chrono::seconds kMeasurementPatience{3};  // with a stream that brings no block
constexpr int kMaxInputs = 16;                           // that are recorded: memory
constexpr double kRateError = 0.005;
constexpr double kBlocksOfRate = 2.0;    // blocks that a clock cannot tell apart
constexpr double kSameDelay = 0.5;       // frames
constexpr double kSessionCertain = 5.0;  // standard errors
constexpr std::size_t kEnoughGood = 3;

using Findings = std::vector<Finding>;

void add_result(Findings& findings, const ProbePlayer& player) {
  if (player.outcome() == ProbePlayer::Outcome::Feedback)
    findings.emplace_back(
        Verdict::Feedback,
        "the input came near full scale and stayed there with the output muted: the captured signal "
        "is played back",
        "switch off direct monitoring, remove connections from inputs to outputs, turn the "
        "loudspeaker down or move the microphone away; then measure again");
  if (player.outcome() != ProbePlayer::Outcome::TooLoud) return;
  const double level = player.level().level;
  const auto when = level > 0.0 ? fmt::format("with an output of {:.1f} dBFS", amplitude_to_db(level))
                                : std::string{"before the first probe"};
  findings.emplace_back(
      Verdict::Clipping,
      "the input came within 3 dB of full scale " + when + "; it became quiet when the output was muted",
      "reduce the gain of the input or of the amplifier");
}

/// Whether anything came back cannot be told where noise hides it.
void explain_noise(Finding& finding, const PathLevel& level) {
  if (finding.verdict != Verdict::NoSignal || !level.hidden_by_noise()) return;
  finding = {Verdict::LowSnr,
             fmt::format("no probe is detected in the noise of {:.0f} dBFS", power_to_db(level.noise_power)),
             "find the source of the noise, raise the input's gain, and check the cable"};
}

void add_event(Findings& findings, const GuardEvent& event, int input, bool drive) {
  switch (event.kind) {
    case GuardEvent::Kind::Feedback:
      findings.emplace_back(Verdict::Feedback, "the drive guard found feedback and faded the output out",
                            "measure at a lower level, or give the limits of the connected actuator");
      return;
    case GuardEvent::Kind::SensorRailed:
      if (drive || event.channel == input)
        findings.emplace_back(
            Verdict::Clipping,
            fmt::format("input {} stayed at the limit of its range for 40 ms", event.channel + 1),
            "check its cable, its power supply and its gain");
      return;
    case GuardEvent::Kind::SensorStuck:
      // A digital connection may be as silent as that, and sound does not stop for it.
      if (drive)
        findings.emplace_back(
            Verdict::NoSignal,
            fmt::format("input {} repeated the same value for 40 ms: it hangs", event.channel + 1),
            "check its cable, and reopen the device");
      return;
    case GuardEvent::Kind::DeadMan:
    case GuardEvent::Kind::DeadManDisarmed:
      findings.emplace_back(Verdict::LostFrames,
                            "the stop inputs were not handled for 500 ms, and the output was faded out",
                            kAgainstGaps);
      return;
  }
}

/// Whether the driver reported gaps.
bool add_lost(Findings& findings, const Health& before, const Health& after) {
  const auto gaps = after.xruns - before.xruns;
  const auto lost = after.lost_frames - before.lost_frames;
  if (gaps == 0 && lost == 0) return false;
  findings.emplace_back(
      Verdict::LostFrames,
      fmt::format("the driver counted {} gap{} and {} lost frames while the probes were played", gaps,
                  gaps == 1 ? "" : "s", lost),
      kAgainstGaps);
  return true;
}

void add_mismatch(Findings& findings, const StreamGranted& granted, const Health& before,
                  const Health& after) {
  const char* remedy =
      "choose the sample rate and block size that the device itself is set to, or use another backend";
  const int block = granted.block_frames;
  if (block > 0 && after.blocks > 0 && (after.shortest_block != block || after.longest_block != block))
    findings.emplace_back(
        Verdict::ApiMismatch,
        fmt::format("the driver granted blocks of {} frames but delivered blocks of {} to {}", block,
                    after.shortest_block, after.longest_block),
        remedy);
  const double seconds = after.seconds - before.seconds;
  const auto frames = static_cast<double>(after.frames - before.frames);
  if (seconds <= 0.0 || frames <= 0.0) return;
  const double granted_rate = granted.format.sample_rate.value;
  const double error = frames / seconds / granted_rate - 1.0;
  if (std::abs(error) <= std::max(kRateError, kBlocksOfRate * after.longest_block / frames)) return;
  findings.emplace_back(
      Verdict::ApiMismatch,
      fmt::format("{:.0f} Hz were granted, but the device runs at {:.0f} Hz by the system clock",
                  granted_rate, frames / seconds),
      remedy);
}

std::vector<const Opening*> those(const Measurement& measurement, Verdict verdict) {
  std::vector<const Opening*> found;
  for (const auto& opening : measurement.openings)
    if (opening.finding.verdict == verdict) found.push_back(&opening);
  return found;
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

Finding unstable(const std::vector<const Opening*>& openings) {
  std::vector<double> delays;
  double error = 0.0;
  for (const auto* opening : openings) {
    delays.push_back(opening->analysis.delay_frames);
    error = std::max(error, opening->analysis.standard_error_frames);
  }
  if (delays.empty()) return {};
  const auto [least, most] = std::ranges::minmax(delays);
  if (most - least <= std::max(kSameDelay, kSessionCertain * error)) return {};
  return {
      Verdict::UnstableStart,
      fmt::format("the delay differs each time the stream is opened: {:.3f} frames", fmt::join(delays, ", ")),
      "measure again before each session, or use a backend and a device whose delay is the same each time "
      "(JACK on the device itself)"};
}

/// What all openings say together: the first finding against any of them; frames that were lost in fewer than
/// half of them are only reported when at least three others agree.
void conclude(Measurement& measurement) {
  const auto good = those(measurement, Verdict::Ok);
  const auto lost = those(measurement, Verdict::LostFrames);
  auto usable = good;
  if (usable.empty())
    for (const auto& opening : measurement.openings)
      if (opening.analysis.detected) usable.push_back(&opening);
  if (!usable.empty()) combine(measurement, usable);

  Findings findings;
  const bool tolerable = good.size() >= kEnoughGood && lost.size() < good.size();
  for (const auto& opening : measurement.openings)
    if (opening.finding.verdict != Verdict::LostFrames || !tolerable) findings.push_back(opening.finding);
  findings.push_back(unstable(good));
  measurement.finding = first_of(findings);
  if (measurement.finding.verdict == Verdict::Ok && !lost.empty())
    measurement.finding = {Verdict::Ok,
                           fmt::format("{} of {} openings lost frames and are ignored; the others agree",
                                       lost.size(), measurement.openings.size()),
                           "use a larger block size or more periods if that happens often"};
}

/// Where a second arrival comes from: `again` was opened with another block. Empty: not known.
std::string second_arrival(const Opening& before, const Opening& again) {
  const int block = before.granted.block_frames, other_block = again.granted.block_frames;
  if (block == other_block || !before.analysis.echo_frames || !again.analysis.echo_frames) return {};
  const int spacing = *before.analysis.echo_frames, other_spacing = *again.analysis.echo_frames;
  const bool stays = std::abs(spacing - other_spacing) <= 1;
  return fmt::format("{:+d} frames with blocks of {}, {:+d} with blocks of {}: {}", spacing, block,
                     other_spacing, other_block,
                     stays ? "direct monitoring in the card"
                           : "a connection in software from the card's input to its output");
}

/// What is played does not depend on what is captured; the level search looks for feedback itself.
GuardedChannel without_feedback(GuardedChannel channel) {
  channel.feedback = {false, false};
  return channel;
}

/// As loud as the probe may be before the guard changes its shape.
double loudest(const MeasureSettings& settings, Hertz rate) {
  const auto& limits = settings.guard.limits;
  double level = std::min(amplitude_from_db(settings.loudest_dbfs), limits.ceiling);
  if (settings.guard.kind == DriveGuard::Kind::Drive)
    level =
        std::min(level, limits.slew_per_second / (2 * std::numbers::pi * measuring_probe(rate).stop.value));
  return level;
}

Status check(const MeasureSettings& settings) {
  if (settings.openings < 1 || settings.probes < 1 || settings.input < 0 || settings.output < 0)
    return fail(Errc::BadArgument, "",
                "a measurement needs at least one opening, one probe, an input and an output", "");
  if (!(settings.softest_dbfs > -150.0 && settings.softest_dbfs <= settings.loudest_dbfs &&
        settings.loudest_dbfs <= 0.0))
    return fail(Errc::OutOfRange, "",
                "the levels of a measurement must be in ascending order, above -150 dBFS and at most 0 dBFS",
                "give the lowest level first");
  return {};
}

class Session {
 public:
  Session(Backend& backend, const MeasureSettings& settings, const MeasureProgress& progress)
      : backend_(backend),
        settings_(settings),
        progress_(progress),
        guarded_(player_, {without_feedback(settings.guard)}) {
    guarded_.set_tap(&player_);
    guarded_.set_dead_mans_switch(settings.dead_mans_switch);
    if (!settings.watch_sensors) guarded_.disable_sensor_watch();
  }

  Result<Measurement> run() {
    auto request = measurement_request(backend_, settings_);
    if (!request) return tl::unexpected(request.error());
    request_ = std::move(*request);
    input_ = static_cast<int>(std::ranges::find(request_.in_map, settings_.input) - request_.in_map.begin());
    Measurement measurement;
    for (turn_ = 0; turn_ < settings_.openings; ++turn_) {
      auto opening = open(request_);
      if (!opening) return tl::unexpected(opening.error());
      measurement.openings.push_back(std::move(*opening));
      if (!worth_repeating(measurement.openings.back())) break;
    }
    conclude(measurement);
    if (measurement.finding.verdict == Verdict::DirectMonitoring) locate_second_path(measurement);
    const auto& granted = measurement.openings.front().granted;
    if (granted.input_latency_frames && granted.output_latency_frames)
      measurement.reported_frames = *granted.input_latency_frames + *granted.output_latency_frames;
    return measurement;
  }

 private:
  Result<Opening> open(const StreamRequest& request) {
    const double most = loudest(settings_, *request.sample_rate);
    player_.set_script({input_,
                        settings_.probes,
                        {std::min(amplitude_from_db(settings_.softest_dbfs), most), most,
                         settings_.guard.limits.soft_start + LevelSearch::kWindow, known_}});
    auto stream = backend_.open(request, guarded_);
    if (!stream) return tl::unexpected(stream.error());
    // A later opening begins by itself: not when the program was stopped in between.
    if (opened_ && settings_.dead_mans_switch != nullptr)
      if (auto status = check_attended(*settings_.dead_mans_switch); !status)
        return tl::unexpected(status.error());
    if (auto status = check_same((*stream)->granted(), request); !status)
      return tl::unexpected(status.error());
    player_.set_stream(stream->get());
    if (auto played = play(**stream); !played) return tl::unexpected(played.error());
    return result_of(**stream);
  }

  /// Each opening looks for the device by its name, which another one may have by then.
  Status check_same(const StreamGranted& granted, const StreamRequest& request) {
    const auto before = opened_ ? opened_ : settings_.previous;
    const bool same_settings = opened_ && request.block_frames == request_.block_frames;
    if (!opened_) opened_ = granted;
    if (!before) return {};
    const auto found = differences_between_openings(*before, granted, same_settings);
    if (found.empty()) return {};
    return fail(Errc::Device, granted.device,
                fmt::format("this is not the device of the opening before, or not as it was: {}",
                            fmt::join(found, "; ")),
                "check what is connected, and measure again");
  }

  Status play(Stream& stream) {
    using Clock = std::chrono::steady_clock;
    if (auto status = check_writers(stream); !status) return status;
    if (auto status = stream.start(); !status) return status;
    auto last_alive = Clock::now();
    while (!player_.done()) {
      std::this_thread::sleep_for(kTick);
      report_progress();
      if (auto status = check_writers(stream); !status) {
        (void)stream.stop();
        return status;
      }
      const auto state = stream.state();
      if (state == StreamState::Running) last_alive = Clock::now();
      const bool lost = state == StreamState::Lost || Clock::now() - last_alive > kMeasurementPatience;
      if (player_.done() || !lost) continue;
      (void)stream.stop();
      return disconnected(stream);
    }
    const bool lost = stream.state() == StreamState::Lost;
    auto status = stream.stop();
    return lost ? disconnected(stream) : status;
  }

  static Status disconnected(const Stream& stream) {
    return fail(Errc::Device, stream.granted().device,
                "the device was disconnected, or stopped delivering blocks",
                "connect the device, start its sound server, and measure again");
  }

  /// The output gets the sum, which is neither limited nor what is measured.
  Status check_writers(const Stream& stream) const {
    if (settings_.shared_port) return {};
    if (stream.granted().writers_unknown && settings_.guard.kind == DriveGuard::Kind::Drive)
      return fail(Errc::Device, stream.granted().device,
                  "this library does not show who else writes to the output",
                  "use --backend jack, or give --shared-port; --cable, if nothing but a cable is connected");
    const auto writers = stream.other_writers();
    if (writers.empty()) return {};
    return fail(Errc::Device, stream.granted().device,
                "'" + writers.front().from + "' also writes to '" + writers.front().to + "'",
                "disconnect it, or give --shared-port");
  }

  void report_progress() const {
    if (!progress_) return;
    const double share = (std::min(turn_, settings_.openings - 1) + player_.share()) / settings_.openings;
    progress_(share, fmt::format("opening {} of {}", turn_ + 1, settings_.openings));
  }

  Result<Opening> result_of(const Stream& stream) {
    Opening opening;
    opening.granted = stream.granted();
    opening.health = stream.health();
    opening.level_dbfs = amplitude_to_db(player_.level().level);
    Findings findings;
    add_result(findings, player_);
    for (GuardEvent event; guarded_.take_event(event);)
      add_event(findings, event, input_, settings_.guard.kind == DriveGuard::Kind::Drive);
    const auto &before = player_.health_before(), &after = player_.health_after();
    const bool lost = add_lost(findings, before, after);
    add_mismatch(findings, opening.granted, before, after);
    opening.recording = player_.take_recording();
    if (player_.outcome() == ProbePlayer::Outcome::Played) {
      auto analysis = analyze(opening.recording, {input_, settings_.profile});
      if (!analysis && findings.empty()) return tl::unexpected(analysis.error());
      if (analysis) {
        opening.analysis = std::move(*analysis);
        explain_noise(opening.analysis.finding, player_.level());
        // A probe with a gap in it has the harmonics of one that is clipped.
        if (!lost || opening.analysis.finding.verdict != Verdict::Clipping)
          findings.push_back(opening.analysis.finding);
        remember(opening.analysis);
      }
    }
    opening.finding = first_of(findings);
    return opening;
  }

  /// The next opening begins where this one ended.
  void remember(const Analysis& analysis) {
    if (!known_) known_ = player_.level();
    if (analysis.detected)
      known_->delay = Seconds{std::max(0.0, analysis.delay_frames) / analysis.sample_rate.value};
  }

  /// Another opening may have another result.
  static bool worth_repeating(const Opening& opening) {
    const auto verdict = opening.finding.verdict;
    return verdict == Verdict::Ok || verdict == Verdict::LostFrames || verdict == Verdict::BackgroundSound;
  }

  void locate_second_path(Measurement& measurement) {
    const auto& detected_twice = measurement.shown();
    auto request = request_;
    request.block_frames = 2 * detected_twice.granted.block_frames;
    const auto again = open(request);
    if (!again) return;  // the device has no such block
    const auto where = second_arrival(detected_twice, *again);
    if (!where.empty()) measurement.finding.what += "; " + where;
  }

  Backend& backend_;
  const MeasureSettings& settings_;
  const MeasureProgress& progress_;
  ProbePlayer player_;
  Guarded guarded_;
  StreamRequest request_;
  int input_ = 0;  ///< among those of the stream
  int turn_ = 0;
  std::optional<PathLevel> known_;
  std::optional<StreamGranted> opened_;  ///< what the first opening was granted
};

}  // namespace

Status check_attended(const DeadMansSwitch& dead_man) {
  if (dead_man.longest_pause() < DeadMansWatch::kDisarm) return {};
  return fail(Errc::Device, "",
              "the stop inputs were not handled for 5 s, and nothing is played after that: ended",
              "measure again");
}

const Opening& Measurement::shown() const {
  const auto found = std::find_if(openings.begin(), openings.end(), [&](const Opening& opening) {
    return opening.finding.verdict == finding.verdict;
  });
  return found != openings.end() ? *found : openings.front();
}

Result<StreamRequest> measurement_request(Backend& backend, const MeasureSettings& settings) {
  const auto devices = backend.devices();
  if (!devices) return tl::unexpected(devices.error());
  auto request = settings.request;
  const auto input =
      device_with_id(*devices, request.input_device.empty() ? request.device : request.input_device);
  if (!input) return tl::unexpected(input.error());
  const auto output = device_with_id(*devices, request.device);
  if (!output) return tl::unexpected(output.error());
  request.sample_rate = request.sample_rate.value_or(output->default_rate);
  request.in_map.resize(index(std::clamp(input->in_channels, 1, kMaxInputs)));
  std::iota(request.in_map.begin(), request.in_map.end(), 0);
  if (settings.input >= static_cast<int>(request.in_map.size())) request.in_map.push_back(settings.input);
  request.in_channels = static_cast<int>(request.in_map.size());
  request.out_channels = 1;
  request.out_map = {settings.output};
  return request;
}

Result<Measurement> measure(Backend& backend, const MeasureSettings& settings,
                            const MeasureProgress& progress) {
  if (auto status = check(settings); !status) return tl::unexpected(status.error());
  return Session{backend, settings, progress}.run();
}

}  // namespace tactus
