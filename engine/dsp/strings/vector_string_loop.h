#pragma once

// Thread: [realtime]; constructors [control].

#include <array>

#include "engine/dsp/delays/taps.h"
#include "engine/dsp/strings/string_loop.h"

namespace tactus {

/// Eight StringLoops in vector registers, each with its own parameters. The pole of the loss filter runs
/// frame by frame in all lanes at once; against StringLoop the output differs by rounding.
class VectorStringLoop {
 public:
  /// [control] Allocates for `lowest_pitch`.
  VectorStringLoop(LossFilter filter, Hertz sample_rate, double lowest_pitch);

  /// [realtime] From the next frame on. Does nothing when nothing changed.
  void tune(const StringParameters& parameters, int lane) noexcept;
  void reset() noexcept;
  /// [realtime] Goes on sounding as `other` did.
  void adopt(VectorStringLoop& other) noexcept {
    line_.adopt(other.line_);
    if (filter_ == other.filter_) loss_ = other.loss_;
  }

  /// [realtime] `x` gives the Lanes of a frame (`x[n]`, `x + n`), `y` is interleaved.
  template <class Input>
  void run(const Input& x, double* y, int frames, int /*position*/) noexcept {
    for (int done = 0; done < frames;) {
      const int count = std::min({frames - done, kMostFrames, shortest_});
      run_frames(x + done, y + done * Lanes::kCount, count);
      line_.write(y + done * Lanes::kCount, count * Lanes::kCount);
      done += count;
    }
  }

 private:
  static constexpr std::size_t kTaps = StringDesign::kTaps;
  static constexpr int kMostFrames = 64;  ///< frames worked on at once
  using Row = std::array<double, Lanes::kCount>;

  void take(int lane, const StringDesign& design) noexcept;

  /// No longer than the newest tap is away.
  template <class Input>
  void run_frames(const Input& x, double* y, int frames) noexcept {
    LanePlaces oldest;
    for (std::size_t lane = 0; lane < oldest.size(); ++lane)
      oldest[lane] = line_.behind((newest_[lane] + static_cast<int>(kTaps) - 1) * Lanes::kCount) + lane;
    std::array<Lanes, kTaps> weights;
    for (std::size_t k = 0; k < kTaps; ++k) weights[k] = Lanes::load(weights_[k].data());
    const auto pole = Lanes::load(pole_.data());
    auto loss = Lanes::load(loss_.data());
    VectorTaps<kTaps> taps{oldest};
    for (int n = 0; n < frames; ++n, y += Lanes::kCount) {
      taps.next(oldest, n);
      if (filter_ == LossFilter::OneZero) {
        taps.sum(weights, x[n]).store(y);
      } else {
        loss = fused_multiply_add(pole, loss, taps.sum(weights, Lanes::broadcast(0)));
        (x[n] + loss).store(y);
      }
    }
    loss.store(loss_.data());
  }

  LossFilter filter_;
  Hertz sample_rate_;
  std::array<StringParameters, Lanes::kCount> parameters_{};
  std::array<int, Lanes::kCount> newest_{};
  int shortest_ = 0;  ///< of the newest taps
  alignas(64) std::array<Row, kTaps> weights_{};
  alignas(64) Row pole_{};
  alignas(64) Row loss_{};  ///< last output of the pole
  DelayLine line_;          ///< interleaved
};

}  // namespace tactus
