#include "backends/loop/loop.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <thread>
#include <utility>

#include "backends/find_device.h"
#include "backends/loop/loop_path.h"
#include "engine/core/channels.h"
#include "engine/core/index.h"
#include "engine/core/realtime.h"
#include "engine/dsp/generators/counter_noise.h"

namespace tactus {
namespace {

constexpr int kChannels = 2;
constexpr int kUsualBlock = 64;
const std::string kPrefix = "loop:";
constexpr Seconds kMaxLateness{2.0};  // a driver restarts then

/// Frames before what is read that a path must know.
int reach_of(const LoopCard& card, double hardware_frames) {
  const bool whole = hardware_frames == std::floor(hardware_frames) && card.input_ppm == 0.0;
  return whole && !card.echo_cancel ? 0 : SincLine::kReach;
}

Result<LoopTiming> timing_of(const LoopCard& card, Hertz sample_rate, int block) {
  LoopTiming timing;
  timing.sample_rate = sample_rate;
  timing.hardware_frames = frames_in(card.delay, sample_rate) + card.delay_frames;
  const double ahead = timing.hardware_frames - reach_of(card, timing.hardware_frames);
  const double longest = card.delay_blocks > 0 ? block : std::min<double>(block, ahead);
  if (ahead + std::max(0, card.delay_blocks - 1) * block < 1.0 || longest < 1.0)
    return fail(
        Errc::OutOfRange, "",
        fmt::format("a delay of {:g} frames is too short for a simulated card", timing.hardware_frames),
        fmt::format("give a whole number of frames, or more than {}", SincLine::kReach));
  timing.block_frames = static_cast<int>(longest);
  timing.buffer_frames = card.delay_blocks * timing.block_frames;
  return timing;
}

/// What this opening adds: 0 … `most`, each equally likely.
int by_chance(int most, int opening) {
  const double even = 0.5 + 0.5 * CounterNoise{2, 0}.uniform(opening);
  return static_cast<int>(even * (most + 1));
}

class LoopStream final : public Stream {
 public:
  LoopStream(const LoopCard& card, const LoopTiming& timing, const StreamRequest& request,
             StreamGranted granted, GuardedBlocks& processor, int opening)
      : card_(card),
        processor_(processor),
        granted_(std::move(granted)),
        in_map_(channels_of(request.in_map, request.in_channels)),
        out_map_(channels_of(request.out_map, request.out_channels)),
        in_(static_cast<int>(in_map_.size()), timing.block_frames),
        out_(static_cast<int>(out_map_.size()), timing.block_frames),
        frames_a_block_(std::clamp(static_cast<int>(std::lround(timing.block_frames * card.block_factor)), 1,
                                   timing.block_frames)),
        later_(by_chance(card.unstable_frames, opening) +
               by_chance(card.unstable_blocks, opening) * timing.block_frames),
        least_later_(timing.block_frames + reach_of(card, timing.hardware_frames) - timing.hardware_frames -
                     timing.buffer_frames) {
    for (int c = 0; c < kChannels; ++c) paths_.emplace_back(card, timing, c);
  }
  ~LoopStream() override { (void)stop(); }

  const StreamGranted& granted() const override { return granted_; }
  Status start(const std::function<void()>& ready) override {
    if (thread_.joinable())
      return fail(Errc::Device, granted_.device, "this stream is already running", "stop it first");
    ready();
    running_ = true;
    thread_ = std::thread{[this] { run(); }};
    return {};
  }
  Status stop() override {
    running_ = false;
    if (thread_.joinable()) thread_.join();
    return {};
  }
  StreamState state() const override { return running_ ? StreamState::Running : StreamState::Stopped; }
  Health health() const override { return meter_.read(); }

 private:
  using Clock = std::chrono::steady_clock;

  double true_rate() const { return granted_.format.sample_rate.value * card_.rate_factor; }
  Clock::time_point due(std::int64_t frames) const {
    const std::chrono::duration<double> after{static_cast<double>(frames) / true_rate()};
    return begun_ + std::chrono::duration_cast<Clock::duration>(after);
  }

  void run() {
    const NoDenormals no_denormals;
    const auto first = frame_;
    begun_ = Clock::now();
    while (running_) {
      // A card that delivers a block has waited for its last frame.
      if (card_.real_time) std::this_thread::sleep_until(due(frame_ - first + frames_a_block_));
      block(false);
    }
    while (!block(true)) continue;
  }

  /// True: the outputs are at zero behind the last block.
  bool block(bool last) noexcept {
    record();
    const BlockIo io{in_.data(), out_.data(), frames_a_block_};
    if (!last) meter_.clock(static_cast<double>(frame_) / true_rate());
    const auto begin = Clock::now();
    bool at_zero = false;
    if (last)
      at_zero = processor_.finish(io);
    else
      processor_.process(io);
    const std::chrono::duration<double> took = Clock::now() - begin;
    if (!last) meter_.block(frames_a_block_, took.count() * true_rate() / frames_a_block_);
    play();
    frame_ += frames_a_block_;
    return at_zero;
  }

  void record() noexcept {
    for (int n = 0; n < frames_a_block_; ++n) {
      const double later = lateness(frame_ + n);
      std::array<double, kChannels> recorded;
      for (std::size_t c = 0; c < kChannels; ++c) recorded[c] = paths_[c].record(frame_ + n, later);
      for (int c = 0; c < in_.size(); ++c) in_[c][n] = recorded[index(in_map_[index(c)])];
    }
  }

  /// By how many frames the input is later than usual: what this opening added, a clock that runs away, and
  /// frames that got lost or came twice. Frames come one after another.
  double lateness(std::int64_t frame) noexcept {
    for (const auto& drop : card_.drops)
      if (happens(drop, frame)) lose(drop.frames);
    const double growth = card_.input_ppm * 1e-6 / (1.0 + card_.input_ppm * 1e-6);
    return std::clamp(later_ + growth * static_cast<double>(frame), least_later_,
                      frames_in(kMaxLateness, granted_.format.sample_rate));
  }
  bool happens(const LoopCard::Drop& drop, std::int64_t frame) const noexcept {
    const auto since = frame - std::llround(frames_in(drop.at, granted_.format.sample_rate));
    const auto every = std::llround(frames_in(drop.every, granted_.format.sample_rate));
    return since == 0 || (every > 0 && since > 0 && since % every == 0);
  }
  void lose(int frames) noexcept {
    later_ -= frames;
    if (!card_.drops_reported) return;
    meter_.gap(Gap::Input);
    meter_.lost(std::max(0, frames));
  }

  /// Each path belongs to the input on which it ends.
  void play() noexcept {
    if (card_.cable == LoopCard::Cable::None) return;
    const int crossed = card_.cable == LoopCard::Cable::Crossed ? 1 : 0;
    for (int c = 0; c < out_.size(); ++c) {
      auto& path = paths_[index((out_map_[index(c)] + crossed) % kChannels)];
      for (int n = 0; n < frames_a_block_; ++n) path.play(frame_ + n, out_[c][n]);
    }
  }

  const LoopCard card_;
  GuardedBlocks& processor_;
  StreamGranted granted_;
  std::vector<int> in_map_, out_map_;
  ChannelBuffers in_, out_;
  int frames_a_block_;
  double later_;              ///< than usual, without what the clock does [frames]
  const double least_later_;  ///< it cannot be earlier, since that has not been played yet
  std::vector<LoopPath> paths_;
  std::int64_t frame_ = 0;
  Clock::time_point begun_;
  HealthMeter meter_;
  std::atomic<bool> running_{false};
  std::thread thread_;
};

/// Single frames of a simulated card. An output that was skipped plays on.
class LoopFrames final : public FrameDevice {
 public:
  LoopFrames(const LoopCard& card, const LoopTiming& timing, const StreamRequest& request)
      : in_map_(channels_of(request.in_map, request.in_channels)),
        out_map_(channels_of(request.out_map, request.out_channels)),
        crossed_(card.cable == LoopCard::Cable::Crossed ? 1 : 0),
        is_connected_(card.cable != LoopCard::Cable::None),
        held_(out_map_.size()) {
    for (int c = 0; c < kChannels; ++c) paths_.emplace_back(card, timing, c);
  }
  int in_channels() const override { return static_cast<int>(in_map_.size()); }
  int out_channels() const override { return static_cast<int>(out_map_.size()); }
  bool read(std::int64_t frame, float* in) noexcept override {
    std::array<double, kChannels> recorded{};
    for (; next_ <= frame; ++next_) {
      for (std::size_t c = 0; c < kChannels; ++c) recorded[c] = paths_[c].record(next_, 0.0);
      if (next_ < frame) play(next_);
    }
    for (std::size_t c = 0; c < in_map_.size(); ++c) in[c] = static_cast<float>(recorded[index(in_map_[c])]);
    return true;
  }
  bool write(std::int64_t frame, const float* out) noexcept override {
    for (std::size_t c = 0; c < held_.size(); ++c) held_[c] = static_cast<double>(out[c]);
    play(frame);
    return true;
  }
  void to_zero() noexcept override { std::fill(held_.begin(), held_.end(), 0.0); }

 private:
  void play(std::int64_t frame) noexcept {
    for (std::size_t c = 0; c < held_.size() && is_connected_; ++c)
      paths_[index((out_map_[c] + crossed_) % kChannels)].play(frame, held_[c]);
  }

  std::vector<int> in_map_, out_map_;
  int crossed_;
  bool is_connected_;
  std::vector<LoopPath> paths_;
  std::vector<double> held_;
  std::int64_t next_ = 0;
};

Device device_called(const std::string& id, const std::string& about, bool per_sample) {
  Device device;
  device.id = id;
  device.name = about;
  device.in_channels = device.out_channels = kChannels;
  device.default_rate = per_sample ? Hertz{10e3} : 48_kHz;
  if (per_sample) {
    device.sample_rates = paced_rates();
    device.block_frames = 1;
  }
  return device;
}

}  // namespace

Result<std::vector<Device>> LoopBackend::devices() {
  std::vector<Device> all;
  for (const auto& card : loop_cards())
    all.push_back(device_called(kPrefix + card.name, card.about, loop_card(card.name)->per_sample));
  for (const auto& [id, card] : cards_) all.push_back(device_called(id, "a simulated card", card.per_sample));
  all.front().is_default = true;
  return all;
}

Status LoopBackend::add(const std::string& id) {
  const auto known = device_with_id(*devices(), id);
  if (known) return {};
  if (!id.starts_with(kPrefix)) return tl::unexpected(known.error());
  auto card = loop_card(id.substr(kPrefix.size()));
  if (!card) return tl::unexpected(card.error());
  add(id, *card);
  return {};
}

LoopCard LoopBackend::card(const std::string& id) const {
  const auto added = cards_.find(id);
  auto card = added != cards_.end() ? added->second : *loop_card(id.substr(kPrefix.size()));
  card.real_time = card.real_time && pace_ == Pace::RealTime;
  return card;
}

Result<std::unique_ptr<Stream>> LoopBackend::open(const StreamRequest& request, GuardedBlocks& processor) {
  const auto choice = choose(*devices(), request);
  if (!choice) return tl::unexpected(choice.error());
  if (choice->input.id != choice->output.id)
    return fail(Errc::BadArgument, "", "a simulated card has no path from another device",
                "omit the input device");
  const auto card = this->card(choice->granted.device);
  const auto timing = timing_of(card, choice->granted.format.sample_rate,
                                card.per_sample ? 1 : request.block_frames.value_or(kUsualBlock));
  if (!timing) return tl::unexpected(timing.error());

  auto granted = choice->granted;
  granted.block_frames = granted.format.max_frames = timing->block_frames;
  granted.periods = card.delay_blocks;
  granted.input_latency_frames = timing->hardware_frames;
  granted.output_latency_frames = timing->buffer_frames;
  if (card.per_sample && card.real_time)
    return PacedStream::open(std::make_unique<LoopFrames>(card, *timing, request), std::move(granted),
                             card.pace, processor);
  if (!card.real_time) processor.disable_dead_mans_switch();  // its 500 ms pass at once
  if (auto status = processor.prepare(granted.format); !status) return tl::unexpected(status.error());
  return std::make_unique<LoopStream>(card, *timing, request, std::move(granted), processor, openings_++);
}

}  // namespace tactus
