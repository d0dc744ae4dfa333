#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <vector>

#include "engine/core/guarded.h"

namespace tactus::test {

/// Plays noise that tells channel and frame, and keeps what it hears of the first frames. Its samples are
/// floats of at most 0.5 and never 0, so that a way that changes no bit can be told from any other.
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
    frames_ = 0;
    heard_.assign(static_cast<std::size_t>(format.in_channels),
                  std::vector<double>(static_cast<std::size_t>(kept_)));
    return {};
  }
  void process(const BlockIo& io) noexcept override {
    const auto first = frames_.load();
    for (std::size_t c = 0; c < heard_.size(); ++c)
      for (int n = 0; n < io.frames && first + n < kept_; ++n)
        heard_[c][static_cast<std::size_t>(first + n)] = io.in[c][n];
    for (int c = 0; c < outputs_; ++c)
      for (int n = 0; n < io.frames; ++n) io.out[c][n] = noise(c, first + n);
    frames_ = first + io.frames;
  }

  /// [any] Frames since it was prepared.
  std::int64_t frames() const { return frames_.load(); }
  bool full() const { return frames() >= kept_; }
  /// [control & stopped] After how many frames this input heard this output, sample for sample from the first
  /// sound on and for at least half of what is kept; empty: it heard something else.
  std::optional<int> delay(int input, int output) const {
    const auto& heard = heard_[static_cast<std::size_t>(input)];
    int first = 0;
    while (first < kept_ && heard[static_cast<std::size_t>(first)] == 0.0) ++first;
    if (first > kept_ / 2) return std::nullopt;
    for (int n = first; n < kept_; ++n)
      if (heard[static_cast<std::size_t>(n)] != noise(output, n - first)) return std::nullopt;
    return first;
  }
  const std::vector<double>& heard(int input) const { return heard_[static_cast<std::size_t>(input)]; }

  int prepared = 0;

 private:
  int kept_;
  int outputs_ = 0;
  std::vector<std::vector<double>> heard_;
  std::atomic<std::int64_t> frames_{0};
};

/// Behind guards that let everything through, so that a test hears the way and not the guard.
struct GuardedProbe {
  explicit GuardedProbe(int channels, int kept_frames = 48000)
      : probe(kept_frames),
        guarded(probe, std::vector<GuardedChannel>(static_cast<std::size_t>(channels),
                                                   {DriveGuard::Kind::Audio, DriveLimits{}})) {
    guarded.trust_sensors();
  }
  NoiseProbe probe;
  Guarded guarded;
};

}  // namespace tactus::test
