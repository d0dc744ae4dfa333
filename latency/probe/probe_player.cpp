#include "latency/probe/probe_player.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "engine/core/index.h"
#include "latency/probe/probe.h"

namespace tactus {
namespace {

constexpr Seconds kProbePlayerQuiet{0.1};  // between the level and the probes
constexpr Seconds kAfter{0.2};             // that is recorded beyond the delay
constexpr Seconds kBefore{0.2};            // that is quiet for sure when the level has been found
constexpr Seconds kLevelTakes{1.0};        // a guess
constexpr Hertz kSlowest{100.0};           // hums and offsets below say nothing about the level
constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

}  // namespace

Status ProbePlayer::prepare(const StreamFormat& format) {
  if (script_.input >= format.in_channels || format.out_channels < 1)
    return fail(Errc::BadArgument, "", "a path cannot be measured without an input and an output",
                "open both");
  format_ = format;
  const auto rate = format.sample_rate;
  level_probe_ = level_probe(rate).samples(rate);
  train_ = ProbeTrain::samples(rate, script_.probes, 1.0);
  search_.emplace(script_.level);
  stage_ = Stage::Level;
  frame_ = 0;
  sounding_ = nullptr;
  window_frames_ = static_cast<int>(whole_frames(LevelSearch::kWindow, rate));
  in_window_ = 0;
  window_ = {};
  slow_ = 0.0;
  slow_share_ = 1.0 - std::exp(-2.0 * std::numbers::pi * kSlowest.value / rate.value);
  const auto capacity = train_.size() + whole_frames(LevelSearch::kWindow * search_->max_windows() +
                                                         LevelSearch::kLongestDelay + kAfter * 2,
                                                     rate);
  played_.assign(capacity, 0.0);
  captured_.assign(index(format.in_channels), played_);
  recorded_ = 0;
  end_frame_ = kNever;
  outcome_ = Outcome::Played;
  level_ = {};
  before_ = after_ = {};
  share_ = 0.0;
  done_ = false;
  return {};
}

void ProbePlayer::process(const BlockIo& io) noexcept {
  for (int c = 1; c < format_.out_channels; ++c) std::fill_n(io.out[c], io.frames, 0.0);
  const double* in = io.in[script_.input];
  for (int n = 0; n < io.frames; ++n) {
    observe_input(in[n]);
    io.out[0][n] = next();
    ++frame_;
  }
  share_.store(share_now(), std::memory_order_relaxed);
}

/// How long the level takes is a guess.
double ProbePlayer::share_now() const noexcept {
  if (stage_ == Stage::Done) return 1.0;
  const double level_frames = frames_in(kLevelTakes, format_.sample_rate);
  const double level_share = level_frames / (level_frames + static_cast<double>(train_.size()));
  if (stage_ == Stage::Level) return level_share * std::min(1.0, static_cast<double>(frame_) / level_frames);
  const auto over = static_cast<double>(frame_ - probes_from_) / static_cast<double>(back_at_ - probes_from_);
  return std::min(1.0, level_share + (1.0 - level_share) * over);
}

double ProbePlayer::next() noexcept {
  if (stage_ == Stage::Probes && frame_ >= back_at_) finish(Outcome::Played);
  if (sounding_ == nullptr) return 0.0;
  if (at_ < sounding_->size()) return gain_ * (*sounding_)[at_++];
  sounding_ = nullptr;
  return 0.0;
}

void ProbePlayer::observe_input(double sample) noexcept {
  if (std::abs(sample) > LevelSearch::kTooLoud) mute();
  slow_ += slow_share_ * (sample - slow_);
  window_.power += (sample - slow_) * (sample - slow_);
  window_.peak = std::max(window_.peak, std::abs(sample));
  if (++in_window_ == window_frames_) end_window();
}

void ProbePlayer::end_window() noexcept {
  window_.power /= window_frames_;
  if (stage_ == Stage::Level) follow(search_->observe(window_));
  if (stage_ == Stage::Muted) {
    const auto result = ring_out_.observe(window_);
    if (result != RingOutMonitor::Result::Nothing)
      finish(result == RingOutMonitor::Result::Feedback ? Outcome::Feedback : Outcome::TooLoud);
  }
  window_ = {};
  in_window_ = 0;
}

void ProbePlayer::follow(LevelSearch::Step step) noexcept {
  level_ = search_->found();
  switch (step) {
    case LevelSearch::Step::Wait:
      return;
    case LevelSearch::Step::Probe:
      sounding_ = &level_probe_;
      at_ = 0;
      gain_ = search_->level();
      return;
    case LevelSearch::Step::Ready:
      return begin_probes();
    case LevelSearch::Step::TooLoud:
      return finish(Outcome::TooLoud);
    case LevelSearch::Step::Feedback:
      return finish(Outcome::Feedback);
  }
}

void ProbePlayer::begin_probes() noexcept {
  stage_ = Stage::Probes;
  probes_from_ = frame_;
  sounding_ = &train_;
  at_ = 0;
  gain_ = level_.level;
  // The delay is known within a window or two.
  const auto back = level_.delay ? *level_.delay + LevelSearch::kWindow * 2 : LevelSearch::kLongestDelay;
  back_at_ =
      frame_ + static_cast<std::int64_t>(train_.size() + whole_frames(back + kAfter, format_.sample_rate));
  before_ = health();
}

/// The search goes on with what was captured so far; probes that are cut short are of no use.
void ProbePlayer::mute() noexcept {
  if (stage_ == Stage::Level) {
    sounding_ = nullptr;
    search_->overload();
  }
  if (stage_ != Stage::Probes) return;
  sounding_ = nullptr;
  stage_ = Stage::Muted;
  ring_out_ = RingOutMonitor{level_.delay.value_or(LevelSearch::kLongestDelay)};
}

void ProbePlayer::finish(Outcome outcome) noexcept {
  stage_ = Stage::Done;
  outcome_ = outcome;
  end_frame_ = frame_;
  after_ = health();
  sounding_ = nullptr;
}

void ProbePlayer::observe(const BlockIo& io, std::int64_t first_frame) noexcept {
  if (done_.load(std::memory_order_relaxed)) return;
  const auto end = std::min<std::int64_t>(end_frame_, static_cast<std::int64_t>(played_.size()));
  const auto frames = std::clamp<std::int64_t>(end - first_frame, 0, io.frames);
  std::copy_n(io.out[0], frames, played_.begin() + static_cast<std::ptrdiff_t>(recorded_));
  for (std::size_t c = 0; c < captured_.size(); ++c)
    std::copy_n(io.in[c], frames, captured_[c].begin() + static_cast<std::ptrdiff_t>(recorded_));
  recorded_ += index(frames);
  if (stage_ == Stage::Done) done_.store(true, std::memory_order_release);
}

// A level probe that came back too loud would be found in the recording as well.
LoopRecording ProbePlayer::take_recording() {
  const bool cut = outcome_ == Outcome::Played && search_->was_overloaded();
  const auto from =
      cut ? probes_from_ - static_cast<std::int64_t>(frames_in(kBefore, format_.sample_rate)) : 0;
  const auto take = [&](std::vector<double>& samples) {
    const auto begin = samples.begin() + static_cast<std::ptrdiff_t>(from);
    std::vector<double> taken{begin, samples.begin() + static_cast<std::ptrdiff_t>(recorded_)};
    samples = {};
    return taken;
  };
  LoopRecording recording{format_.sample_rate, take(played_), {}};
  for (auto& channel : captured_) recording.captured.push_back(take(channel));
  return recording;
}

}  // namespace tactus
