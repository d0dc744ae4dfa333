#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>
#include <thread>
#include <vector>

#include "engine/core/not_realtime.h"
#include "engine/guard/guarded.h"

namespace tactus::test {

/// Plays noise that tells channel and frame, and keeps what it hears from one frame on. Its samples are
/// floats of at most 0.5 and never 0, so that a way that changes no bit can be distinguished from any other.
class NoiseProbe final : public BlockProcessor {
 public:
  explicit NoiseProbe(int kept_frames = 48000) : kept_(kept_frames) {}

  static double noise(int channel, std::int64_t frame) {
    auto x = static_cast<std::uint64_t>(frame) * 0x9e3779b97f4a7c15u + static_cast<std::uint64_t>(channel);
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    const auto fraction = static_cast<std::int64_t>(x >> 41) | 1;  // odd, below 2^23
    return static_cast<double>(fraction - (1 << 22)) / (1 << 23);
  }

  Status prepare(const StreamFormat& format) override {
    ++prepared;
    outputs_ = format.out_channels;
    frames_ = from_ = 0;
    heard_.assign(static_cast<std::size_t>(format.in_channels),
                  std::vector<double>(static_cast<std::size_t>(kept_)));
    return {};
  }
  void process(const BlockIo& io) noexcept override {
    const auto first = frames_.load();
    if (const int ms = sleep_ms; ms > 0) {
      again_ = true;
      sleep_ms = 0;
      const NotRealtime waits;
      std::this_thread::sleep_for(std::chrono::milliseconds{ms});
    } else if (again_.exchange(false)) {
      from_ = first;
    }
    const auto at = first - from_;
    for (std::size_t c = 0; c < heard_.size(); ++c)
      for (int n = 0; n < io.frames && at + n < kept_; ++n)
        heard_[c][static_cast<std::size_t>(at + n)] = io.in[c][n];
    for (int c = 0; c < outputs_; ++c)
      for (int n = 0; n < io.frames; ++n) io.out[c][n] = noise(c, first + n);
    frames_ = first + io.frames;
  }

  /// [any] Frames since it was prepared.
  std::int64_t frames() const { return frames_; }
  /// [control] What it hears from now on is kept instead.
  void listen_again() { again_ = true; }
  bool full() const { return !again_ && sleep_ms == 0 && frames_ - from_ >= kept_; }
  /// [control & full] After how many frames this input hears this output, sample for sample in all that is
  /// kept; empty: it hears something else. At most half of what is kept, or 16384 frames.
  std::optional<int> delay(int input, int output) const {
    const auto& heard = heard_[static_cast<std::size_t>(input)];
    const auto fits = [&](int delay) {
      for (int n = 0; n < kept_; ++n) {
        const auto sent = from_ + n - delay;
        if (heard[static_cast<std::size_t>(n)] != (sent < 0 ? 0.0 : noise(output, sent))) return false;
      }
      return true;
    };
    for (int delay = 0; delay <= (from_ == 0 ? kept_ / 2 : 16384); ++delay)
      if (fits(delay)) return delay;
    return std::nullopt;
  }
  const std::vector<double>& heard(int input) const { return heard_[static_cast<std::size_t>(input)]; }

  int prepared = 0;
  std::atomic<int> sleep_ms{0};  ///< its next block takes this long, and what it hears after that is kept

 private:
  int kept_;
  int outputs_ = 0;
  std::vector<std::vector<double>> heard_;
  std::atomic<std::int64_t> frames_{0}, from_{0};
  std::atomic<bool> again_{false};
};

/// Behind guards that let everything through, so that a test hears the way and not the guard.
struct GuardedProbe {
  explicit GuardedProbe(int channels, int kept_frames = 48000)
      : probe(kept_frames),
        guarded(probe, std::vector<GuardedChannel>(static_cast<std::size_t>(channels),
                                                   {DriveGuard::Kind::Audio, DriveLimits{}})) {
    guarded.disable_sensor_watch();
  }
  NoiseProbe probe;
  Guarded guarded;
};

}  // namespace tactus::test
