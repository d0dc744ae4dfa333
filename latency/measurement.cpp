#include "latency/measurement.h"

#include <fmt/format.h>

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
#include "latency/probe/probe.h"
#include "latency/probe/probe_player.h"
#include "latency/session.h"

namespace tactus {
namespace {

constexpr std::chrono::milliseconds kTick{10};
constexpr std::chrono::seconds kMeasurementPatience{3};  // with a stream that brings no block
constexpr int kMostInputs = 16;                          // that are listened to: memory

/// As loud as the sweep may be before the guard changes its shape.
double loudest(const MeasureSettings& settings, Hertz rate) {
  const auto& limits = settings.guard.limits;
  double level = std::min(amplitude_from_db(settings.loudest_dbfs), limits.ceiling);
  if (settings.guard.kind == DriveGuard::Kind::Drive)
    level =
        std::min(level, limits.slew_per_second / (2 * std::numbers::pi * measuring_sweep(rate).stop.value));
  return level;
}

Status check(const MeasureSettings& settings) {
  if (settings.openings < 1 || settings.sweeps < 1 || settings.input < 0 || settings.output < 0)
    return fail(Errc::BadArgument, "", "a measurement needs an opening, a sweep, an input and an output", "");
  if (!(settings.softest_dbfs > -150.0 && settings.softest_dbfs <= settings.loudest_dbfs &&
        settings.loudest_dbfs <= 0.0))
    return fail(Errc::OutOfRange, "",
                "the level of a measurement goes up from above -150 dBFS to 0 dBFS at most",
                "give the softest and the loudest level in this order");
  return {};
}

class Session {
 public:
  Session(Backend& backend, const MeasureSettings& settings, const MeasureProgress& progress)
      : backend_(backend), settings_(settings), progress_(progress), guarded_(player_, {settings.guard}) {
    guarded_.set_tap(&player_);
  }

  Result<Measurement> run() {
    if (auto status = find_channels(); !status) return tl::unexpected(status.error());
    Measurement measurement;
    for (turn_ = 0; turn_ < settings_.openings; ++turn_) {
      auto opening = open(request_);
      if (!opening) return tl::unexpected(opening.error());
      measurement.openings.push_back(std::move(*opening));
      if (!is_hopeful(measurement.openings.back())) break;
    }
    conclude(measurement);
    if (measurement.finding.verdict == Verdict::DirectMonitoring) tell_where_it_comes_from(measurement);
    const auto& granted = measurement.openings.front().granted;
    if (granted.input_latency_frames && granted.output_latency_frames)
      measurement.reported_frames = *granted.input_latency_frames + *granted.output_latency_frames;
    return measurement;
  }

 private:
  Status find_channels() {
    const auto devices = backend_.devices();
    if (!devices) return tl::unexpected(devices.error());
    request_ = settings_.request;
    const auto input =
        device_with_id(*devices, request_.input_device.empty() ? request_.device : request_.input_device);
    if (!input) return tl::unexpected(input.error());
    const auto output = device_with_id(*devices, request_.device);
    if (!output) return tl::unexpected(output.error());
    request_.sample_rate = request_.sample_rate.value_or(output->default_rate);
    request_.in_map.resize(index(std::clamp(input->in_channels, 1, kMostInputs)));
    std::iota(request_.in_map.begin(), request_.in_map.end(), 0);
    input_ = settings_.input;
    if (input_ >= static_cast<int>(request_.in_map.size())) {
      input_ = static_cast<int>(request_.in_map.size());
      request_.in_map.push_back(settings_.input);
    }
    request_.in_channels = static_cast<int>(request_.in_map.size());
    request_.out_channels = 1;
    request_.out_map = {settings_.output};
    return {};
  }

  /// Opens the stream, plays, and says what came of it.
  Result<Opening> open(const StreamRequest& request) {
    ProbePlayer::Script script;
    script.input = input_;
    script.sweeps = settings_.sweeps;
    script.level.loudest = loudest(settings_, *request.sample_rate);
    script.level.softest = std::min(amplitude_from_db(settings_.softest_dbfs), script.level.loudest);
    script.level.quiet = settings_.guard.limits.soft_start + LevelSearch::kWindow;
    script.level.known = known_;
    player_.set_script(script);
    auto stream = backend_.open(request, guarded_);
    if (!stream) return tl::unexpected(stream.error());
    player_.set_stream(stream->get());
    if (auto played = play(**stream); !played) return tl::unexpected(played.error());
    return judged(**stream);
  }

  Status play(Stream& stream) {
    using Clock = std::chrono::steady_clock;
    if (auto status = stream.start(); !status) return status;
    auto last_alive = Clock::now();
    while (!player_.done()) {
      std::this_thread::sleep_for(kTick);
      tell_progress();
      if (stream.state() == StreamState::Running) last_alive = Clock::now();
      if (player_.done() || Clock::now() - last_alive <= kMeasurementPatience) continue;
      (void)stream.stop();
      return fail(Errc::Device, stream.granted().device,
                  "the device was disconnected, or delivers no more blocks",
                  "plug it in, start its sound server, and measure again");
    }
    return stream.stop();
  }

  void tell_progress() const {
    if (!progress_) return;
    const double share = (std::min(turn_, settings_.openings - 1) + player_.share()) / settings_.openings;
    progress_(share, fmt::format("opening {} of {}", turn_ + 1, settings_.openings));
  }

  Result<Opening> judged(const Stream& stream) {
    Opening opening;
    opening.granted = stream.granted();
    opening.health = stream.health();
    opening.level_dbfs = amplitude_to_db(player_.level().level);
    std::vector<GuardEvent> events;
    for (GuardEvent event; guarded_.take_event(event);) events.push_back(event);
    auto findings = stream_findings(player_, opening.granted, events, input_,
                                    settings_.guard.kind == DriveGuard::Kind::Drive);
    opening.recording = player_.take_recording();
    if (player_.outcome() == ProbePlayer::Outcome::Played) {
      auto analysis = analyze(opening.recording, {input_, settings_.profile});
      if (!analysis && findings.empty()) return tl::unexpected(analysis.error());
      if (analysis) {
        opening.analysis = std::move(*analysis);
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

  /// Opening it again may tell something else.
  static bool is_hopeful(const Opening& opening) {
    return opening.finding.verdict == Verdict::Ok || opening.finding.verdict == Verdict::LostFrames;
  }

  void tell_where_it_comes_from(Measurement& measurement) {
    const auto detected_twice = std::find_if(
        measurement.openings.begin(), measurement.openings.end(),
        [](const Opening& opening) { return opening.finding.verdict == Verdict::DirectMonitoring; });
    auto request = request_;
    request.block_frames = 2 * detected_twice->granted.block_frames;
    const auto again = open(request);
    if (!again) return;  // the device has no such block
    const auto where = second_arrival(*detected_twice, *again);
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
};

}  // namespace

Result<Measurement> measure(Backend& backend, const MeasureSettings& settings,
                            const MeasureProgress& progress) {
  if (auto status = check(settings); !status) return tl::unexpected(status.error());
  return Session{backend, settings, progress}.run();
}

}  // namespace tactus
