#include "engine/runtime/player.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/core/every_block.h"
#include "engine/core/transpose.h"
#include "engine/dsp/simd/lanes.h"
#include "engine/runtime/operations.h"
#include "engine/runtime/signal_reader.h"

namespace tactus {
namespace {

constexpr double kSilence[kMaxSubBlock] = {};

}  // namespace

Player::Player(std::unique_ptr<Plan> plan) : versions_(std::move(plan)), steps_(*this) {
  use(versions_.restart());
}

Status Player::prepare(const StreamFormat& format) {
  if (format.sample_rate != plan().sample_rate)
    return fail(Errc::BadArgument, {}, "the graph was compiled for another sample rate",
                "compile it for the rate of the stream");
  format_ = format;
  use(versions_.restart());
  running_->start(format.max_frames);
  fades_.assign(running_->outputs.size(), {});
  stored_ = std::min(index(format.out_channels), running_->outputs.size());
  fading_until_ = 0;
  last_frames_ = 0;
  outside_in_.resize(out_channels(), kMaxSubBlock);
  outside_out_.resize(in_channels(), kMaxSubBlock);
  bad_inputs_ = 0;
  replacements_ = 0;
  now_ = 0;
  frame_ = 0;
  inbox_.restart();
  return {};
}

TACTUS_EVERY_BLOCK void Player::process(const BlockIo& io) noexcept {
  io_ = &io;
  for (offset_ = 0; offset_ < io.frames;) {
    int frames = std::min(io.frames - offset_, kMaxSubBlock);
    if (versions_.next() != nullptr || !inbox_.empty()) frames = frames_to_next_entry(frames);
    run_sub_block(frames);
    offset_ += frames;
    now_ += frames;
    last_frames_ = frames;
  }
  frame_.store(now_, std::memory_order_relaxed);
}

inline void Player::run_sub_block(int frames) noexcept {
  running_->advance(now_, frames);
  if (outside_ == nullptr) load_inputs(frames);
  timed_ ? steps_.run<true>(now_, frames) : steps_.run<false>(now_, frames);
  if (outside_ == nullptr) store_outputs(frames);
  if (!running_->taps.empty()) store_taps(frames);
  for (auto* observer : observers_) observer->observe(*running_, now_, frames);
}

void Player::store_taps(int frames) noexcept {
  for (std::size_t t = 0; t < running_->taps.size(); ++t) {
    const auto& signal = running_->plan->channels[index(running_->tap_channels[t])].signal;
    for (int n = 0; n < frames; ++n) running_->taps[t][index(offset_ + n)] = signal[n];
  }
}

// Journal and replacement.

int Player::frames_to_next_entry(int frames) noexcept {
  std::int64_t until = frames;
  if (Running* next = versions_.next(); next != nullptr) {
    if (next->frame <= now_)
      take_over(*next);
    else
      until = std::min(until, next->frame - now_);
  }
  return static_cast<int>(
      inbox_.take_due(now_, until, [this](const JournalEntry& entry) noexcept { apply(entry); }));
}

void Player::apply(const JournalEntry& entry) noexcept {
  const auto& plan = *running_->plan;
  // Where it is no longer known, the last known value is the best guess.
  if (entry.kind == JournalEntry::Kind::SystemDelay && plan.system_delay != nullptr && entry.value >= 0)
    running_->set_system_delay(Seconds{entry.value / plan.sample_rate.value});
  const bool at_once = entry.kind == JournalEntry::Kind::ControlSet;
  if (entry.kind != JournalEntry::Kind::ControlChange && !at_once) return;
  if (entry.index < 0 || entry.index >= static_cast<int>(running_->control_of.size())) return;
  const int control = running_->control_of[index(entry.index)];
  if (control < 0 || !std::isfinite(entry.value)) return;
  at_once ? running_->set_control(index(control), entry.value)
          : running_->move_control(index(control), now_, entry.value);
}

int Player::control_index(std::string_view control) const {
  const auto& names = control_names();
  const auto found = std::find(names.begin(), names.end(), control);
  if (found == names.end()) return -1;
  const auto number = found - names.begin();
  return versions_.newest().control_of[index(number)] < 0 ? -1 : static_cast<int>(number);
}

void Player::take_over(Running& next) noexcept {
  constexpr double kFade_s = 0.010;
  const auto fade = static_cast<std::int64_t>(std::lround(kFade_s * next.plan->sample_rate.value));
  next.take_over(*running_, now_, fade);
  for (std::size_t c = 0; c < fades_.size(); ++c)
    if (next.handover.jumps[c]) fades_[c].begin(now_, fade, last_output(c));
  fading_until_ = now_ + fade;
  use(next);
  inbox_.observe({now_, JournalEntry::Kind::Replacement, ++replacements_, 0.0});
  versions_.done();
}

/// What went out in the frame before this one.
double Player::last_output(std::size_t output) const noexcept {
  if (last_frames_ == 0) return 0.0;
  return output_signal(output)[last_frames_ - 1] + fades_[output].at(now_ - 1);
}

// Samples.

inline void Player::load_inputs(int frames) noexcept {
  for (const auto& input : running_->loaded_inputs)
    if (input.channel < format_.in_channels)
      load_input(io_->in[input.channel] + offset_, frames, input.to);
    else
      std::fill_n(input.to, frames, 0.0);
  for (const auto& lanes : running_->plan->input_lanes)
    load_lanes(lanes, frames, lanes.to, [this](int channel) {
      return channel < format_.in_channels ? io_->in[channel] + offset_ : kSilence;
    });
}

/// Nodes see neither what is not finite nor denormals, which are 0 to arithmetic, but not to what only copies
/// or chooses.
inline void Player::load_input(const double* from, int frames, double* to) noexcept {
  if (!copy_finite(from, frames, to)) [[unlikely]]
    clear_input(to, frames);
}

/// The same for channels that become lanes.
template <class Samples>
inline void Player::load_lanes(const InputLanes& lanes, int frames, double* to,
                               const Samples& samples_of) noexcept {
  std::array<const double*, kVectorWidth> from;
  std::transform(lanes.channels.begin(), lanes.channels.end(), from.begin(), samples_of);
  if (!pack_finite(from, frames, to)) [[unlikely]]
    clear_input(to, frames * kVectorWidth);
}

void Player::clear_input(double* samples, int frames) noexcept {
  bad_inputs_.fetch_add(clear_nonfinite(samples, frames), std::memory_order_relaxed);
}

inline void Player::store_outputs(int frames) noexcept {
  const auto channels = stored_;
  for (std::size_t c = 0; c < channels; ++c)
    if (const auto& signal = output_signal(c); signal.stride == 1)
      copy_samples(signal.data, frames, io_->out[c] + offset_);
    else
      c += store_lanes(c, channels, frames) - 1;
  if (now_ < fading_until_) [[unlikely]]
    fade_outputs(channels, frames);
}

void Player::fade_outputs(std::size_t channels, int frames) noexcept {
  for (std::size_t c = 0; c < channels; ++c) fades_[c].process(io_->out[c] + offset_, frames, now_);
}

/// Returns of how many outputs.
std::size_t Player::store_lanes(std::size_t first, std::size_t channels, int frames) noexcept {
  const auto& signal = output_signal(first);
  if (running_->vectorised[first] && first + kVectorWidth <= channels) {
    std::array<double*, kVectorWidth> lanes;
    for (std::size_t lane = 0; lane < kVectorWidth; ++lane) lanes[lane] = io_->out[first + lane] + offset_;
    Transpose::unpack(signal.data, lanes, frames);
    return kVectorWidth;
  }
  for (int n = 0; n < frames; ++n) io_->out[first][offset_ + n] = signal[n];
  return 1;
}

void Player::answer(int offset, int frames) noexcept {
  if (outside_ == nullptr) return;  // the channels were loaded like any others
  for (std::size_t c = 0; c < running_->outputs.size(); ++c) {
    const auto& signal = output_signal(c);
    double* const samples = outside_in_[static_cast<int>(c)];
    for (int n = 0; n < frames; ++n) samples[n] = signal[offset + n];
    if (now_ + offset < fading_until_) fades_[c].process(samples, frames, now_ + offset);
    if (static_cast<int>(c) < format_.out_channels)
      std::copy_n(samples, frames, io_->out[c] + offset_ + offset);
  }
  outside_->process({outside_in_.data(), outside_out_.data(), frames});
  for (const auto& input : running_->loaded_inputs)
    load_input(outside_out_[input.channel], frames, input.to + offset);
  for (const auto& lanes : running_->plan->input_lanes)
    load_lanes(lanes, frames, lanes.to + offset * kVectorWidth,
               [this](int channel) { return outside_out_[channel]; });
}

}  // namespace tactus
